"""What each flight measured, and how well its models fit."""

import math

from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.typesetting import length, lengths, number, scale
from einschalt.pipeline.summary.section import Section
from einschalt.pipeline.summary.wording import flight_name, with_error

CURVED = mark(
    "Spatial models were corrected for Earth curvature and for the scale of the map; "
    'set earth_curvature = "ignored" if they had been corrected before.'
)
CURVED_PLANE = mark(
    "Models were corrected for the scale of the map, which changes across them by "
    'millimetres; set earth_curvature = "ignored" if they are maps themselves.'
)
GIVEN = mark(
    "Approximate coordinates: {n:point|points} given, {length} (total, given)."
)
GIVEN_UNKNOWN = mark(
    "Approximate coordinates: {n:point|points} given, of unknown precision."
)
FROM_HIGH = mark(
    "Approximate coordinates: {n:point|points} from the high flight, {length} (total, "
    "internal)."
)
FROM_HIGH_UNKNOWN = mark(
    "Approximate coordinates: {n:point|points} from the high flight."
)
ORIENTED_BY_IMAGES = mark(
    "Relative orientation, {flight}: {n:model|models}, sigma_0 {sigma_0} of an image "
    "coordinate; it reflects y-parallax only."
)
ORIENTED_BY_PARALLAXES = mark(
    "Relative orientation, {flight}: {n:model|models}, sigma_0 {sigma_0} of a "
    "y-parallax; it reflects y-parallax only."
)
M_G_OF_PARALLAXES = mark(
    "m_g of the {flight}: given {given} µm, of which {bent} µm come from errors of the "
    "relative orientation."
)
M_G_OF_IMAGES = mark(
    "m_g of the {flight}: given {given} µm; the image residuals show {shown} µm for an "
    "image point, and so {model} µm for a model point ({rays} from the rays, {bent} "
    "from the orientation)."
)
M_G_SHOWN = mark("m_g of the {flight}: given {given} µm, estimated {shown} µm.")


def section(flights, approximations) -> Section:
    """Set what each flight measured, and how well its models fit."""
    m_0 = lengths([flight.m_0 for flight in flights])
    m_g = lengths([flight.m_g_ground for flight in flights])
    rows = [
        (
            flight_name(flight.name),
            scale(flight.scale_number),
            flight.transformation,
            figure(flight.n_models, "d"),
            figure(flight.n_usable, "d"),
            f"{number(flight.m_g_um)} µm",
            m_g[place],
            m_0[place],
        )
        for place, flight in enumerate(flights)
    ]
    titles = [
        *(translated("scale"), translated("fit"), translated("models")),
        *(translated("usable"), "m_g", translated("on ground"), "m_0"),
    ]
    remarks = (
        approximation_remark(approximations),
        *orientation_remarks(flights),
        *measured_error_remarks(flights),
        *curvature_remark(flights),
    )
    title = translated("Flights (m_g and m_0 are total)")
    return Section(title, ("", *titles), tuple(rows), remarks)


def curvature_remark(flights) -> tuple[str, ...]:
    """Say that the points of models are not as they were measured."""
    kinds = {flight.transformation for flight in flights if flight.is_curved}
    if not kinds:
        return ()
    return (translated(CURVED if "helmert_3d" in kinds else CURVED_PLANE),)


def approximation_remark(facts) -> str:
    """Say where the approximate coordinates come from and how good they are."""
    if math.isfinite(facts.total):
        message = GIVEN if facts.is_given else FROM_HIGH
        return translated(message, n=facts.n_points, length=length(facts.total))
    return translated(
        GIVEN_UNKNOWN if facts.is_given else FROM_HIGH_UNKNOWN, n=facts.n_points
    )


def orientation_remarks(flights) -> tuple[str, ...]:
    """Say how well the models of each flight could be oriented."""
    lines = []
    for flight in flights:
        if (found := flight.orientation) is None:
            continue
        by_images = found.is_from_images
        lines.append(
            translated(
                ORIENTED_BY_IMAGES if by_images else ORIENTED_BY_PARALLAXES,
                flight=flight_name(flight.name),
                n=found.n_models,
                sigma_0=length(found.sigma_0),
            )
        )
        lines += _of_images(flight) if by_images else _of_parallaxes(flight)
    return tuple(lines)


def _of_parallaxes(flight):
    """What the errors of y-parallaxes make of m_g, beside the one given."""
    bent = flight.orientation.m_g_orientation_um
    if not math.isfinite(bent):
        return []
    sizes = {"given": number(flight.m_g_um), "bent": number(bent)}
    return [translated(M_G_OF_PARALLAXES, flight=flight_name(flight.name), **sizes)]


def _of_images(flight):
    """What the residuals say of the image points' m_g, beside the one given."""
    found = flight.orientation
    if (shown := found.image_points) is None:
        return []
    rays, bent = found.m_g_intersection_um, found.m_g_orientation_um
    return [
        translated(
            M_G_OF_IMAGES,
            flight=flight_name(flight.name),
            given=number(shown.given),
            shown=_shown(shown),
            model=number(math.hypot(rays, bent)),
            rays=number(rays),
            bent=number(bent),
        )
    ]


def measured_error_remarks(flights) -> tuple[str, ...]:
    """Say what m_g of each flight the measurements show."""
    return tuple(
        translated(
            M_G_SHOWN,
            flight=flight_name(flight.name),
            given=number(flight.shown_m_g.given),
            shown=_shown(flight.shown_m_g),
        )
        for flight in flights
        if flight.shown_m_g is not None
    )


def _shown(component):
    return with_error(component.estimated, component.standard_error)
