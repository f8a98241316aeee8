"""The three answers of ``einschalt plan``: tables, plans for a target, one layout.

Each answer has a text, and tables and figures that are made only when they are written.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.cli.plan_values import PlannedFlight, numbers
from einschalt.pipeline.camera_presets import DEFAULT_M_0
from einschalt.pipeline.planning import best_columns, frame_of, precision_table
from einschalt.pipeline.planning_arguments import checked_axis
from einschalt.pipeline.planning_text import describe_table

SEARCHED_SCALES = 16
HALF_TO_THRICE = (0.5, 3.0)


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
        Gives a dict of name to dict of suffix to bytes.
    """

    text: str
    tables: Callable
    figures: Callable


@dataclass(frozen=True)
class Asked:
    """What was written on the command line, beside camera and axes.

    Attributes
    ----------
    values : dict of str to list of str or None
        Options that take several values, by name.
    high_scale_number, high_m_g_um, width, height : float or None
    control_standard_error : float
    """

    values: dict = field(default_factory=dict)
    high_scale_number: float | None = None
    high_m_g_um: float | None = None
    width: float | None = None
    height: float | None = None
    control_standard_error: float = 0.03

    def numbers(self, name, usual):
        """Values of an option as numbers, the usual ones where it was not given."""
        return numbers(f"--{name.replace('_', '-')}", self.values.get(name), usual)

    def only(self, name, usual):
        """Give the one value of an option of which a layout can have one only."""
        given = self.numbers(name, usual)
        if len(given) != 1:
            option = f"--{name.replace('_', '-')}"
            raise SettingsError(
                f"{option} has {len(given)} values",
                expected="one value: a layout has one",
                remedy=f"Write {option} {given[0]:g}",
            )
        return given[0]


def tables(flight: PlannedFlight, asked: Asked) -> Answer:
    """Answer with the tables of Kovarik's diagrams.

    Parameters
    ----------
    flight : PlannedFlight
    asked : Asked

    Returns
    -------
    Answer
    """
    preset = flight.preset
    axes = {
        "scale_number": asked.numbers("scale_number", preset.scale_numbers),
        "spacing": asked.numbers("spacing", preset.spacings),
        "m_0": asked.numbers("m_0", DEFAULT_M_0),
        "m_g_um": asked.numbers("m_g_um", preset.m_g_um),
    }
    table = precision_table(axes, flight.model, flight.principal_distance)
    best = best_columns(axes, flight.model, flight.principal_distance)

    def figures():
        # imported when figures are written: matplotlib takes its time
        from einschalt.interfaces.reports import planning_figures  # noqa: PLC0415

        return {
            "diagrams_1_to_3": planning_figures.figure_bytes(
                planning_figures.points_and_transformation_figure(table)
            ),
            "diagram_4": planning_figures.figure_bytes(
                planning_figures.total_error_figure(table)
            ),
        }

    return Answer(
        describe_table(table, best),
        lambda: {"plan": frame_of(table.columns()), "best_scales": frame_of(best)},
        figures,
    )


