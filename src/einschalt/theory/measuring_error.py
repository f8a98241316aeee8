"""The error m_g of a measured point: from settings, instrument and magnification.

m_g is the TOTAL error of ONE setting in the image plane. See
docs/theory/error_budget.md.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.theory.adjustment.least_squares import pool_standard_errors


def m_g_of_mean(m_g, n_settings):
    """Error of the mean of k settings, m_g / √k, from the TOTAL error of one.

    Examples
    --------
    >>> m_g_of_mean(10.0, 4)
    5.0
    """
    root = np.sqrt(n_settings)
    return m_g / (float(root) if np.ndim(root) == 0 else root)


def mean_of_settings(coordinates, start):
    """Mean of the settings of each point, and how they scatter about it.

    Parameters
    ----------
    coordinates : ndarray, shape (n_settings, 2 or 3)
        All settings, sorted by point; x and y first.
    start : ndarray of int, shape (n_points + 1,)
        Point k owns rows ``start[k]:start[k + 1]``, at least one.

    Returns
    -------
    mean : ndarray, shape (n_points, 2 or 3)
    spread : ndarray, shape (n_points,)
        TOTAL in x and y, √(Σ|xy − mean|² / (k − 1)); NaN where a point was set once.

    Examples
    --------
    >>> mean, spread = mean_of_settings(np.array([[1.0, 5.0], [3.0, 5.0]]), [0, 2])
    >>> mean.tolist(), spread.round(3).tolist()
    ([[2.0, 5.0]], [1.414])
    """
    start = np.asarray(start)
    count = np.diff(start)
    # about the first setting of each point, so that large coordinates lose nothing
    first = coordinates[start[:-1]]
    offset = coordinates - np.repeat(first, count, axis=0)
    mean = segment_sum(offset, start) / count[:, None]
    apart = offset[:, :2] - np.repeat(mean[:, :2], count, axis=0)
    squares = segment_sum(np.sum(apart**2, axis=1), start)
    is_repeated = count > 1
    spread = np.sqrt(squares / np.where(is_repeated, count - 1, 1))
    return first + mean, np.where(is_repeated, spread, np.nan)


def m_g_from_repeated_settings(spread, n_settings):
    """Error of one setting from points that were set several times.

    Parameters
    ----------
    spread : ndarray, shape (n_points,)
        TOTAL, of the settings of each point about their mean, in the image plane; NaN
        where it is not known.
    n_settings : ndarray, shape (n_points,)
        How often each point was set, k.

    Returns
    -------
    m_g : float
        TOTAL, √(Σ(k − 1) spread² / Σ(k − 1)), in the unit of ``spread``; NaN where no
        point was set twice.
    standard_error : float
        Of m_g: m_g / (2 √Σ(k − 1)), both coordinates being equally good.

    Notes
    -----
    It sees the setting alone: not the deformation of film, lens and model.
    """
    spread, n_settings = np.asarray(spread, dtype=float), np.asarray(n_settings)
    is_repeated = np.isfinite(spread) & (n_settings > 1)
    redundancy = np.where(is_repeated, n_settings - 1.0, 0.0)
    if not is_repeated.any():
        return np.nan, np.nan
    m_g = pool_standard_errors(spread, redundancy)
    return m_g, m_g / (2.0 * float(np.sqrt(redundancy.sum())))


def m_g_from_machine(m_x, m_y, magnification):
    """TOTAL error in the image plane, √(m_x² + m_y²) / magnification.

    From the standard errors of the machine coordinates, in their unit, and the
    magnification from image to model.

    Examples
    --------
    Kovarik 1971, footnote: 0.015 and 0.01 mm in the machine, 2.5 times enlarged, are
    "hardly 0.01 mm":

    >>> round(m_g_from_machine(0.015, 0.01, 2.5), 4)
    0.0072
    """
    return float(np.hypot(m_x, m_y) / magnification)
