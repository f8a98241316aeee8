"""Answers of ``einschalt plan`` that lay blocks out: a target, and one layout."""

import math
from dataclasses import replace

from einschalt.foundations.errors import EinschaltError, GeometryError, SettingsError
from einschalt.foundations.language import (
    figure,
    in_english,
    mark,
    mark_each,
    translated,
)
from einschalt.foundations.typesetting import length, wrapped
from einschalt.interfaces.cli.plan_answers import Answer
from einschalt.interfaces.cli.plan_heights import (
    heights_expected,
    max_height_of,
    said_of_film,
    said_of_limit,
)
from einschalt.interfaces.cli.plan_values import Asked, costs_of
from einschalt.interfaces.cli.progress import late_progress
from einschalt.interfaces.cli.typed_options import option_of, told_as_typed
from einschalt.pipeline.planning.area.simulated_plan import planned_block
from einschalt.pipeline.planning.choice.check import check_plans
from einschalt.pipeline.planning.choice.finer_choices import REFINED
from einschalt.pipeline.planning.estimate.effort import describe_effort
from einschalt.pipeline.planning.estimate.further_effort import describe_efforts
from einschalt.pipeline.planning.estimate.search import (
    ALLOWED_CHOICES,
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.estimate.text import ONE_COVERAGE
from einschalt.pipeline.planning.flights.arguments import RANGES, checked_number
from einschalt.pipeline.planning.flights.cameras import flown_columns
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.propagation.expected_precision import expect_precision

SEARCHED_SCALES = 16
HALF_TO_THRICE = (0.5, 3.0)
OF_THE_HIGHEST = 5.0  # where a limit of height is far below what is usual
LEAST = mark(
    "The target is out of reach: with all that would help, the smallest error is about "
    "{least}. Give a larger --target."
)
PRICES = mark_each(
    {
        "image": "{price} image",
        "model": "{price} model",
        "setting": "{price} pointing",
        "control_point": "{price} control point",
    }
)


def search(asked: Asked) -> Answer:
    """Answer with the plan that keeps a precision on its own layout."""
    frame = frame_of(asked)
    found = find_plans(
        *(asked["target"], choices_of(asked), frame),
        where=asked["where"],
        by=asked["by"],
    )
    try:
        with late_progress() as progress:
            given = {"refine": refined_by(asked), "progress": progress}
            checked = check_plans(found, frame, **given)
    except EinschaltError as error:
        return _unchecked(found, error)

    found = checked.search
    parts = [
        f"{checked.verdict()}\n{limits_of(checked, found, asked)}",
        found.summary(),
        checked.expected.summary(),
    ]
    return Answer(
        "\n\n".join(parts),
        lambda: {"plans": found.plans, **tables_of_layout(checked.expected)},
        lambda: figures_of(found, checked, _without_shift(checked.expected)),
        scales_of(checked.plan),
        headline=lambda: headline_of(checked),
        planned=lambda: (planned_block(checked), frame),
        problem=problem_of(checked, found),
        notes=notes_of(checked.plan["n_coverages"]),
    )


def _unchecked(found, error):
    """Answer with the plans, which were asked for: the check of the best failed."""
    message = mark("No plan is recommended: the best cannot be laid out: {reason}")
    reason = told_as_typed(error)
    said = wrapped(translated(message, reason=reason), indent="  ")
    tables, scales = {"plans": found.plans}, scales_of(found.nearest)
    return Answer(
        *(f"{said}\n\n{found.summary()}", lambda: tables),
        *(lambda: _figure_of(found), scales),
        headline=lambda: _headline_without_layout(found),
        problem=error,
        notes=notes_of(found.nearest["n_coverages"]),
    )


def figures_of(found, checked, unshifted=None, area=None):
    """Draw the plans of a search, and the precision of the one that was checked.

    ``unshifted``: the same layout without shifted coverages, if there is one;
    ``area``: the FlightArea that it was laid out over.
    """
    precision_map = _map_of(checked.expected, unshifted, area)
    return {**_figure_of(found, checked), "precision_map": precision_map}


def headline_of(checked):
    """Row of the plan that was checked, for programs, and whether it holds."""
    other = checked.next_best
    return _of_checked(checked) | {
        "finer": checked.finer,
        "next_best": None if other is None else _of_checked(other),
    }


def _headline_without_layout(found):
    """Row of the nearest plan, none of which can be laid out."""
    headline = _headline(found.nearest, None, is_recommended=False)
    of_layout = {"expected_on_layout": None, "next_best": None, "finer": {}}
    return headline | {"target": found.target} | of_layout


def _of_checked(checked):
    headline = _headline(checked.plan, checked.reached, is_recommended=checked.is_kept)
    return headline | {
        "target": checked.target,
        "expected_on_layout": expected_figures(checked.expected),
    }


def expected_figures(expected):
    """What a layout is expected to give, for programs [m, TOTAL]."""
    new = expected.points[expected.points["role"] == "new"]
    return {
        **vars(expected.figures),
        "percentile_95": expected.figures.worst,
        "largest": float(new["standard_error_total"].max()),
        **{f"from_{source}": size for source, size in expected.parts.items()},
        "n_new": len(new),
        "n_control": expected.n_control,
        "n_high_models": expected.n_high_models,
        "n_low_models": expected.n_low_models,
    }


@in_english
def problem_of(checked, search):
    """Say for programs that the nearest plan misses the target; None where it holds."""
    if checked.is_kept:
        return None
    # where the closed estimate knows a plan, it has nothing to add
    remedy = describe_efforts(search).rstrip(".") or "Allow more choices"
    if (least := _least_of(checked, search)) is not None:
        reachable = translated(LEAST, least=length(least)).rstrip(".")
        remedy = f"{remedy}. {reachable}"
    return GeometryError(
        f"no plan is recommended: the nearest comes to {length(checked.reached)} on "
        "its layout",
        expected=f"at most {length(checked.target)}",
        remedy=remedy,
    )


def limits_of(checked, search, asked):
    """Say what can be reached, where the target cannot, and which limits were given."""
    least, said = _least_of(checked, search), said_of_frame(asked)
    if least is None:
        return said
    reachable = translated(LEAST, least=length(least))
    return f"{wrapped(reachable, first='  ', indent='    ')}\n{said}"


def _least_of(checked, search):
    """Smallest error [m] where nothing that would help reaches the target; or None."""
    if checked.is_kept or search.beyond is None:
        return None
    errors = [effort.reached for effort in search.beyond.efforts]
    least = min(checked.reached, search.beyond.together, *errors)
    return least if least > checked.target else None


def notes_of(n_coverages):
    """Say for programs that one coverage shows no gross error."""
    if n_coverages > 1:
        return ()
    note = EinschaltError(
        "one coverage has no other to be compared with: gross errors cannot be seen",
        expected="two coverages or more",
        remedy="Write --n-coverages 2",
    )
    return (note,)


def _headline(plan, reached, *, is_recommended):
    on_layout = {"reached_on_layout": reached, "is_recommended": is_recommended}
    return {**plan.to_dict(), **on_layout}


def said_of_frame(asked):
    """Say which limits and prices are no choice of the planner's."""
    said = [said_of_limit(asked)]
    if "spacing" not in asked.typed:
        message = mark("Distances of the points tried (--spacing): {spacings} m.")
        spacings = ", ".join(figure(one, "g") for one in choices_of(asked).spacing)
        said.append(translated(message, spacings=spacings))
    costs = costs_of(asked["costs"])
    each = ", ".join(
        translated(text, price=figure(getattr(costs, name), "g"))
        for name, text in PRICES.items()
    )
    message = mark("Prices (defaults, not yours: --costs): {prices}.")
    if "costs" in asked.typed:
        message = mark("Prices: {prices}.")
    said.append(translated(message, prices=each))
    said += filter(None, [said_of_film(asked.flight.preset)])
    return wrapped(" ".join(said), first="  ", indent="    ")


def scales_of(plan):
    """Scale numbers of both flights of a plan, for the terrain."""
    return [float(plan["scale_number"]), float(plan["high_scale_number"])]


def _figure_of(found, checked=None):
    # imported when figures are drawn: matplotlib takes its time
    from einschalt.interfaces.reports.plans_figure import plans_figure  # noqa: PLC0415

    return {"plans": plans_figure(found, checked)}


def frame_of(asked) -> PlanFrame:
    """Put what is at hand together."""
    model = asked.flight.model
    return PlanFrame(
        kind=model.kind,
        image_format=model.image_format,
        principal_distance=asked.flight.principal_distance,
        forward_overlap=model.forward_overlap,
        side_overlap=model.side_overlap,
        control_standard_error=asked["control_standard_error"],
        high_over_low_m_g=_high_over_low_m_g(asked),
        costs=costs_of(asked["costs"]),
        max_height=max_height_of(asked),
        sampled_um=asked.flight.preset.sampled_um,
    )


def _high_over_low_m_g(asked):
    """Error of measuring in the high flight over that in the low one, of a setting."""
    high = asked["high_m_g_um"]
    if high is None:
        return 1.0
    given = asked.numbers("m_g_um", asked.flight.preset.m_g_um[:1])
    if len(given) != 1:
        option, ratio = option_of("m_g_um"), option_of("high_m_g_um")
        raise SettingsError(
            f"{option} has {len(given)} values beside {ratio}",
            expected="one value: a search has one ratio of the errors of both flights",
            remedy=f"Write {option} {given[0]:g}, or leave {ratio} out",
        )
    (low,) = given
    return checked_number("m_g_um", high) / low


def choices_of(asked) -> PlanChoices:
    """Put down what is free to be chosen: as asked, or as is usual."""
    preset = asked.flight.preset
    usual = PlanChoices(
        scale_number=_usual_scales(asked),
        spacing=preset.spacings,
        m_g_um=preset.m_g_um[:1],
    )
    return PlanChoices(
        **{
            name: tuple(asked.numbers(name, getattr(usual, name)))
            for name in PlanChoices.__dataclass_fields__
        }
    )


def refined_by(asked):
    """Give the choices that are not asked for, and can have any value."""
    return [name for name in REFINED if name not in asked.typed]


def _usual_scales(asked):
    """Scales about those of the preset, rounded; so low as the limit asks for."""
    scales = asked.flight.preset.scale_numbers
    half, thrice = HALF_TO_THRICE
    low, high = half * min(scales), thrice * max(scales)
    limit = frame_of(asked).max_height  # as far as it is one
    if limit is not None:
        lowest = min(asked.numbers("high_over_low", PlanChoices.high_over_low))
        # what is no ratio is refused with the other choices
        lowest = min(max(lowest, 1.0), ALLOWED_CHOICES["high_over_low"].high)
        high = min(high, limit / asked.flight.principal_distance / lowest)
        low = min(low, high / OF_THE_HIGHEST)
    ratio = (high / low) ** (1.0 / (SEARCHED_SCALES - 1))
    # downward: the highest stays below the limit
    scales = (_rounded_down(low * ratio**i) for i in range(SEARCHED_SCALES))
    return tuple(dict.fromkeys(scales))


def _rounded_down(scale_number):
    step = 100.0 if scale_number >= 2000.0 else 10.0
    least = RANGES["scale_number"].low
    return max(step * math.floor(scale_number / step + 1e-9), least)


def layout(asked: Asked) -> Answer:
    """Answer with the expected precision of one block, over its area."""
    design = _design_of(asked)
    heights = heights_expected(asked, design)
    expected, unshifted = _expected_of(design)
    rest = expected.summary().removeprefix(expected.verdict)
    said = [wrapped(line, first="  ", indent="    ") for line in heights.lines]
    if design.n_coverages == 1:
        said.append(_of_one_coverage())
    text = "\n".join([expected.verdict, *said])
    text += f"{rest}\n\n{describe_effort(expected)}"
    if unshifted is not None:
        same = length(unshifted.figures.mean)
        said = translated("With coverages that are not shifted: {same}.", same=same)
        text += f"\n  {said}"
    return Answer(
        text,
        lambda: tables_of_layout(expected),
        lambda: {"precision_map": _map_of(expected, unshifted)},
        [design.scale_number, design.scale_of_high_flight],
        headline=lambda: _asked_design(asked, design) | expected_figures(expected),
        planned=lambda: (planned_block(expected), None),
        notes=(*heights.problems, *notes_of(design.n_coverages)),
    )


def _expected_of(design):
    """Propagate a layout, and the same without shifted coverages, if there is one."""
    with late_progress() as progress:
        progress("propagating the layout", 0.0)
        expected = expect_precision(design)
        if design.n_coverages > 1:
            progress("propagating coverages that are not shifted", 0.5)
        return expected, _without_shift(expected)


def _of_one_coverage():
    return wrapped(translated(ONE_COVERAGE), first="  ", indent="    ")


def _asked_design(asked, design):
    """The flights of a layout, for programs, by the names that a search has."""
    names = ("scale_number", "spacing", "m_g_um", "n_coverages", "control_per_model")
    of_design = {name: getattr(design, name) for name in names}
    of_design["high_scale_number"] = design.scale_of_high_flight
    preset, distance = asked.flight.preset, asked.flight.principal_distance
    return of_design | flown_columns(of_design, distance, preset.sampled_um)


def _design_of(asked):
    preset, model = asked.flight.preset, asked.flight.model
    return FlightDesign(
        scale_number=asked.only("scale_number", (preset.usual_scale_number,)),
        spacing=asked.only("spacing", (preset.usual_spacing,)),
        m_g_um=asked.only("m_g_um", preset.m_g_um[:1]),
        kind=model.kind,
        image_format=model.image_format,
        principal_distance=asked.flight.principal_distance,
        forward_overlap=model.forward_overlap,
        side_overlap=model.side_overlap,
        n_coverages=_whole(asked.only("n_coverages", (2,))),
        high_scale_number=asked["high_scale_number"],
        high_m_g_um=asked["high_m_g_um"],
        control_standard_error=asked["control_standard_error"],
        control_per_model=_whole(asked.only("control_per_model", (5,))),
        width=asked["width"],
        height=asked["height"],
    )


def _without_shift(expected):
    """Give the same block with coverages that lie upon each other."""
    if expected.design.n_coverages == 1:
        return None
    return expect_precision(replace(expected.design, coverage_shift=0.0))


def _map_of(expected, unshifted, area=None):
    # imported when figures are drawn: matplotlib takes its time
    from einschalt.interfaces.reports.precision_map_figure import precision_map_figure  # noqa: PLC0415

    return precision_map_figure(expected, unshifted, area)


def _whole(value):
    return int(value) if float(value).is_integer() else value


def tables_of_layout(expected):
    """Tables of a layout that was propagated."""
    return {"expected_points": expected.points, "expected_values": expected.values}
