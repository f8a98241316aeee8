"""The error m_g of a measured point: from settings, instrument and magnification.

m_g is the TOTAL error of ONE setting in the image plane. See
docs/theory/error_budget.md.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum


def m_g_of_mean(m_g, n_settings):
    """Error of the mean of several settings: m_g / √k.

    Parameters
    ----------
    m_g : float or ndarray
        TOTAL error of one setting.
    n_settings : float or ndarray
        How often the point was set, k.

    Returns
    -------
    float or ndarray
        In the unit of ``m_g``.

    Examples
    --------
    >>> m_g_of_mean(10.0, 4)
    5.0
    """
    root = np.sqrt(n_settings)
    return m_g / (float(root) if np.ndim(root) == 0 else root)


def m_g_from_repeated_settings(xy, start):
    """Error of one setting from points that were set several times.

    Parameters
    ----------
    xy : ndarray, shape (n_settings, 2)
        All settings in one model, sorted by point; in the image plane.
    start : ndarray of int, shape (n_points + 1,)
        Point k owns rows ``start[k]:start[k + 1]``.

    Returns
    -------
    m_g : float
        TOTAL, √(Σ|xy − mean|² / Σ(k − 1)), in the unit of ``xy``; NaN where no point
        was set twice.
    standard_error : float
        Of m_g: m_g / (2 √Σ(k − 1)), both coordinates being equally good.

    Notes
    -----
    It sees the setting alone: not the deformation of film, lens and model.
    """
    xy, start = np.asarray(xy, dtype=float), np.asarray(start)
    count = np.diff(start)
    is_set = count > 0
    # about the first setting of each point, so that large coordinates lose nothing
    first = np.repeat(start[:-1][is_set], count[is_set])
    offset = xy - xy[first]
    mean = segment_sum(offset, start) / np.maximum(count, 1)[:, None]
    squares = np.sum((offset - np.repeat(mean, count, axis=0)) ** 2)
    redundancy = int(np.maximum(count - 1, 0).sum())
    if redundancy == 0:
        return np.nan, np.nan
    m_g = float(np.sqrt(squares / redundancy))
    return m_g, m_g / (2.0 * np.sqrt(redundancy))


def m_g_from_machine(m_x, m_y, magnification):
    """Error in the image plane from those of the two machine coordinates.

    Parameters
    ----------
    m_x, m_y : float
        Standard errors of the machine coordinates.
    magnification : float
        From image to model.

    Returns
    -------
    float
        TOTAL, √(m_x² + m_y²) / magnification, in the unit of ``m_x``.

    Examples
    --------
    Kovarik 1971, footnote: 0.015 and 0.01 mm in the machine, 2.5 times enlarged, are
    "hardly 0.01 mm":

    >>> round(m_g_from_machine(0.015, 0.01, 2.5), 4)
    0.0072
    """
    return float(np.hypot(m_x, m_y) / magnification)
