"""Figures that stand by themselves: panels, labels at the curves, and their bytes."""

import io

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.atomic import write_bytes
from einschalt.interfaces.reports.map_sheet import EDGE, FAINT, INK, STYLE

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
    """Write a figure.

    Parameters
    ----------
    figure : Figure
    kinds : iterable of {"png", "svg"}

    Returns
    -------
    dict of str to bytes
        By kind. The same figure gives the same bytes.
    """
    files = {}
    with mpl.rc_context(SHEET_STYLE):
        for kind in kinds:
            buffer = io.BytesIO()
            figure.savefig(buffer, format=kind, dpi=PNG_DPI, **FIGURE_FORMATS[kind])
            files[kind] = buffer.getvalue()
    return files


def write_figure(draw, file):
    """Write a figure in the format that the suffix of its file names.

    Parameters
    ----------
    draw : callable
        Gives the Figure; not called where the suffix is unknown.
    file : Path

    Raises
    ------
    FileError
        The suffix is none of .png and .svg, or the file cannot be written.
    """
    kind = file.suffix.lower().removeprefix(".")
    if kind not in FIGURE_FORMATS:
        raise FileError(
            f"the suffix {file.suffix!r} is none of a figure",
            expected=" or ".join(f".{known}" for known in FIGURE_FORMATS),
            remedy=f"Write {file.stem or 'plan'}.png",
            file=file.name,
        )
    write_bytes(file, figure_bytes(draw(), (kind,))[kind])


def panels(n_rows, n_columns, size):
    """Make a figure of equal panels.

    Parameters
    ----------
    n_rows, n_columns : int
    size : tuple of float
        [inch]

    Returns
    -------
    figure : Figure
    axes : ndarray of Axes, shape (n_rows · n_columns,)
    """
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

    Parameters
    ----------
    panel : Axes
        Its limits are set.
    labels : list of (float, str, str)
        Height of the end, text, colour; those that are not finite are left out.
    height_in : float
        Of the panel, roughly [inch].
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
    """Move places as little as it takes to have a gap between neighbours.

    Parameters
    ----------
    places : sequence of float
        Growing.
    gap : float

    Returns
    -------
    list of float

    Examples
    --------
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
    """Write a small grey remark into a panel.

    Parameters
    ----------
    panel : Axes
    text : str
    place : tuple of float
        In data.
    **more
        Of ``Axes.annotate``.
    """
    panel.annotate(text, place, **{"color": EDGE, "fontsize": SMALL, **more})


def headline(figure, title, text):
    """Write what a figure shows above it.

    Parameters
    ----------
    figure : Figure
    title : str
    text : str
        How to read it.
    """
    # empty lines keep the room in which the text stands
    room = "\n" * (text.count("\n") + 1)
    figure.suptitle(
        f"{title}{room}", x=0.008, ha="left", fontsize=11.0, weight="bold", color=INK
    )
    below = 1.0 - TITLE_IN / figure.get_figheight()
    figure.text(0.008, below, text, fontsize=SMALL, color=EDGE, va="top")
