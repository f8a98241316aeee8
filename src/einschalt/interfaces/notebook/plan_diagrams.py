"""Diagrams of plans on axes of matplotlib."""

import numpy as np

from einschalt.foundations.frame_columns import PLAN
from einschalt.foundations.language import mark, translated
from einschalt.foundations.typesetting import length
from einschalt.interfaces.notebook.axes import (
    CONTROL,
    EDGE,
    MAP_IN,
    PLOT_IN,
    PRECISION,
    SOURCE_COLOURS,
    axes_for,
    colour_bar,
    colours_of,
    frame,
    key_below,
    map_frame,
    unit_for,
)
from einschalt.interfaces.reports.plans_figure import draw_plans, plans_title
from einschalt.interfaces.reports.precision_map_figure import by_place
from einschalt.pipeline.planning.propagation.expected_precision import SOURCE_TEXT

CURVES = (
    ("standard_error_total", CONTROL, mark("expected")),
    ("standard_error_paper", "#d58600", mark("formula of 1971")),
)


def expected_map(ax, expected):
    """Standard errors of the new points of a layout, and its control."""
    points = expected.points
    new, control = (points[points["role"] == role] for role in ("new", "control"))
    unit = unit_for(expected.figures.mean)
    errors = unit.of(new["standard_error_total"])
    ax = axes_for(ax, MAP_IN, layout="compressed")
    extent = np.ptp(points[PLAN].to_numpy(), axis=0).max()
    title = translated("Expected: {length}", length=length(expected.figures.mean))
    map_frame(ax, title=title, extent=extent)
    drawn = ax.tripcolor(
        new["easting"],
        new["northing"],
        errors,
        shading="gouraud",
        cmap=PRECISION,
        norm=colours_of(errors),
        rasterized=True,
    )
    ax.plot(
        control["easting"],
        control["northing"],
        "^",
        color=CONTROL,
        markerfacecolor="white",
        markersize=4.5,
        linestyle="",
        label=translated("control points"),
    )
    text = mark("expected standard error, total [{unit}]")
    colour_bar(ax, drawn, translated(text, unit=unit.name))
    ax.set_xlabel(translated("{axis} from the centre", axis=ax.get_xlabel()))
    key_below(ax)
    return ax


def profile(ax, expected):
    """Precision of one model's values by how far they lie from its middle."""
    unit, ax = unit_for(expected.figures.mean), axes_for(ax)
    means = (expected.figures.mean, expected.figures.paper_mean)
    for (column, colour, curve), mean in zip(CURVES, means, strict=True):
        centres, errors = by_place(expected.values, column)
        name = translated(curve)
        dots = {"color": colour, "markersize": 3.5, "label": name}
        ax.plot(centres, unit.of(errors), "o-", **dots)
        message = mark("{name}, mean of all coverages {length}")
        text = translated(message, name=name, length=length(mean))
        line = {"color": colour, "linestyle": (0, (4, 2)), "linewidth": 1.0}
        ax.axhline(unit.of(mean), label=text, **line)
    frame(
        ax,
        title=translated("One model's values, and the mean"),
        x=translated("from the middle of a model (0) to its edge (1)"),
        y=translated("standard error, total [{unit}]", unit=unit.name),
    )
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, None))
    ax.legend(loc="lower right", frameon=False, fontsize="small")
    return ax


def expected_sources(ax, expected):
    """What each source makes of the new points, and all together."""
    unit, parts = unit_for(expected.figures.mean), expected.parts
    texts = (*(SOURCE_TEXT[code] for code in parts), mark("all together"))
    names = [translated(text) for text in texts]
    sizes = [*parts.values(), float(np.sqrt(sum(v**2 for v in parts.values())))]
    colours = [*(SOURCE_COLOURS.get(code, EDGE) for code in parts), EDGE]
    ax = axes_for(ax, (PLOT_IN[0], 0.45 * len(names) + 1.0))
    bars = ax.barh(names, unit.of(sizes), 0.7, color=colours)
    ax.bar_label(bars, [length(size) for size in sizes], padding=4, fontsize="small")
    frame(
        ax,
        title=translated("Sources of the expected error"),
        x=translated("standard error, total, RMS [{unit}]", unit=unit.name),
        y="",
    )
    ax.invert_yaxis()
    ax.margins(x=0.12)
    ax.grid(visible=False, axis="y")
    return ax


def costs(ax, search):
    """Cost against precision of all plans."""
    ax = axes_for(ax, (7.6, 5.2))
    frame(ax, title=plans_title(search), x="", y="")
    draw_plans(ax, search)
    return ax
