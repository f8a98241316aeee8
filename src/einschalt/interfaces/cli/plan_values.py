"""What a planner writes on the command line, as numbers."""

import re
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.near_words import nearest
from einschalt.foundations.units import METRES_PER_MM
from einschalt.interfaces.cli.typed_options import option_of
from einschalt.pipeline.planning.flights.arguments import (
    checked_number,
    planned_model,
)
from einschalt.pipeline.planning.flights.cameras import CAMERAS, CameraPreset
from einschalt.pipeline.planning.flights.costs import PlanCosts
from einschalt.theory.planning.kovarik_precision import PlannedModel

MOST_STEPS = 1_000_000
QUESTIONS = ("tables", "target", "area", "expect")
COUNTS_FOR = {
    **dict.fromkeys(("m_0", "edge"), ("tables",)),
    **dict.fromkeys(
        ("where", "by", "costs", "high_over_low", "n_settings"),
        ("target", "area"),
    ),
    **dict.fromkeys(
        (
            *("n_coverages", "control_per_model", "control_standard_error"),
            "high_m_g_um",
        ),
        ("target", "area", "expect"),
    ),
    **dict.fromkeys(("expect", "high_scale_number", "width", "height"), ("expect",)),
    **dict.fromkeys(("area", "area_layer", "crs", "ground_heights"), ("area",)),
}
"""Options that do not count for every question."""
COSTS = "costs as image=10,model=20,setting=0.5,control_point=100"
# as answers write a scale
AS_PRINTED_SCALE = re.compile(r"1:(\d+)")
# what answers call a price, in the singular
AS_PRINTED = {
    "photograph": "image",
    "pointing": "setting",
    "pointing at a point": "setting",
    "control point": "control_point",
    # as answers in German do
    **dict.fromkeys(("bild", "bilder", "aufnahme", "aufnahmen"), "image"),
    **dict.fromkeys(("modell", "modelle"), "model"),
    **dict.fromkeys(
        (
            *("einstellung", "einstellungen", "einstellung eines punktes"),
            "einstellungen eines punktes",
        ),
        "setting",
    ),
    **dict.fromkeys(("passpunkt", "passpunkte"), "control_point"),
}
BEFORE_A_NAME = re.compile(r"[,;](?=[^,;]*=)")
CENTS = re.compile(r"^([+-]?\d+),(\d{1,2})$")
SIDES = "millimetres as 230 or 68.0x105.8"
NUMBERS = "numbers as 6000,8000 or first:last:step"


class PlannedFlight(NamedTuple):
    """A camera and how it is flown."""

    preset: CameraPreset
    model: PlannedModel
    principal_distance: float


def numbers(option, texts, usual):
    """Read the values of an option that may be given several times.

    >>> numbers("--scale-number", ["6000:8000:1000", "12000"], ())
    [6000.0, 7000.0, 8000.0, 12000.0]
    >>> numbers("--scale-number", ["1:6000;8000"], ())
    [6000.0, 8000.0]
    """
    if not texts:
        return list(usual)
    parts = [part.strip() for text in texts for part in re.split("[,;]", text)]
    return [value for part in parts for value in _values(option, part)]


def _values(option, part):
    if ":" not in part:
        return [_number(option, part)]
    if "scale" in option and (scale := AS_PRINTED_SCALE.fullmatch(part)):
        return [_number(option, scale[1])]
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


def flight_of(options, *, on_layout=False) -> PlannedFlight:
    """Put a camera and what was given in its place [mm] together, and check them.

    ``on_layout``: overlaps are those that a layout may have.
    """
    preset = CAMERAS[options["camera"]]
    sides, distance = sides_and_distance(options)
    sides = preset.image_format if sides is None else sides
    distance = preset.principal_distance if distance is None else distance
    overlaps = {
        name: getattr(preset, name) if options[name] is None else options[name]
        for name in ("forward_overlap", "side_overlap")
    }
    if on_layout:
        # imported when a layout is asked for: it takes numba along
        from einschalt.pipeline.planning.flights.flight_design import (  # noqa: PLC0415
            require_overlaps,
        )

        require_overlaps(sides, **overlaps)
    return PlannedFlight(
        preset,
        planned_model(options["kind"], options["edge"], sides, **overlaps),
        checked_number("principal_distance", distance),
    )


