"""Kovarik's diagrams 1 to 4 on one sheet, for any camera and any values."""

import matplotlib as mpl
import numpy as np
from matplotlib.ticker import FuncFormatter, MaxNLocator
from matplotlib.transforms import ScaledTranslation

from einschalt.foundations.language import figure as figure_text
from einschalt.foundations.language import language, translated, written_in
from einschalt.foundations.typesetting import scale
from einschalt.foundations.units import METRES_PER_MM
from einschalt.interfaces.reports.axis_figures import set_figures
from einschalt.interfaces.reports.figure_files import (
    ORDERED,
    SHEET_STYLE,
    headline,
    label_ends,
    note,
    panels,
)
from einschalt.interfaces.reports.figure_style import EDGE, INK
from einschalt.pipeline.planning.estimate.text import KIND_TEXT

MOST_SPACINGS, MOST_M_0, MOST_PAIRS = len(ORDERED), 2, 8
MOST_BARS = 6
BESIDE_PT = 6.0
SMOOTH = 241
SHOWN_POINTS = np.arange(4, 101)
PANEL_IN = (4.3, 2.85)
DRAWN_IN = 2.1
HEAD_IN = 0.5


def diagrams_figure(table):
    """Draw diagrams 1 to 3, and 4 for each pair of m_0 and m_g.

    The first five spacings, diagram 3 for the first two m_0, diagram 4 for the first
    eight pairs.
    """
    m_0s = table.axes["m_0"][:MOST_M_0]
    pairs = [(a, b) for b in table.axes["m_g_um"] for a in table.axes["m_0"]]
    pairs = pairs[:MOST_PAIRS]
    n_panels = 2 + len(m_0s) + len(pairs)
    n_rows = -(-n_panels // 2)
    size = (2.0 * PANEL_IN[0], n_rows * PANEL_IN[1] + HEAD_IN)
    with mpl.rc_context(SHEET_STYLE):
        figure, axes = panels(n_rows, 2, size)
        title = translated("Precision before the flight")
        headline(figure, title, _how_to_read(table.model))
        for panel in axes[n_panels:]:
            panel.axis("off")
        _draw_points_alone(axes[0], table.model)
        _draw_points(axes[1], table)
        thirds, fourths = axes[2 : 2 + len(m_0s)], axes[2 + len(m_0s) : n_panels]
        _draw_alike(thirds, table, [(m_0, 0.0) for m_0 in m_0s])
        _draw_alike(fourths, table, pairs)
        for panel, m_0 in zip(thirds, m_0s, strict=True):
            size = figure_text(100 * m_0, ".3g")
            text = translated("transformation, $m_0$ = {size} cm", size=size)
            panel.set_title(f"3   {text}")
            panel.set_ylabel("$m_t$ [cm]")
        for i, (panel, (m_0, m_g)) in enumerate(zip(fourths, pairs, strict=True)):
            size, m_g_um = figure_text(100 * m_0, ".3g"), figure_text(m_g, "g")
            given = f"$m_0$ = {size} cm, $m_g$ = {m_g_um} µm"
            panel.set_title(f"4{'abcdefgh'[i]}   {given}")
            panel.set_ylabel("$M$ [cm]")
        return figure


def _how_to_read(model):
    along, across = (side / METRES_PER_MM for side in model.image_format)
    return translated(
        "{kind}, edge = {edge}; image {along} x {across} mm, overlaps {forward} and "
        "{side} %. Total point errors after the formula of 1971.\nBars reach from the "
        "middle of a model (tick) to its edge (dot). Lines: the edge; ring: the scale "
        "that is best there.",
        kind=translated(KIND_TEXT[model.kind]),
        edge=model.edge,
        along=figure_text(along, ".4g"),
        across=figure_text(across, ".4g"),
        forward=figure_text(100 * model.forward_overlap, ".3g"),
        side=figure_text(100 * model.side_overlap, ".3g"),
    )


def _draw_points_alone(panel, model):
    lines = [(translated("middle"), 1.0, INK)]
    if np.isfinite(model.edge_factor):
        lines.append((translated("edge"), model.edge_factor, EDGE))
    for _, factor, colour in lines:
        panel.plot(SHOWN_POINTS, factor * SHOWN_POINTS**-0.5, color=colour)
    panel.plot([30, 30, 0], [0, 30**-0.5, 30**-0.5], color=EDGE, linewidth=0.6)
    note(panel, f"n = 30: {figure_text(0.18)} $m_0$", (32, 0.02))
    panel.set_title(f"1   {translated('transformation by number of points')}")
    panel.set(xlabel=translated("points in a model, n"), ylabel="$m_t$ [$m_0$]")
    set_figures(panel.yaxis)
    panel.set(xlim=(0, 100), ylim=(0, None))
    label_ends(panel, [(f * 0.1, text, colour) for text, f, colour in lines], DRAWN_IN)


def _draw_points(panel, table):
    smooth, ends = _smooth(table), []
    for spacing, colour in zip(_spacings(table), ORDERED, strict=False):
        n_points = table.model.n_points(smooth, spacing)
        panel.plot(smooth, n_points, color=colour)
        ends.append((n_points[-1], f"{figure_text(spacing, 'g')} m", colour))
    panel.set_title(f"2   {translated('points in a model')}")
    panel.set(ylabel="n", ylim=(0, None))
    _scale_axis(panel)
    label_ends(panel, ends, DRAWN_IN)


def _draw_alike(axes, table, pairs):
    """Draw the error for pairs of m_0 and m_g, all panels with the same height."""
    ends = [
        _draw_ranges(panel, table, *pair)
        for panel, pair in zip(axes, pairs, strict=True)
    ]
    top = max(panel.get_ylim()[1] for panel in axes)
    for panel, labels in zip(axes, ends, strict=True):
        panel.set_ylim(0.0, top)
        label_ends(panel, labels, DRAWN_IN)


def _draw_ranges(panel, table, m_0, m_g_um):
    """Draw the error from the middle to the edge, and return where curves end."""
    smooth, ends = _smooth(table), []
    spacings = _spacings(table)
    for i, (spacing, colour) in enumerate(zip(spacings, ORDERED, strict=False)):
        _, edge = _errors(table.model, smooth, spacing, m_0, m_g_um)
        panel.plot(smooth, edge, color=colour, linewidth=1.1)
        best = int(np.nanargmin(edge)) if np.isfinite(edge).any() else 0
        if 0 < best < len(smooth) - 1:
            ring = {"markerfacecolor": "white", "markeredgecolor": colour}
            panel.plot(smooth[best], edge[best], "o", markersize=6, **ring)
        beside = BESIDE_PT * (i - (len(spacings) - 1) / 2.0)
        _draw_bars(panel, table, (spacing, m_0, m_g_um), colour, beside)
        ends.append((edge[-1], f"{figure_text(spacing, 'g')} m", colour))
    _scale_axis(panel)
    return ends


def _draw_bars(panel, table, given, colour, beside):
    """Draw a bar at each image scale, moved a little so that none hides another."""
    scales = table.axes["scale_number"]
    if len(scales) > MOST_BARS:
        scales = scales[np.linspace(0, len(scales) - 1, MOST_BARS).round().astype(int)]
    low, high = _errors(table.model, scales, *given)
    moved = panel.transData + ScaledTranslation(
        beside / 72.0, 0.0, panel.figure.dpi_scale_trans
    )
    drawn = {"transform": moved, "color": colour}
    panel.vlines(scales, low, high, linewidth=3.5, alpha=0.35, **drawn)
    panel.plot(scales, high, "o", markersize=3.5, **drawn)
    panel.plot(scales, low, "_", markersize=6.5, markeredgewidth=1.4, **drawn)


def _errors(model, scales, spacing, m_0, m_g_um):
    """Error in the middle and at the edge [cm], NaN where it is not finite."""
    leverage = model.leverage(scales, spacing)
    ground = m_g_um * 1e-6 * scales
    errors = [
        100.0 * np.hypot(ground, m_0 * np.sqrt(h))
        for h in (leverage.centre, leverage.edge)
    ]
    return [np.where(np.isfinite(error), error, np.nan) for error in errors]


def _spacings(table):
    return table.axes["spacing"][:MOST_SPACINGS]


def _smooth(table):
    """Scale numbers for a curve: those of the table, and a little beyond one value."""
    scales = table.axes["scale_number"]
    low, high = scales.min(), scales.max()
    if low == high:
        low, high = 0.7 * low, 1.5 * high
    return np.linspace(low, high, SMOOTH)


def _scale_axis(panel):
    panel.set_xlabel(translated("image scale"))
    spoken = language()

    def scale_text(value, _):
        with written_in(spoken):
            return scale(value)

    panel.xaxis.set_major_locator(MaxNLocator(4, integer=True, steps=[1, 2, 2.5, 5]))
    panel.xaxis.set_major_formatter(FuncFormatter(scale_text))
    set_figures(panel.yaxis)
    panel.margins(x=0.06)
