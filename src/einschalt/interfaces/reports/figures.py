"""Figures of a result as SVG text: a map with residual vectors, and one of precision.

The same result gives the same text, byte for byte. Many points are drawn as an image
inside the SVG, so that a block of 50 000 points stays a small file.
"""

from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.collections import LineCollection

from einschalt.foundations.display_names import shortened
from einschalt.foundations.typesetting import lengths, number
from einschalt.interfaces.reports.ellipses_on_map import (
    draw_ellipses,
    ellipse_exaggeration,
    ellipse_label,
    evenly_thinned,
    one_of_each_cell,
)
from einschalt.interfaces.reports.map_sheet import (
    INK,
    STYLE,
    draw_key,
    draw_lengths,
    map_sheet,
    round_down,
    svg_of,
)
from einschalt.interfaces.reports.precision_colours import error_range

NEW = "#6b7c85"
COLOURS = {"control": "#0b4f8a", "check": "#b4430b"}
MARKERS = {"control": "^", "check": "s"}
COVERAGES = "#2f8f7a"
MOST_VECTORS = {"new": 1500, "control": 400, "check": 400}
MOST_DRAWN_AS_PATHS = 2500
POINTS_PER_IN = 72.0


def block_map(result) -> str:
    """Draw the points by role, and vectors that show their errors, as SVG.

    Vectors at control and check points are densified − given, with confidence ellipses
    of the densified points; at new points they are the difference of the first two
    coverages. Their exaggeration is stated, and is that of the ellipses. Empty where no
    point has coordinates.
    """
    points = _located(result.points)
    if points.empty:
        return ""
    with mpl.rc_context(STYLE):
        sheet = map_sheet(points)
        vectors = _vectors(result, points)
        exaggeration = _exaggeration(vectors, sheet)
        _draw_points(sheet, points)
        for vector in vectors:
            _draw_vectors(sheet.axes, vector, exaggeration)
        known = points.loc[points["role"] != "new", "point_id"]
        ellipses = result.ellipses
        ellipses = ellipses[ellipses["point_id"].isin(known)]
        if len(ellipses) <= MOST_VECTORS["control"]:
            draw_ellipses(sheet, ellipses, exaggeration, NEW)
        draw_lengths(sheet, exaggeration)
        draw_key(sheet, _markers(points), [(v.label, v.colour) for v in vectors])
        return svg_of(sheet.figure, "map", "Map of the block with residual vectors")


def precision_figure(result) -> str:
    """Draw the total error of the new points over the block, and its histogram.

    The propagated one where there is one, else that of the paper; empty where no new
    point has a standard error.
    """
    points = _located(result.points)
    claim = result.assessment.credible.column
    points = points[(points["role"] == "new") & points[claim].notna()]
    if points.empty:
        return ""
    error_cm = points[claim].to_numpy() * 100.0
    with mpl.rc_context(STYLE):
        sheet = map_sheet(points, foot_in=0.45)
        drawn = sheet.axes.scatter(
            *_place_km(points).T,
            c=error_cm,
            s=_marker_area(sheet, len(points), 0.75, 0.8, 5.0),
            cmap="viridis_r",
            norm=_norm(error_cm),
            linewidths=0,
            rasterized=len(points) > MOST_DRAWN_AS_PATHS,
        )
        _draw_histogram(sheet, error_cm, drawn, claim)
        _draw_new_ellipses(sheet, result, points)
        return svg_of(sheet.figure, "precision", f"{claim} over the block")


def _draw_new_ellipses(sheet, result, points):
    """Ellipses of new points, evenly thinned, with what they are."""
    ellipses = result.ellipses
    ellipses = ellipses[ellipses["point_id"].isin(points["point_id"])]
    if ellipses.empty:
        return
    shown = evenly_thinned(ellipses)
    factor = ellipse_exaggeration(sheet, shown)
    draw_ellipses(sheet, shown, factor, INK)
    said = ellipse_label(result, factor)
    if len(shown) < len(ellipses):
        said += f", at {len(shown)} of {len(ellipses)} points"
    below = {"ha": "right", "va": "top", "fontsize": 8.5}
    low = -0.28 / sheet.size_in[1]  # on one line with the name of the axis
    sheet.axes.set_xlabel(sheet.axes.get_xlabel(), loc="left")
    sheet.axes.text(1.0, low, said, transform=sheet.axes.transAxes, **below)


def _norm(error_cm):
    low, high = error_range(error_cm)
    return mpl.colors.Normalize(low, high if high - low > 1e-9 else low + 1.0)


def _draw_histogram(sheet, error_cm, drawn, claim):
    """Histogram below the map, its bars in the colours of the map: it is the key."""
    low, high = drawn.norm.vmin, drawn.norm.vmax
    edges = np.linspace(low, high, 49)
    held = np.clip(error_cm, low, high)
    counts, _ = np.histogram(held, edges)
    axes = sheet.figure.add_axes(sheet.below)
    centres = (edges[:-1] + edges[1:]) / 2.0
    axes.bar(centres, counts, np.diff(edges), color=drawn.to_rgba(centres))
    axes.set(xlim=(low, high), ylim=(0.0, counts.max() * 1.05), yticks=[])
    axes.spines[["top", "left", "right"]].set_visible(False)
    marks = np.append(np.quantile(error_cm, [0.5, 0.95]), error_cm.max())
    median, most, largest = lengths(marks / 100.0)
    axes.set_xlabel(
        f"{claim} [cm]: median {median}, 95 % below {most}, largest {largest}"
    )


