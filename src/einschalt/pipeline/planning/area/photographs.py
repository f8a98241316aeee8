"""Photographs of a layout: where they are taken, and how high."""

import numpy as np
import pandas as pd

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
    photographs = pd.concat(
        [_photographs(layout, flight) for flight in FLIGHTS], ignore_index=True
    )
    photographs = _flown(photographs, layout, heights, follows=follows)
    return _within_limit(photographs, limit, heights, follows=follows)


def planned_heights(design):
    """Flying heights above ground of both flights [m], by flight."""
    scales = design.scale_of_high_flight, float(design.scale_number)
    given = (float(design.principal_distance) * scale for scale in scales)
    return dict(zip(FLIGHTS, given, strict=True))


def by_image(photographs, flown, flight):
    """Put the altitudes of a table into the places of the rasters' images."""
    of_flight = photographs[photographs["flight"] == flight]
    found = []
    for k, raster in enumerate(flown.rasters):
        altitudes = np.full(int(np.prod(raster.images().shape)), np.nan)
        places = np.unique(flown.image_places[flown.coverage == k])
        is_in = of_flight["coverage"] == str(k + 1)
        altitudes[places] = of_flight.loc[is_in, "altitude"]
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


def _photographs(layout, flight):
    """Photographs of all models that are flown, line by line."""
    flown, tables = layout.flights[flight], []
    letter = LETTER[flight]
    for k, raster in enumerate(flown.rasters):
        strip, place = stations(flown, k)
        n_along, _ = raster.shape
        centres = raster.images().centres()[strip * (n_along + 1) + place]
        is_new = np.ones(len(strip), dtype=bool)
        is_new[1:] = (np.diff(strip) != 0) | (np.diff(place) != 1)
        line = np.cumsum(is_new)
        ground = layout.area.to_ground(centres)
        tables.append(
            pd.DataFrame(
                {
                    "line_id": [f"{letter}{k + 1}-{one:02d}" for one in line],
                    "flight": flight,
                    "coverage": str(k + 1),
                    "easting": ground[:, 0],
                    "northing": ground[:, 1],
                    "azimuth": layout.area.azimuth,
                }
            )
        )
    table = pd.concat(tables, ignore_index=True)
    n_before = table.groupby("line_id", sort=False).cumcount() + 1
    photo_id = table["line_id"] + "-" + n_before.astype(str).str.zfill(3)
    table.insert(0, "photo_id", photo_id)
    return table


def _flown(photographs, layout, heights, *, follows):
    """Join heights above ground, of the ground and of the cameras [m]."""
    flight = photographs["flight"].to_numpy()
    planned, above = planned_heights(layout.design), np.zeros(len(photographs))
    ground = np.full(len(photographs), np.nan)
    plane = photographs[["easting", "northing"]].to_numpy()
    for name, height in planned.items():
        rows = flight == name
        above[rows] = height
        if heights is not None:
            reach = reach_of(layout, name)
            ground[rows] = heights.mean_around(plane[rows], reach)
    if heights is not None and not follows:
        lines = photographs["line_id"].to_numpy()
        of_line = pd.Series(ground).groupby(lines).transform("mean")
        ground = of_line.to_numpy()
    return photographs.assign(
        flying_height=above, ground=ground, altitude=ground + above
    )


def reach_of(layout, flight):
    """How far from a photograph the ground counts that its models show [m]."""
    scale_number = layout.flights[flight].scale_number
    return float(scale_number * np.sqrt(np.prod(layout.geometry.usable_model)) / 2.0)


def _within_limit(photographs, limit, heights, *, follows):
    """Lower cameras to the limit above the ground straight below their lines [m]."""
    if heights is None:
        return photographs.assign(height_above_nadir=np.nan)
    plane = photographs[["easting", "northing"]].to_numpy()
    nadir = heights.straight_below(plane)
    lower = np.zeros(len(photographs))
    if limit is not None:
        altitude = photographs["altitude"].to_numpy()
        lower = np.maximum(altitude - nadir - limit, 0.0)
        before, height = _on_the_way(photographs, heights)
        for end in (before, before + 1):
            np.maximum.at(lower, end, height - limit)
        if not follows:
            lines = photographs["line_id"].to_numpy()
            lower = pd.Series(lower).groupby(lines).transform("max").to_numpy()
    altitude = photographs["altitude"] - lower
    return photographs.assign(
        flying_height=photographs["flying_height"] - lower,
        altitude=altitude,
        height_above_nadir=altitude - nadir,
    )


def least_above_ground(photographs, heights):
    """Least height above what lies straight below photographs and lines [m].

    By flight; of ground beside the area as well, as far as there are heights.
    """
    least = photographs["height_above_nadir"].to_numpy(dtype=float, copy=True)
    before, height = _on_the_way(photographs, heights)
    np.minimum.at(least, before, height)
    return pd.Series(least).groupby(photographs["flight"].to_numpy()).min().to_dict()


def _on_the_way(photographs, heights):
    """Heights above what lies straight below between photographs of a line [m].

    Half as far apart as heights of the ground. Rows of the photographs before them, and
    the heights: the camera goes straight from one altitude to the next.
    """
    place = photographs[["easting", "northing", "altitude"]].to_numpy()
    line = photographs["line_id"].to_numpy()
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
