"""Rows of a search as designs of two flights, and those that users hand back."""

from types import SimpleNamespace

from einschalt.foundations.arguments import finite_number, require_kind
from einschalt.foundations.errors import SettingsError, name_some, raise_problems
from einschalt.foundations.value_ranges import Range, problems_in
from einschalt.pipeline.planning.choice.trials import LAYOUT
from einschalt.pipeline.planning.estimate.search import (
    ALLOWED_CHOICES,
    OF_MEASURING,
    PlanFrame,
)
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.theory.measuring_error import m_g_of_mean

COUNTED = {
    **{name: ALLOWED_CHOICES[name] for name in ("n_settings", "n_coverages")},
    "control_per_model": Range(5, 9, is_whole=True),
}


def design_of(plan, frame) -> FlightDesign:
    """Put a plan of a search down as a design of two flights."""
    m_g_um = float(m_g_of_mean(plan["m_g_um"], plan["n_settings"]))
    return FlightDesign(
        scale_number=float(plan["scale_number"]),
        spacing=float(plan["spacing"]),
        m_g_um=m_g_um,
        kind=frame.kind,
        image_format=frame.image_format,
        principal_distance=frame.principal_distance,
        forward_overlap=frame.forward_overlap,
        side_overlap=frame.side_overlap,
        n_coverages=int(plan["n_coverages"]),
        high_scale_number=float(plan["high_scale_number"]),
        high_m_g_um=frame.high_over_low_m_g * m_g_um,
        control_standard_error=frame.control_standard_error,
        control_per_model=int(plan["control_per_model"]),
    )


def require_frame(frame):
    """See that a frame is one."""
    remedy = "Write frame=PlanFrame(…), that of the search"
    require_kind("frame", frame, PlanFrame, expected="a PlanFrame", remedy=remedy)


def require_row(name, row, *, asked_by):
    """See that what is given as a row of a search has its numbers.

    ``name`` is the argument, ``asked_by`` the function that has it.
    """
    missing = [one for one in (*LAYOUT, *OF_MEASURING) if one not in row.index]
    if missing:
        raise SettingsError(
            f"{name} is a row without {name_some(missing)}",
            expected="a row of find_plans(…).plans",
            remedy=f"Write {asked_by}(found.nearest, frame=frame)",
        )
    given = {one: finite_number(one, row[one]) for one in (*LAYOUT, *OF_MEASURING)}
    raise_problems(problems_in(SimpleNamespace(**given), COUNTED))


def design_of_row(name, row, frame, *, asked_by) -> FlightDesign:
    """Put a row of a search down as a design, with the frame of the search."""
    require_frame(frame)
    require_row(name, row, asked_by=asked_by)
    return design_of(row, frame)
