"""Figures of a plan: Kovarik's diagrams, plans by cost, and the map of precision."""

import io

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from einschalt.foundations.typesetting import length
from einschalt.interfaces.reports.map_sheet import EDGE, FAINT, INK, STYLE

COLOURS = ("#0b4f8a", "#2f8f7a", "#b4430b", "#6b4c9a", "#8a7a0b")
PAPER, EXPECTED = "#b4430b", "#0b4f8a"
PNG_DPI = 150
MOST_SPACINGS, MOST_PANELS = 5, 4
SMOOTH = 60
SHOWN_POINTS = np.arange(4, 101)
BINS = np.linspace(0.0, 0.5, 11)


def figure_bytes(figure):
    """Write a figure as PNG and as SVG.

    Parameters
    ----------
    figure : Figure

    Returns
    -------
    dict of str to bytes
        By suffix, ``png`` and ``svg``. The same figure gives the same bytes.
    """
    files = {}
    with mpl.rc_context(STYLE):
        for kind, metadata in (("png", {"Software": None}), ("svg", {"Date": None})):
            buffer = io.BytesIO()
            figure.savefig(buffer, format=kind, dpi=PNG_DPI, metadata=metadata)
            files[kind] = buffer.getvalue()
    return files


def points_and_transformation_figure(table) -> Figure:
    """Draw diagrams 1 to 3: points in a model, and what they make of m_0.

    Parameters
    ----------
    table : PrecisionTable

    Returns
    -------
    Figure
    """
    with mpl.rc_context(STYLE):
        figure, panels = _panels(1, 3, (10.4, 3.7))
        _draw_points_alone(panels[0], table.model)
        smooth = _smooth(table)
        for i, spacing in enumerate(_spacings(table)):
            colour = COLOURS[i]
            n_points = table.model.n_points(smooth, spacing)
            panels[1].plot(smooth, n_points, color=colour, label=f"{spacing:g} m")
            leverage = table.model.leverage(smooth, spacing)
            m_0 = 100.0 * table.axes["m_0"][0]
            low, high = (m_0 * np.sqrt(h) for h in (leverage.centre, leverage.edge))
            _band(panels[2], smooth, (low, high), colour, f"{spacing:g} m")
        panels[1].set(title="2  Points in a model", ylabel="n")
        panels[2].set(
            title=f"3  m_t with m_0 = {m_0:.3g} cm, middle to edge", ylabel="m_t [cm]"
        )
        for panel in panels[1:]:
            _scale_axis(panel)
            panel.set_ylim(bottom=0.0)
            panel.legend(title="spacing", frameon=False)
        return figure


