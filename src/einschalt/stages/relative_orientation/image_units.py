"""Image coordinates that cannot be millimetres from the principal point."""

from dataclasses import dataclass

import numpy as np

# tangent of the widest and the narrowest field angle that is believed
WIDEST_FIELD, NARROWEST_FIELD = 2.5, 0.01
EXPECTED = "millimetres, from the principal point"


@dataclass(frozen=True)
class UnitFault:
    """What image coordinates have instead, and how to mend it."""

    found: str
    remedy: str
    expected: str = EXPECTED
    are_pixels: bool = False


def unit_fault(xy, distance) -> UnitFault | None:
    """Say why coordinates (n, k) [mm] do not fit a principal distance [mm]; or None."""
    sizes = np.abs(xy).max(axis=1)
    largest, distance_mm = f"{sizes.max():.4g}", f"{distance:g}"
    found = (
        f"image coordinates up to {largest} with a principal distance of {distance_mm}"
    )
    if np.median(sizes) > WIDEST_FIELD * distance:
        remedy = "Did you give pixels? Convert them by a camera: Camera, or --camera"
        return UnitFault(found, remedy, are_pixels=True)
    if np.min(xy) >= 0.0 and sizes.max() > distance:
        remedy = "Is the origin in a corner? Subtract the principal point"
        return UnitFault(f"{found}, none of them negative", remedy)
    if 0.0 < sizes.max() < NARROWEST_FIELD * distance:
        return UnitFault(found, "Did you give metres? Multiply them by 1000")
    return None