def _located(points):
    return points[np.isfinite(points["easting"]) & np.isfinite(points["northing"])]


def _place_km(rows):
    return rows[["easting", "northing"]].to_numpy(dtype=float) / 1e3


def _draw_points(sheet, points):
    new = points[points["role"] == "new"]
    sheet.axes.scatter(
        *_place_km(new).T,
        s=_marker_area(sheet, len(new), 0.12, 0.5, 3.0),
        color=NEW,
        linewidths=0,
        rasterized=len(new) > MOST_DRAWN_AS_PATHS,
    )
    for role, colour in COLOURS.items():
        known = points[points["role"] == role]
        sheet.axes.scatter(
            *_place_km(known).T,
            s=_marker_area(sheet, len(known), 0.3, 1.2, 4.8),
            marker=MARKERS[role],
            facecolor="white",
            edgecolor=colour,
            linewidths=float(np.clip(_spacing_in(sheet, len(known)) * 3.0, 0.3, 0.9)),
            zorder=4,
            rasterized=len(known) > MOST_DRAWN_AS_PATHS,
        )


@dataclass(frozen=True, eq=False)
class _Vectors:
    """Vectors in metres at places in kilometres, with what they are."""

    label: str
    colour: str
    place_km: np.ndarray
    vector_m: np.ndarray


def _vectors(result, points):
    found = [_coverage_differences(result, points)]
    for role, colour in COLOURS.items():
        rows = points[(points["role"] == role) & points["difference_easting"].notna()]
        vector_m = rows[["difference_easting", "difference_northing"]].to_numpy()
        what = (role, "densified − given", colour)
        found.append(_thinned(what, _place_km(rows), vector_m))
    return [vectors for vectors in found if len(vectors.place_km)]


def _coverage_differences(result, points):
    """Difference of the first two coverages at each new point."""
    values = result.single_values
    new = points.loc[points["role"] == "new"].set_index("point_id")
    coverages = sorted(values["coverage"].unique())[:2]
    what = ("new", f"coverage {' − '.join(map(shortened, coverages))}", COVERAGES)
    if len(coverages) < 2:
        return _thinned(what, np.empty((0, 2)), np.empty((0, 2)))
    first, second = (
        values[values["coverage"] == coverage]
        .groupby("point_id")[["easting", "northing"]]
        .mean()
        for coverage in coverages
    )
    difference = (first - second).dropna()
    difference = difference[difference.index.isin(new.index)]
    return _thinned(what, _place_km(new.loc[difference.index]), difference.to_numpy())


def _thinned(what, place_km, vector_m):
    """Vectors with their label; where they are dense, one for each cell of a grid."""
    role, kind, colour = what
    n_all, most = len(place_km), MOST_VECTORS[role]
    if n_all <= most:
        return _Vectors(f"{role} points: {kind}", colour, place_km, vector_m)
    chosen = one_of_each_cell(place_km, most)
    label = f"{role} points, 1 in {number(n_all / len(chosen))}: {kind}"
    return _Vectors(label, colour, place_km[chosen], vector_m[chosen])


def _exaggeration(vectors, sheet):
    """Round factor at which a long vector hardly reaches its neighbour."""
    if not vectors:
        return 1.0
    long_m = np.quantile(np.hypot(*np.vstack([v.vector_m for v in vectors]).T), 0.95)
    most = max(len(v.place_km) for v in vectors)
    reach_m = min(sheet.width_m / 20.0, 1.5 * _spacing_in(sheet, most) * sheet.m_per_in)
    return round_down(reach_m / long_m) if long_m > 0.0 else 1.0


def _spacing_in(sheet, n_points):
    """Distance of neighbours on the sheet, were the points spread evenly [inch]."""
    width, height = sheet.size_in
    return float(np.sqrt(width * height / max(n_points, 1)))


def _marker_area(sheet, n_points, part, least, most):
    """Area of a marker whose diameter is a part of the spacing [points²]."""
    diameter = part * _spacing_in(sheet, n_points) * POINTS_PER_IN
    return float(np.clip(diameter, least, most) ** 2)


def _draw_vectors(axes, vectors, exaggeration):
    tips = vectors.place_km + vectors.vector_m * exaggeration / 1e3
    axes.add_collection(
        LineCollection(
            np.stack([vectors.place_km, tips], axis=1),
            colors=vectors.colour,
            linewidths=0.7 if vectors.colour == COVERAGES else 1.3,
            zorder=5,
            rasterized=len(tips) > MOST_DRAWN_AS_PATHS,
        ),
        autolim=False,
    )


def _markers(points):
    roles = [role for role in COLOURS if (points["role"] == role).any()]
    known = [(f"{role} points", MARKERS[role], COLOURS[role]) for role in roles]
    return [("new points", "o", NEW), *known]
