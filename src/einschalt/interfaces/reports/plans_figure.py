"""Plans by cost and precision, with those that no other beats."""

import matplotlib as mpl
from matplotlib.ticker import FuncFormatter

from einschalt.foundations.language import in_english
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


@in_english
def plans_figure(search, checked=None):
    """Draw cost against precision; ``checked`` is the plan that holds on its layout."""
    with mpl.rc_context(SHEET_STYLE):
        figure, (panel,) = panels(1, 1, SIZE_IN)
        headline(
            figure,
            f"{len(search.plans)} plans, {length(search.target)} wanted",
            "The staircase joins the plans that no other plan beats in both cost and "
            "precision.",
        )
        draw_plans(panel, search, checked)
        return figure


def draw_plans(panel, search, checked=None):
    """Draw all plans on logarithmic axes, the target, and the plan to take."""
    _draw_dots(panel, search)
    panel.set(xscale="log", yscale="log", xlabel="cost for each km²")
    panel.set_ylabel("total error at the place of the target [cm]")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(FuncFormatter(_some_minor))
    _draw_target(panel, search)
    best = search.nearest
    name = "cheapest" if best["is_feasible"] else "nearest"
    is_other = checked is not None and not checked.plan.equals(best)
    if is_other and checked.is_kept:
        _point_out(panel, checked.plan, checked.reached, "holds on its layout", 0)
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
    for text, below, colour in (
        (f"{rest} plans beyond {length(search.target)}", 5, EDGE),
        (f"{n_feasible} reach it", -12, PAPER),
    ):
        note(panel, text, (1.0, target), xytext=(0, below), color=colour, **at_right)


def _point_out(panel, plan, reached, name, place):
    """Name a plan below and left of the front, where no plan can be."""
    at = (plan["cost"], 100.0 * reached)
    panel.plot(*at, "D" if place == 0 else "s", color=CHOSEN, ms=6, zorder=5)
    text = (
        f"{name}: {scale(plan['scale_number'])} after "
        f"{scale(plan['high_scale_number'])},\n"
        f"{plan['n_coverages']:.0f} x covered, {plan['spacing']:g} m, set "
        f"{plan['n_settings']:.0f} x, {length(reached)}"
    )
    panel.annotate(
        text,
        at,
        xycoords="data",
        textcoords=("axes fraction", "axes fraction"),
        xytext=(0.03, 0.06 + 0.13 * place),
        color=CHOSEN,
        fontsize=SMALL,
        arrowprops={
            "arrowstyle": "-",
            "color": CHOSEN,
            "linewidth": 0.6,
            "relpos": (1.0, 0.5),
        },
    )


def _some_minor(value, _place):
    return f"{value:g}" if f"{value:e}"[0] in "235" else ""
