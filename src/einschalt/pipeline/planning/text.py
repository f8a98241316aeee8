"""Plans as text: tables in the order of Kovarik's diagrams, and what a search found."""

import numpy as np

from einschalt.foundations import typesetting
from einschalt.foundations.typesetting import (
    count,
    fixed,
    length,
    number,
    scale,
    wrapped,
)
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.planning.cameras import describe_heights
from einschalt.theory.planning.kovarik_precision import settings_that_balance

MOST_SCALES, MOST_SPACINGS, MOST_BLOCKS = 8, 10, 8
SHOWN_PLANS = 10
SHOWN_POINTS = (5, 10, 15, 20, 30, 50, 100)
ROUNDED = "numbers of points are means, and not rounded"
BREAK_EVEN = """\
Break-even at the edge: so many settings of a point pay, beyond them m_t decides. Below
1 even one is wasted there, and denser points pay: down to the spacing times the root"""
TOO_GOOD = (
    "M is Kovarik's formula. It takes both coverages, and the approximate coordinates "
    "of neighbours, for independent of each other; they are not, and the mean of two "
    "coverages is worse than it says."
)
PLACES = {
    "centre": "at the centre of models",
    "edge": "at the edge of models",
    "everywhere": "everywhere",
}
FORMULAS = {
    "expected": "as is to be expected",
    "paper": "by the formula of 1971, which is too good",
}
LIMITS = {
    "measuring": "measuring in the low flight",
    "noise": "noise of the approximate coordinates",
    "transformation": "the transformations of the high flight",
    "control": "the errors of control",
}
REMEDIES = {
    "measuring": "Set points more often, fly lower, or with more coverages",
    "noise": "Fly the high flight lower, or with more coverages",
    "transformation": "Fly the high flight lower, measure it better, or give its "
    "models nine control points",
    "control": "Survey the control better, or give nine points to each model",
}
SEVERAL_COVERAGES = (
    "  With several coverages it is the error of their mean, alike at every place."
)
ONE_COVERAGE = """\
  One coverage has no other to be compared with: gross errors stay unseen, and only
  control says how good it was. Two: --n-coverages 2"""


def describe_table(table, best) -> str:
    """Write a table of precision as aligned text.

    ``best`` has the columns of the scales that are best for the edge.
    """
    parts = [
        _head(table),
        problems(table.warnings),
        _points_alone(table),
        _points(table),
        _transformation(table),
        _totals(table),
        _break_even(table),
        _best(best),
        wrapped(TOO_GOOD),
    ]
    return "\n\n".join(part for part in parts if part)


def problems(warnings) -> str:
    """List what the planner should know first."""
    said = [wrapped(text, first="  ", indent="    ") for text in warnings]
    return "\n".join(["Problems and suggestions", *(said or ["  none"])])


def _head(table):
    model = table.model
    sides = [side / METRES_PER_MM for side in model.image_format]
    counted = " x ".join(f"{side / METRES_PER_MM:.4g}" for side in model.extent)
    n_all = int(np.prod(table.shape))
    image = f"{sides[0]:.4g} x {sides[1]:.4g} mm"
    distance = f"{table.principal_distance / METRES_PER_MM:.4g} mm"
    overlaps = f"{100 * model.forward_overlap:.3g} % and {100 * model.side_overlap:.3g}"
    return (
        f"Precision before the flight: {model.kind}, edge = {model.edge}, "
        f"{count(n_all, 'combination')}\n"
        f"  image {image}, principal distance {distance}, overlaps {overlaps} %\n"
        f"  points counted on {counted} mm of the image; all errors are total"
    )


def _points_alone(table):
    """Diagram 1: what a number of points makes of m_0."""
    factor = table.model.edge_factor
    rows = [["centre", *(fixed(n**-0.5, 2) for n in SHOWN_POINTS)]]
    if np.isfinite(factor):
        rows.append(["edge", *(fixed(factor * n**-0.5, 2) for n in SHOWN_POINTS)])
    header = ["points", *(str(n) for n in SHOWN_POINTS)]
    text = typesetting.table(rows, header=header)
    return f"m_t by the number of points in a model [m_0] (diagram 1)\n{text}"


