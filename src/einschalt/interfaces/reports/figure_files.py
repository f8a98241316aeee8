"""Figures that stand by themselves: panels, labels at the curves, and their bytes."""

import io

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from einschalt.interfaces.reports.figure_style import EDGE, FAINT, INK, STYLE

ORDERED = ("#10315f", "#0092a8", "#d58600", "#8a1538", "#9b3fe0")
"""Colours of growing spacings: told apart by the colour-blind, and in grey."""
EXPECTED, PAPER = "#10315f", "#d58600"
PNG_DPI = 150
SMALL = 8.0
LINE_PT = 9.5
TITLE_IN = 0.25
FIGURE_FORMATS = {
    "png": {"metadata": {"Software": None}},
    "svg": {"metadata": {"Date": None, "Creator": None}},
}
SHEET_STYLE = {
    **STYLE,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "mathtext.fontset": "dejavusans",
}


def figure_bytes(figure, kinds=tuple(FIGURE_FORMATS)):
    """Bytes of a figure by kind; the same figure gives the same bytes."""
    files = {}
    with mpl.rc_context(SHEET_STYLE):
        for kind in kinds:
            buffer = io.BytesIO()
            figure.savefig(buffer, format=kind, dpi=PNG_DPI, **FIGURE_FORMATS[kind])
            files[kind] = buffer.getvalue()
    return files


def panels(n_rows, n_columns, size):
    """Make a figure of equal panels, its size in inches; the axes are (n_panels,)."""
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(n_rows, n_columns, squeeze=False).ravel()
    for panel in axes:
        panel.spines[["top", "right"]].set_visible(False)
        panel.grid(color=FAINT, linewidth=0.5)
        panel.set_axisbelow(True)
    return figure, axes


def label_ends(panel, labels, height_in):
    """Write labels beside the right ends of curves, none over another.

    Labels are (height of the end, text, colour), those that are not finite are left
    out; the limits of the panel are set, its height in inches is a rough one.
    """
    low, high = panel.get_ylim()
    shown = sorted(label for label in labels if np.isfinite(label[0]))
    places = apart([y for y, *_ in shown], LINE_PT / 72.0 / height_in * (high - low))
    for place, (_, text, colour) in zip(places, shown, strict=True):
        panel.annotate(
            text,
            (1.015, place),
            xycoords=("axes fraction", "data"),
            va="center",
            color=colour,
            fontsize=SMALL,
            annotation_clip=False,
        )


def apart(places, gap):
    """Move growing places as little as it takes to have a gap between neighbours.

    >>> apart([1.0, 1.5, 9.0], 1.0)
    [0.75, 1.75, 9.0]
    """
    groups = []
    for place in places:
        groups.append([place])
        while len(groups) > 1 and _top(groups[-2], gap) > _bottom(groups[-1], gap):
            groups[-2:] = [groups[-2] + groups[-1]]
    return [
        _bottom(group, gap) + gap / 2.0 + gap * i
        for group in groups
        for i in range(len(group))
    ]


def _bottom(group, gap):
    return sum(group) / len(group) - gap * len(group) / 2.0


def _top(group, gap):
    return sum(group) / len(group) + gap * len(group) / 2.0


def note(panel, text, place, **more):
    """Write a small grey remark into a panel, at a place in its data."""
    panel.annotate(text, place, **{"color": EDGE, "fontsize": SMALL, **more})


def headline(figure, title, text):
    """Write what a figure shows above it, and how to read it."""
    # empty lines keep the room in which the text stands
    room = "\n" * (text.count("\n") + 1)
    figure.suptitle(
        f"{title}{room}", x=0.008, ha="left", fontsize=11.0, weight="bold", color=INK
    )
    below = 1.0 - TITLE_IN / figure.get_figheight()
    figure.text(0.008, below, text, fontsize=SMALL, color=EDGE, va="top")
