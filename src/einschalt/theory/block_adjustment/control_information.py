"""What the models of all flights, adjusted together, know of the control points.

Every value of a point in a model is D θ, with the parameters θ of the model; the point
itself stands between its values. Eliminating the points leaves the normal equations of
the models, and these tell how far every control point is from where the rest has it.
Everything is linear about the values that are there already; one complex number stands
for easting and northing where the transformations allow it. Terms that all models of a
flight share are few, and border these equations.

Source: partitioned normal equations of an adjustment of independent models; see
docs/theory/systematic_patterns.md.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.linalg import block_diag

from einschalt.foundations.batches import segment_sum, sum_by_group
from einschalt.foundations.sparse_cholesky.multifrontal import Factor, factorize
from einschalt.theory.block_adjustment.model_graph import incidence_of
from einschalt.theory.block_adjustment.point_elimination import (
    PointSystem,
    assemble,
    invert_point_blocks,
)
from einschalt.theory.block_adjustment.solver import order_placed

# weight of "no correction" for each parameter of a model, against its diagonal: models
# that hang on nothing stay where they are
RIDGE = 1e-9
# times what it makes of a shift of everything: that much of it may look like a check
MOST_OF_RIDGE = 20.0
# times what errors of measurement in the design make of a linear field: likewise; and
# how much of what is known of a point may be taken for that
MOST_OF_ERRORS, LARGEST_NOISE = 20.0, 1e-4
# of the best known sum of terms: less is left by rounding
LEAST_OF_TERMS = 1e-9
AT_ONCE = 256  # right sides: more would take much memory


@dataclass(frozen=True, eq=False)
class ModelValues:
    """Values of points in models."""

    # (n_values, n_parameters): D of each value, with columns of about unit size;
    # complex where it must be
    design: np.ndarray
    model: np.ndarray  # (n_values,)
    point: np.ndarray  # (n_values,)
    # complex (n_values,): easting + i northing, from any place near all points [m]
    value: np.ndarray
    weight: np.ndarray  # (n_values,), 1 / σ² of one coordinate [1/m²]
    # (n_values, n_bent): what deformations that each model has for itself do, by
    # coefficients of variance 1 in each axis [m]
    bent: np.ndarray
    # complex (n_values, n_common): displacement by terms that all of them share, whose
    # complex coefficients are of variance 1 in each axis, if there are such terms [m]
    common: np.ndarray


@dataclass(frozen=True, eq=False)
class ControlValues:
    """Given coordinates of control points."""

    point: np.ndarray  # (n,): which point each is; none twice
    value: np.ndarray  # complex (n,): as in ModelValues [m]
    weight: np.ndarray  # (n,), 1 / σ² of one coordinate [1/m²]


@dataclass(frozen=True, eq=False)
class CommonTermsFound:
    """What the adjustment of everything knows of terms that models share.

    As of errors of control: the weighted sums of what is left, and their covariances.
    """

    scores: np.ndarray  # complex (n_common,)
    information: np.ndarray  # complex (n_common, n_common)
    with_control: np.ndarray  # complex (n_control, n_common)

    @cached_property
    def covariance(self):
        """Covariance of the terms, of either part, (n_common, n_common)."""
        return np.linalg.pinv(self.information, LEAST_OF_TERMS, hermitian=True)

    @cached_property
    def coefficients(self):
        """The terms as they are estimated, complex (n_common,)."""
        return self.covariance @ self.scores

    def only(self, some):
        """The same of some terms, (n_common,), the others being 0."""
        return CommonTermsFound(
            self.scores[some],
            self.information[np.ix_(some, some)],
            self.with_control[:, some],
        )

    def square_of(self, some):
        """χ² of some of the coefficients, a slice: two degrees of freedom for each."""
        own = self.coefficients[some]
        covariance = self.covariance[some, some]
        information = np.linalg.pinv(covariance, LEAST_OF_TERMS, hermitian=True)
        return float(np.real(own.conj() @ information @ own))

    @property
    def likelihood_ratio(self):
        """Twice the logarithm: of terms of variance 1 against none."""
        values, vectors = np.linalg.eigh(self.information)
        squares = np.abs(vectors.conj().T @ self.scores) ** 2
        variance = 1.0 + np.maximum(values, 0.0)
        return float(np.sum(squares / variance - 2.0 * np.log(variance)))

    def set_free(self, scores, information):
        """Scores (n,) and information (n, n) of control, whatever the terms are."""
        scores = scores - self.with_control @ self.coefficients
        taken = self.with_control @ self.covariance @ self.with_control.conj().T
        return scores, information - np.real(taken)


@dataclass(frozen=True, eq=False)
class ControlChecks:
    """What the adjustment of everything knows of control, not written out."""

    is_held: np.ndarray  # (n_control,): whether any model holds it
    own: np.ndarray  # (n_control,): what of the information is on its diagonal only
    # complex (n_control,): weight times correction of each control point [1/m]
    scores: np.ndarray
    pull: sparse.csc_array  # of control on the models, (n_unknowns, n_control)
    weight: np.ndarray  # (n_control,) [1/m²]
    place: np.ndarray  # (n_control,): which point of the system each is, −1 for none
    system: PointSystem
    factor: Factor
    # information that the ridge, and errors in the design, may make of a shift or a
    # strain of everything, which nothing checks [1/m²]
    noise: float
    common: CommonTermsFound

    def written_out(self, free=None):
        """Scores of control points, and the information that checks them.

        Without directions of which hardly anything is known.

        Parameters
        ----------
        free : CommonTermsFound, optional
            Terms that models share which may have any size.

        Returns
        -------
        scores : ndarray of complex, shape (n_control,)
            Weight times correction of each control point in the adjustment of
            everything [1/m]. Without gross or systematic errors their covariance is the
            information, for either coordinate.
        information : ndarray, shape (n_control, n_control)
            W = P - P Q P [1/m²], Q being the cofactors of the adjusted control points.
            The real part where transformations are complex.
        """
        scores, information = self.scores, self._information
        if free is not None:
            scores, information = free.set_free(scores, information)
        return _checked(scores, information, self.noise)

    @cached_property
    def _information(self):
        taken = _answers(self.factor, self.pull, self.pull)
        return np.diag(self.own) - np.real(taken)

    def draw(self, n_draws, seed):
        """Draw scores of errors of the given sizes, (n_control, n_draws) [1/m].

        Complex, with errors of both coordinates, where these show in each other.
        """
        rng, system = np.random.default_rng(seed), self.system
        incidence, weight = system.incidence, system.weights[:, :1]
        shape = (len(weight), n_draws)
        errors = _normal(rng, shape, self.factor.panels.dtype) / np.sqrt(weight)
        weighted = (weight * errors)[incidence.rows]
        sums = segment_sum(weighted, incidence.point_start)
        total = np.bincount(incidence.point, weight[:, 0])
        mean = sums / total[:, None]
        given = _normal(rng, (len(self.weight), n_draws), errors.dtype)
        closed = given / np.sqrt(self.weight)[:, None] - mean[self.place]
        closed[~self.is_held] = 0.0
        gradient = system.gradient((errors - mean[incidence.point])[:, None, :])
        asked = gradient - (self.pull @ closed).reshape(gradient.shape)
        moved = self.factor.solve(asked).reshape(-1, n_draws)
        return self.own[:, None] * closed + self.pull.conj().T @ moved

    def times(self, columns):
        """Information times columns, (n_control, n_columns), dense or sparse."""
        if np.iscomplexobj(columns) and not np.iscomplexobj(self.pull):
            return self.times(columns.real) + 1j * self.times(columns.imag)
        through = _answers(self.factor, self.pull, self.pull @ columns)
        columns = columns.toarray() if sparse.issparse(columns) else columns
        return self.own[:, None] * columns - through


def control_checks(flights, control) -> ControlChecks:
    """Adjust everything, for what that knows of control.

    Parameters
    ----------
    flights : sequence of ModelValues
        Their models are counted apart, and so are common terms; their points together.
    control : ControlValues
    """
    values = _joined(flights)
    n_points = 1 + int(max(values.point.max(), control.point.max()))
    ordering = _ordering_of(values, n_points)
    incidence = ordering.reordered.incidence
    rows, points = ordering.reordered.rows, ordering.reordered.points
    place = np.full(n_points, -1)
    place[points] = np.arange(incidence.n_points)
    place = place[control.point]
    is_held = place >= 0
    given = np.zeros((incidence.n_points, 1, 1))
    given[place[is_held], 0, 0] = control.weight[is_held]
    design = np.hstack([values.design, values.bent])[rows]
    system = _system(incidence, design, values.weight[rows], given)
    columns = np.column_stack([values.value, values.common])[rows]
    offset, closed = _about_means(columns, system, place, control.value)
    factor = _factor(system, ordering, values.bent.shape[1])
    # no model holds the others: they are where they are given
    part = np.ones(len(place))
    part[is_held] = (system.inverse * given)[place[is_held], 0, 0]
    pull = _pull(system, place, part)
    own = control.weight * (1.0 - part)
    asked = _gradient(system, offset)
    scores, common = _known(
        factor, (asked, pull), (offset, system.weights), (closed, own)
    )
    ridge = RIDGE * system.weights.sum() / max(np.count_nonzero(is_held), 1)
    return ControlChecks(
        is_held=is_held,
        own=own,
        scores=scores,
        pull=pull,
        weight=control.weight,
        place=place,
        system=system,
        factor=factor,
        noise=max(MOST_OF_RIDGE * ridge, _noise_of_design(len(rows), control)),
        common=common,
    )


def _about_means(columns, system, place, control):
    """Columns of all values, and of control, less the means of the values of a point.

    About its mean a point asks nothing of the models. The first column is that of the
    coordinates, the others are displacements, which control does not have.
    """
    incidence, is_held = system.incidence, place >= 0
    total = np.bincount(incidence.point, system.weights[:, 0])[:, None]
    centre = sum_by_group(incidence.point, system.weights * columns) / total
    closed = np.zeros((len(place), columns.shape[1]), dtype=complex)
    closed[is_held] = -centre[place[is_held]]
    closed[is_held, 0] += control[is_held]
    return columns - centre[incidence.point], closed


def _known(factor, asked, offsets, closed):
    """Scores of control by the values, which are the first of all columns, and terms.

    ``asked`` is that of the models, and the pull of control on them; ``offsets`` are
    those of the values from the means of their points, with weights, ``closed`` those
    of control.
    """
    (asked, pull), (offset, weight), (closed, own) = asked, offsets, closed
    asked = asked - pull @ closed
    moved = _solved(factor, asked)
    left = offset.conj().T @ (weight * offset)
    left += closed.conj().T @ (own[:, None] * closed) - asked.conj().T @ moved
    with_control = own[:, None] * closed + pull.conj().T @ moved
    terms = CommonTermsFound(left[1:, 0], left[1:, 1:], with_control[:, 1:])
    return with_control[:, 0], terms


def _noise_of_design(n_values, control):
    """Information that errors of measurement make of a linear field [1/m²].

    Models follow such a field but for the errors of the coordinates that stand in their
    design. These are in their residuals as well, so that it would look significant: a
    misfit of kilometres, where nothing is known of it. Along the shorter extent of
    control; each value has an error as it was stated.
    """
    offset = control.value - control.value.mean()
    scatter = np.cov(offset.real, offset.imag, bias=True) * len(offset)
    largest = LARGEST_NOISE * np.median(control.weight)
    shortest = np.linalg.eigvalsh(scatter)[0]
    if not shortest > 0.0:
        return largest
    return min(MOST_OF_ERRORS * n_values / shortest, largest)


def _normal(rng, shape, dtype):
    """Draw normal numbers of variance 1, in both parts of complex ones."""
    if np.issubdtype(dtype, np.complexfloating):
        return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    return rng.standard_normal(shape)


def _checked(scores, information, least):
    """Scores (n,) and information (n, n) without directions that hardly have any.

    Those of at most ``least`` [1/m²] are left out. What moves everything alike is held
    by nothing but the ridge: where models have many points and control few, that would
    look like a check, which the block fails.
    """
    values, vectors = np.linalg.eigh((information + information.T) / 2.0)
    is_checked = values > least
    if is_checked.all():
        return scores, information
    kept = vectors[:, is_checked]
    return kept @ (kept.T @ scores), (kept * values[is_checked]) @ kept.T


def _joined(flights):
    """Values of all flights, sorted by model; a model that lacks a column has 0."""
    n_columns = max(flight.design.shape[1] for flight in flights)
    designs, models, before = [], [], 0
    for flight in flights:
        lacking = n_columns - flight.design.shape[1]
        designs.append(np.pad(flight.design, ((0, 0), (0, lacking))))
        models.append(flight.model + before)
        before += 1 + int(flight.model.max())
    model = np.concatenate(models)
    order = np.argsort(model, kind="stable")
    return ModelValues(
        np.concatenate(designs)[order],
        model[order],
        np.concatenate([flight.point for flight in flights])[order],
        np.concatenate([flight.value for flight in flights])[order],
        np.concatenate([flight.weight for flight in flights])[order],
        np.concatenate([flight.bent for flight in flights])[order],
        block_diag(*(flight.common for flight in flights))[order],
    )


def _ordering_of(values, n_points):
    """Order of elimination of models that lie where their values are."""
    incidence = incidence_of(
        values.model, values.point, 1 + int(values.model[-1]), n_points
    )
    middle = sum_by_group(values.model, values.value) / np.bincount(values.model)
    positions = np.column_stack([middle.real, middle.imag])
    n_real = values.design.shape[1] * (1 + np.iscomplexobj(values.design))
    return order_placed(incidence, lambda: positions, n_real)


def _system(incidence, design, weight, given):
    """Observations of the models, and the weights of given points."""
    weight, is_fixed = weight[:, None], np.zeros(incidence.n_points, dtype=bool)
    inverse = invert_point_blocks(incidence, weight, given, is_fixed)
    return PointSystem(incidence, design[:, None, :], weight, given, is_fixed, inverse)


def _factor(system, ordering, n_bent):
    """Factor of the normal equations of the models."""
    blocks = assemble(system, ordering.pattern)
    squares = system.weights * np.abs(system.design[:, 0, :]) ** 2
    own = np.add.reduceat(squares, system.incidence.model_start[:-1], axis=0)
    unknown = np.arange(system.n_unknowns)
    # a column that a model lacks stands alone
    ridge = np.where(own > 0.0, RIDGE * own, 1.0)
    # what bends models is 0 before it is observed, with variance 1
    ridge[:, len(unknown) - n_bent :] = 1.0
    blocks[ordering.pattern.start[:-1, None], unknown, unknown] += ridge
    return factorize(blocks, ordering.pattern, ordering.fronts)


def _pull(system, place, part):
    """What each control point asks of the models: sparse, (n_unknowns, n_control)."""
    incidence, design = system.incidence, system.design[:, 0, :]
    control = np.full(incidence.n_points, -1)
    control[place[place >= 0]] = np.flatnonzero(place >= 0)
    control = control[incidence.point]
    at = np.flatnonzero(control >= 0)
    n_each = design.shape[1]
    share = system.weights[at, 0] * part[control[at]]
    rows = incidence.model[at, None] * n_each + np.arange(n_each)
    entries = (design[at].conj() * share[:, None]).ravel()
    shape = (incidence.n_models * n_each, len(place))
    return sparse.csc_array(
        (entries, (rows.ravel(), control[at].repeat(n_each))), shape=shape
    )


def _answers(factor, pull, asked):
    """Pullᴴ N⁻¹ of what is asked of the models, a few columns at a time."""
    shape = (*factor.is_held.shape, -1)
    answers = []
    for first in range(0, asked.shape[1], AT_ONCE):
        some = asked[:, first : first + AT_ONCE]
        some = some.toarray() if sparse.issparse(some) else some
        solved = factor.solve(some.reshape(shape)).reshape(some.shape)
        answers.append(pull.conj().T @ solved)
    return np.hstack(answers)


def _gradient(system, offset):
    """What complex offsets of all values ask of the models, (n_unknowns, n_columns)."""
    parts = _parts(offset, system.design)
    gradient = [system.gradient(part[:, None, :]) for part in parts]
    return _whole([part.reshape(-1, offset.shape[1]) for part in gradient])


def _solved(factor, asked):
    """Unknowns of the models that (n_unknowns, n_columns) ask for."""
    shape = (*factor.is_held.shape, -1)
    parts = _parts(asked, factor.panels)
    return _whole(
        [factor.solve(part.reshape(shape)).reshape(asked.shape) for part in parts]
    )


def _parts(columns, like):
    """Complex columns as they are, or both parts where a system is real."""
    if np.iscomplexobj(like):
        return [columns]
    # kernels would be compiled once more for parts that are not contiguous
    return [np.ascontiguousarray(part) for part in (columns.real, columns.imag)]


def _whole(parts):
    return parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]


def with_shared_errors(scores, information, shared):
    """Scores and their covariance where control errors have more in common.

    The estimated errors W⁻¹u of control have the covariance W⁻¹ + Δ then, with what is
    ``shared`` (n, n) of either coordinate beside the errors that each point has for
    itself: u′ = (I + WΔ)⁻¹ u, W′ = (I + WΔ)⁻¹ W.
    """
    solve = np.eye(len(information)) + information @ shared
    new = np.linalg.solve(solve, np.column_stack([scores, information]))
    information = new[:, scores.shape[1] :]
    return new[:, : scores.shape[1]], (information + information.T) / 2.0
