"""Whether the models of a flight are deformed in the same way, and by how much.

Polynomials of the position in the model, common to a flight, are added as unknowns
(:mod:`einschalt.theory.block_adjustment.common_parameters`), and the fall of the sum of
squares is tested: F = ((Ω_0 − Ω_1)/k) / (Ω_1/(f − k)). What each model has for itself
no common term finds; it shows in residuals of neighbouring points that are alike.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from einschalt.foundations.kernels import compiled
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.common_border import UndeterminedTermsError
from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    CUBIC,
    QUADRATIC,
    CommonTerms,
    positions_in_model,
)

MIDDLE, EDGE = 0.35, 0.75  # of the half extent of a model
# observations for each common term, below which a flight is too small to tell
LEAST_ROWS = 3
# residuals that are less alike do no harm
LEAST_CORRELATION = 0.1
# standard errors, which chance passes once in a thousand times
BEYOND_CHANCE = 3.1


@dataclass(frozen=True, eq=False)
class DeformationTest:
    """Test of one flight for a deformation that its models share."""

    terms: CommonTerms  # that take it up
    # NaN where the flight is too small to tell, or no residuals are left
    f_statistic: float
    p_value: float
    # displacement that no affine transformation takes up, over all points, in the
    # middle and at the edge of the models (RMS, total, on the ground) [m]
    size: float
    size_middle: float
    size_edge: float

    @property
    def flight(self):
        """Number of the flight."""
        return self.terms.flight

    @property
    def n_terms(self):
        """Number of the terms."""
        return len(self.terms.names)


def examine_deformation(solution, flight) -> DeformationTest:
    """Test the models of a flight for a common deformation."""
    observations = solution.observations
    known = {t.flight: t.families for t in solution.terms}.get(flight, ())
    is_affine = observations.is_affine[observations.flight == flight].all()
    wanted = (QUADRATIC, CUBIC) if is_affine else (AFFINITY, QUADRATIC, CUBIC)
    added = tuple(family for family in wanted if family not in known)
    own = CommonTerms(flight, (*known, *added))
    rows = np.flatnonzero(observations.flight[observations.model] == flight)
    degrees = len(own.names) - len(CommonTerms(flight, known).names)
    rest = solution.redundancy - degrees
    nothing = DeformationTest(own, *[np.nan] * 5)
    if degrees == 0 or rest <= 0 or len(rows) < LEAST_ROWS * degrees:
        return nothing
    others = tuple(t for t in solution.terms if t.flight != flight)
    try:
        # its sum of squares is least: it changes by the square of what is left
        terms = (*others, own)
        larger = adjust(observations, terms, solution.ordering, is_rough=True)
    except UndeterminedTermsError:  # the points of the models cannot tell terms apart
        return nothing
    if not larger.sum_of_squares > 0.0:
        return nothing
    fall = (solution.sum_of_squares - larger.sum_of_squares) / degrees
    f = max(fall, 0.0) / (larger.sum_of_squares / rest)
    sizes = _sizes(larger, flight, rows)
    return DeformationTest(own, float(f), float(fdtrc(degrees, rest, f)), *sizes)


def _sizes(solution, flight, rows):
    """RMS of the modelled displacement over all points, in the middle, at the edge."""
    observations, deformation = solution.observations, solution.deformation
    is_own = np.array(deformation.flight) == flight
    moved = deformation.columns[rows][:, :, is_own] @ solution.common[is_own]
    position, _ = positions_in_model(observations.xy[rows], observations.model[rows])
    moved = without_plane(moved, position)
    linear = solution.affinities[observations.model[rows]][:, :, 1:]
    squares = (np.einsum("nij,nj->ni", linear, moved) ** 2).sum(axis=1)
    return rms_in_model(squares, position)


def without_plane(moved, position):
    """What no plane over the models takes up of displacements of their points."""
    design = np.column_stack([np.ones(len(position)), position])
    return moved - design @ np.linalg.lstsq(design, moved)[0]


def rms_in_model(squares, position):
    """Root mean square over all points, in the middle and at the edge of the models."""
    away = np.abs(position).max(axis=1)
    return tuple(
        float(np.sqrt(np.mean(squares[part]))) if part.any() else np.nan
        for part in (away >= 0.0, away < MIDDLE, away > EDGE)
    )


@dataclass(frozen=True)
class Likeness:
    """How alike residuals of neighbouring points in a model are."""

    # of the residuals of each point with those of its nearest neighbour; somewhat below
    # 0 where errors are independent. NaN without residuals
    correlation: float
    standard_error: float  # where the errors are independent

    @property
    def is_large(self):
        """Whether chance does not explain it, and it is worth a word."""
        least = max(LEAST_CORRELATION, BEYOND_CHANCE * self.standard_error)
        return bool(self.correlation > least)


def neighbour_autocorrelation(solution, flight) -> Likeness:
    """Correlate the residuals of every point with those of its nearest neighbour."""
    observations = solution.observations
    rows = np.flatnonzero(observations.flight[observations.model] == flight)
    model = observations.model[rows]
    start = np.concatenate([[0], np.flatnonzero(np.diff(model)) + 1, [len(rows)]])
    neighbour = _nearest(np.ascontiguousarray(observations.xy[rows]), start)
    v = solution.residuals[rows] / observations.standard_error[rows, None]
    is_used = neighbour >= 0
    squares = (v**2).sum(axis=1)
    scale = squares[is_used].sum()
    if not scale > 0.0:
        return Likeness(np.nan, np.nan)
    product = (v[is_used] * v[neighbour[is_used]]).sum()
    used = np.flatnonzero(is_used)
    # two that are the nearest of each other say the same twice
    n_alike = np.count_nonzero(neighbour[neighbour[used]] == used)
    error = np.sqrt(0.5 * (used.size + n_alike)) / used.size
    return Likeness(float(product / scale), float(error))


@compiled
def _nearest(xy, start):
    """Nearest other point of the same model; −1 where there is none."""
    nearest = np.empty(len(xy), dtype=np.int64)
    nearest[:] = -1
    for m in range(start.size - 1):
        for i in range(start[m], start[m + 1]):
            least = np.inf
            for j in range(start[m], start[m + 1]):
                d = (xy[i, 0] - xy[j, 0]) ** 2 + (xy[i, 1] - xy[j, 1]) ** 2
                if j != i and d < least:
                    least = d
                    nearest[i] = j
    return nearest
