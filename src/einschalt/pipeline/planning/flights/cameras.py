"""Cameras with their usual flights: what a planner need not look up.

And how high a flight with them is above ground, how large a pixel is there, and
whether it may be flown so high.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.known_fields import with_known_fields
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import length
from einschalt.foundations.units import METRES_PER_UM
from einschalt.pipeline.planning.flights.points_in_models import BELOW

FILM_SCALES = (6_000.0, 8_000.0, 10_000.0, 12_000.0)
FILM_SPACINGS = (200.0, 300.0, 400.0)
FILM_M_G_UM = (10.0, 5.0)
FILM_M_0 = (0.10, 0.20)
SCANNED_UM = 15.0  # of film, as photogrammetric scanners do

# whether the limit was given, and which flights are above it
TOO_HIGH = mark_each(
    {
        (False, "high"): "The high flight, {high} m above ground, is higher than the "
        "{limit} m that drones may usually fly.",
        (False, "both"): "Both flights, {low} and {high} m above ground, are higher "
        "than the {limit} m that drones may usually fly.",
        (False, "scales"): "Flights at {scale} are {high} m above ground, which is "
        "higher than the {limit} m that drones may usually fly.",
        (True, "high"): "The high flight, {high} m above ground, is higher than the "
        "limit of {limit} m.",
        (True, "both"): "Both flights, {low} and {high} m above ground, are higher "
        "than the limit of {limit} m.",
        (True, "scales"): "Flights at {scale} are {high} m above ground, which is "
        "higher than the limit of {limit} m.",
    }
)
MOST_DECIMALS = 6  # of heights, as many as show that they are above a limit


@with_known_fields
@dataclass(frozen=True, kw_only=True)
class CameraPreset:
    """A camera and how it is usually flown.

    Attributes
    ----------
    title : str
    image_format : tuple of float
        Sides of the image along and across the strip [m].
    principal_distance : float
        [m]
    pixel_um : float, optional
        Size of a pixel in the image [µm]; None for film.
    sampled_um : float
        What a ground sampling distance is of, in the image [µm]: for film the usual
        scan.
    max_height : float, optional
        That the camera's carrier may usually fly above ground [m]; None: no limit.
    forward_overlap, side_overlap : float
        Of consecutive images, and of neighbouring strips; parts of the image, 0 to 1.
    m_0 : tuple of float
        Usual errors of approximate coordinates, TOTAL [m]: for film those of Kovarik
        1971, else what a high flight of the same camera gives.
    m_g_um : tuple of float
        Usual errors of a signalised point, TOTAL, in the image [µm]: for film those of
        Kovarik 1971, for digital images 0.3 pixels in each coordinate.
    scale_numbers : tuple of float
        Denominators of the usual image scales, the largest scale first.
    spacings : tuple of float
        Usual distances of points [m], the closest first.
    """

    title: str
    image_format: tuple[float, float]
    principal_distance: float
    pixel_um: float | None = None
    sampled_um: float = SCANNED_UM
    max_height: float | None = None
    forward_overlap: float = 0.60
    side_overlap: float = 0.30
    m_0: tuple[float, ...]
    m_g_um: tuple[float, ...]
    scale_numbers: tuple[float, ...]
    spacings: tuple[float, ...]

    @property
    def usual_scale_number(self) -> float:
        """Of the low flight where one is wanted: the second, neither bold nor dear."""
        return self.scale_numbers[min(1, len(self.scale_numbers) - 1)]

    @property
    def usual_spacing(self) -> float:
        """Distance of points where one is wanted, the second [m]."""
        return self.spacings[min(1, len(self.spacings) - 1)]


def _film(title, principal_distance):
    return CameraPreset(
        title=title,
        image_format=(0.23, 0.23),
        principal_distance=principal_distance,
        m_0=FILM_M_0,
        m_g_um=FILM_M_G_UM,
        scale_numbers=FILM_SCALES,
        spacings=FILM_SPACINGS,
    )


def _digital(title, pixels, pixel_um, principal_distance, **usual):
    """Make a preset of a frame camera: pixels along and across the strip."""
    along, across = (round(1e-6 * pixel_um * count, 9) for count in pixels)
    return CameraPreset(
        title=title,
        image_format=(along, across),
        principal_distance=principal_distance,
        pixel_um=pixel_um,
        sampled_um=pixel_um,
        m_g_um=(round(0.3 * 2.0**0.5 * pixel_um, 1),),
        **usual,
    )


LARGE_FORMAT = {
    "m_0": (0.05, 0.10),
    "scale_numbers": (15_000.0, 20_000.0, 25_000.0, 30_000.0),
    "spacings": FILM_SPACINGS,
}
OPEN_CATEGORY = 120.0
"""Metres above ground: EU Regulation 2019/947, UAS.OPEN.010; other states are alike."""
UAV = {
    "forward_overlap": 0.80,
    "side_overlap": 0.60,
    "m_0": (0.02, 0.05),
    "max_height": OPEN_CATEGORY,
}
CAMERAS = {
    "film_wide": _film("aerial film 23 cm, wide angle", 0.152),
    "film_normal": _film("aerial film 23 cm, normal angle", 0.305),
    "film_super_wide": _film("aerial film 23 cm, super-wide angle", 0.088),
    "ultracam_eagle": _digital(
        "UltraCam Eagle Mark 3", (17_004, 26_460), 4.0, 0.100, **LARGE_FORMAT
    ),
    "dmc_3": _digital("Leica DMC III", (14_592, 25_728), 3.9, 0.092, **LARGE_FORMAT),
    "ultracam_xp": _digital(
        "UltraCam Xp", (11_310, 17_310), 6.0, 0.1005, **LARGE_FORMAT
    ),
    "dmc_ii_250": _digital(
        "Z/I DMC II 250", (14_656, 17_216), 5.6, 0.112, **LARGE_FORMAT
    ),
    "uav_full_frame": _digital(
        "UAV, 45 megapixels of 36 mm x 24 mm, as DJI P1",
        (5_460, 8_192),
        4.4,
        0.035,
        scale_numbers=(2_000.0, 2_500.0, 3_000.0, 3_400.0),
        spacings=(5.0, 10.0, 15.0),
        **UAV,
    ),
    "uav_one_inch": _digital(
        "UAV, 20 megapixels of 13 mm x 9 mm, as DJI Phantom 4 RTK",
        (3_648, 5_472),
        2.41,
        0.0088,
        scale_numbers=(8_000.0, 10_000.0, 12_000.0, 13_500.0),
        spacings=(10.0, 15.0, 20.0),
        **UAV,
    ),
    "uav_four_thirds": _digital(
        "UAV, 20 megapixels of 17 mm x 13 mm, as DJI Mavic 3 Enterprise",
        (3_956, 5_280),
        3.3,
        0.0123,
        scale_numbers=(5_000.0, 6_500.0, 8_000.0, 9_700.0),
        spacings=(5.0, 10.0, 15.0),
        **UAV,
    ),
}
"""By the name that the command line takes. Sizes after the makers' data sheets."""


