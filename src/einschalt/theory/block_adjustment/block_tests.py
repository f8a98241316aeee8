"""Which observations of an adjusted block contradict the others.

All d coordinates of a point are tested together: T = vᵀ Q_vv⁻¹ v, by which the sum of
squares Ω falls when the point is left out. T/Ω is beta distributed; in the plane that
is p = (1 − T/Ω)^((f − 2)/2) as in :mod:`einschalt.theory.adjustment.reliability`, with
the redundancy f of the block.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import betaincc, chdtri, fdtrc

# share of an error that has to show before an observation is checked. Measured
# coordinates stand in the design matrix, errors and all: shrunk to nothing the block
# would have no residuals. So it pulls at the least control, which nothing checks, as if
# redundancy numbers were f σ²/d², with its redundancy f and the size d of the control
LEAST_CHECK = 1e-4
CLEARLY = 10.0  # times that


@dataclass(frozen=True, eq=False)
class BlockTests:
    """Joint tests of all coordinates of a point."""

    w: np.ndarray  # (n,): √T / s_0
    # (n,): probability of a w as large as this without a gross error
    p_value: np.ndarray
    # (n, d): gross error of the measured or given point that explains its residual best
    # [m]
    error: np.ndarray


@dataclass(frozen=True, eq=False)
class DrawnCovariance:
    """Covariance of residuals, from draws of all errors."""

    covariance: np.ndarray  # (n_rows, d, d) [m²]
    n_draws: int

    @cached_property
    def weights(self):
        """Inverse of each covariance, (n_rows, d, d): for all tests of a search.

        NaN where there is none, as of a residual that cannot arise.
        """
        is_regular = np.linalg.det(self.covariance) > 0.0
        weights = np.full(self.covariance.shape, np.nan)
        weights[is_regular] = np.linalg.inv(self.covariance[is_regular])
        return weights


def judge_observations(solution, given) -> BlockTests:
    """Test all measured points of all models.

    Parameters
    ----------
    solution : AdjustedBlock
    given : BlockObservations
        The same with the standard errors that the observations have; those of the
        solution are larger where an observation was taken out or weighs less.

    Returns
    -------
    BlockTests
        NaN where nothing checks an observation.

    Notes
    -----
    With R = I − A Q Aᵀ P of the weights that were used, residuals have the cofactors
    σ² R Rᵀ + R A Q Aᵀ: σ² R where they weigh as they should, and σ² I + A Q Aᵀ where
    they were taken out.
    """
    n_rows, d = solution.residuals.shape
    used, variance = (
        o.standard_error.reshape(n_rows, 1, -1) ** 2
        for o in (solution.observations, given)
    )
    adjusted = solution.adjusted_cofactors
    redundancy = np.eye(d) - adjusted / used
    turned = np.swapaxes(redundancy, 1, 2)
    cofactors = (redundancy * variance) @ turned + redundancy @ adjusted
    found = _tests(solution, solution.residuals, cofactors, redundancy)
    # residuals are transformed less adjusted: errors of the model go along with them
    return BlockTests(found.w, found.p_value, -found.error)


def judge_by_covariance(solution, known, drawn, group, is_in) -> BlockTests:
    """Test measured points whose residuals have covariances that were drawn.

    Parameters
    ----------
    solution : AdjustedBlock
    known : BlockTests
        Of the same observations, taken for independent: what is checked at all.
    drawn : DrawnCovariance
        Of the residuals.
    group : ndarray of int, shape (n_rows,)
        Observations whose errors are too large or too small by one factor.
    is_in : ndarray of bool, shape (n_rows,)
        Observations that tell this factor.

    Notes
    -----
    T = vᵀ C⁻¹ v over its mean s² in the group, which has f degrees of freedom. Were s²
    known, C drawn n times would leave T (n − d + 1)/(n d) with the F distribution
    (Hotelling 1931); the χ² of the same probability over f is beta distributed.
    """
    n_draws, d = drawn.n_draws, drawn.covariance.shape[1]
    is_checked = np.isfinite(known.p_value)
    v = solution.residuals[is_checked]
    square = np.full(len(is_checked), np.nan)
    square[is_checked] = np.einsum("na,nab,nb->n", v, drawn.weights[is_checked], v)
    is_told, n_groups = is_checked & is_in, int(group.max(initial=-1)) + 1
    own, among = square[is_told], group[is_told]
    share = np.clip(1.0 - solution.leverage[is_told], 0.0, 1.0).sum(axis=1)
    free = np.bincount(among, share, n_groups)[group]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.bincount(among, own, n_groups) / np.bincount(among, None, n_groups)
        square *= d / mean[group]
    left = n_draws - d + 1
    alone = chdtri(d, fdtrc(d, left, square * left / (n_draws * d)))
    freedom = np.maximum(free, d + 1.0)
    share = np.minimum(alone / freedom, 1.0)
    p_value = betaincc(d / 2.0, (freedom - d) / 2.0, share)
    return BlockTests(np.sqrt(square), p_value, known.error)


def judge_control(solution) -> BlockTests:
    """Test the given coordinates of all points.

    Row for row as the points; NaN where a point is no control, or is held. Control
    without heights is tested in plan.
    """
    observations = solution.observations
    is_observed = observations.is_control & ~observations.is_fixed
    n_given = observations.is_given.sum(axis=1)
    least = max(LEAST_CHECK, CLEARLY * _pull(observations, solution))
    tests = BlockTests(
        np.full(len(n_given), np.nan),
        np.full(len(n_given), np.nan),
        np.full(observations.control.shape, np.nan),
    )
    for d in np.unique(n_given[is_observed]):
        some = np.flatnonzero(is_observed & (n_given == d))
        found = _tests_of_given(solution, some, d, least)
        tests.w[some], tests.p_value[some] = found.w, found.p_value
        tests.error[some, :d] = found.error
    return tests


def _tests_of_given(solution, some, d, least):
    """Tests of the first d coordinates of some points."""
    observations = solution.observations
    given = observations.control_covariance[some, :d, :d]
    adjusted = solution.point_cofactors[some, :d, :d]
    weight = observations.control_weight[some, :d, :d]
    redundancy = np.eye(d) - adjusted @ weight
    residuals = solution.control_residuals[some, :d]
    return _tests(solution, residuals, given - adjusted, redundancy, least)


def _tests(solution, residuals, cofactors, redundancy, least=LEAST_CHECK):
    """Tests of residuals v with cofactors Q_vv.

    A gross error ∇ of a given value leaves adjusted minus given −R ∇, so that it is
    estimated by −R⁻¹ v.
    """
    d = residuals.shape[1]
    is_checked = _least_share(redundancy) > least
    which = is_checked[:, None, None]
    v = residuals[:, :, None]
    error = -np.linalg.solve(np.where(which, redundancy, np.eye(d)), v)[:, :, 0]
    weighted = np.linalg.solve(np.where(which, cofactors, np.eye(d)), v)[:, :, 0]
    square = np.sum(residuals * weighted, axis=1)
    square = np.where(is_checked & (square >= 0.0), square, np.nan)
    error = np.where(is_checked[:, None], error, np.nan)
    f, omega = solution.redundancy, solution.sum_of_squares
    if f <= d or omega <= 0.0:
        return BlockTests(np.full(len(square), np.nan), square * np.nan, error)
    share = np.minimum(square / omega, 1.0)
    # the share is beta distributed: (1 − T/Ω)^((f − 2)/2) for two coordinates
    p_value = betaincc(d / 2.0, (f - d) / 2.0, share)
    return BlockTests(np.sqrt(square) / solution.s_0, p_value, error)


def _least_share(redundancy):
    """About the least eigenvalue, where all are shares between 0 and 1.

    The determinant over what the others would be if all were equal: exact then, and
    too small by 2^(d - 1) at most.
    """
    d = redundancy.shape[1]
    mean = np.trace(redundancy, axis1=1, axis2=2) / d
    others = np.where(mean > 0.0, mean, np.inf) ** (d - 1)
    return np.linalg.det(redundancy) / others


def _pull(observations, solution):
    """Redundancy number of the least control that errors in the design feign."""
    is_observed = observations.is_control & ~observations.is_fixed
    if not is_observed.any():
        return 0.0
    weight = observations.control_weight[is_observed]
    n_given = observations.is_given[is_observed].sum(axis=1)
    weight = np.trace(weight, axis1=1, axis2=2) / n_given
    plan = solution.points[is_observed, :2]
    plan = plan - np.average(plan, axis=0, weights=weight)
    least, greatest = np.linalg.eigvalsh((plan.T * weight) @ plan)
    # one direction gives a similarity transformation its scale in the other too
    is_affine = getattr(observations, "is_affine", np.zeros(1, dtype=bool))
    hold = least if is_affine.all() else least + greatest
    return 0.5 * solution.redundancy / hold if hold > 0.0 else 0.0