def sides_and_distance(options):
    """Sides of the image and principal distance [m], None where not given."""
    sides = distance = None
    if options["image_format"] is not None:
        texts = options["image_format"].lower().replace("×", "x").split("x")
        given_mm = [_number("--image-format", text, SIDES) for text in texts]
        sides = [_in_metres("image_format", side) for side in given_mm]
    if options["principal_distance"] is not None:
        distance = _in_metres("principal_distance", options["principal_distance"])
    return sides, distance


def _in_metres(name, length_mm):
    if 2.0 <= length_mm <= 1000.0:
        return length_mm * METRES_PER_MM
    raise SettingsError(
        f"--{name.replace('_', '-')} = {length_mm:g}",
        expected="2 to 1000 millimetres",
        remedy="Did you give metres?" if 0.002 <= length_mm <= 1.0 else "",
    )


def costs_of(text) -> PlanCosts:
    """Read costs; what is not named costs what it usually does.

    A comma before no name is a decimal one; such a price has one or two decimals.

    >>> given = costs_of("model=35,image=12,5,pointing=1")
    >>> given.model, given.image, given.setting
    (35.0, 12.5, 1.0)
    """
    given = {}
    for part in map(str.strip, BEFORE_A_NAME.split(text)):
        name, sign, cost = (piece.strip() for piece in part.partition("="))
        if not sign:
            raise SettingsError(f"--costs {part!r}", expected=COSTS)
        name = _item_of(name)
        if name in given:
            raise SettingsError(
                f"--costs has two prices of {name}",
                expected="one of each",
                remedy="Leave one out",
            )
        point = CENTS.sub(r"\1.\2", cost)
        given[name] = _number("--costs", point, COSTS)
    return PlanCosts(**given)


def _item_of(name):
    """Give the item that a price is of, however an answer calls it."""
    words = {name, name.lower(), name.lower().replace("pointings", "pointing")}
    words |= {word.removesuffix("s") for word in words}
    known = AS_PRINTED | {item: item for item in PlanCosts.__dataclass_fields__}
    for word in sorted(words):
        if word in known:
            return known[word]
    near = nearest(name, known)
    raise SettingsError(
        f"--costs has a price of {name!r}",
        expected=COSTS,
        remedy=f"Did you mean {near!r}?" if near else "",
    )


@dataclass(frozen=True)
class Asked:
    """What was asked on the command line."""

    question: str  # one of QUESTIONS
    options: dict  # values of all options by name
    flight: PlannedFlight
    unused: tuple[str, ...] = ()  # written, and do not count for this question
    typed: tuple[str, ...] = ()  # written at all

    def __getitem__(self, name):
        """Value of an option."""
        return self.options[name]

    def numbers(self, name, usual):
        """Values of an option as numbers, the usual ones where it was not given."""
        return numbers(option_of(name), self[name], usual)

    def only(self, name, usual):
        """Give the one value of an option of which a layout can have one only."""
        given = self.numbers(name, usual)
        if len(given) != 1:
            option = option_of(name)
            raise SettingsError(
                f"{option} has {len(given)} values",
                expected="one value: a layout has one",
                remedy=f"Write {option} {given[0]:g}",
            )
        return given[0]


def asked_of(options, typed) -> Asked:
    """Find out which question is asked, and what was typed that does not count."""
    question = "expect" if options["expect"] else "tables"
    if options["target"] is not None:
        question = "target" if options["area"] is None else "area"
    elif options["area"] is not None:
        raise SettingsError(
            "--area without --target",
            expected="the total error that the points over it may have",
            remedy="Write --target 5cm as well",
        )
    unused = [name for name in typed if question not in COUNTS_FOR.get(name, QUESTIONS)]
    flight = flight_of(options, on_layout=question != "tables")
    return Asked(question, options, flight, tuple(unused), tuple(typed))
