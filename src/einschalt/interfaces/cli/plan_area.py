"""An answer of ``einschalt plan``: the flight plan over an area."""

from einschalt.foundations.errors import EinschaltError, ProjectionError
from einschalt.foundations.language import mark, translated
from einschalt.foundations.told_errors import told
from einschalt.foundations.typesetting import number, wrapped
from einschalt.interfaces.cli.exits import print_error
from einschalt.interfaces.cli.outcome import report_problems
from einschalt.interfaces.cli.plan_answers import Answer
from einschalt.interfaces.cli.plan_layouts import (
    choices_of,
    figures_of,
    frame_of,
    headline_of,
    limits_of,
    notes_of,
    problem_of,
    refined_by,
    scales_of,
    tables_of_layout,
)
from einschalt.interfaces.cli.plan_values import Asked
from einschalt.interfaces.cli.progress import late_progress
from einschalt.interfaces.files.area_files import read_area
from einschalt.interfaces.files.height_files import read_heights_over
from einschalt.pipeline.planning.area.recommended import plan_area, search_over
from einschalt.pipeline.planning.area.simulated_plan import planned_block


def over_area(asked: Asked) -> Answer:
    """Answer with the flight plan that keeps the target over an area."""
    area = read_area(asked["area"], layer=asked["area_layer"], crs=asked["crs"])
    file = asked["ground_heights"]
    heights = None if file is None else read_heights_over(file, area)
    found, frame = search_over(
        *(asked["target"], area, choices_of(asked), frame_of(asked)),
        where=asked["where"],
        by=asked["by"],
    )
    with late_progress() as progress:
        plan = plan_area(
            *(area, found, frame),
            heights=heights,
            refine=refined_by(asked),
            progress=progress,
        )
    parts = [
        f"{plan.verdict()}\n{limits_of(plan.checked, plan.search, asked)}",
        plan.checked.expected.summary(),
        f"{plan.search.summary()}\n{wrapped(_of_costs(plan), first='  ', indent='  ')}",
    ]
    return Answer(
        "\n\n".join(parts),
        lambda: _tables_of(plan),
        lambda: figures_of(plan.search, plan.checked, area=plan.checked_on),
        scales_of(plan.checked.plan),
        headline=lambda: _headline_of(plan),
        files=lambda folder: _write_maps(plan, folder),
        planned=lambda: (planned_block(plan, name=_name_of(asked)), frame),
        problem=problem_of(plan.checked, plan.search),
        notes=(
            *notes_of(plan.checked.plan["n_coverages"]),
            *_notes_of_ground(plan),
        ),
    )


def _notes_of_ground(plan):
    """Say for programs that a limit of height counts above level ground."""
    limit = plan.frame.max_height
    if limit is None or plan.heights is not None:
        return ()
    note = EinschaltError(
        "the ground was taken to be level",
        expected=f"heights of the terrain, to keep {limit:g} m above it",
        remedy="Give --ground-heights",
    )
    return (note,)


def _of_costs(plan):
    """Say which costs are counted, beside those of the table, which are estimates."""
    area, other = plan.area.square_km, plan.next_flown
    message = mark(
        "Counted on the layout over the area, for each km²: cost {cost} of the plan "
        "with which this answer begins."
    )
    if other is not None:
        message = mark(
            "Counted on the layouts over the area, for each km²: cost {cost} of the "
            "plan with which this answer begins, {next} of the next best."
        )
    return translated(
        message,
        cost=number(plan.flown.cost / area, 3),
        next="" if other is None else number(other.cost / area, 3),
    )


def _name_of(asked):
    """Name of the area: that of its layer, or of its file."""
    return asked["area_layer"] or asked["area"].stem


def _headline_of(plan):
    """What was recommended, for programs; a row of a plan is for each km²."""
    flown, other = plan.flown, plan.next_flown
    headline = headline_of(plan.checked) | {
        "totals": _totals(plan.area, flown),
        "effort": flown.effort.to_dict("records"),
        "cost_of_area": flown.cost,
        "next_cost_of_area": None if other is None else other.cost,
    }
    if other is not None:
        headline["next_best"]["totals"] = _totals(plan.area, other)
    return headline


def _totals(area, flown):
    """What the whole area takes."""
    amounts = dict(zip(flown.effort["item"], flown.effort["amount"], strict=True))
    return {
        "area_km2": area.square_km,
        "photographs": amounts["image"],
        "models": amounts["model"],
        "pointings": amounts["setting"],
        "control_points": amounts["control_point"],
        "flight_lines": len(flown.flight_lines),
        "length_of_lines": flown.flight_lines["length"].sum(),
        "cost": flown.cost,
    }


def _tables_of(plan):
    flown = plan.flown
    return {
        "flight_lines": flown.flight_lines,
        "photographs": flown.photographs,
        "control": flown.control,
        "effort": flown.effort,
        "plans": plan.search.plans,
        **tables_of_layout(plan.checked.expected),
        "expected_points": plan.expected_points,
    }


def _write_maps(plan, folder):
    # imported when they are written: GDAL takes its time
    from einschalt.interfaces.files import flight_plan_map  # noqa: PLC0415
    from einschalt.interfaces.programs import flight_plan_kml  # noqa: PLC0415

    flight_plan_map.write_flight_plan(plan, folder / flight_plan_map.FILE)
    if plan.area.crs is None:
        return
    kml = folder / flight_plan_kml.FILE
    try:
        flight_plan_kml.write_flight_plan_kml(plan, kml)
    except ProjectionError as error:  # the plan itself needs no degrees
        left_out = mark("{file} was left out: {reason}")
        said = translated(left_out, file=flight_plan_kml.FILE, reason=told(error))
        print_error(f"einschalt: {said}")
        found = f"{flight_plan_kml.FILE} was left out: {error.found}"
        report_problems(error.with_facts(found=found))
