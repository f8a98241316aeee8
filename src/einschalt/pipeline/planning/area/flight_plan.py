"""A layout as what is flown and measured: lines, photographs, control, effort."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.typesetting import number
from einschalt.pipeline.planning.area.layout import FLIGHTS, AreaLayout
from einschalt.pipeline.planning.area.photographs import (
    least_above_ground,
    photographs_of,
    reach_of,
    stations,
)
from einschalt.pipeline.planning.flights.costs import COLUMN_OF_ITEM

RIM_OF_OVERLAP = 0.5  # a model needs more than half of an image
LOWER_IS_SAID = 0.5  # metres
NEAR_GROUND = 0.5  # of the flying height: lines that come nearer to the ground are said


class GroundTooHighError(GeometryError):
    """Ground so high that photographs do not overlap on it."""


@dataclass(frozen=True, eq=False)
class FlightPlan:
    """What is flown and measured; easting, northing in the system of the area.

    Attributes
    ----------
    flight_lines : DataFrame
        line_id, flight, coverage, n_photographs, length [m], azimuth [degrees],
        start_easting, start_northing, end_easting, end_northing [m]; flying_height
        (mean, above ground), gsd, ground (mean height below) and altitude (of the
        camera in the height system; NaN without heights) [m].
    photographs : DataFrame
        photo_id, line_id, flight, coverage, easting, northing [m], azimuth [degrees];
        flying_height (altitude less ground), ground, altitude, height_above_nadir
        (above what lies straight below; NaN without heights) [m].
    control : DataFrame
        point_id, easting, northing, height (NaN without heights) [m], n_models (of the
        high flight), standard_error_m (TOTAL, that is asked of it) [m].
    effort : DataFrame
        item, amount, price, cost, in the currency of the prices.
    """

    flight_lines: pd.DataFrame
    photographs: pd.DataFrame
    control: pd.DataFrame
    effort: pd.DataFrame

    @property
    def cost(self) -> float:
        """What the whole area costs, in the currency of the prices."""
        return float(self.effort["cost"].sum())


def flight_plan(
    layout: AreaLayout, plan, frame, heights=None, *, follows=False, photographs=None
):
    """Make the tables of a layout.

    ``plan`` is the row of the search, ``heights`` a GroundHeights over the area,
    ``photographs`` the table of them, where they were laid over that ground before.
    With ``follows`` every photograph keeps its height above the ground below, otherwise
    every line that above the mean of the ground below it. Where the ground straight
    below a camera, at a photograph or on the straight way to the next one, is so low
    that the limit of the frame would not be kept, photographs or lines fly lower.
    """
    if photographs is None:
        given = layout, heights, frame.max_height
        photographs = photographs_of(*given, follows=follows)
    lines = _lines(photographs, plan)
    control = _control(layout, frame, heights)
    return FlightPlan(lines, photographs, control, effort(layout, plan, frame))


def _lines(photographs, plan):
    by_line = photographs.groupby("line_id", sort=False)
    first, last = by_line.first(), by_line.last()
    shift = [last[name] - first[name] for name in ("easting", "northing")]
    is_high = first["flight"] == "high_flight"
    flying_height = by_line["flying_height"].mean()
    planned = np.where(is_high, plan["high_flying_height"], plan["flying_height"])
    gsd = np.where(is_high, plan["high_gsd"], plan["gsd"])
    lines = pd.DataFrame(
        {
            "flight": first["flight"],
            "coverage": first["coverage"],
            "n_photographs": by_line.size(),
            "length": np.hypot(*shift),
            "azimuth": first["azimuth"],
            "start_easting": first["easting"],
            "start_northing": first["northing"],
            "end_easting": last["easting"],
            "end_northing": last["northing"],
            "flying_height": flying_height,
            "gsd": gsd * (flying_height / planned),
            "ground": by_line["ground"].mean(),
            "altitude": by_line["altitude"].mean(),
        }
    )
    return lines.reset_index()


def _control(layout, frame, heights):
    places = layout.control
    ground = layout.area.to_ground(layout.position[places])
    high = layout.oriented("high_flight")
    n_models = np.bincount(high.point, minlength=len(layout.position))[places]
    height = np.full(len(places), np.nan)
    if heights is not None:
        height = heights.at(ground)
    return pd.DataFrame(
        {
            "point_id": [f"C{k + 1}" for k in range(len(places))],
            "easting": ground[:, 0],
            "northing": ground[:, 1],
            "height": height,
            "n_models": n_models,
            "standard_error_m": frame.control_standard_error,
        }
    )


def amounts_of(layout: AreaLayout, plan) -> dict[str, int]:
    """Amounts over the whole area, by item; settings by the points that are wanted.

    ``plan`` is the row of the search.
    """
    values = sum(len(layout.oriented(flight).point) for flight in FLIGHTS)
    denser = (layout.geometry.point_spacing / float(plan["spacing"])) ** 2
    settings = round(values * denser * int(plan["n_settings"]))
    images = sum(
        stations(layout.flights[flight], k).shape[1]
        for flight in FLIGHTS
        for k in range(len(layout.flights[flight].rasters))
    )
    models = sum(layout.flights[flight].n_models for flight in FLIGHTS)
    return {
        "image": images,
        "model": models,
        "setting": settings,
        "control_point": len(layout.control),
    }


def effort(layout: AreaLayout, plan, frame) -> pd.DataFrame:
    """Item, amount, price and cost of all that a row of a search takes."""
    amounts = amounts_of(layout, plan)
    items = list(COLUMN_OF_ITEM)
    table = pd.DataFrame(
        {
            "item": items,
            "amount": [amounts[item] for item in items],
            "price": [float(getattr(frame.costs, item)) for item in items],
        }
    )
    return table.assign(cost=table["amount"] * table["price"])


def said_of_limit(flown, plan, limit):
    """Say how much lower than planned cameras fly to keep a limit, or ""."""
    is_high = flown.photographs["flight"] == "high_flight"
    planned = np.where(is_high, plan["high_flying_height"], plan["flying_height"])
    lower = float(np.max(planned - flown.photographs["flying_height"]))
    if limit is None or lower < LOWER_IS_SAID:
        return ""
    return kept(
        "Cameras fly up to {lower} m lower than planned above low ground: none is more "
        "than {limit} m above the ground straight below it, on its whole line.",
        lower=number(lower, 2),
        limit=f"{limit:g}",
    )


def said_of_level_ground(limit):
    """Say that a limit of height [m] counts above level ground, or "" without one."""
    if limit is None:
        return ""
    return kept(
        "The ground was taken to be level: to keep {limit} m above it over relief, "
        "give its heights (--ground-heights).",
        limit=f"{limit:g}",
    )


def require_above_ground(photographs, plan, heights):
    """Refuse lines that lead through the ground, be it beside the area.

    Returns what is to be said of lines that come near to it, or "".
    """
    least = least_above_ground(photographs, heights)
    names = zip(FLIGHTS, ("high_flying_height", "flying_height"), strict=True)
    planned = {flight: float(plan[name]) for flight, name in names}
    flight = min(least, key=lambda one: least[one] / planned[one])
    facts = {"flight": flight.replace("_", " "), "planned": f"{planned[flight]:.0f}"}
    if least[flight] <= 0.0:
        raise GroundTooHighError(
            f"lines of the {facts['flight']}, {facts['planned']} m above the ground of "
            f"the area, lead through ground beside it, {-least[flight]:.0f} m below it",
            expected="lines above the ground on their whole way",
            remedy="Give larger scale numbers, or an area that leaves the slope out",
        )
    if least[flight] >= NEAR_GROUND * planned[flight]:
        return ""
    return kept(
        "Lines of the {flight} come as near as {least} m to the ground straight below "
        "them, {planned} m are planned: see height_above_nadir of the photographs.",
        least=f"{least[flight]:.0f}",
        **facts,
    )


def require_overlap(photographs, plan, layout, heights):
    """Refuse ground so high that photographs do not overlap on it.

    What cameras fly lower than planned leaves as little overlap as ground that rises.

    Returns what is to be said of overlaps on the highest ground, or "".
    """
    geometry, left_over = layout.geometry, []
    lowest, highest = heights.range
    for flight, name in zip(
        FLIGHTS, ("high_flying_height", "flying_height"), strict=True
    ):
        above = float(plan[name])
        of_flight = photographs[photographs["flight"] == flight]
        rise = _rise(of_flight, above, heights, layout, flight)
        left = 1.0 - rise / above
        forward, side = (
            1.0 - (1.0 - overlap) / left if left > 0.0 else 0.0
            for overlap in (geometry.forward_overlap, geometry.side_overlap)
        )
        if left <= 0.0 or forward < RIM_OF_OVERLAP or side < 0.0:
            lowered = above - of_flight["flying_height"].min()
            raise _too_high(
                flight, rise, above, (forward, side), is_limited=lowered > LOWER_IS_SAID
            )
        left_over += [f"{100 * forward:.0f}", f"{100 * side:.0f}"]
    names = ("high_forward", "high_side", "low_forward", "low_side")
    return kept(
        "Ground from {lowest} to {highest} m; overlaps left on the highest: high "
        "flight {high_forward} and {high_side} %, low flight {low_forward} and "
        "{low_side} %. The expected precision is that of this ground: errors grow "
        "with the depth of points below the cameras.",
        lowest=f"{lowest:.0f}",
        highest=f"{highest:.0f}",
        **dict(zip(names, left_over, strict=True)),
    )


def _too_high(flight, rise, above, overlaps, *, is_limited):
    """Refuse ground that rises above what a flight is laid out for [m]."""
    forward, side = (100.0 * max(overlap, 0.0) for overlap in overlaps)
    found = (
        f"the ground rises {number(rise, 2)} m above what the "
        f"{flight.replace('_', ' ')}, {above:.0f} m above it, is laid out for: "
        f"overlaps of {forward:.0f} and {side:.0f} % are left"
    )
    return GroundTooHighError(
        found,
        expected="more than 50 % forward and 0 % to the side",
        remedy="Give larger overlaps; --max-height leaves no room to fly higher"
        if is_limited
        else "Give larger overlaps, or fly higher above the ground",
    )


def _rise(photographs, above, heights, layout, flight):
    """How far the ground rises above what lies ``above`` below the cameras [m]."""
    plane = photographs[["easting", "northing"]].to_numpy()
    peaks = heights.highest_around(plane, reach_of(layout, flight))
    laid_out_for = photographs["altitude"].to_numpy() - above
    return float(np.max(peaks - laid_out_for, initial=0.0))
