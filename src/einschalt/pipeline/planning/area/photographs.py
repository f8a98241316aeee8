"""Photographs of a layout: where they are taken, and how high."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.batches import segment_min_max, segment_sum, used_places
from einschalt.pipeline.planning.area.layout import FLIGHTS

LETTER = {"high_flight": "H", "low_flight": "L"}
PARTS_OF_SPACING = 0.5
"""Of the heights of the ground: of a drop between them half a step may be missed."""
FINEST = 1.0  # m: heights that stand closer tell no more of what lies below


def photographs_of(layout, heights=None, limit=None, *, follows=False):
    """Make the table of all photographs, as FlightPlan has it.

    ``heights`` are GroundHeights, ``limit`` that of cameras above the ground straight
    below them [m]; ``follows``: see :func:`flight_plan`.
    """
    flights = [_exposures(layout, flight) for flight in FLIGHTS]
    names = {
        name: np.concatenate([getattr(flight, name) for flight in flights])
        for name in ("photo_id", "line_id", "flight", "coverage")
    }
    plane, line = np.concatenate([one.plane for one in flights]), names["line_id"]
    # photographs of a line follow each other
    start = np.flatnonzero(np.concatenate([[True], line[1:] != line[:-1], [True]]))
    n_in_line = np.diff(start)
    above, ground = _heights_over(layout, flights, heights)
    if heights is not None and not follows:
        ground = np.repeat(segment_sum(ground, start) / n_in_line, n_in_line)
    altitude = ground + above
    lower, nadir = _within_limit(plane, altitude, line, limit, heights)
    if not follows:
        lower = np.repeat(segment_min_max(lower, start)[1], n_in_line)
    return pd.DataFrame(
        {
            **names,
            "easting": plane[:, 0],
            "northing": plane[:, 1],
            "azimuth": layout.area.azimuth,
            "flying_height": above - lower,
            "ground": ground,
            "altitude": altitude - lower,
            "height_above_nadir": altitude - lower - nadir,
        }
    )


def planned_heights(design):
    """Flying heights above ground of both flights [m], by flight."""
    scales = design.scale_of_high_flight, float(design.scale_number)
    given = (float(design.principal_distance) * scale for scale in scales)
    return dict(zip(FLIGHTS, given, strict=True))


def by_image(photographs, flown, flight):
    """Put the altitudes of a table into the places of the rasters' images."""
    is_of_flight = photographs["flight"].to_numpy() == flight
    coverage = photographs["coverage"].to_numpy()[is_of_flight]
    altitude = photographs["altitude"].to_numpy()[is_of_flight]
    found = []
    for k, raster in enumerate(flown.rasters):
        n_images = int(np.prod(raster.images().shape))
        altitudes = np.full(n_images, np.nan)
        places = used_places(flown.image_places[flown.coverage == k], n_images)
        altitudes[places] = altitude[coverage == str(k + 1)]
        found.append(altitudes)
    return tuple(found)


def stations(flown, coverage):
    """Strip, and place in it, of the photographs of a coverage, line by line."""
    n_along, _ = flown.rasters[coverage].shape
    strip, place = np.divmod(flown.place[flown.coverage == coverage], n_along)
    # a model is made by the photograph at its place and the next, of one more in a line
    first = strip * (n_along + 1) + place
    every = np.unique(np.concatenate([first, first + 1]))
    return np.stack(np.divmod(every, n_along + 1))


@dataclass(frozen=True, eq=False)
class _Exposures:
    """Photographs of all models of a flight that are flown, line by line."""

    flight: np.ndarray  # (n,) of str
    coverage: np.ndarray  # (n,) of str
    line_id: np.ndarray  # (n,) of str
    photo_id: np.ndarray  # (n,) of str
    plane: np.ndarray  # (n, 2): easting, northing [m]