def _points(table):
    """Diagram 2."""
    values = table.array("n_points")[:, :, 0, 0]
    text = _grid(table, [("", values)], lambda value: fixed(value, 1))
    return f"Points in a model (diagram 2); {ROUNDED}\n{text}"


def _transformation(table):
    """Diagram 3, one table for each m_0."""
    at = {name: table.array(f"m_t_{name}")[..., 0] for name in ("centre", "edge")}
    return _blocks(
        f"m_t [cm] with m_0 = {_cm(m_0)} cm (diagram 3)\n"
        + _grid(table, [(name, at[name][:, :, i]) for name in at], _in_cm)
        for i, m_0 in enumerate(table.axes["m_0"])
    )


def _totals(table):
    """Diagram 4, one table for each m_0 and m_g."""
    named = {"centre": "M_centre", "edge": "M_edge", "double": "M_double"}
    return _blocks(
        f"M [cm] with m_0 = {_cm(m_0)} cm, m_g = {m_g:g} µm (diagram 4)\n"
        + _grid(
            table,
            [(label, table.array(name)[:, :, i, j]) for label, name in named.items()],
            _in_cm,
        )
        for j, m_g in enumerate(table.axes["m_g_um"])
        for i, m_0 in enumerate(table.axes["m_0"])
    )


def _grid(table, layers, write):
    """Rows of spacings, and of what is in each layer; columns of scales."""
    scales = table.axes["scale_number"][:MOST_SCALES]
    rows = []
    for j, spacing in enumerate(table.axes["spacing"][:MOST_SPACINGS]):
        for i, (label, values) in enumerate(layers):
            name = f"{spacing:g} m" if i == 0 else ""
            cells = [write(values[k, j]) for k in range(len(scales))]
            rows.append([name, label, *cells])
    header = ["spacing", "", *(scale(value) for value in scales)]
    align = "ll" + "r" * len(scales)
    text = typesetting.table(rows, header=header, align=align)
    hidden = [
        count(len(table.axes[name]) - most, noun)
        for name, most, noun in (
            ("scale_number", MOST_SCALES, "scale"),
            ("spacing", MOST_SPACINGS, "spacing"),
        )
        if len(table.axes[name]) > most
    ]
    return text + (f"\n  and {' and '.join(hidden)} more" if hidden else "")


def _blocks(texts):
    texts = list(texts)
    rest = len(texts) - MOST_BLOCKS
    more = [f"and {count(rest, 'such table')} more"] if rest > 0 else []
    return "\n\n".join([*texts[:MOST_BLOCKS], *more])


def _break_even(table):
    """Settings up to which a better measurement decides at the edge."""
    m_g, m_t = table.array("m_g_ground"), table.array("m_t_edge")
    settings = settings_that_balance(m_g, m_t)
    scales = table.axes["scale_number"][:MOST_SCALES]
    combinations = [
        [f"{spacing:g} m", f"{_cm(m_0)} cm", f"{m_g:g} µm", settings[:, j, m, k]]
        for k, m_g in enumerate(table.axes["m_g_um"])
        for m, m_0 in enumerate(table.axes["m_0"])
        for j, spacing in enumerate(table.axes["spacing"])
    ]
    rows = [
        [*words, *map(number, at_scales[: len(scales)])]
        for *words, at_scales in combinations[: 3 * MOST_BLOCKS]
    ]
    header = ["spacing", "m_0", "m_g", *(scale(value) for value in scales)]
    text = typesetting.table(rows, header=header, align="r" * len(header))
    rest = len(combinations) - len(rows)
    more = f"\n  and {rest} more" if rest > 0 else ""
    return f"{BREAK_EVEN}\n{text}{more}"


