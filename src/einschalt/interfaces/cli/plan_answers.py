"""The three answers of ``einschalt plan``: tables, plans for a target, one layout.

Each answer has a text, and tables and figures that are made only when they are written.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.typesetting import length, wrapped
from einschalt.interfaces.cli.plan_values import Asked, costs_of
from einschalt.pipeline.planning.precision_table import (
    best_columns,
    break_even_columns,
    frame_of,
    precision_table,
)
from einschalt.pipeline.planning.text import describe_table

SEARCHED_SCALES = 16
HALF_TO_THRICE = (0.5, 3.0)
QUESTION = {"tables": "the tables", "target": "--target", "expect": "--expect"}


@dataclass(frozen=True, eq=False)
class Answer:
    """A text, and how to make the rest of it.

    Attributes
    ----------
    text : str
    tables : callable
        Gives a dict of name to DataFrame; the first is the one that a single file
        holds.
    figures : callable
        Gives a dict of name to Figure; the first is the one that a single file holds.
    scale_numbers : sequence of float
        Image scales that are in question, for the terrain.
    """

    text: str
    tables: Callable
    figures: Callable
    scale_numbers: Sequence[float]


def answer(asked: Asked) -> Answer:
    """Answer what was asked, and say which options did not count.

    Parameters
    ----------
    asked : Asked

    Returns
    -------
    Answer

    Raises
    ------
    EinschaltError
        A value is not sensible.
    """
    given = {"tables": tables, "target": search, "expect": layout}[asked.question](
        asked
    )
    if not asked.unused:
        return given
    options = ", ".join(f"--{name.replace('_', '-')}" for name in asked.unused)
    said = f"Not used for {QUESTION[asked.question]}: {options}."
    return replace(given, text=f"{given.text}\n\n{wrapped(said, indent='  ')}")


def tables(asked: Asked) -> Answer:
    """Answer with the tables of Kovarik's diagrams.

    Parameters
    ----------
    asked : Asked

    Returns
    -------
    Answer
    """
    flight = asked.flight
    preset = flight.preset
    axes = {
        "scale_number": asked.numbers("scale_number", preset.scale_numbers),
        "spacing": asked.numbers("spacing", preset.spacings),
        "m_0": asked.numbers("m_0", preset.m_0),
        "m_g_um": asked.numbers("m_g_um", preset.m_g_um),
    }
    table = precision_table(axes, flight.model, flight.principal_distance)
    best = best_columns(axes, flight.model, flight.principal_distance)

    def figures():
        # imported when figures are drawn: matplotlib takes its time
        from einschalt.interfaces.reports import planning_figures  # noqa: PLC0415

        return {"diagrams": planning_figures.diagrams_figure(table)}

    def frames():
        return {
            "plan": frame_of(table.columns()),
            "best_scales": frame_of(best),
            "break_even": frame_of(break_even_columns(table)),
        }

    scales = table.axes["scale_number"]
    return Answer(describe_table(table, best), frames, figures, scales)


def search(asked: Asked) -> Answer:
    """Answer with the plans that reach a precision, the best held against its layout.

    Parameters
    ----------
    asked : Asked

    Returns
    -------
    Answer
    """
    # imported when they are asked for: propagation takes numba along
    from einschalt.pipeline.planning.check import check_plans  # noqa: PLC0415
    from einschalt.pipeline.planning.search import find_plans  # noqa: PLC0415

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
        return _plans_alone(found, said)

    def figures():
        # imported when figures are drawn: matplotlib takes its time
        from einschalt.interfaces.reports.plans_figure import plans_figure  # noqa: PLC0415

        return {
            "plans": plans_figure(found, checked),
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


def _plans_alone(found, said):
    def figures():
        # imported when figures are drawn: matplotlib takes its time
        from einschalt.interfaces.reports.plans_figure import plans_figure  # noqa: PLC0415

        return {"plans": plans_figure(found)}

    text = f"{found.summary()}\n\n{said}"
    tables = {"plans": found.plans}
    return Answer(text, lambda: tables, figures, _scales_of(found.nearest))


def _frame_of(asked):
    # imported where it is needed: the tables alone come faster
    from einschalt.pipeline.planning.search import PlanFrame  # noqa: PLC0415

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
    # imported where it is needed: the tables alone come faster
    from einschalt.pipeline.planning.search import PlanChoices  # noqa: PLC0415

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
    low, high = (
        factor * edge
        for factor, edge in zip(
            HALF_TO_THRICE,
            (min(preset.scale_numbers), max(preset.scale_numbers)),
            strict=True,
        )
    )
    ratio = (high / low) ** (1.0 / (SEARCHED_SCALES - 1))
    return tuple(round(low * ratio**i, -2) for i in range(SEARCHED_SCALES))


def layout(asked: Asked) -> Answer:
    """Answer with the expected precision of one block, over its area.

    Parameters
    ----------
    asked : Asked

    Returns
    -------
    Answer
    """
    # imported when they are asked for: propagation takes numba along
    from einschalt.pipeline.planning.effort import describe_effort  # noqa: PLC0415
    from einschalt.pipeline.planning.expected_precision import expect_precision  # noqa: PLC0415

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
    # imported where it is needed: the tables alone come faster
    from einschalt.pipeline.planning.flight_design import FlightDesign  # noqa: PLC0415

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
    # imported when they are asked for: propagation takes numba along
    from einschalt.pipeline.planning.expected_precision import expect_precision  # noqa: PLC0415

    if expected.design.n_coverages == 1:
        return None
    return expect_precision(replace(expected.design, coverage_shift=0.0))


def _map_of(expected, unshifted=None):
    # imported when figures are drawn: matplotlib takes its time
    from einschalt.interfaces.reports.precision_map_figure import precision_map_figure  # noqa: PLC0415

    if unshifted is None:
        unshifted = _without_shift(expected)
    return precision_map_figure(expected, unshifted)


def with_terrain(given, file, asked: Asked) -> Answer:
    """Add the dangerous surfaces of a terrain to an answer.

    Parameters
    ----------
    given : Answer
    file : Path
        model_id, h1 … h6 [m].
    asked : Asked

    Returns
    -------
    Answer
    """
    # imported when a terrain is given: the tables alone come faster
    from einschalt.foundations.errors import raise_problems  # noqa: PLC0415
    from einschalt.foundations.tables import check_table  # noqa: PLC0415
    from einschalt.interfaces.files.tables_by_suffix import read_table  # noqa: PLC0415
    from einschalt.pipeline.planning import terrain as terrain_forecast  # noqa: PLC0415
    from einschalt.stages.relative_orientation.dangerous_surface import TERRAIN_HEIGHTS  # noqa: PLC0415

    raw = read_table(file, TERRAIN_HEIGHTS)
    checked = check_table(raw, TERRAIN_HEIGHTS, source=file.name)
    raise_problems(checked.problems)
    flight = asked.flight
    forecast = terrain_forecast.forecast_by_scale(
        checked.frame, given.scale_numbers, flight.model, flight.principal_distance
    )
    by_camera = terrain_forecast.forecast_by_camera(
        checked.frame, given.scale_numbers[0] * flight.principal_distance
    )
    said = terrain_forecast.describe_forecast(forecast, by_camera)
    return replace(
        given,
        text=f"{given.text}\n\n{said}",
        tables=lambda: {
            **given.tables(),
            "dangerous_surfaces": forecast,
            "dangerous_surfaces_by_camera": by_camera,
        },
    )


def _whole(value):
    return int(value) if float(value).is_integer() else value


def _of_layout(expected):
    return {"expected_points": expected.points, "expected_values": expected.values}
