"""How far an observation is checked by the others, and which of them fail the check.

Residuals are adjusted less observed, so that an error ∇ of an observation shows itself
as −r ∇. All functions take the points of all models at once.

Sources: Baarda 1968 (w-test, minimal detectable bias), Pope 1976 (τ); see
docs/theory/reliability.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, chndtrinc, stdtr

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE

# below it a point alone fixes its model: nothing of it is left in its residual
LEAST_REDUNDANCY_NUMBER = 1e-9
AXES_OF_A_POINT = 2
MOST_FACTORS = 10_000  # of a power: their roundings stay below 1e-12


def redundancy_numbers(leverage):
    """Redundancy number r = 1 − h of each observed coordinate.

    Their sum is the redundancy of the adjustment; an error of an observation shows
    itself in its residual with the factor −r.

    Parameters
    ----------
    leverage : ndarray
        Diagonal of the hat matrix.

    Returns
    -------
    ndarray
        Never below zero: where h is 1 up to rounding, r is 0.
    """
    return np.maximum(1.0 - np.asarray(leverage), 0.0)


def standardized_residuals(residuals, redundancy_number, sigma):
    """Residuals over their own standard errors: v / (σ √r).

    With σ known before they are Baarda's w, standard normal; with s_0 of the same
    adjustment they are Pope's τ, which cannot exceed √redundancy.

    Parameters
    ----------
    residuals, redundancy_number : ndarray
        Of one shape.
    sigma : float or ndarray
        Standard error of the observation itself, s_0 / √weight.

    Returns
    -------
    ndarray
        NaN where an observation is not checked at all.
    """
    r = np.asarray(redundancy_number, dtype=float)
    is_checked = r > LEAST_REDUNDANCY_NUMBER
    root = np.sqrt(np.where(is_checked, r, np.nan))
    return residuals / (sigma * root)


def external_t(tau, redundancy):
    """Student's t of an observation against the adjustment without it.

    τ √((f − 1) / (f − τ²)) with Pope's τ and the redundancy f with the observation: of
    f − 1 degrees of freedom; NaN where f ≤ 1.
    """
    tau, f = np.asarray(tau, dtype=float), np.asarray(redundancy, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = tau * np.sqrt((f - 1.0) / np.maximum(f - tau**2, 0.0))
    return np.where(f > 1.0, t, np.nan)


def tau_p_value(tau, redundancy):
    """Two-sided probability of a τ as large as this without a gross error."""
    degrees = np.asarray(redundancy, dtype=float) - 1.0
    t = external_t(tau, redundancy)
    return 2.0 * stdtr(np.where(degrees > 0.0, degrees, np.nan), -np.abs(t))


def prediction_p_value(squares, sum_of_squares, redundancy):
    """Two-sided probability of what one coordinate misses its prediction by.

    ``squares`` are its square over the cofactor of the difference, ``sum_of_squares``
    and ``redundancy`` those of the adjustment that predicts it without having it:
    Student's t. NaN where that has no redundancy.
    """
    f = np.asarray(redundancy, dtype=float)
    is_testable = (f > 0.0) & (np.asarray(sum_of_squares) > 0.0)
    f = np.where(is_testable, f, np.nan)
    omega = np.where(is_testable, sum_of_squares, np.nan)
    return 2.0 * stdtr(f, -np.sqrt(squares / omega * f))


@dataclass(frozen=True, eq=False)
class FittedPoints:
    """What the joint test needs of the points of all models, sorted by model."""

    residuals: np.ndarray  # (n_points, 2): easting, northing [m]
    weights: np.ndarray  # (n_points,)
    leverage: np.ndarray  # (n_points, 2)
    # (n_points,): off-diagonal element of each point's block of the hat matrix; 0 for
    # affine and helmert
    cross_leverage: np.ndarray
    start: np.ndarray  # (n_models + 1,)


@dataclass(frozen=True, eq=False)
class PointTests:
    """Joint tests of both coordinates of each point."""

    # (n_points,): √(w_E² + w_N²), or √(vᵀ Q_vv⁻¹ v) / s_0 where the two are correlated
    w: np.ndarray
    # (n_points,): probability of a w as large as this without a gross error
    p_value: np.ndarray


def joint_point_tests(points, sum_of_squares, redundancy) -> PointTests:
    """Test both coordinates of each point together, σ being taken from the model.

    Without point i the sum of squares Ω falls by T = vᵀ Q_vv⁻¹ v, for affine and
    helmert w (v_E² + v_N²) / (1 − h). T / Ω has a beta distribution whose first
    parameter is 1, so that its tail is closed: p = (1 − T/Ω)^((f − 2) / 2). It is the
    F test of the model with and without the point.

    Parameters
    ----------
    points : FittedPoints
    sum_of_squares : ndarray, shape (n_models,)
        Ω = Σ w |v|² [m²].
    redundancy : ndarray, shape (n_models,)
        f of each model.

    Returns
    -------
    PointTests
        NaN where f ≤ 2, where a point is not checked by others, and where all
        residuals of the model vanish.
    """
    w, p_value = np.empty(len(points.weights)), np.empty(len(points.weights))
    over_segments(
        _test_jointly,
        points.start,
        np.ascontiguousarray(points.residuals, dtype=float),
        np.ascontiguousarray(points.weights, dtype=float),
        # of one layout, and writable: for each other one it would be compiled again
        np.array(points.leverage, dtype=float, order="C"),
        points.cross_leverage,
        np.ascontiguousarray(sum_of_squares, dtype=float),
        np.ascontiguousarray(redundancy, dtype=float),
        w,
        p_value,
    )
    return PointTests(w, p_value)


@compiled(error_model="numpy")
def _test_jointly(first, last, start, v, weights, h, cross, omega, f, w, p):
    for k in range(first, last):
        is_testable = f[k] > AXES_OF_A_POINT and omega[k] > 0.0
        degrees = f[k] - AXES_OF_A_POINT
        is_whole = degrees == np.floor(degrees) and degrees < MOST_FACTORS
        for i in range(start[k], start[k + 1]):
            r_e, r_n, c = 1.0 - h[i, 0], 1.0 - h[i, 1], cross[i]
            determinant = r_e * r_n - c * c
            least = min(r_e, r_n)
            if not (is_testable and least > LEAST_REDUNDANCY_NUMBER):
                w[i] = p[i] = np.nan
                continue
            e, n = v[i, 0], v[i, 1]
            form = r_n * e * e + r_e * n * n + 2.0 * c * e * n
            share = weights[i] * form / determinant / omega[k]
            w[i] = np.sqrt(share * f[k])
            rest = max(1.0 - share, 0.0)
            p[i] = (
                _whole_power(np.sqrt(rest), int(degrees))
                if is_whole
                else rest ** (0.5 * degrees)
            )


@compiled
def _whole_power(base, exponent):
    """Power by squares, of an exponent from 0 on: quicker than with any exponent."""
    power = 1.0
    while exponent > 0:
        if exponent & 1:
            power *= base
        base *= base
        exponent >>= 1
    return power


def joint_prediction_tests(squares, sum_of_squares, redundancy) -> PointTests:
    """Test points that took no part in the fit against what it predicts for them.

    Parameters
    ----------
    squares : ndarray, shape (n_points,)
        T = vᵀ Q⁻¹ v of the two differences predicted minus given, Q = I / w + Q_fit.
    sum_of_squares, redundancy : ndarray, shape (n_points,)
        Ω and f of each point's model.

    Returns
    -------
    PointTests
        w = √T / s_0 and p = (1 + T/Ω)^(−f/2), which is the joint test of the fit that
        still had the point.
    """
    f = np.asarray(redundancy, dtype=float)
    is_testable = (f > 0.0) & (np.asarray(sum_of_squares) > 0.0)
    omega = np.where(is_testable, sum_of_squares, np.nan)
    share = squares / omega
    p_value = np.where(is_testable, (1.0 + share) ** (-0.5 * f), np.nan)
    return PointTests(np.sqrt(share * f), p_value)


def noncentrality(significance=GROSS_ERROR_SIGNIFICANCE, power=0.80, degrees=1):
    """How many standard errors a bias must have to be found.

    Parameters
    ----------
    significance : float
        Share of good observations that the test refuses.
    power : float
        Share of observations with that bias that it finds.
    degrees : int
        1 for a coordinate, 2 for both coordinates of a point together.

    Returns
    -------
    float
        δ; 4.13 for one coordinate with α = 0.001 and power 0.80.
    """
    limit = chdtri(degrees, significance)
    return float(np.sqrt(chndtrinc(limit, degrees, 1.0 - power)))


def minimal_detectable_bias(
    sigma, redundancy_number, *, significance=GROSS_ERROR_SIGNIFICANCE, power=0.80
):
    """Smallest error of an observation that the w-test finds: σ δ / √r.

    Parameters
    ----------
    sigma : float or ndarray
        Standard error of the observation [m].
    redundancy_number : ndarray
    significance, power : float
        As in :func:`noncentrality`.

    Returns
    -------
    ndarray
        [m]; infinite where nothing checks the observation.

    Examples
    --------
    A corner of five control points under an affine transformation:

    >>> round(float(minimal_detectable_bias(0.10, 0.30)), 2)
    0.75
    """
    r = np.asarray(redundancy_number, dtype=float)
    with np.errstate(divide="ignore"):
        root = np.sqrt(np.where(r > LEAST_REDUNDANCY_NUMBER, r, 0.0))
        return sigma * noncentrality(significance, power) / root


def external_reliability(bias, redundancy_number):
    """Share (1 − r) ∇ of an undetected error that stays in the point's fitted value."""
    return (1.0 - np.asarray(redundancy_number, dtype=float)) * bias
