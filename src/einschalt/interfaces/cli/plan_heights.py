"""What answers say of flying heights and GSD, and of flights above a limit.

Nothing here takes pandas or numba along: the tables of ``einschalt plan`` come at once.
"""

from typing import NamedTuple

import numpy as np

from einschalt.foundations.errors import EinschaltError, SettingsError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import length
from einschalt.pipeline.planning.flights.arguments import MAX_HEIGHT, RANGES
from einschalt.pipeline.planning.flights.cameras import (
    describe_heights,
    flown_columns,
    problem_of_height,
    said_of_height,
    said_of_scales,
)

# by what a command can be told, and which flights are too high: "none" where no scale
# number that may be asked for keeps the limit, which that of a camera always leaves
REMEDIES = mark_each(
    {
        ("plan", "high"): "Give a --high-scale-number of at most {most}, or a greater "
        "--max-height where that is permitted",
        ("plan", "both"): "Give scale numbers of at most {most} to both flights, or a "
        "greater --max-height where that is permitted",
        ("plan", "tables"): "Give scale numbers of at most {most}, or a greater "
        "--max-height where that is permitted",
        ("plan", "none"): "Give a greater --max-height where that is permitted",
        ("simulate", "high"): "Give a --high-scale-number of at most {most}, unless "
        "higher flights are permitted",
        ("simulate", "both"): "Give scale numbers of at most {most} to both flights, "
        "unless higher flights are permitted",
    }
)


def said_of(problem):
    """Write a problem of height as text: the flights name the limit themselves."""
    return retold(f"{problem.found}. {problem.remedy}.")


class FlownHeights(NamedTuple):
    """What is said of flying heights: lines of text, and what programs are told."""

    lines: tuple[str, ...]
    problems: tuple[EinschaltError, ...]


def max_height_of(asked):
    """Limit above ground: what was given, or what is usual for the camera [m]."""
    given = asked["max_height"]
    if given is None:
        return asked.flight.preset.max_height
    if given not in MAX_HEIGHT:
        raise SettingsError(f"max_height = {given:g}", expected=str(MAX_HEIGHT))
    return given


def heights_expected(asked, design) -> FlownHeights:
    """Say how high the flights of a layout are, and whether the limit is kept."""
    limit, is_given = max_height_of(asked), asked["max_height"] is not None
    said = heights_of(design, asked.flight.preset, limit, is_given=is_given)
    if limit is None or said.problems:
        return said
    return said._replace(lines=(*said.lines, said_of_limit(asked)))


def heights_of(
    design, preset, limit, *, is_given=False, command="plan"
) -> FlownHeights:
    """Say how high both flights of a design are, and whether a limit is kept [m]."""
    scales = {
        "scale_number": float(design.scale_number),
        "high_scale_number": float(design.scale_of_high_flight),
    }
    distance = float(design.principal_distance)
    flown = flown_columns(scales, distance, preset.sampled_um)
    problems = ()
    if said := said_of_height(flown, limit, is_given=is_given):
        most = limit / distance
        which = "high" if int(most) > scales["scale_number"] else "both"
        which = which if most >= RANGES["scale_number"].low else "none"
        remedy = REMEDIES[command, which]
        problems = (problem_of_height(said, limit, distance, remedy),)
    lines = (describe_heights(flown), *map(said_of, problems), said_of_film(preset))
    return FlownHeights(tuple(filter(None, lines)), problems)


def heights_of_tables(asked, scale_numbers) -> FlownHeights:
    """Say how high flights at the scales of the tables are, and what is too high."""
    preset, distance = asked.flight.preset, asked.flight.principal_distance
    limit, is_given = max_height_of(asked), asked["max_height"] is not None
    problems = ()
    if said := said_of_scales(scale_numbers, distance, limit, is_given=is_given):
        is_scale = limit / distance >= RANGES["scale_number"].low
        remedy = REMEDIES["plan", "tables" if is_scale else "none"]
        problems = (problem_of_height(said, limit, distance, remedy),)
    lines = (_from_to(scale_numbers, distance, preset), said_of_film(preset))
    return FlownHeights(tuple(filter(None, lines)), problems)


def _from_to(scale_numbers, distance, preset):
    """Say the heights and sampling distances between which scales are flown."""
    ends = np.unique([np.min(scale_numbers), np.max(scale_numbers)])
    scales = {"scale_number": ends, "high_scale_number": ends}
    flown = flown_columns(scales, distance, preset.sampled_um)
    height = [figure(one, ".0f") for one in flown["flying_height"]]
    gsd = [length(one) for one in flown["gsd"]]
    message = mark("flown {height} m above ground, GSD {gsd}")
    if len(ends) > 1:
        message = mark(
            "flown {height} to {highest} m above ground, GSD {gsd} to {largest}"
        )
    facts = {"height": height[0], "highest": height[-1]}
    return translated(message, **facts, gsd=gsd[0], largest=gsd[-1])


def said_of_limit(asked):
    """Say which limit of height there is."""
    limit = max_height_of(asked)
    if limit is None:
        return translated("Flying heights have no limit (--max-height).")
    message = mark("Up to {limit} m above ground.")
    if asked["max_height"] is None:
        message = mark("Up to {limit} m above ground, as usual for it (--max-height).")
    return translated(message, limit=figure(limit, "g"))


def said_of_film(preset):
    """Say of which scan of film a GSD is, or ""."""
    if preset.pixel_um is not None:
        return ""
    sampled = figure(preset.sampled_um, "g")
    return translated("GSD: of film that is scanned at {pixel} µm.", pixel=sampled)
