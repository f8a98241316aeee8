"""Figure of the parallaxes that a relative orientation leaves, as SVG text.

One panel per model, all to one scale: the points in plan, the base between the two
projection centres, and the residual parallax of each point as a stroke across the base.
The same result gives the same text, byte for byte.
"""

import math
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from einschalt.foundations.display_names import shortened
from einschalt.foundations.language import mark, translated
from einschalt.foundations.typesetting import number
from einschalt.foundations.units import UM_PER_MM
from einschalt.interfaces.reports.figure_style import (
    EDGE,
    FAINT,
    FONT,
    INK,
    STYLE,
    WIDTH_IN,
    draw_bar,
    round_down,
    svg_figure,
    svg_of,
)

MOST_PANELS = 12
MOST_NAMED = 12
SMALL_FONT = 7.0
POINT, STROKE, LARGE = EDGE, "#2f8f7a", "#b4430b"
VERDICT_COLOURS = {mark("weak"): "#8a6100", mark("critical"): LARGE}
LARGE_FROM = 3.29
"""In standard errors of the residual: one in a thousand is larger by chance."""
TITLE_IN, GAP_IN, FOOT_IN, SIDE_IN = 0.46, 0.16, 0.62, 0.1
TALLEST_IN = 7.4
LARGEST_PANEL_IN = 4.4
LEAST_PANEL_IN = 1.05
BAR_IN = 0.7
USUAL_STROKE, LONGEST_STROKE = 0.1, 0.24  # in heights of a panel
NEAREST_NAME_IN = 0.09
LEAST_NAMED_IN = 1.6


def parallax_figure(points, models) -> str:
    """Draw the residual parallaxes of the models with the largest ones.

    ``points``: model, point_id, x, y (in plan, x along the base, origin in the left
    projection centre), residual, standard_error of the residual or NaN; ``models``:
    model, base, sigma_0, verdict; all in mm. An ``<svg>`` element; empty where there
    are no residuals.
    """
    points = points[np.isfinite(points["residual"])]
    models = models[models["model"].isin(points["model"])]
    chosen = _chosen(points, models)
    if chosen.empty:
        return ""
    points = points[points["model"].isin(chosen["model"])]
    with mpl.rc_context(STYLE):
        sheet = _sheet(points, chosen)
        by_model = dict(iter(points.groupby("model", sort=False)))
        for place, model in enumerate(chosen.itertuples()):
            _draw_panel(sheet, place, model, by_model[model.model])
        _draw_foot(sheet, points, n_shown=len(chosen), n_all=len(models))
        title = translated("Residual parallaxes of the models")
        return svg_of(sheet.figure, "parallaxes", title)


def _chosen(points, models):
    """Models that are shown, in their order: those with the largest residuals."""
    size = points["residual"].abs().groupby(points["model"], sort=False).max()
    order = np.argsort(-size[models["model"]].to_numpy(), kind="stable")
    return models.iloc[np.sort(order[:MOST_PANELS])]


@dataclass(frozen=True, eq=False)
class _Sheet:
    """A figure with equal panels, and the scales that hold in all of them."""

    figure: Figure
    n_columns: int
    panel_in: np.ndarray
    low: np.ndarray
    high: np.ndarray
    exaggeration: float

    @property
    def mm_per_in(self):
        return float((self.high - self.low)[0] / self.panel_in[0])

    def corner_in(self, place):
        """Lower left corner of a panel, from the upper left corner of the sheet."""
        row, column = divmod(place, self.n_columns)
        step = self.panel_in + np.array([GAP_IN, TITLE_IN])
        return np.array([SIDE_IN + column * step[0], (row + 1) * step[1]])


def _sheet(points, models):
    places = points[["x", "y"]].to_numpy()
    centres = np.array([[0.0, 0.0], [models["base"].max(), 0.0]])
    places = np.vstack([places, centres])
    low, high = places.min(axis=0), places.max(axis=0)
    size = np.maximum(high - low, (high - low).max() / 3.0) * 1.16
    n_columns, scale = _best_grid(len(models), size)
    n_rows = math.ceil(len(models) / n_columns)
    panel = size * scale
    figure = svg_figure((WIDTH_IN, n_rows * (panel[1] + TITLE_IN) + FOOT_IN))
    middle = (low + high) / 2.0
    low, high = middle - size / 2.0, middle + size / 2.0
    exaggeration = _exaggeration(points["residual"].abs().to_numpy() / size[1])
    return _Sheet(figure, n_columns, panel, low, high, exaggeration)


def _best_grid(n_panels, size):
    """Columns of panels with which these are largest, and inches per millimetre."""
    found = []
    for n_columns in range(1, n_panels + 1):
        n_rows = math.ceil(n_panels / n_columns)
        room = [
            (WIDTH_IN - 2.0 * SIDE_IN - GAP_IN * (n_columns - 1)) / n_columns,
            (TALLEST_IN - FOOT_IN) / n_rows - TITLE_IN,
        ]
        scale = float((np.minimum(room, LARGEST_PANEL_IN) / size).min())
        # titles need their width, and fewer rows are better where panels are equal
        has_room = scale * size[0] >= LEAST_PANEL_IN or n_columns == 1
        found.append((has_room, round(scale, 9), n_columns))
    _, scale, n_columns = max(found)
    n_rows = math.ceil(n_panels / n_columns)
    return math.ceil(n_panels / n_rows), scale