def total_error_figure(table) -> Figure:
    """Draw diagrams 4 a to d: the total error from the middle to the edge.

    Parameters
    ----------
    table : PrecisionTable

    Returns
    -------
    Figure
        One panel for each pair of m_0 and m_g, at most four; a dot at the scale that is
        best for the edge.
    """
    pairs = [(a, b) for b in table.axes["m_g_um"] for a in table.axes["m_0"]]
    pairs = pairs[:MOST_PANELS]
    n_rows = -(-len(pairs) // 2)
    with mpl.rc_context(STYLE):
        n_columns = min(len(pairs), 2)
        figure, panels = _panels(n_rows, n_columns, (4.9 * n_columns, 3.7 * n_rows))
        smooth = _smooth(table)
        for panel, letter, (m_0, m_g) in zip(panels, "abcd", pairs, strict=False):
            _draw_total(panel, table.model, smooth, (_spacings(table), m_0, m_g))
            panel.set_title(f"4{letter}  m_0 = {100 * m_0:.3g} cm, m_g = {m_g:g} µm")
        top = max(panel.get_ylim()[1] for panel in panels)
        for panel in panels:
            panel.set_ylim(0.0, top)
        panels[0].legend(title="spacing", frameon=False, loc="lower right")
        return figure


def _draw_total(panel, model, smooth, given):
    spacings, m_0, m_g_um = given
    ground = m_g_um * 1e-6 * smooth
    for i, spacing in enumerate(spacings):
        leverage = model.leverage(smooth, spacing)
        low, high = (
            100.0 * np.hypot(ground, m_0 * np.sqrt(h))
            for h in (leverage.centre, leverage.edge)
        )
        _band(panel, smooth, (low, high), COLOURS[i], f"{spacing:g} m")
        best = int(np.argmin(high))
        if 0 < best < len(smooth) - 1:
            panel.plot(smooth[best], high[best], "o", color=COLOURS[i], markersize=4)
    panel.set_ylabel("M [cm], middle (dashed) to edge")
    _scale_axis(panel)


def _band(panel, x, edges, colour, label):
    """Draw a band from the middle (dashed) to the edge of models."""
    low, high = (np.where(np.isfinite(edge), edge, np.nan) for edge in edges)
    panel.fill_between(x, low, high, color=colour, alpha=0.13, linewidth=0)
    panel.plot(x, high, color=colour, linewidth=1.4, label=label)
    panel.plot(x, low, color=colour, linewidth=1.0, linestyle=(0, (4, 2)))


def _draw_points_alone(panel, model):
    panel.plot(SHOWN_POINTS, SHOWN_POINTS**-0.5, color=INK, label="middle")
    if np.isfinite(model.edge_factor):
        at_edge = model.edge_factor * SHOWN_POINTS**-0.5
        panel.plot(SHOWN_POINTS, at_edge, color=PAPER, label="edge")
    panel.plot([30, 30, 0], [0, 30**-0.5, 30**-0.5], color=EDGE, linewidth=0.6)
    panel.annotate("0.18 m_0 at n = 30", (32, 0.23), color=EDGE, fontsize=8)
    panel.set(title="1  m_t by the number of points", xlabel="n", ylabel="m_t [m_0]")
    panel.set(xlim=(0, 100), ylim=(0, None))
    panel.legend(frameon=False)


def plans_figure(search) -> Figure:
    """Draw cost against precision, with the plans that no other beats.

    Parameters
    ----------
    search : PlanSearch

    Returns
    -------
    Figure
    """
    plans = search.plans
    front = plans[plans["is_efficient"]].sort_values("cost")
    with mpl.rc_context(STYLE):
        figure, (panel,) = _panels(1, 1, (7.4, 4.8))
        for is_feasible, colour, label in (
            (False, EDGE, "beyond the target"),
            (True, COLOURS[1], "reaches the target"),
        ):
            part = plans[plans["is_feasible"] == is_feasible]
            panel.scatter(
                *(part["cost"], 100.0 * part["reached"]),
                s=5,
                alpha=0.35,
                color=colour,
                linewidths=0,
                label=f"{label} ({len(part)})",
                rasterized=True,
            )
        reached = 100.0 * front["reached"]
        panel.step(front["cost"], reached, where="post", color=EXPECTED, linewidth=1.3)
        panel.plot(
            front["cost"], reached, "o", color=EXPECTED, ms=3.5, label="efficient"
        )
        panel.axhline(100.0 * search.target, color=PAPER, linewidth=0.9)
        # half a line above the target, where the plot is empty at the left
        panel.annotate(
            f"target {length(search.target)}",
            (0.99, 100.0 * search.target),
            xycoords=("axes fraction", "data"),
            ha="right",
            va="bottom",
            color=PAPER,
        )
        best = search.nearest
        panel.plot(best["cost"], 100.0 * best["reached"], "D", color=PAPER, ms=6)
        name = "cheapest" if best["is_feasible"] else "nearest"
        panel.annotate(
            f"{name}: 1:{best['scale_number']:.0f} after "
            f"1:{best['high_scale_number']:.0f}",
            (best["cost"], 100.0 * best["reached"]),
            textcoords="offset points",
            xytext=(8, -16),
            color=PAPER,
            bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.0},
        )
        panel.set(xscale="log", yscale="log", xlabel="cost for each km²")
        panel.set_ylabel("error at the place of the target [cm]")
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(FuncFormatter(_some_minor))
        panel.legend(frameon=False, loc="upper right")
        return figure


def _some_minor(value, _place):
    return f"{value:g}" if f"{value:e}"[0] in "235" else ""


