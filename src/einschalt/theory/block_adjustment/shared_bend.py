"""Bends that all spatial models of a flight share.

A plate of the plotter or the Earth bends the models of a flight alike: their heights
are off by

    dz = c₁ x² + c₂ x y + c₃ y²

of the position in the model. A lens displaces image points, and what relative
orientation does not take up of that bends models too. Neighbours tilt against each
other and overlap well; what shows it is a block that is bent as a whole, against
control or another flight. The coefficients border the normal equations as deformations
in plan do: with the columns D of the terms, and R that leads from observations to their
residuals v,

    (Dᵀ W R D) c = −Dᵀ W v,

and the errors of c follow from what errors of the observations make of Dᵀ W v.

Heights of another scale, as of a wrong principal distance, look in part like a bend:
where a scale shows beside it, no bend is believed.

See docs/theory/block_adjustment.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from einschalt.theory.block_adjustment.common_border import (
    UndeterminedTermsError,
    inverse_of_common,
    normals_of_common,
)
from einschalt.theory.block_adjustment.common_parameters import positions_in_model
from einschalt.theory.block_adjustment.model_deformation import (
    rms_in_model,
    without_plane,
)

# errors of measured heights, beyond which it is no bend of models that is found: where
# a block hardly determines it, other errors seem to be one of many times their size
MOST_OF_ERROR = 4.0
OF_HEIGHTS = ("dz:x2", "dz:xy", "dz:y2")
SCALE = "dz:z"


@dataclass(frozen=True, eq=False)
class BendTerms:
    """What the terms of each flight do to its models."""

    # (n_rows, 3, n_terms): displacement by a coefficient of 1 [model units]; 0 in rows
    # of other flights
    columns: np.ndarray
    flight: np.ndarray  # (n_terms,): of each term
    names: tuple[str, ...]  # of the terms
    # (n_rows, 2): in the model, about 1 at its edge; NaN of projection centres
    position: np.ndarray

    @property
    def is_scale(self):
        """Whether it is the scale of heights, (n_terms,)."""
        return np.array(self.names, dtype=object) == SCALE

    def of_flights(self, flights):
        """Bends of some of the flights."""
        is_of = np.isin(self.flight, flights) & ~self.is_scale
        names = tuple(np.array(self.names, dtype=object)[is_of])
        return BendTerms(
            self.columns[:, :, is_of], self.flight[is_of], names, self.position
        )


def bent_heights(position):
    """Displacement by each of the terms ``OF_HEIGHTS``, (n_points, 3, 3).

    ``position`` (n_points, 2) in the model; a coefficient is that of the edge.
    """
    x, y = position.T
    columns = np.zeros((len(position), 3, len(OF_HEIGHTS)))
    columns[:, 2] = np.column_stack([x * x, x * y, y * y])
    return columns


def scaled_heights(observations, is_ground):
    """Displacement by another scale of the heights of models, (n_rows, 3, 1).

    About the mean height of each model; a coefficient is the ratio.
    """
    z, model = observations.xyz[:, 2], observations.model
    sums, numbers = (
        np.bincount(model[is_ground], of, observations.n_models)
        for of in (z[is_ground], None)
    )
    columns = np.zeros((len(z), 3, 1))
    columns[:, 2, 0] = z - (sums / np.maximum(numbers, 1))[model]
    return columns


def positions_of_flights(observations, is_ground):
    """Position of each observation in its model, (n_rows, 2); NaN where no ground."""
    flight_of_row = observations.flight[observations.model]
    positions = np.full((len(flight_of_row), 2), np.nan)
    for flight in np.unique(observations.flight):
        rows = np.flatnonzero((flight_of_row == flight) & is_ground)
        xy, model = observations.xyz[rows, :2], observations.model[rows]
        positions[rows] = positions_in_model(xy, model)[0]
    return positions


@dataclass(frozen=True, eq=False)
class AnswerToBends:
    """What terms do to a block that has none, and what its residuals say of them."""

    on_ground: np.ndarray  # (n_rows, 3, n_terms): by a coefficient of 1 [m]
    normals: np.ndarray  # (n_terms, n_terms): Dᵀ W R D
    whole: np.ndarray  # (n_terms,): diagonal of Dᵀ W D
    weights: np.ndarray  # (n_rows, 3) [1/m²]
    # by a coefficient of 1 [m]: of points, and of what they miss models by
    heights: np.ndarray  # (n_points, n_terms)
    residuals: np.ndarray  # (n_rows, 3, n_terms)

    @classmethod
    def of(cls, solution, terms):
        """Of a SpatialSolution without any term."""
        given = solution.observations
        on_ground = solution.linear[given.model] @ terms.columns
        held = np.zeros((*given.control.shape, on_ground.shape[2]))
        points, residuals = solution.answer_to(on_ground, held)
        weights = given.standard_error**-2.0
        normals = normals_of_common(on_ground, weights, residuals)
        return cls(on_ground, *normals, weights, points[:, 2], residuals)

    def sums(self, residuals):
        """Dᵀ W v of residuals (n_rows, 3) or (n_rows, 3, n), shape (n_terms[, n])."""
        weighted = self.on_ground * self.weights[:, :, None]
        return np.tensordot(weighted, residuals, axes=((0, 1), (0, 1)))


@dataclass(frozen=True, eq=False)
class MadeByErrors:
    """What errors of the observations make of a block that has no bend."""

    sums: np.ndarray  # (n_terms, n_terms): covariance of Dᵀ W v
    unit_variance: float  # mean of Σ w v² over the redundancy


@dataclass(frozen=True, eq=False)
class BendTest:
    """Test of one flight for a bend that its models share."""

    flight: int
    n_terms: int
    # NaN where the block does not determine the bend, or one that no lens makes, or
    # heights have another scale, or no residuals are left
    f_statistic: float
    p_value: float
    # displacement of heights that no tilt takes up, over all points, in the middle and
    # at the edge of the models (RMS, on the ground) [m]
    size: float
    size_middle: float
    size_edge: float


def examine_bends(solution, terms, answer, made, significance):
    """Test the flights one after the other, the clearest first.

    Parameters
    ----------
    solution : SpatialSolution
        Without any of the terms.
    terms : BendTerms
    answer : AnswerToBends
    made : MadeByErrors
    significance : float
        Probability with which a flight without a bend seems to have one.

    Returns
    -------
    tests : list of BendTest
        In the order of the flights.
    found : list of int
        Flights to have terms: none, or all whose bends the block determines.

    Notes
    -----
    A bend of one flight bends the points, and with them the models of the others: so
    the clearest takes part where the others are tested. What bends one, a lens, a plate
    or the Earth, mostly bends the others too, though they may not show it: their terms
    cost little where they are not needed.
    """
    left, found, tests = sorted(set(terms.flight.tolist())), [], {}
    while left:
        now = {k: _test(solution, terms, answer, made, k, found) for k in left}
        tests.update(now)
        clearest = min(left, key=lambda k: np.nan_to_num(now[k].p_value, nan=1.0))
        if not now[clearest].p_value < significance:
            break
        left.remove(clearest)
        found.append(clearest)
    every = [tests[k] for k in sorted(tests)]
    return every, [t.flight for t in every if found and np.isfinite(t.p_value)]


def untested(terms):
    """Tests of all flights where no bend can be believed."""
    return [_untested(terms, flight) for flight in np.unique(terms.flight).tolist()]


def _untested(terms, flight):
    n_terms = np.count_nonzero((terms.flight == flight) & ~terms.is_scale)
    return BendTest(flight, int(n_terms), *[np.nan] * 5)


def _test(solution, terms, answer, made, flight, beside):
    """Test of one flight beside others that are bent."""
    is_bend = (terms.flight == flight) & ~terms.is_scale
    nothing = _untested(terms, flight)
    is_used = np.isin(terms.flight, [flight, *beside]) & ~terms.is_scale
    border = border_of(solution, answer, made, is_used)
    if border is None:
        return nothing
    own = is_bend[border.used]
    heights = answer.on_ground[:, 2, border.used[own]] @ border.found[own]
    of_row = solution.observations.flight[solution.observations.model]
    rows = (of_row == flight) & np.isfinite(terms.position[:, 0])
    position = terms.position[rows]
    sizes = rms_in_model(without_plane(heights[rows], position) ** 2, position)
    error = np.median(solution.observations.standard_error[rows, 2])
    if not sizes[2] <= MOST_OF_ERROR * error:
        return nothing
    tested = border.f_statistic(own), border.p_value(own)
    return BendTest(flight, int(own.sum()), *tested, *sizes)


@dataclass(frozen=True, eq=False)
class Border:
    """Terms of some flights, determined together."""

    used: np.ndarray  # (n,): of all terms
    found: np.ndarray  # (n,): coefficients
    covariance: np.ndarray  # (n, n): that errors of size 1 make
    redundancy: int
    variance: float  # of the residuals that are left, 1 as errors make them

    def f_statistic(self, which):
        """Size of some of the coefficients, True in ``which`` (n,)."""
        found, covariance = self.found[which], self.covariance[np.ix_(which, which)]
        away = found @ np.linalg.solve(covariance, found)
        return float(away / len(found) / self.variance)

    def p_value(self, which):
        """Probability that errors make coefficients as large."""
        f, n_terms = self.f_statistic(which), int(np.sum(which))
        return float(fdtrc(n_terms, self.redundancy, f))


def border_of(solution, answer, made, is_used):
    """Some of the terms, True in ``is_used``; None where they are not determined."""
    used = np.flatnonzero(is_used)
    square = np.ix_(used, used)
    try:
        cofactors = inverse_of_common(answer.normals[square], answer.whole[used])
    except UndeterminedTermsError:
        return None
    sums = answer.sums(solution.residuals)[used]
    found = -cofactors @ sums
    rest = solution.redundancy - len(used)
    left = solution.sum_of_squares + sums @ found
    if rest <= 0 or not left > 0.0:
        return None
    covariance = cofactors @ made.sums[square] @ cofactors
    return Border(used, found, covariance, rest, left / rest / made.unit_variance)
