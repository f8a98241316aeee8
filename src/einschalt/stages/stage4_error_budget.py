"""Stage 4: the error budget of every point in every model."""

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.units import METRES_PER_UM
from einschalt.theory.error_budget import total_error


def error_budget(m_g_um, scale_number, m_t):
    """Total error after Kovarik 1971: M² = (m_g · scale number)² + m_t².

    It is what ``standard_error_paper`` holds. It takes errors for independent that
    are not, and is therefore too small (docs/theory/error_budget.md).

    Parameters
    ----------
    m_g_um : float or array_like
        TOTAL error of a measured point in the image plane [µm].
    scale_number : float or array_like
        Denominator of the image scale.
    m_t : float or array_like
        TOTAL error of the point from the transformation [m].

    Returns
    -------
    float or ndarray
        TOTAL error M on the ground [m].

    Raises
    ------
    SettingsError
        ``m_g_um`` or ``m_t`` is negative, or ``scale_number`` is not positive.

    Examples
    --------
    >>> round(error_budget(5.0, 8000, 0.03), 3)
    0.05
    """
    for name, value, is_bad in (
        ("m_g_um", m_g_um, np.less(m_g_um, 0)),
        ("scale_number", scale_number, np.less_equal(scale_number, 0)),
        ("m_t", m_t, np.less(m_t, 0)),
    ):
        if np.any(is_bad):
            raise SettingsError(
                f"{name} = {np.min(value):g}",
                expected="a positive number" if name == "scale_number" else "0 or more",
            )
    m_g = np.multiply(m_g_um, METRES_PER_UM)
    total = np.asarray(total_error(m_g, scale_number, m_t))
    return float(total) if total.ndim == 0 else total
