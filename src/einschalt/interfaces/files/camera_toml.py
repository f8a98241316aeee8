"""Cameras in TOML: a file such as camera.toml, or a section [low_flight.camera].

Four conventions, told by the key ``convention``; see
:mod:`einschalt.theory.interior_orientation` for what the constants mean.
"""

import tomllib
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from einschalt.foundations.arguments import described, is_choice
from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.files.block_toml import parse_toml, write_keys
from einschalt.interfaces.files.input_files import read_text_bytes
from einschalt.interfaces.files.toml_faults import toml_fault
from einschalt.pipeline.settings import checked
from einschalt.theory.interior_orientation import Camera


def _pixels(what):
    return Field(description=f"a number (pixels): {what}")


def _coefficient():
    return Field(default=0.0, description="a number: a coefficient of the distortion")


def _pitch(**default):
    return Field(gt=0.0, description="a number above 0 (micrometres)", **default)


class _Constants(BaseModel):
    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, allow_inf_nan=False
    )


class OpencvConstants(_Constants):
    """Keys of a camera as OpenCV has it."""

    convention: Literal["opencv"]
    fx: float = _pixels("focal length")
    fy: float = _pixels("focal length")
    cx: float = _pixels("principal point")
    cy: float = _pixels("principal point")
    k1: float = _coefficient()
    k2: float = _coefficient()
    p1: float = _coefficient()
    p2: float = _coefficient()
    k3: float = _coefficient()
    pixel_size_um: float = _pitch()

    def camera(self):
        """Return the camera."""
        distortion = (self.k1, self.k2, self.p1, self.p2, self.k3)
        pitch = self.pixel_size_um
        return Camera.from_opencv(
            self.fx, self.fy, self.cx, self.cy, distortion, pixel_size_um=pitch
        )


class MetashapeConstants(_Constants):
    """Keys of a camera as Metashape has it."""

    convention: Literal["metashape"]
    f: float = _pixels("focal length")
    cx: float = Field(default=0.0, description="a number (pixels from the centre)")
    cy: float = Field(default=0.0, description="a number (pixels from the centre)")
    width: int = Field(gt=0, description="a whole number of pixels, at least 1")
    height: int = Field(gt=0, description="a whole number of pixels, at least 1")
    b1: float = _coefficient()
    b2: float = _coefficient()
    k1: float = _coefficient()
    k2: float = _coefficient()
    k3: float = _coefficient()
    k4: float = _coefficient()
    p1: float = _coefficient()
    p2: float = _coefficient()
    pixel_size_um: float = _pitch()

    def camera(self):
        """Return the camera."""
        names = ("b1", "b2", "k1", "k2", "k3", "k4", "p1", "p2")
        return Camera.from_metashape(
            self.f,
            (self.width, self.height),
            (self.cx, self.cy),
            {name: getattr(self, name) for name in names},
            pixel_size_um=self.pixel_size_um,
        )


class MillimetreConstants(_Constants):
    """Keys of a camera in millimetres, measured in millimetres or in pixels."""

    convention: Literal["mm"]
    c: float = Field(description="a number (millimetres): the principal distance")
    x0: float = Field(default=0.0, description="a number (millimetres)")
    y0: float = Field(default=0.0, description="a number (millimetres)")
    k1: float = _coefficient()
    k2: float = _coefficient()
    k3: float = _coefficient()
    p1: float = _coefficient()
    p2: float = _coefficient()
    pixel_size_um: float | None = _pitch(default=None)
    width: int | None = Field(default=None, gt=0, description="a number of pixels")
    height: int | None = Field(default=None, gt=0, description="a number of pixels")
    pixel_height_um: float | None = _pitch(default=None)

    def camera(self):
        """Return the camera."""
        names = ("pixel_size_um", "width", "height")
        pixels = {name: getattr(self, name) for name in names}
        n_given = sum(value is not None for value in pixels.values())
        is_tall = self.pixel_height_um is not None
        pixels |= {"pixel_height_um": self.pixel_height_um} if is_tall else {}
        if n_given < len(names) and (n_given or is_tall):
            raise SettingsError(
                "pixel_size_um, width and height are not all given",
                expected="all three where pixels were measured, or none of them",
            )
        return Camera.from_mm(
            self.c,
            (self.x0, self.y0),
            {name: getattr(self, name) for name in ("k1", "k2", "k3", "p1", "p2")},
            pixels=pixels if n_given else None,
        )


class MicmacConstants(_Constants):
    """Keys of a camera as MicMac has it, distorted about a centre of its own."""

    convention: Literal["micmac"]
    f: float = _pixels("focal length")
    cx: float = _pixels("principal point")
    cy: float = _pixels("principal point")
    centre_x: float | None = Field(default=None, description="a number (pixels)")
    centre_y: float | None = Field(default=None, description="a number (pixels)")
    k1: float = _coefficient()
    k2: float = _coefficient()
    k3: float = _coefficient()
    k4: float = _coefficient()
    k5: float = _coefficient()
    p1: float = _coefficient()
    p2: float = _coefficient()
    b1: float = _coefficient()
    b2: float = _coefficient()
    pixel_size_um: float = _pitch()

    def camera(self):
        """Return the camera."""
        names = ("k1", "k2", "k3", "k4", "k5", "p1", "p2", "b1", "b2")
        centre = (self.centre_x, self.centre_y)
        if centre.count(None) == 1:
            raise SettingsError(
                "centre_x and centre_y are not both given",
                expected="both, or none where it is the principal point",
            )
        return Camera.from_micmac(
            self.f,
            (self.cx, self.cy),
            {name: getattr(self, name) for name in names},
            None if None in centre else centre,
            pixel_size_um=self.pixel_size_um,
        )


CONVENTIONS = {
    "opencv": OpencvConstants,
    "metashape": MetashapeConstants,
    "mm": MillimetreConstants,
    "micmac": MicmacConstants,
}


def camera_of(keys, section="camera", file=None) -> Camera:
    """Camera of the keys of a section; section and file are said in messages."""
    convention = keys.get("convention")
    if not is_choice(convention, CONVENTIONS):
        said = "missing" if convention is None else f"unknown: {described(convention)}"
        raise SettingsError(
            f"[{section}] convention is {said}",
            expected=" or ".join(CONVENTIONS),
            remedy=f"Add convention = 'opencv' to [{section}], or another of these",
            file=file,
            section=section,
            key="convention",
        )
    kind = CONVENTIONS[convention]

    def build(**fields):
        return kind.model_validate(fields)

    constants = checked(build, keys, section=section, names=kind, file=file)
    try:
        return constants.camera()
    except SettingsError as error:
        found = f"[{section}] {error.found}"
        raise error.with_facts(found=found, file=file, section=section) from None


def read_camera(path, source=None) -> Camera:
    """Read a camera from a file of its own; ``source`` is its name in messages."""
    source = source or str(path)
    try:
        keys = parse_toml(read_text_bytes(path, source).decode("utf-8"), source)
    except tomllib.TOMLDecodeError as error:
        reason, row = toml_fault(error)
        raise SettingsError(
            f"the file is no TOML: {reason}",
            expected="key = value",
            file=source,
            row=row,
        ) from error
    nested = keys.get("camera")
    # both are natural: the keys alone, or below [camera]
    return camera_of(nested if isinstance(nested, dict) else keys, file=source)


def write_camera(path, camera):
    """Write a camera so that :func:`read_camera` gives it back."""
    write_keys(path, camera.given)
