"""What a planner writes on the command line, as numbers."""

from typing import NamedTuple

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.camera_presets import CAMERAS, CameraPreset
from einschalt.pipeline.planning_arguments import checked_number, planned_model
from einschalt.theory.precision_planning import PlannedModel

MOST_STEPS = 1_000_000
SIDES = "millimetres as 230 or 68.0x105.8"
NUMBERS = "numbers as 6000,8000 or first:last:step"


class PlannedFlight(NamedTuple):
    """A camera and how it is flown."""

    preset: CameraPreset
    model: PlannedModel
    principal_distance: float


def numbers(option, texts, usual):
    """Read the values of an option that may be given several times.

    Parameters
    ----------
    option : str
        Its name, for messages.
    texts : list of str or None
    usual : sequence of float
        What holds where it was not given.

    Returns
    -------
    list of float

    Raises
    ------
    SettingsError
        A part is no number, or a range has no steps.

    Examples
    --------
    >>> numbers("--scale-number", ["6000:8000:1000", "12000"], ())
    [6000.0, 7000.0, 8000.0, 12000.0]
    """
    if not texts:
        return list(usual)
    parts = [part.strip() for text in texts for part in text.split(",")]
    return [value for part in parts for value in _values(option, part)]


def _values(option, part):
    if ":" not in part:
        return [_number(option, part)]
    pieces = [_number(option, piece) for piece in part.split(":")]
    if len(pieces) != 3:
        raise SettingsError(f"{option} {part}", expected=NUMBERS)
    first, last, step = pieces
    if not np.isfinite(pieces).all() or step <= 0.0 or last < first:
        raise SettingsError(
            f"{option} {part}", expected="first:last:step with a step above 0, upwards"
        )
    n_steps = np.floor((last - first) / step + 1e-9)
    if n_steps > MOST_STEPS:
        raise SettingsError(
            f"{option} {part} has {n_steps:.0f} values",
            expected=f"at most {MOST_STEPS}",
            remedy="Give a larger step",
        )
    return [first + step * i for i in range(int(n_steps) + 1)]


def _number(option, text, expected=NUMBERS):
    try:
        return float(text)
    except ValueError:
        raise SettingsError(f"{option} {text!r}", expected=expected) from None


def flight_of(camera, kind, edge, given) -> PlannedFlight:
    """Put a camera and what was given in its place together, and check them.

    Parameters
    ----------
    camera : str
    kind, edge : str
    given : dict
        ``image_format`` (text) and ``principal_distance`` [mm], ``forward_overlap``,
        ``side_overlap``; None where the camera's holds.

    Returns
    -------
    PlannedFlight

    Raises
    ------
    SettingsError
        A value is not sensible; in the unit in which it was given.
    """
    preset = CAMERAS[camera]
    sides = preset.image_format
    if given["image_format"] is not None:
        texts = given["image_format"].lower().replace("×", "x").split("x")
        given_mm = [_number("--image-format", text, SIDES) for text in texts]
        sides = [_in_metres("image_format", side) for side in given_mm]
    distance = preset.principal_distance
    if given["principal_distance"] is not None:
        distance = _in_metres("principal_distance", given["principal_distance"])
    overlaps = [
        getattr(preset, name) if given[name] is None else given[name]
        for name in ("forward_overlap", "side_overlap")
    ]
    return PlannedFlight(
        preset,
        planned_model(kind, edge, sides, *overlaps),
        checked_number("principal_distance", distance),
    )


def _in_metres(name, length_mm):
    if 2.0 <= length_mm <= 1000.0:
        return length_mm * METRES_PER_MM
    raise SettingsError(
        f"--{name.replace('_', '-')} = {length_mm:g}",
        expected="2 to 1000 millimetres",
        remedy="Did you give metres?" if 0.0 < length_mm < 2.0 else "",
    )
