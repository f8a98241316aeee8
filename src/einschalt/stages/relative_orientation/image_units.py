"""Image coordinates that cannot be millimetres from the principal point."""

from dataclasses import dataclass

import numpy as np

# tangent of the widest and the narrowest field angle that is believed: beyond the first
# these are pixels; of super-wide angles it reaches 1.3 in each coordinate
WIDEST_FIELD, NARROWEST_FIELD = 2.5, 0.01
WIDEST_CAMERA = 2.0
# of the points: what lies outside may be gross errors
SHARE_INSIDE = 0.95
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
    widest = np.quantile(sizes, SHARE_INSIDE) / distance
    if widest > WIDEST_CAMERA:
        angle = np.degrees(np.arctan(widest))
        remedy = "Correct the principal distance, or the size of the pixels"
        expected = f"points up to {np.degrees(np.arctan(WIDEST_CAMERA)):.0f}° away"
        return UnitFault(
            f"{found}: points {angle:.0f}° away from the axis of the camera",
            remedy,
            expected=expected,
        )
    if 0.0 < sizes.max() < NARROWEST_FIELD * distance:
        return UnitFault(found, "Did you give metres? Multiply them by 1000")
    return None