def _best(best):
    """Scales beyond which a lower flight loses accuracy at the edge."""
    rows = [
        [
            f"{best['spacing'][i]:g} m",
            f"{_cm(best['m_0'][i])} cm",
            f"{best['m_g_um'][i]:g} µm",
            scale(best["scale_number"][i]),
            number(best["n_points"][i]),
            _in_cm(best["M_centre"][i]),
            _in_cm(best["M_edge"][i]),
        ]
        for i in range(min(len(best["spacing"]), 3 * MOST_BLOCKS))
    ]
    header = ["spacing", "m_0", "m_g", "scale", "points", "M centre", "M edge [cm]"]
    text = typesetting.table(rows, header=header, align="rrrrrrr")
    rest = len(best["spacing"]) - len(rows)
    more = f"\n  and {rest} more" if rest > 0 else ""
    return f"Best scale for the edge: a larger one loses accuracy there\n{text}{more}"


def _cm(metres):
    return f"{100.0 * metres:.4g}"


def _in_cm(metres):
    return fixed(100.0 * float(metres), 1)


def describe_verdict(search) -> str:
    """Say how many plans of a ``PlanSearch`` reach its target, and the best."""
    best = search.nearest
    aim = f"{length(search.target)} ({PLACES[search.where]}, {FORMULAS[search.by]})"
    if len(search.feasible):
        of_all = f"{len(search.feasible)} of {count(len(search.plans), 'plan')}"
        return (
            f"{of_all} reach {aim}, by the closed estimate; the cheapest: "
            f"{describe_plan(best)}"
        )
    limit = best["limited_by"]
    return (
        f"No plan of {len(search.plans)} reaches {aim}. The nearest comes to "
        f"{length(best['reached'])}: {describe_plan(best)}. It is limited by "
        f"{LIMITS[limit]}. {REMEDIES[limit]}. {describe_heights(best)}."
    )


def describe_search(search) -> str:
    """Say the verdict of a ``PlanSearch``, with its cheapest plans."""
    feasible, best = search.feasible, search.nearest
    shown = feasible
    if not len(feasible):
        shown = search.plans.sort_values("reached", kind="stable")
    rest = len(shown) - SHOWN_PLANS
    more = [f"  and {rest} more"] if rest > 0 else []
    return "\n".join(
        [
            wrapped(search.verdict, indent="  "),
            ONE_COVERAGE if best["n_coverages"] == 1 else SEVERAL_COVERAGES,
            "",
            _plans(shown.head(SHOWN_PLANS), search.by),
            *more,
            "  up to: the high flight above ground; cost, images and control for each",
            "  km²; errors are total, in cm",
        ]
    )


def describe_plan(plan) -> str:
    """Say a plan in a sentence.

    ``plan`` is a row of ``PlanSearch.plans``.
    """
    coverages = count(int(plan["n_coverages"]), "coverage")
    settings = count(int(plan["n_settings"]), "setting")
    return (
        f"{scale(plan['scale_number'])} after {scale(plan['high_scale_number'])}, "
        f"{coverages}, {plan['spacing']:g} m, {settings} of {plan['m_g_um']:g} µm, "
        f"{plan['control_per_model']:.0f} control points per model"
    )


def _plans(plans, by):
    other = "paper" if by == "expected" else "expected"
    rows = [
        [
            scale(plan.scale_number),
            scale(plan.high_scale_number),
            f"{plan.high_flying_height:.0f} m",
            f"{plan.spacing:g} m",
            f"{plan.n_coverages:.0f}",
            f"{plan.n_settings:.0f} x {plan.m_g_um:g} µm",
            f"{plan.control_per_model:.0f}",
            fixed(100.0 * plan.reached, 1),
            fixed(100.0 * getattr(plan, f"reached_{other}"), 1),
            number(plan.images, 2),
            number(plan.control_points, 2),
            number(plan.cost, 3),
        ]
        for plan in plans.itertuples()
    ]
    name = "formula" if by == "expected" else "expected"
    header = [
        "scale",
        "high",
        "up to",
        "spacing",
        "cov.",
        "settings",
        "control",
        "error",
        name,
    ]
    header += ["images", "c. points", "cost"]
    return typesetting.table(rows, header=header, align="r" * len(header))