def search(flight: PlannedFlight, asked: Asked, target, where, by) -> Answer:
    """Answer with the plans that reach a precision, the best held against its layout.

    Parameters
    ----------
    flight : PlannedFlight
    asked : Asked
    target : float
        [m]
    where, by : str

    Returns
    -------
    Answer
    """
    # imported when they are asked for: propagation takes numba along
    from einschalt.pipeline.plan_check import check_plans  # noqa: PLC0415
    from einschalt.pipeline.plan_search import (  # noqa: PLC0415
        PlanChoices,
        PlanFrame,
        find_plans,
    )

    frame = PlanFrame(
        kind=flight.model.kind,
        image_format=flight.model.image_format,
        principal_distance=flight.principal_distance,
        forward_overlap=flight.model.forward_overlap,
        side_overlap=flight.model.side_overlap,
        control_standard_error=asked.control_standard_error,
    )
    usual = PlanChoices(
        scale_number=_usual_scales(flight.preset),
        spacing=flight.preset.spacings,
        m_g_um=flight.preset.m_g_um[:1],
    )
    names = PlanChoices.__dataclass_fields__
    choices = PlanChoices(
        **{name: tuple(asked.numbers(name, getattr(usual, name))) for name in names}
    )
    found = find_plans(target, choices, frame, where=where, by=by)
    checked = check_plans(found, frame)

    def figures():
        # imported when figures are written: matplotlib takes its time
        from einschalt.interfaces.reports import planning_figures  # noqa: PLC0415

        return {
            "plans": planning_figures.figure_bytes(
                planning_figures.plans_figure(found)
            ),
            "precision_map": planning_figures.figure_bytes(
                planning_figures.precision_map_figure(checked.expected)
            ),
        }

    return Answer(
        f"{found.summary()}\n\n{checked.summary()}",
        lambda: {"plans": found.plans, **_of_layout(checked.expected)},
        figures,
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


def layout(flight: PlannedFlight, asked: Asked) -> Answer:
    """Answer with the expected precision of one block, over its area.

    Parameters
    ----------
    flight : PlannedFlight
    asked : Asked

    Returns
    -------
    Answer
    """
    # imported when they are asked for: propagation takes numba along
    from einschalt.pipeline.expected_precision import expect_precision  # noqa: PLC0415
    from einschalt.pipeline.flight_design import FlightDesign  # noqa: PLC0415

    preset, model = flight.preset, flight.model
    design = FlightDesign(
        scale_number=asked.only("scale_number", preset.scale_numbers[1:2]),
        spacing=asked.only("spacing", preset.spacings[1:2]),
        m_g_um=asked.only("m_g_um", preset.m_g_um[:1]),
        kind=model.kind,
        image_format=model.image_format,
        principal_distance=flight.principal_distance,
        forward_overlap=model.forward_overlap,
        side_overlap=model.side_overlap,
        n_coverages=_whole(asked.only("n_coverages", (2,))),
        high_scale_number=asked.high_scale_number,
        high_m_g_um=asked.high_m_g_um,
        control_standard_error=asked.control_standard_error,
        control_per_model=_whole(asked.only("control_per_model", (5,))),
        width=asked.width,
        height=asked.height,
    )
    expected = expect_precision(design)

    def figures():
        # imported when figures are written: matplotlib takes its time
        from einschalt.interfaces.reports import planning_figures  # noqa: PLC0415

        unshifted = None
        if design.n_coverages > 1:
            unshifted = expect_precision(replace(design, coverage_shift=0.0))
        return {
            "precision_map": planning_figures.figure_bytes(
                planning_figures.precision_map_figure(expected, unshifted)
            )
        }

    return Answer(expected.summary(), lambda: _of_layout(expected), figures)


def with_terrain(answer, file, flight: PlannedFlight, asked: Asked) -> Answer:
    """Add the dangerous surfaces of a terrain to an answer.

    Parameters
    ----------
    answer : Answer
    file : Path
        model_id, h1 … h6 [m].
    flight : PlannedFlight
    asked : Asked

    Returns
    -------
    Answer
    """
    # imported when a terrain is given: the tables alone come faster
    from einschalt.foundations.errors import raise_problems  # noqa: PLC0415
    from einschalt.foundations.tables import check_table  # noqa: PLC0415
    from einschalt.interfaces.files.tables_by_suffix import read_table  # noqa: PLC0415
    from einschalt.pipeline import terrain_forecast  # noqa: PLC0415
    from einschalt.stages.relative_orientation.dangerous_surface import TERRAIN_HEIGHTS  # noqa: PLC0415

    raw = read_table(file, TERRAIN_HEIGHTS)
    checked = check_table(raw, TERRAIN_HEIGHTS, source=file.name)
    raise_problems(checked.problems)
    forecast = terrain_forecast.forecast_by_scale(
        checked.frame,
        checked_axis(
            "scale_number",
            asked.numbers("scale_number", flight.preset.scale_numbers),
        ),
        flight.model,
        flight.principal_distance,
    )
    return replace(
        answer,
        text=f"{answer.text}\n\n{terrain_forecast.describe_forecast(forecast)}",
        tables=lambda: {**answer.tables(), "dangerous_surfaces": forecast},
    )


def _whole(value):
    return int(value) if float(value).is_integer() else value


def _of_layout(expected):
    return {"expected_points": expected.points, "expected_values": expected.values}