def _exaggeration(residuals):
    """Round factor at which most strokes are short, and the longest not too long.

    The residuals are in heights of a panel.
    """
    longest = residuals.max()
    if longest == 0.0:
        return 1.0
    usual = max(np.quantile(residuals, 0.95), 1e-9 * longest)
    return round_down(min(USUAL_STROKE / usual, LONGEST_STROKE / longest))


def _axes(sheet, corner_in, size_in):
    width, height = sheet.figure.get_size_inches()
    left, below_top = corner_in
    place = (left / width, 1.0 - below_top / height)
    return sheet.figure.add_axes((*place, size_in[0] / width, size_in[1] / height))


def _draw_panel(sheet, place, model, points):
    axes = _axes(sheet, sheet.corner_in(place), sheet.panel_in)
    axes.set(
        xlim=(sheet.low[0], sheet.high[0]),
        ylim=(sheet.low[1], sheet.high[1]),
        xticks=[],
        yticks=[],
    )
    axes.spines[:].set_color(FAINT)
    axes.plot([0.0, model.base], [0.0, 0.0], color=FAINT, linewidth=1.2, zorder=1)
    axes.plot(
        *([0.0, model.base], [0.0, 0.0]),
        linestyle="",
        marker="+",
        markersize=6.0,
        markeredgewidth=0.8,
        color=INK,
        zorder=2,
    )
    _draw_strokes(sheet, axes, points)
    if len(points) <= MOST_NAMED and sheet.panel_in[0] >= LEAST_NAMED_IN:
        _draw_names(sheet, axes, points)
    _draw_title(sheet, axes, model)


def _draw_strokes(sheet, axes, points):
    foot = points[["x", "y"]].to_numpy()
    tip = foot.copy()
    tip[:, 1] += points["residual"].to_numpy() * sheet.exaggeration
    is_large = _are_large(points)
    axes.add_collection(
        LineCollection(
            np.stack([foot, tip], axis=1),
            colors=np.where(is_large, LARGE, STROKE),
            linewidths=1.6 if len(points) <= 60 else 1.0,
            zorder=3,
            clip_on=False,
        ),
        autolim=False,
    )
    size = 7.0 if len(points) <= 60 else 2.5
    axes.scatter(*foot.T, s=size, color=POINT, linewidths=0, zorder=4)


def _are_large(points):
    return (points["residual"].abs() > LARGE_FROM * points["standard_error"]).to_numpy()


def _draw_names(sheet, axes, points):
    beside = NEAREST_NAME_IN * sheet.mm_per_in
    middle = (sheet.low[0] + sheet.high[0]) / 2.0
    for point in points.itertuples():
        side = 1.0 if point.x <= middle else -1.0
        axes.text(
            point.x + side * beside,
            point.y,
            shortened(point.point_id, 12),
            ha="left" if side > 0.0 else "right",
            va="center",
            fontsize=SMALL_FONT,
            color=EDGE,
            parse_math=False,
        )


def _draw_title(sheet, axes, model):
    """Name, and below it sigma_0 and a verdict that is not safe."""
    width, height = sheet.panel_in
    said = [f"σ₀ {number(model.sigma_0 * UM_PER_MM)} µm"]
    said = said if math.isfinite(model.sigma_0) else []
    said += [translated(model.verdict)] if model.verdict in VERDICT_COLOURS else []
    colour = VERDICT_COLOURS.get(model.verdict, INK)
    name = shortened(model.model, max(int(width * 10.0), 8))
    lines = ((0.19, name, FONT, "bold"), (0.05, ", ".join(said), SMALL_FONT, "normal"))
    for above_in, text, size, weight in lines:
        axes.text(
            0.0,
            1.0 + above_in / height,
            text,
            fontsize=size,
            weight=weight,
            color=colour,
            va="bottom",
            transform=axes.transAxes,
            parse_math=False,
        )


def _draw_foot(sheet, points, *, n_shown, n_all):
    height = sheet.figure.get_size_inches()[1]
    axes = _axes(sheet, (SIDE_IN, height), (WIDTH_IN - 2.0 * SIDE_IN, FOOT_IN))
    axes.set(xlim=(0.0, WIDTH_IN - 2.0 * SIDE_IN), ylim=(0.0, FOOT_IN))
    axes.axis("off")
    _draw_bars(sheet, axes)
    text = translated("+ projection centres")
    if n_shown < n_all:
        text = translated(
            "{key}; {n} of {n_all:model|models}, those with the largest residuals",
            key=text,
            n=n_shown,
            n_all=n_all,
        )
    axes.text(2.9, 0.38, text, va="center", fontsize=FONT)
    if _are_large(points).any():
        axes.plot([2.9, 3.15], [0.16, 0.16], color=LARGE, linewidth=1.6)
        message = mark("more than {factor} times its standard error")
        text = translated(message, factor=number(LARGE_FROM, 3))
        axes.text(3.23, 0.16, text, va="center", fontsize=FONT)


def _draw_bars(sheet, axes):
    model_mm = round_down(BAR_IN * sheet.mm_per_in)
    parallax_mm = round_down(BAR_IN * sheet.mm_per_in / sheet.exaggeration)
    said_model = translated("{size} mm in plan", size=number(model_mm))
    facts = {
        "size": number(parallax_mm * UM_PER_MM),
        "factor": number(sheet.exaggeration),
    }
    said_parallax = translated("{size} µm (parallax × {factor})", **facts)
    bars = (
        (0.38, model_mm / sheet.mm_per_in, said_model, INK),
        (
            0.16,
            parallax_mm * sheet.exaggeration / sheet.mm_per_in,
            said_parallax,
            STROKE,
        ),
    )
    for bottom, wide, text, colour in bars:
        draw_bar(axes, bottom, wide, text, colour)
