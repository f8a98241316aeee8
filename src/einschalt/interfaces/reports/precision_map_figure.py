"""The expected precision of a block as a map, and from the middle to the edge."""

import matplotlib as mpl
import numpy as np
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator

from einschalt.foundations.language import mark, translated
from einschalt.foundations.typesetting import length
from einschalt.interfaces.reports.axis_figures import set_figures
from einschalt.interfaces.reports.figure_files import (
    EXPECTED,
    PAPER,
    SHEET_STYLE,
    headline,
    label_ends,
    note,
    panels,
)
from einschalt.interfaces.reports.figure_style import INK

MAP_IN = 3.5
PROFILE_IN = 4.0
HEIGHT_IN = 4.2
DRAWN_IN = 2.9
BINS = np.linspace(0.0, 0.5, 11)
SHOWN = (0.0, 0.98)
"""Errors that the colours span; the few worst points have the darkest."""


def precision_map_figure(expected, unshifted=None, area=None):
    """Draw the expected precision over the area, and from the middle to the edge.

    ``unshifted`` has coverages that are not shifted: what shifting gains. ``area`` is
    the FlightArea over which the points lie: it is drawn in its own system, with its
    border, and nothing beyond. Without one easting and northing are those of the
    points.
    """
    figures = expected.figures
    total = "standard_error_total"
    shown = [(translated("expected"), figures.mean, expected, total)]
    if unshifted is not None:
        mean = unshifted.figures.mean
        shown.append((translated("coverages not shifted"), mean, unshifted, total))
    by_formula = (figures.paper_mean, expected, "standard_error_paper")
    shown.append((translated("formula of 1971"), *by_formula))
    errors = np.concatenate(
        [100.0 * _new(of.points)[column].to_numpy() for _, _, of, column in shown]
    )
    norm = mpl.colors.Normalize(*np.quantile(errors, SHOWN))
    with mpl.rc_context(SHEET_STYLE):
        size = (MAP_IN * len(shown) + PROFILE_IN, HEIGHT_IN)
        figure, axes = panels(1, len(shown) + 1, size)
        headline(
            figure,
            translated("Expected precision of the new points, mean of all coverages"),
            translated(
                "Errors of control and both flights carried through every stage on "
                "this layout; triangles: control points. Figures: root mean squares."
            ),
        )
        for panel, (title, mean, of, column) in zip(axes[:-1], shown, strict=True):
            drawn = _draw_map(panel, of, column, norm, area)
            panel.set_title(f"{title}: {length(mean)}")
        axes[0].set_ylabel(translated("north [km]"))
        bar = figure.colorbar(drawn, ax=axes[:-1].tolist(), shrink=0.8, pad=0.012)
        bar.set_label(translated("total error [{unit}]", unit="cm"))
        set_figures(bar.long_axis)
        bar.outline.set_visible(False)
        _draw_profile(axes[-1], expected)
        return figure


def _draw_map(panel, expected, column, norm, area):
    """Draw the precision of all points as a surface between them."""
    points = _new(expected.points)
    drawn = panel.tripcolor(
        *_places(points, area),
        100.0 * points[column],
        shading="gouraud",
        cmap="cividis_r",
        norm=norm,
        rasterized=True,
    )
    control = expected.points[expected.points["role"] == "control"]
    panel.plot(
        *_places(control, area),
        "^",
        markersize=3.2,
        markerfacecolor="white",
        markeredgecolor=INK,
        markeredgewidth=0.5,
    )
    if area is not None:
        border = PathPatch(_path_of(area), facecolor="none", edgecolor=INK, linewidth=1)
        panel.add_patch(border)
        drawn.set_clip_path(border)
    panel.set_aspect("equal")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        set_figures(axis)
    panel.set_xlabel(translated("east [km]"))
    panel.grid(visible=False)
    return drawn


def _places(points, area):
    """Easting and northing of points, in the system of an area if there is one [km]."""
    plane = points[["easting", "northing"]].to_numpy()
    return (plane if area is None else area.to_ground(plane)).T / 1e3


def _path_of(area):
    """The border of an area, its holes as well [km]."""
    import shapely  # noqa: PLC0415 - loaded when an area is drawn
    from shapely.geometry.polygon import orient  # noqa: PLC0415

    # holes run the other way round: they are not filled
    parts = map(orient, shapely.get_parts(area.shape))
    rings = [ring for part in parts for ring in (part.exterior, *part.interiors)]
    paths = [Path(shapely.get_coordinates(ring) / 1e3, closed=True) for ring in rings]
    return Path.make_compound_path(*paths)


def _draw_profile(panel, expected):
    """Precision of one model's values by how far they lie from its middle."""
    figures, ends = expected.figures, []
    for name, column, mean, colour in (
        (translated("expected"), "standard_error_total", figures.mean, EXPECTED),
        ("1971", "standard_error_paper", figures.paper_mean, PAPER),
    ):
        centres, errors = by_place(expected.values, column)
        error = 100.0 * errors
        panel.plot(centres, error, "o-", color=colour, markersize=3)
        panel.axhline(100.0 * mean, color=colour, linestyle=(0, (4, 2)), linewidth=1.0)
        texts = (mark("{name},\none model"), mark("{name},\nmean"))
        one, all_ = (translated(text, name=name) for text in texts)
        ends += [(error[np.isfinite(error)][-1], one, colour)]
        ends += [(100.0 * mean, all_, colour)]
    title = translated("One model's values, and the mean")
    panel.set(title=title, xlim=(0, 1), ylim=(0, None))
    panel.set_box_aspect(1.0)
    panel.set_xlabel(translated("from the middle (0) to the edge (1)"))
    panel.set_ylabel(translated("total error [{unit}]", unit="cm"))
    for axis in (panel.xaxis, panel.yaxis):
        set_figures(axis)
    text = translated("dashed: mean of all coverages")
    note(panel, text, (0.03, 0.03), xycoords="axes fraction")
    # labels have two lines
    label_ends(panel, ends, DRAWN_IN / 2.3)


def by_place(values, column):
    """Root mean squares of errors by how far values lie from the middle of their model.

    Places from 0 in the middle to 1 at the edge, and errors there [m]; NaN where no
    value lies.
    """
    away = values[["position_u", "position_v"]].abs().max(axis=1).to_numpy()
    place = np.clip(np.digitize(away, BINS) - 1, 0, len(BINS) - 2)
    centres = BINS[:-1] + BINS[1:]
    count = np.bincount(place, minlength=len(centres))
    squares = values[column].to_numpy() ** 2
    total = np.bincount(place, squares, minlength=len(centres))
    return centres, np.sqrt(np.divide(total, np.where(count, count, np.nan)))


def _new(points):
    return points[points["role"] == "new"]
