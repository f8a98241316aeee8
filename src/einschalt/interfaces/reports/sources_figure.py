"""Figure of the sources of error: the block as a whole, and from good points to bad."""

import matplotlib as mpl
import numpy as np

from einschalt.foundations.typesetting import lengths
from einschalt.interfaces.reports.map_sheet import EDGE, STYLE, svg_figure, svg_of
from einschalt.pipeline.summary.sections.error_sources import share_text, source_name

SIZE_IN = (7.4, 2.6)
COLOURS = {
    "control": "#0b4f8a",
    "high_flight": "#c9772b",
    "low_flight": "#2f8f7a",
    "orientation": "#8a5a9e",
    "own_deformation": "#a8963a",
}
OTHER = EDGE
N_CLASSES = 10
LEAST_POINTS = 20


def sources_figure(result) -> str:
    """Draw what each source contributes to the variance of the new points.

    The upper bar is the block; the columns below are tenths of the new points, from
    those with the smallest ``standard_error_total`` to those with the largest.

    Parameters
    ----------
    result : DensificationResult

    Returns
    -------
    str
        An ``<svg>`` element; empty where the errors were not propagated.
    """
    block = result.block_error_sources
    if block.empty or not block["share"].sum() > 0.0:
        return ""
    with mpl.rc_context(STYLE):
        figure = svg_figure(SIZE_IN)
        _draw_block(figure.add_axes((0.10, 0.84, 0.88, 0.14)), block)
        _draw_classes(figure.add_axes((0.10, 0.20, 0.88, 0.48)), result, block)
        return svg_of(figure, "sources", "Sources of the error of the new points")


def _draw_block(axes, block):
    """One bar, the largest share first."""
    left = 0.0
    for source, share in zip(block["source"], block["share"], strict=True):
        axes.barh(0.0, share, left=left, color=_colour(source), edgecolor="white")
        if share > 0.04:
            where = {"ha": "center", "va": "center", "color": "white"}
            axes.text(left + share / 2.0, 0.0, share_text(share), **where)
        left += share
    axes.set(xlim=(0.0, 1.0), ylim=(-0.4, 0.4))
    axes.axis("off")


def _draw_classes(axes, result, block):
    """Columns of variance, from good points to bad."""
    table = result.error_sources
    new = result.points.loc[result.points["role"] == "new", "point_id"]
    is_new = table["point_id"].isin(new)
    table = table[is_new] if is_new.any() else table
    table = table.sort_values("standard_error_total", kind="stable")
    n_classes = N_CLASSES if len(table) >= LEAST_POINTS else 1
    parts = np.array_split(np.arange(len(table)), n_classes)
    middle = np.arange(n_classes) + 0.5
    bottom = np.zeros(n_classes)
    for source in block["source"]:
        variance = table[f"standard_error_{source}"].to_numpy(dtype=float) ** 2
        heights = np.array([variance[part].mean() for part in parts]) * 1e4
        label = source_name(source)
        axes.bar(middle, heights, 0.86, bottom, color=_colour(source), label=label)
        bottom += heights
    axes.set_xticks(middle, lengths(np.sqrt(bottom) / 100.0), fontsize=8.0)
    axes.tick_params(length=0.0)
    axes.set(xlim=(0.0, n_classes), ylabel="variance [cm²]")
    said = ", each column a tenth of the new points" if n_classes > 1 else ""
    axes.set_xlabel(f"standard_error_total{said}")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(
        frameon=False,
        fontsize=8.5,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=len(block),
        borderpad=0.0,
    )


def _colour(source):
    return COLOURS.get(source, OTHER)
