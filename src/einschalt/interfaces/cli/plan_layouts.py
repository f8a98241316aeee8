"""Answers of ``einschalt plan`` that lay blocks out: a target, and one layout."""

from dataclasses import replace

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.typesetting import length, wrapped
from einschalt.interfaces.cli.plan_answers import Answer
from einschalt.interfaces.cli.plan_values import Asked, costs_of
from einschalt.pipeline.planning.check import check_plans
from einschalt.pipeline.planning.effort import describe_effort
from einschalt.pipeline.planning.expected_precision import expect_precision
from einschalt.pipeline.planning.flight_design import FlightDesign
from einschalt.pipeline.planning.search import PlanChoices, PlanFrame, find_plans

SEARCHED_SCALES = 16
HALF_TO_THRICE = (0.5, 3.0)


def search(asked: Asked) -> Answer:
    """Answer with the plans that reach a precision, the best laid out as a check."""
    frame = _frame_of(asked)
    found = find_plans(
        *(asked["target"], _choices_of(asked), frame),
        where=asked["where"],
        by=asked["by"],
    )
    try:
        checked = check_plans(found, frame)
    except EinschaltError as error:
        # the plans are what was asked for; the check of the best comes on top
        said = wrapped(f"The best plan cannot be laid out: {error}", indent="  ")
        tables, scales = {"plans": found.plans}, _scales_of(found.nearest)
        text = f"{found.summary()}\n\n{said}"
        return Answer(text, lambda: tables, lambda: _figure_of(found), scales)

    def figures():
        return {
            **_figure_of(found, checked),
            "precision_map": _map_of(checked.expected),
        }

    return Answer(
        f"{found.summary()}\n\n{checked.summary()}",
        lambda: {"plans": found.plans, **_of_layout(checked.expected)},
        figures,
        _scales_of(checked.plan),
    )


def _scales_of(plan):
    return [float(plan["scale_number"]), float(plan["high_scale_number"])]


def _figure_of(found, checked=None):
    # imported when figures are drawn: matplotlib takes its time
    from einschalt.interfaces.reports.plans_figure import plans_figure  # noqa: PLC0415

    return {"plans": plans_figure(found, checked)}


def _frame_of(asked):
    model = asked.flight.model
    return PlanFrame(
        kind=model.kind,
        image_format=model.image_format,
        principal_distance=asked.flight.principal_distance,
        forward_overlap=model.forward_overlap,
        side_overlap=model.side_overlap,
        control_standard_error=asked["control_standard_error"],
        costs=costs_of(asked["costs"]),
    )


def _choices_of(asked):
    preset = asked.flight.preset
    usual = PlanChoices(
        scale_number=_usual_scales(preset),
        spacing=preset.spacings,
        m_g_um=preset.m_g_um[:1],
    )
    return PlanChoices(
        **{
            name: tuple(asked.numbers(name, getattr(usual, name)))
            for name in PlanChoices.__dataclass_fields__
        }
    )


def _usual_scales(preset):
    """Scales from half of the preset's smallest to thrice its largest, rounded."""
    half, thrice = HALF_TO_THRICE
    low, high = half * min(preset.scale_numbers), thrice * max(preset.scale_numbers)
    ratio = (high / low) ** (1.0 / (SEARCHED_SCALES - 1))
    return tuple(round(low * ratio**i, -2) for i in range(SEARCHED_SCALES))


def layout(asked: Asked) -> Answer:
    """Answer with the expected precision of one block, over its area."""
    expected = expect_precision(_design_of(asked))
    unshifted = _without_shift(expected)
    text = f"{expected.summary()}\n\n{describe_effort(expected)}"
    if unshifted is not None:
        same = length(unshifted.figures.mean)
        text += f"\n  With coverages that are not shifted: {same}."
    return Answer(
        text,
        lambda: _of_layout(expected),
        lambda: {"precision_map": _map_of(expected, unshifted)},
        [expected.design.scale_number, expected.design.scale_of_high_flight],
    )


def _design_of(asked):
    preset, model = asked.flight.preset, asked.flight.model
    return FlightDesign(
        scale_number=asked.only("scale_number", preset.scale_numbers[1:2]),
        spacing=asked.only("spacing", preset.spacings[1:2]),
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


def _map_of(expected, unshifted=None):
    # imported when figures are drawn: matplotlib takes its time
    from einschalt.interfaces.reports.precision_map_figure import precision_map_figure  # noqa: PLC0415

    if unshifted is None:
        unshifted = _without_shift(expected)
    return precision_map_figure(expected, unshifted)


def _whole(value):
    return int(value) if float(value).is_integer() else value


def _of_layout(expected):
    return {"expected_points": expected.points, "expected_values": expected.values}