def precision_map_figure(expected, unshifted=None) -> Figure:
    """Draw the expected precision over the area, and from the middle to the edge.

    Parameters
    ----------
    expected : ExpectedPrecision
    unshifted : ExpectedPrecision, optional
        The same with coverages that are not shifted: what shifting gains.

    Returns
    -------
    Figure
    """
    shown = [("expected", expected, "standard_error_total")]
    if unshifted is not None:
        shown.append(("second coverage not shifted", unshifted, "standard_error_total"))
    shown.append(("formula of 1971", expected, "standard_error_paper"))
    errors = np.concatenate(
        [100.0 * _new(of.points)[column].to_numpy() for _, of, column in shown]
    )
    norm = mpl.colors.Normalize(*np.quantile(errors, [0.0, 0.98]))
    with mpl.rc_context(STYLE):
        n_maps = len(shown)
        figure, panels = _panels(1, n_maps + 1, (3.5 * n_maps + 4.2, 4.1))
        for panel, (title, of, column) in zip(panels[:-1], shown, strict=True):
            drawn = _draw_map(panel, of, column, norm)
            panel.set_title(title)
        bar = figure.colorbar(drawn, ax=panels[:-1].tolist(), shrink=0.85, pad=0.01)
        bar.set_label("total error of the mean [cm]")
        bar.outline.set_visible(False)
        _draw_profile(panels[-1], expected)
        return figure


def _draw_map(panel, expected, column, norm):
    """Draw the precision of all points as a surface between them."""
    points = _new(expected.points)
    drawn = panel.tripcolor(
        points["easting"] / 1e3,
        points["northing"] / 1e3,
        100.0 * points[column],
        shading="gouraud",
        cmap="viridis_r",
        norm=norm,
        rasterized=True,
    )
    control = expected.points[expected.points["role"] == "control"]
    panel.plot(
        *(control[name] / 1e3 for name in ("easting", "northing")),
        "^",
        markersize=3.5,
        markerfacecolor="white",
        markeredgecolor=INK,
        markeredgewidth=0.6,
        label="control",
    )
    panel.set_aspect("equal")
    panel.set_xlabel("east [km]")
    panel.grid(visible=False)
    return drawn


def _draw_profile(panel, expected):
    """Precision of one model's values by how far they lie from its middle."""
    values = expected.values
    away = values[["position_u", "position_v"]].abs().max(axis=1).to_numpy()
    place = np.clip(np.digitize(away, BINS) - 1, 0, len(BINS) - 2)
    centres = BINS[:-1] + BINS[1:]  # from 0 in the middle to 1 at the edge
    for column, colour, label in (
        ("standard_error_total", EXPECTED, "expected"),
        ("standard_error_paper", PAPER, "formula of 1971"),
    ):
        squares = values[column].to_numpy() ** 2
        count = np.bincount(place, minlength=len(centres))
        total = np.bincount(place, squares, minlength=len(centres))
        error = 100.0 * np.sqrt(np.divide(total, np.where(count, count, np.nan)))
        panel.plot(centres, error, "o-", color=colour, markersize=3, label=label)
    figures = expected.figures
    for value, colour in (
        (figures.mean, EXPECTED),
        (figures.paper_mean, PAPER),
    ):
        panel.axhline(100.0 * value, color=colour, linestyle=(0, (4, 2)), linewidth=1.0)
    panel.annotate(
        "dashed: mean of the coverages",
        (0.03, 0.03),
        xycoords="axes fraction",
        fontsize=8,
        color=EDGE,
    )
    panel.set(title="one model's values", xlim=(0, 1), ylim=(0, None))
    panel.set_ylim(top=1.25 * panel.get_ylim()[1])  # room for the key
    panel.set(xlabel="from the middle (0) to the edge (1)", ylabel="total error [cm]")
    panel.legend(frameon=False, loc="upper left")


def _new(points):
    return points[points["role"] == "new"]


def _panels(n_rows, n_columns, size):
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(n_rows, n_columns, squeeze=False).ravel()
    for panel in panels:
        panel.spines[["top", "right"]].set_visible(False)
        panel.grid(color=FAINT, linewidth=0.5)
        panel.set_axisbelow(True)
    return figure, panels


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
    panel.set_xlabel("image scale")
    panel.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"1:{value:.0f}"))
