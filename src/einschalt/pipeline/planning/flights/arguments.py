"""What a planner may ask for: ranges, and what numbers say of their units."""

import re
from collections.abc import Iterable
from dataclasses import fields
from numbers import Real

import numpy as np

from einschalt.foundations.arguments import described, require_choice
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.number_parsing import LARGEST_NUMBER
from einschalt.foundations.value_ranges import Range
from einschalt.theory.planning.kovarik_precision import EDGES, PlannedModel
from einschalt.theory.planning.leverage import PLANNED_KINDS

IN_MM = "Did you give millimetres?"
PER_CENT = "Did you give per cent?"
# what may be meant for them: from 2 % on, since 101 % are per cent that were understood
OF_PER_CENT = (2.0, 100.0)
RANGES = {
    # of scales, spacings and cameras what a layout takes as well: a test compares them
    "scale_number": Range(
        *(100, 200_000),
        likely_slip="Give the denominator: 8000 for 1:8000",
        slips=(0, 1),
    ),
    "spacing": Range(
        *(0.5, 50_000, "metres"),
        likely_slip="Did you give kilometres?",
        slips=(1e-3, 10),
    ),
    "m_0": Range(
        *(1e-4, 5, "metres"),
        likely_slip="Did you give centimetres? 10 cm are 0.10",
        slips=(1, 500),
    ),
    "m_g_um": Range(
        *(0.05, 500, "micrometres in the image"),
        likely_slip="Did you give metres or millimetres? 0.01 mm are 10",
        slips=(5e-8, 0.5),
    ),
    "image_format": Range(0.002, 1, "metres", likely_slip=IN_MM, slips=(2, 1000)),
    "principal_distance": Range(0.002, 1, "metres", likely_slip=IN_MM, slips=(2, 1000)),
    "forward_overlap": Range(
        *(0.01, 0.99, "of the image"), likely_slip=PER_CENT, slips=OF_PER_CENT
    ),
    "side_overlap": Range(
        *(0, 0.99, "of the image"), likely_slip=PER_CENT, slips=OF_PER_CENT
    ),
    "target": Range(
        *(1e-4, 1, "metres"),
        likely_slip="Did you give centimetres? 5 cm are 0.05",
        slips=(1, 100),
    ),
}
MAX_HEIGHT = Range(5, 20_000, "metres above ground")
PRINTED_SCALE = re.compile(r"1\s*:\s*[\d ]+")
MOST_COMBINATIONS = 20_000_000
SIDES = Range(1e-3, 1e15)  # and size of an area
ROUNDED = 1.0 + 1e-9


def checked_axis(name, values):
    """Check one argument that is a number or a sequence of numbers.

    ``name`` is a key of ``RANGES``. SettingsError where something is no number, lies
    outside of what is sensible, or is missing.

    Examples
    --------
    >>> checked_axis("spacing", 300)
    array([300.])
    >>> checked_axis("m_g_um", [5, 10e-6])
    Traceback (most recent call last):
    einschalt.foundations.errors.SettingsError: m_g_um = 1e-05; expected 0.05 to 500 \
micrometres in the image. Did you give metres or millimetres? 0.01 mm are 10.
    """
    is_many = isinstance(values, Iterable) and not isinstance(values, str | bytes)
    if getattr(values, "ndim", 1) == 0:  # an array that is one number
        values, is_many = values.item(), False
    listed = list(values) if is_many else [values]
    if not listed:
        raise SettingsError(
            f"{name} is empty", expected="a number or a sequence of numbers"
        )
    allowed = RANGES[name]
    for value in listed:
        # numpy's scalars are registered as Real; Range asks for what it knows
        plain = float(value) if _is_number(value) else value
        if plain not in allowed:
            raise SettingsError(
                f"{name} = {shown(value)}",
                expected=str(allowed),
                remedy=_remedy_for(plain, allowed),
            )
    return np.array(listed, dtype=float)


def _remedy_for(value, allowed):
    """What a value that is refused suggests: a scale as it is printed as well."""
    if isinstance(value, str) and PRINTED_SCALE.fullmatch(value.strip()):
        return allowed.likely_slip if allowed is RANGES["scale_number"] else ""
    return allowed.remedy_for(value)


def _is_number(value):
    is_real = isinstance(value, Real) and not isinstance(value, bool | np.bool_)
    # a whole number can be longer than a float
    return is_real and not (isinstance(value, int) and abs(value) > LARGEST_NUMBER)


def shown(value):
    """Write a value as messages quote it."""
    return f"{float(value):g}" if _is_number(value) else described(value)


def take_single_numbers(choices):
    """Make tuples of the fields of frozen choices that are one number."""
    for one in fields(choices):
        value = getattr(choices, one.name)
        if _is_number(value):
            object.__setattr__(choices, one.name, (value,))


def require_extent(extent):
    """See that length, width and size of the ground are those of an area [m, m, m²]."""
    is_listed = isinstance(extent, tuple | list) and len(extent) == 3
    if not is_listed or not all(side in SIDES for side in extent):
        raise SettingsError(
            f"extent = {described(extent)}",
            expected="length, width and size of an area [m, m, m²]",
        )
    length, width, size = extent
    if size > ROUNDED * length * width:
        raise SettingsError(
            f"extent = {described(extent)}",
            expected="a size of at most length times width",
        )


def checked_number(name, value) -> float:
    """Check one argument that is one number."""
    if not _is_number(value):
        allowed = RANGES[name]
        raise SettingsError(
            f"{name} = {value!r}",
            expected=str(allowed),
            remedy=_remedy_for(value, allowed),
        )
    return float(checked_axis(name, value)[0])


def planned_model(kind, edge, image_format, forward_overlap, side_overlap):
    """Check how models are flown and fitted.

    ``image_format`` is the side of the image, or its sides along and across the strip
    [m].
    """
    sides = checked_axis("image_format", image_format)
    if len(sides) > 2:
        raise SettingsError(
            f"image_format has {len(sides)} values",
            expected="the side of the image, or its sides along and across the strip",
        )
    require_choice("kind", kind, PLANNED_KINDS)
    require_choice("edge", edge, EDGES)
    return PlannedModel(
        kind=kind,
        edge=edge,
        image_format=(float(sides[0]), float(sides[-1])),
        forward_overlap=checked_number("forward_overlap", forward_overlap),
        side_overlap=checked_number("side_overlap", side_overlap),
    )


def flown_model(flown):
    """Give the planned model of a design or a frame, its edge by the rule of 1971."""
    sides, overlaps = flown.image_format, (flown.forward_overlap, flown.side_overlap)
    return planned_model(flown.kind, "kovarik", sides, *overlaps)


def require_reasonable_size(*axes):
    """Refuse a table that no memory holds.

    Every value of one axis is combined with every value of the others.
    """
    n_combinations = int(np.prod([len(axis) for axis in axes], dtype=float))
    if n_combinations > MOST_COMBINATIONS:
        raise SettingsError(
            f"{n_combinations} combinations are asked for",
            expected=f"at most {MOST_COMBINATIONS}",
            remedy="Give fewer values, or plan in several parts",
        )
