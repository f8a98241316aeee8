"""Plans as text: tables in the order of Kovarik's diagrams, and what a search found."""

from textwrap import indent

import numpy as np

from einschalt.foundations import typesetting
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import (
    fixed,
    length,
    number,
    scale,
    wrapped,
)
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.planning.estimate.further_effort import describe_efforts
from einschalt.pipeline.planning.flights.cameras import describe_heights
from einschalt.theory.planning.kovarik_precision import settings_that_balance

MOST_SCALES, MOST_SPACINGS, MOST_BLOCKS = 8, 10, 8
SHOWN_PLANS = 10
MOST_DECIMALS = 6  # of centimetres
SHOWN_POINTS = (5, 10, 15, 20, 30, 50, 100)
BREAK_EVEN = mark(
    "Break-even at the edge: so many pointings at a point pay, beyond them m_t "
    "decides. Below 1 even one is wasted there, and denser points pay: down to the "
    "spacing times the root"
)
TOO_GOOD = mark(
    "M is Kovarik's formula. It takes both coverages, and the approximate coordinates "
    "of neighbours, for independent of each other; they are not, and the mean of two "
    "coverages is worse than it says."
)
PLACES = mark_each(
    {
        "centre": "at the centre of models",
        "edge": "at the edge of models",
        "everywhere": "everywhere",
    }
)
OF_ONE_COVERAGE = PLACES | mark_each({"corner": "in the corners of models"})
"""Where one coverage may be at its worst."""
FORMULAS = mark_each(
    {
        "expected": "expected error",
        "paper": "by the formula of 1971, which is too good",
    }
)
KIND_TEXT = mark_each({"affine": "affine", "helmert": "Helmert", "rigid": "rigid"})
LIMITS = mark_each(
    {
        "measuring": "measuring in the low flight",
        "noise": "noise of the approximate coordinates",
        "transformation": "the transformations of the high flight",
        "control": "the errors of control",
    }
)
SEVERAL_COVERAGES = mark(
    "With several coverages it is the root mean square of the means of all points, "
    "wherever they lie in models; single ones are worse."
)
ONE_COVERAGE = mark(
    "One coverage has no other to be compared with: gross errors stay unseen, and only "
    "control says how good it was. Two: --n-coverages 2"
)
WHERE_IS_OF_ONE = mark(
    "--where {where} counts with one coverage only (--n-coverages 1): here the target "
    "is that of the RMS of all points."
)
OF_PLANS = mark(
    "up to: the high flight above ground; cost, images and control points are\n"
    "estimated, for each km²; errors are total, in cm"
)


def describe_table(table, best, flown=()) -> str:
    """Write a table of precision as aligned text.

    ``best`` has the columns of the scales that are best for the edge, ``flown`` are
    lines on how high flights at its scales are.
    """
    parts = [
        _head(table, flown),
        problems(table.warnings),
        _points_alone(table),
        _points(table),
        _transformation(table),
        _totals(table),
        _break_even(table),
        _best(best),
        wrapped(translated(TOO_GOOD)),
    ]
    return "\n\n".join(part for part in parts if part)


def problems(warnings) -> str:
    """List what the planner should know first."""
    said = [wrapped(retold(text), first="  ", indent="    ") for text in warnings]
    none = f"  {translated('none')}"
    return "\n".join([translated("Problems and suggestions"), *(said or [none])])


def _head(table, lines):
    model = table.model
    title = translated(
        "Precision before the flight: {kind}, edge = {edge}, "
        "{n:combination|combinations}",
        kind=translated(KIND_TEXT[model.kind]),
        edge=model.edge,
        n=int(np.prod(table.shape)),
    )
    flown = translated(
        "image {sides} mm, principal distance {distance} mm, overlaps {forward} % and "
        "{side} %",
        sides=_sides_in_mm(model.image_format),
        distance=_in_mm(table.principal_distance),
        forward=figure(100 * model.forward_overlap, ".3g"),
        side=figure(100 * model.side_overlap, ".3g"),
    )
    counted = translated(
        "points counted on {sides} mm of the image; all errors are total",
        sides=_sides_in_mm(model.extent),
    )
    return "\n  ".join([title, flown, *lines, counted])


def _sides_in_mm(sides):
    return " x ".join(map(_in_mm, sides))


def _in_mm(metres):
    return figure(metres / METRES_PER_MM, ".4g")


def _points_alone(table):
    """Diagram 1: what a number of points makes of m_0."""
    factor = table.model.edge_factor
    rows = [[translated("centre"), *(fixed(n**-0.5, 2) for n in SHOWN_POINTS)]]
    if np.isfinite(factor):
        rows.append(
            [
                translated("edge"),
                *(fixed(factor * n**-0.5, 2) for n in SHOWN_POINTS),
            ]
        )
    header = [translated("points"), *(str(n) for n in SHOWN_POINTS)]
    text = typesetting.table(rows, header=header)
    title = translated("m_t by the number of points in a model [m_0] (diagram 1)")
    return f"{title}\n{text}"


