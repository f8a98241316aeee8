"""Plans by cost and precision, with those that no other beats."""

import matplotlib as mpl
import numpy as np
from matplotlib.ticker import FuncFormatter

from einschalt.foundations.language import figure as figure_text
from einschalt.foundations.language import language, mark, translated, written_in
from einschalt.foundations.typesetting import length, scale
from einschalt.interfaces.reports.figure_files import (
    EXPECTED,
    PAPER,
    SHEET_STYLE,
    SMALL,
    headline,
    note,
    panels,
)
from einschalt.interfaces.reports.figure_style import EDGE, INK

SIZE_IN = (7.6, 5.2)
CHOSEN = "#8a1538"


def plans_figure(search, checked=None):
    """Draw cost against precision; ``checked`` is the plan that holds on its layout."""
    with mpl.rc_context(SHEET_STYLE):
        figure, (panel,) = panels(1, 1, SIZE_IN)
        text = translated(
            "The staircase joins the plans that no other plan beats in both cost and "
            "precision."
        )
        headline(figure, plans_title(search), text)
        draw_plans(panel, search, checked)
        return figure


def plans_title(search):
    """How many plans there are, and what was asked of them."""
    facts = {"n": len(search.plans), "length": length(search.target)}
    return translated("{n:plan|plans}, {length} wanted", **facts)


def draw_plans(panel, search, checked=None):
    """Draw all plans on logarithmic axes, the target, and the plan to take."""
    if not np.isfinite(search.plans["reached"]).any():
        panel.set_axis_off()
        text = translated("The estimate bounds the error of no plan.")
        note(panel, text, (0.5, 0.5), xycoords="axes fraction", ha="center")
        return
    _draw_dots(panel, search)
    panel.set(xscale="log", yscale="log", xlabel=translated("cost for each km²"))
    panel.set_ylabel(translated("total error at the place of the target [cm]"))
    spoken = language()

    def value_text(value, _):
        with written_in(spoken):
            return figure_text(value, "g")

    def some_minor(value, place):
        return value_text(value, place) if f"{value:e}"[0] in "235" else ""

    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_formatter(FuncFormatter(value_text))
        axis.set_minor_formatter(FuncFormatter(some_minor))
    _draw_target(panel, search)
    best = search.nearest
    name = mark("cheapest estimate") if best["is_feasible"] else mark("nearest")
    is_other = checked is not None and not checked.plan.equals(best)
    if is_other and checked.is_kept:
        held = mark("holds on its layout")
        _point_out(panel, checked.plan, checked.reached, held, 0)
    _point_out(panel, best, best["reached"], name, int(is_other))


def _draw_dots(panel, search):
    plans = search.plans
    for is_feasible, colour in ((False, EDGE), (True, PAPER)):
        part = plans[plans["is_feasible"] == is_feasible]
        panel.scatter(
            *(part["cost"], 100.0 * part["reached"]),
            s=6,
            alpha=0.4,
            color=colour,
            linewidths=0,
            rasterized=True,
        )
    front = plans[plans["is_efficient"]].sort_values("cost")
    reached = 100.0 * front["reached"]
    panel.step(front["cost"], reached, where="post", color=EXPECTED, linewidth=1.1)
    panel.plot(front["cost"], reached, "o", color=EXPECTED, ms=3, label="efficient")


def _draw_target(panel, search):
    """Draw the target, and how many plans lie on either side of it."""
    target, n_feasible = 100.0 * search.target, int(search.plans["is_feasible"].sum())
    panel.axhline(target, color=INK, linewidth=0.8)
    rest = len(search.plans) - n_feasible
    at_right = {
        "xycoords": ("axes fraction", "data"),
        "textcoords": "offset points",
        "ha": "right",
    }
    missing = {"n": rest, "length": length(search.target)}
    for text, below, colour in (
        (translated("{n:plan|plans} miss {length}", **missing), 5, EDGE),
        (translated("{n} reach it", n=n_feasible), -12, PAPER),
    ):
        note(panel, text, (1.0, target), xytext=(0, below), color=colour, **at_right)


def _point_out(panel, plan, reached, name, place):
    """Name a plan below and left of the front, where no plan can be."""
    at = (plan["cost"], 100.0 * reached)
    panel.plot(*at, "D" if place == 0 else "s", color=CHOSEN, ms=6, zorder=5)
    text = translated(
        "{name}: low flight {low}, high flight {high},\n"
        "{n_coverages:coverage|coverages}, {spacing} m, "
        "{n_settings:pointing|pointings each}, {length}",
        name=translated(name),
        low=scale(plan["scale_number"]),
        high=scale(plan["high_scale_number"]),
        n_coverages=int(plan["n_coverages"]),
        spacing=figure_text(plan["spacing"], "g"),
        n_settings=int(plan["n_settings"]),
        length=length(reached),
    )
    panel.annotate(
        text,
        at,
        xycoords="data",
        textcoords=("axes fraction", "axes fraction"),
        xytext=(0.03, 0.03 + 0.11 * place),
        color=CHOSEN,
        fontsize=SMALL,
        arrowprops={
            "arrowstyle": "-",
            "color": CHOSEN,
            "linewidth": 0.6,
            "relpos": (1.0, 0.5),
        },
    )
