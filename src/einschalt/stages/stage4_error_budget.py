"""Stage 4: the error budget of every point in every model."""

from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from einschalt.foundations.arguments import as_numbers
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.units import METRES_PER_UM
from einschalt.theory.error_budget import total_error


@overload
def error_budget(m_g_um: float, scale_number: float, m_t: float) -> float: ...


@overload
def error_budget(
    m_g_um: ArrayLike, scale_number: ArrayLike, m_t: ArrayLike
) -> float | NDArray[np.float64]: ...


def error_budget(
    m_g_um: ArrayLike, scale_number: ArrayLike, m_t: ArrayLike
) -> float | NDArray[np.float64]:
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
        ``m_g_um`` or ``m_t`` is negative, ``scale_number`` is not positive, or their
        shapes do not fit each other.

    Examples
    --------
    >>> round(error_budget(5.0, 8000, 0.03), 3)
    0.05
    """
    given = {"m_g_um": m_g_um, "scale_number": scale_number, "m_t": m_t}
    values = {name: as_numbers(name, value) for name, value in given.items()}
    for name, value in values.items():
        is_scale = name == "scale_number"
        if np.any(value <= 0 if is_scale else value < 0):
            raise SettingsError(
                f"{name} = {np.min(value):g}",
                expected="a positive number" if is_scale else "0 or more",
            )
    _require_one_shape(values)
    m_g = values["m_g_um"] * METRES_PER_UM
    total = np.asarray(total_error(m_g, values["scale_number"], values["m_t"]))
    return float(total) if total.ndim == 0 else total


def _require_one_shape(values):
    try:
        np.broadcast_shapes(*(value.shape for value in values.values()))
    except ValueError:
        shapes = [f"{name} of shape {value.shape}" for name, value in values.items()]
        raise SettingsError(
            ", ".join(shapes),
            expected="numbers, or arrays of one shape",
            remedy="Give one value of each for every point",
        ) from None
