"""Tests of a whole set of errors: whether it is as large as stated, and its mean zero.

Both are the global tests of an adjustment: the root mean square against its expected
value (χ²), the mean of each coordinate against zero (Student's t).

See docs/theory/reliability.md.
"""

import numpy as np

# scipy.stats takes a second to import
from scipy.special import chdtrc, chdtri, stdtr


def ratio_limits(degrees, significance, least_ratio=1.0):
    """Limits of an RMS error divided by its expected value, if the latter is correct.

    Parameters
    ----------
    degrees : float or ndarray
        Degrees of freedom: squares in the mean, two for each point in plan.
    significance : float
        Probability of a ratio beyond each of the limits, 0 to 0.5.
    least_ratio : float
        The limits are at least as far from 1 as this ratio and its reciprocal: with
        many points a difference can be significant and yet too small to matter.

    Returns
    -------
    lower, upper : float or ndarray
        √(χ²_f / f) at both quantiles; NaN where there are no degrees of freedom.

    Examples
    --------
    >>> [round(float(limit), 3) for limit in ratio_limits(20, 0.001)]
    [0.544, 1.505]
    >>> [round(float(limit), 3) for limit in ratio_limits(2000, 0.001, 1.25)]
    [0.8, 1.25]
    """
    degrees = np.asarray(degrees, dtype=float)
    f = np.where(degrees > 0.0, degrees, np.nan)
    lower = np.sqrt(chdtri(f, 1.0 - significance) / f)
    upper = np.sqrt(chdtri(f, significance) / f)
    return np.minimum(lower, 1.0 / least_ratio)[()], np.maximum(upper, least_ratio)[()]


def ratio_p_value(ratio, degrees):
    """Probability of an RMS error this large or larger, if the expected one is correct.

    ``ratio`` is the RMS error divided by its expected value: upper tail of χ²_f at
    f · ratio². NaN where there are no degrees of freedom.

    >>> round(float(ratio_p_value(1.505, 20)), 4)
    0.001
    """
    degrees = np.asarray(degrees, dtype=float)
    f = np.where(degrees > 0.0, degrees, np.nan)
    return chdtrc(f, f * np.square(ratio))


def mean_p_values(values):
    """Probabilities of means at least this far from zero, if their expectation is zero.

    The values of each column, (n, n_axes), are independent and have one unknown
    variance. Two-sided, of Student's t with n − 1 degrees of freedom; NaN for fewer
    than two values, and for values that are all zero.
    """
    values = np.asarray(values, dtype=float)
    n = len(values)
    if n < 2:
        return np.full(values.shape[1], np.nan)
    error = values.std(axis=0, ddof=1) / np.sqrt(n)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = values.mean(axis=0) / error
    return 2.0 * stdtr(n - 1, -np.abs(t))