def camera_preset(name: str) -> CameraPreset:
    """Look up a camera with its usual flights, as ``einschalt plan --camera`` has it.

    Parameters
    ----------
    name : str
        film_wide, film_normal, film_super_wide, ultracam_eagle, dmc_3, ultracam_xp,
        dmc_ii_250, uav_full_frame, uav_one_inch or uav_four_thirds.

    Raises
    ------
    SettingsError
        There is no such camera.

    Examples
    --------
    >>> camera_preset("uav_one_inch").max_height
    120.0
    """
    require_choice("camera", name, tuple(CAMERAS))
    return CAMERAS[name]


def flown_columns(columns, principal_distance, sampled_um) -> dict:
    """Heights above ground and ground sampling distances of both flights [m].

    ``columns`` has scale_number and high_scale_number. Without ``sampled_um``, the size
    of a pixel in the image, the sampling distances are NaN.
    """
    low, high = columns["scale_number"], columns["high_scale_number"]
    pixel = np.nan if sampled_um is None else sampled_um * METRES_PER_UM
    return {
        "flying_height": principal_distance * low,
        "high_flying_height": principal_distance * high,
        "gsd": pixel * low,
        "high_gsd": pixel * high,
    }


def describe_heights(plan) -> str:
    """Say how high both flights are above ground, and how large a pixel is there.

    ``plan`` has flying_height, high_flying_height, gsd and high_gsd [m].
    """
    message = mark("Low flight {low} m above ground; high flight {high} m")
    if np.isfinite([plan["gsd"], plan["high_gsd"]]).all():
        message = mark(
            "Low flight {low} m above ground, GSD {gsd}; high flight {high} m, GSD "
            "{high_gsd}"
        )
    return translated(
        message,
        low=figure(plan["flying_height"], ".0f"),
        high=figure(plan["high_flying_height"], ".0f"),
        gsd=length(plan["gsd"]),
        high_gsd=length(plan["high_gsd"]),
    )


def said_of_height(plan, limit, *, is_given=False) -> str:
    """Say which flights are higher than a limit above ground, or "".

    ``plan`` has flying_height and high_flying_height [m]; ``limit`` is None where there
    is none [m]. ``is_given``: by the planner; else it is what the camera's carrier may
    usually fly. The text is English, and to be retold.
    """
    heights = {"low": plan["flying_height"], "high": plan["high_flying_height"]}
    if limit is None or heights["high"] <= limit * BELOW:
        return ""
    which = "both" if heights["low"] > limit * BELOW else "high"
    shown = {name: _above(height, limit) for name, height in heights.items()}
    return kept(TOO_HIGH[is_given, which], limit=f"{limit:g}", **shown)


def said_of_scales(scale_numbers, principal_distance, limit, *, is_given=False) -> str:
    """Say the same of flights at several scales, by the highest of them, or ""."""
    highest = float(np.max(scale_numbers))
    height = principal_distance * highest
    if limit is None or height <= limit * BELOW:
        return ""
    facts = {"limit": f"{limit:g}", "high": _above(height, limit)}
    return kept(TOO_HIGH[is_given, "scales"], scale=f"1:{highest:.0f}", **facts)


def _above(height, limit):
    """Write a height; one above a limit is seen to be so [m]."""
    if height <= limit:
        return f"{height:.0f}"
    written = (f"{height:.{n}f}" for n in range(MOST_DECIMALS))
    return next((text for text in written if float(text) > limit), f"{height:g}")


def problem_of_height(said, limit, principal_distance, remedy) -> EinschaltError:
    """Make what is said of flights above a limit [m] a problem for programs.

    ``remedy``: a message with a place for {most}, the scale number that keeps it.
    """
    most = int(BELOW * limit / principal_distance)
    return EinschaltError(
        said.rstrip("."),
        expected=kept("at most {limit} m above ground", limit=f"{limit:g}"),
        remedy=kept(remedy, most=f"{most}"),
    )