def _points(table):
    """Diagram 2."""
    values = table.array("n_points")[:, :, 0, 0]
    text = _grid(table, [("", values)], lambda value: fixed(value, 1))
    title = translated(
        "Points in a model (diagram 2); numbers of points are means, and not rounded"
    )
    return f"{title}\n{text}"


def _transformation(table):
    """Diagram 3, one table for each m_0."""
    at = {
        translated("centre"): table.array("m_t_centre")[..., 0],
        translated("edge"): table.array("m_t_edge")[..., 0],
    }
    return _blocks(
        translated("m_t [cm] with m_0 = {m_0} cm (diagram 3)", m_0=_cm(m_0))
        + "\n"
        + _grid(table, [(name, at[name][:, :, i]) for name in at], _in_cm)
        for i, m_0 in enumerate(table.axes["m_0"])
    )


def _totals(table):
    """Diagram 4, one table for each m_0 and m_g."""
    named = {
        translated("centre"): "M_centre",
        translated("edge"): "M_edge",
        translated("double"): "M_double",
    }
    return _blocks(
        translated(
            "M [cm] with m_0 = {m_0} cm, m_g = {m_g} µm (diagram 4)",
            m_0=_cm(m_0),
            m_g=figure(m_g, "g"),
        )
        + "\n"
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
            name = f"{figure(spacing, 'g')} m" if i == 0 else ""
            cells = [write(values[k, j]) for k in range(len(scales))]
            rows.append([name, label, *cells])
    header = [translated("spacing"), "", *(scale(value) for value in scales)]
    align = "ll" + "r" * len(scales)
    text = typesetting.table(rows, header=header, align=align)
    return "\n".join([text, *(f"  {said}" for said in _said_of_hidden(table.axes))])


def _said_of_hidden(axes):
    """How many scales and spacings are not shown."""
    n_scales = len(axes["scale_number"]) - MOST_SCALES
    n_spacings = len(axes["spacing"]) - MOST_SPACINGS
    if n_scales > 0 and n_spacings > 0:
        message = mark(
            "and {n_scales:scale|scales} and {n_spacings:spacing|spacings} more"
        )
    elif n_scales > 0:
        message = mark("and {n_scales:scale|scales} more")
    elif n_spacings > 0:
        message = mark("and {n_spacings:spacing|spacings} more")
    else:
        return []
    return [translated(message, n_scales=n_scales, n_spacings=n_spacings)]


def _blocks(texts):
    texts = list(texts)
    rest = len(texts) - MOST_BLOCKS
    message = mark("and {n:such table|such tables} more")
    more = [translated(message, n=rest)] if rest > 0 else []
    return "\n\n".join([*texts[:MOST_BLOCKS], *more])


def _break_even(table):
    """Settings up to which a better measurement decides at the edge."""
    m_g, m_t = table.array("m_g_ground"), table.array("m_t_edge")
    settings = settings_that_balance(m_g, m_t)
    scales = table.axes["scale_number"][:MOST_SCALES]
    combinations = [
        [*_given(spacing, m_0, m_g), settings[:, j, m, k]]
        for k, m_g in enumerate(table.axes["m_g_um"])
        for m, m_0 in enumerate(table.axes["m_0"])
        for j, spacing in enumerate(table.axes["spacing"])
    ]
    rows = [
        [*words, *map(number, at_scales[: len(scales)])]
        for *words, at_scales in combinations[: 3 * MOST_BLOCKS]
    ]
    header = [translated("spacing"), "m_0", "m_g", *(scale(value) for value in scales)]
    text = typesetting.table(rows, header=header, align="r" * len(header))
    more = _more(len(combinations) - len(rows))
    return "\n".join([wrapped(translated(BREAK_EVEN)), text, *more])


def _given(spacing, m_0, m_g_um):
    return [f"{figure(spacing, 'g')} m", f"{_cm(m_0)} cm", f"{figure(m_g_um, 'g')} µm"]


def _more(rest):
    return [translated("  and {n} more", n=rest)] if rest > 0 else []


def _best(best):
    """Scales beyond which a lower flight loses accuracy at the edge."""
    rows = [
        [
            *_given(best["spacing"][i], best["m_0"][i], best["m_g_um"][i]),
            scale(best["scale_number"][i]),
            number(best["n_points"][i]),
            _in_cm(best["M_centre"][i]),
            _in_cm(best["M_edge"][i]),
        ]
        for i in range(min(len(best["spacing"]), 3 * MOST_BLOCKS))
    ]
    header = [
        translated("spacing"),
        *("m_0", "m_g"),
        translated("scale"),
        translated("points"),
        translated("M centre"),
        translated("M edge [cm]"),
    ]
    text = typesetting.table(rows, header=header, align="rrrrrrr")
    title = translated("Best scale for the edge: a larger one loses accuracy there")
    return "\n".join([title, text, *_more(len(best["spacing"]) - len(rows))])


def _cm(metres):
    return figure(100.0 * metres, ".4g")


def _in_cm(metres):
    return fixed(100.0 * float(metres), 1)


def describe_verdict(search) -> str:
    """Say how many plans of a ``PlanSearch`` reach its target, and the best."""
    best = search.nearest
    facts = {
        "target": length(search.target),
        "place": _place_of(best, search.where),
        "formula": translated(FORMULAS[search.by]),
        "plan": describe_plan(best),
        "n_all": len(search.plans),
    }
    if len(search.feasible):
        return translated(
            "{n} of {n_all:plan|plans} reach {target} ({place}, {formula}), by the "
            "closed estimate; the cheapest: {plan}",
            n=len(search.feasible),
            **facts,
        )
    message = mark(
        "By the closed estimate no plan of {n_all} reaches {target} ({place}, "
        "{formula}). The nearest comes to {reached}: {plan}."
    )
    if not np.isfinite(best["reached"]):
        message = mark(
            "By the closed estimate no plan of {n_all} reaches {target} ({place}, "
            "{formula}): models hold so few points that it knows no bound of the "
            "error, such as of {plan}."
        )
    reached = _nearest(best["reached"], search.target)
    nearest = translated(message, reached=reached, **facts)
    limit = translated(LIMITS[best["limited_by"]])
    limited = translated("It is limited by {limit}.", limit=limit)
    parts = [nearest, limited, describe_efforts(search), f"{describe_heights(best)}."]
    return " ".join(part for part in parts if part)


def _place_of(plan, where):
    """Say where the error of a plan is: with several coverages, that of all points."""
    if plan["n_coverages"] > 1:
        return translated("RMS of all points")
    return translated(PLACES[where])


def _nearest(reached, target):
    """Write an error that misses a target; both are seen to differ."""
    said = length(reached)
    return missed_in_cm(reached, target) if said == length(target) else said


def describe_search(search) -> str:
    """Say the verdict of a ``PlanSearch``, with its cheapest plans."""
    feasible, best = search.feasible, search.nearest
    shown = feasible
    if not len(feasible):
        shown = search.plans.sort_values("reached", kind="stable")
    coverages = ONE_COVERAGE if best["n_coverages"] == 1 else SEVERAL_COVERAGES
    return "\n".join(
        [
            wrapped(search.verdict, indent="  "),
            wrapped(translated(coverages), first="  ", indent="  "),
            "",
            _plans(shown.head(SHOWN_PLANS), search.by),
            *_more(len(shown) - SHOWN_PLANS),
            indent(translated(OF_PLANS), "  "),
        ]
    )


def describe_plan(plan) -> str:
    """Say a plan in a sentence.

    ``plan`` is a row of ``PlanSearch.plans``.
    """
    return translated(
        "low flight {low}, high flight {high}, {n_coverages:coverage|coverages}, "
        "{spacing} m, {n_settings:pointing|pointings each} of {m_g} µm, {n_control} "
        "control points per model",
        low=scale(plan["scale_number"]),
        high=scale(plan["high_scale_number"]),
        n_coverages=int(plan["n_coverages"]),
        spacing=figure(plan["spacing"], "g"),
        n_settings=int(plan["n_settings"]),
        m_g=figure(plan["m_g_um"], "g"),
        n_control=int(plan["control_per_model"]),
    )


def missed_in_cm(reached, target) -> str:
    """Write an error that misses a target, with as many digits as show the miss [m].

    >>> missed_in_cm(0.050041, 0.05), missed_in_cm(0.0518, 0.05)
    ('5.004 cm', '5.18 cm')
    """
    missed, wanted = 100.0 * reached, 100.0 * target
    shown = (d for d in range(2, MOST_DECIMALS) if _differ(missed, wanted, d))
    return f"{figure(missed, f'.{next(shown, MOST_DECIMALS)}f')} cm"


def _differ(missed, wanted, decimals):
    return f"{missed:.{decimals}f}" != f"{wanted:.{decimals}f}"


def _plans(plans, by):
    other = "paper" if by == "expected" else "expected"
    rows = [
        [
            scale(plan.scale_number),
            scale(plan.high_scale_number),
            f"{figure(plan.high_flying_height, '.0f')} m",
            f"{figure(plan.spacing, 'g')} m",
            f"{plan.n_coverages:.0f}",
            f"{plan.n_settings:.0f} x {figure(plan.m_g_um, 'g')} µm",
            f"{plan.control_per_model:.0f}",
            fixed(100.0 * plan.reached, 1),
            fixed(100.0 * getattr(plan, f"reached_{other}"), 1),
            number(plan.images, 2),
            number(plan.control_points, 2),
            number(plan.cost, 3),
        ]
        for plan in plans.itertuples()
    ]
    header = [
        translated("scale"),
        translated("high"),
        translated("up to"),
        translated("spacing"),
        translated("cov."),
        translated("pointings"),
        translated("control"),
        translated("error"),
        translated("formula") if by == "expected" else translated("expected"),
        translated("images"),
        translated("c. points"),
        translated("cost"),
    ]
    return typesetting.table(rows, header=header, align="r" * len(header))
