"""What each flight measured, and how well its models fit."""

import math

from einschalt.foundations.typesetting import count, length, lengths, number, scale
from einschalt.pipeline.summary.section import Section
from einschalt.pipeline.summary.wording import flight_name, with_error

CURVED = (
    "Spatial models were brought onto the curved Earth and to the scale of the map; "
    'set earth_curvature = "ignored" where they were corrected for it before.'
)
CURVED_PLANE = (
    "Models were brought to the scale of the map, which changes across them by enough "
    'for millimetres; set earth_curvature = "ignored" where they are maps themselves.'
)


def section(flights, approximations) -> Section:
    """Set what each flight measured, and how well its models fit."""
    m_0 = lengths([flight.m_0 for flight in flights])
    m_g = lengths([flight.m_g_ground for flight in flights])
    rows = [
        (
            flight_name(flight.name),
            scale(flight.scale_number),
            flight.transformation,
            f"{flight.n_models:d}",
            f"{flight.n_usable:d}",
            f"{number(flight.m_g_um)} µm",
            m_g[place],
            m_0[place],
        )
        for place, flight in enumerate(flights)
    ]
    header = ("", "scale", "fit", "models", "usable", "m_g", "on ground", "m_0")
    remarks = (
        approximation_remark(approximations),
        *orientation_remarks(flights),
        *measured_error_remarks(flights),
        *curvature_remark(flights),
    )
    return Section("Flights (m_g and m_0 are total)", header, tuple(rows), remarks)


def curvature_remark(flights) -> tuple[str, ...]:
    """Say that the points of models are not as they were measured."""
    kinds = {flight.transformation for flight in flights if flight.is_curved}
    if not kinds:
        return ()
    return (CURVED,) if "helmert_3d" in kinds else (CURVED_PLANE,)


def approximation_remark(facts) -> str:
    """Say where the approximate coordinates come from and how good they are."""
    n_points = count(facts.n_points, "point")
    is_known = math.isfinite(facts.total)
    if facts.is_given:
        said = f"{length(facts.total)} (total, as given)"
        said = said if is_known else "of unknown precision"
        return f"Approximate coordinates: {n_points} given, {said}."
    if not is_known:
        return f"Approximate coordinates: {n_points} from the high flight."
    said = f"{length(facts.total)} (total, internal)"
    return f"Approximate coordinates: {n_points} from the high flight, {said}."


def orientation_remarks(flights) -> tuple[str, ...]:
    """Say how well the models of each flight could be oriented."""
    lines = []
    for flight in flights:
        if (found := flight.orientation) is None:
            continue
        observed = "an image coordinate" if found.is_from_images else "a y-parallax"
        lines.append(
            f"Relative orientation, {flight_name(flight.name)}: "
            f"{count(found.n_models, 'model')}, sigma_0 {length(found.sigma_0)} "
            f"of {observed}; it sees y-parallax only."
        )
        lines += _of_images(flight) if found.is_from_images else _of_parallaxes(flight)
    return tuple(lines)


def _of_parallaxes(flight):
    """What the errors of y-parallaxes make of m_g, beside the one given."""
    bent = flight.orientation.m_g_orientation_um
    if not math.isfinite(bent):
        return []
    return [
        (
            f"m_g of the {flight_name(flight.name)}: given {number(flight.m_g_um)}, of "
            f"which errors of the relative orientation make {number(bent)} µm."
        )
    ]


def _of_images(flight):
    """What the residuals say of the image points' m_g, beside the one given."""
    found = flight.orientation
    if (shown := found.image_points) is None:
        return []
    rays, bent = found.m_g_intersection_um, found.m_g_orientation_um
    return [
        (
            f"m_g of the {flight_name(flight.name)}: given {number(shown.given)}, "
            f"the image residuals say {_shown(shown)} µm for an image point, and so "
            f"{number(math.hypot(rays, bent))} µm for a model point ({number(rays)} "
            f"from the rays, {number(bent)} from the orientation)."
        )
    ]


def measured_error_remarks(flights) -> tuple[str, ...]:
    """Say what m_g of each flight the measurements show."""
    return tuple(
        f"m_g of the {flight_name(flight.name)}: given "
        f"{number(flight.shown_m_g.given)}, the data say {_shown(flight.shown_m_g)} µm."
        for flight in flights
        if flight.shown_m_g is not None
    )


def _shown(component):
    return with_error(component.estimated, component.standard_error)