def _exposures(layout, flight) -> _Exposures:
    """Photographs of all models of a flight."""
    flown, letter = layout.flights[flight], LETTER[flight]
    coverage, line_id, photo_id, centres = [], [], [], []
    for k, raster in enumerate(flown.rasters):
        strip, place = stations(flown, k)
        n_along, _ = raster.shape
        centres.append(raster.images().centres()[strip * (n_along + 1) + place])
        is_new = np.ones(len(strip), dtype=bool)
        is_new[1:] = (np.diff(strip) != 0) | (np.diff(place) != 1)
        start = np.flatnonzero(is_new)
        n_in_line = np.diff(np.append(start, len(strip)))
        for number, n in enumerate(n_in_line.tolist(), start=1):
            name = f"{letter}{k + 1}-{number:02d}"
            line_id += [name] * n
            photo_id += [f"{name}-{one:03d}" for one in range(1, n + 1)]
        coverage += [str(k + 1)] * len(strip)
    return _Exposures(
        flight=np.full(len(line_id), flight, dtype=object),
        coverage=np.array(coverage, dtype=object),
        line_id=np.array(line_id, dtype=object),
        photo_id=np.array(photo_id, dtype=object),
        plane=layout.area.to_ground(np.concatenate(centres)),
    )


def _heights_over(layout, flights, heights):
    """Flying height above the ground, and mean height of the ground [m], (n,) each."""
    planned, above, ground = planned_heights(layout.design), [], []
    for name, flight in zip(FLIGHTS, flights, strict=True):
        above.append(np.full(len(flight.plane), planned[name]))
        if heights is None:
            ground.append(np.full(len(flight.plane), np.nan))
        else:
            reach = reach_of(layout, name)
            ground.append(heights.mean_around(flight.plane, reach))
    return np.concatenate(above), np.concatenate(ground)


def reach_of(layout, flight):
    """How far from a photograph the ground counts that its models show [m]."""
    scale_number = layout.flights[flight].scale_number
    return float(scale_number * np.sqrt(np.prod(layout.geometry.usable_model)) / 2.0)


def _within_limit(plane, altitude, line, limit, heights):
    """How much lower cameras fly to keep a limit, and the ground straight below [m].

    The limit is that above the ground straight below their lines.
    """
    lower = np.zeros(len(plane))
    if heights is None:
        return lower, np.full(len(plane), np.nan)
    nadir = heights.straight_below(plane)
    if limit is not None:
        lower = np.maximum(altitude - nadir - limit, 0.0)
        before, height = _on_the_way(plane, altitude, line, heights)
        for end in (before, before + 1):
            np.maximum.at(lower, end, height - limit)
    return lower, nadir


def least_above_ground(photographs, heights):
    """Least height above what lies straight below photographs and lines [m].

    By flight; of ground beside the area as well, as far as there are heights.
    """
    least = photographs["height_above_nadir"].to_numpy(dtype=float, copy=True)
    plane = photographs[["easting", "northing"]].to_numpy()
    altitude = photographs["altitude"].to_numpy()
    line = photographs["line_id"].to_numpy()
    before, height = _on_the_way(plane, altitude, line, heights)
    np.minimum.at(least, before, height)
    return pd.Series(least).groupby(photographs["flight"].to_numpy()).min().to_dict()


def _on_the_way(plane, altitude, line, heights):
    """Heights above what lies straight below between photographs of a line [m].

    Half as far apart as heights of the ground. Rows of the photographs before them, and
    the heights: the camera goes straight from one altitude to the next.
    """
    place = np.column_stack([plane, altitude])
    before = np.flatnonzero(line[1:] == line[:-1])
    step = place[before + 1] - place[before]
    apart = max(PARTS_OF_SPACING * heights.spacing, FINEST)
    n_parts = np.ceil(np.hypot(*step[:, :2].T) / apart).astype(np.int64)
    n_between = np.maximum(n_parts - 1, 0)
    segment = np.repeat(np.arange(len(before)), n_between)
    first = np.cumsum(n_between) - n_between
    k = np.arange(len(segment)) - first[segment] + 1
    way = (k / n_parts[segment])[:, None]
    between = place[before[segment]] + way * step[segment]
    return before[segment], between[:, 2] - heights.straight_below(between[:, :2])
