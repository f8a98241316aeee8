"""What each flight measured, and how well its models fit."""

import numpy as np

from einschalt.foundations.typesetting import count, length, lengths, number, scale
from einschalt.foundations.units import METRES_PER_MM, ground_from_image_um
from einschalt.pipeline.assessment.image_precision import (
    common_sigma_0,
    image_component,
)
from einschalt.pipeline.block.facts import count_models
from einschalt.pipeline.summary.sections.section import Section
from einschalt.pipeline.summary.wording import with_error


def section(result) -> Section:
    """Say what each flight measured, and how well its models fit."""
    figures = result.figures
    m_0_of = {"high_flight": figures.m_0_high, "low_flight": figures.m_0_low}
    m_0 = lengths([m_0_of[name] for name in result.block.flights])
    m_g = lengths(
        [
            ground_from_image_um(flight.m_g_um, flight.scale_number)
            for flight in result.block.flights.values()
        ]
    )
    rows = [
        (
            name.replace("_", " "),
            scale(flight.scale_number),
            flight.transformation,
            f"{count_models(flight):d}",
            _usable(result.models, name),
            f"{number(flight.m_g_um)} µm",
            m_g[place],
            m_0[place],
        )
        for place, (name, flight) in enumerate(result.block.flights.items())
    ]
    header = ("", "scale", "fit", "models", "usable", "m_g", "on ground", "m_0")
    remarks = (*approximations(result), *orientations(result), *measured_errors(result))
    return Section("Flights (m_g and m_0 are total)", header, tuple(rows), remarks)


def _usable(models, flight):
    is_usable = models["is_usable"].astype(bool)
    return f"{int((is_usable & (models['flight'] == flight)).sum()):d}"


def approximations(result) -> tuple[str, ...]:
    """Say where the approximate coordinates come from and how good they are."""
    block, figures = result.block, result.figures
    if block.high_flight is None:
        n_points = count(len(block.approximate_points), "point")
        m_0 = block.approximate_m_0_m
        said = f"{length(m_0)} (total, as given)" if m_0 else "of unknown precision"
        return (f"Approximate coordinates: {n_points} given, {said}.",)
    n_points = count(len(result.approximations), "point")
    internal = figures.approximation_internal
    if not np.isfinite(internal):
        return (f"Approximate coordinates: {n_points} from the high flight.",)
    said = f"{length(internal)} (total, internal)"
    return (f"Approximate coordinates: {n_points} from the high flight, {said}.",)


def orientations(result) -> tuple[str, ...]:
    """Say how well the models of each flight could be oriented."""
    lines = []
    for flight, rows in result.orientations.groupby("flight", sort=False):
        sigma_0 = common_sigma_0(rows)[0]
        has_images = result.block.flights[flight].has_images
        observed = "an image coordinate" if has_images else "a y-parallax"
        lines.append(
            f"Relative orientation, {flight.replace('_', ' ')}: "
            f"{count(len(rows), 'model')}, sigma_0 {length(sigma_0 * METRES_PER_MM)} "
            f"of {observed}; it sees y-parallax only."
        )
        measuring_error = _of_images if has_images else _of_parallaxes
        lines += measuring_error(flight, rows, result.block)
    return tuple(lines)


def _of_parallaxes(flight, rows, block):
    """What the errors of y-parallaxes make of m_g, beside the one given."""
    bent = np.sqrt(np.mean(rows["m_g_orientation_um"].astype(float) ** 2))
    if not np.isfinite(bent):
        return []
    return [
        (
            f"m_g of the {flight.replace('_', ' ')}: given "
            f"{number(block.flights[flight].m_g_um)}, of which errors of the relative "
            f"orientation make {number(bent)} µm."
        )
    ]


def _of_images(flight, rows, block):
    """What the residuals say of the image points' m_g, beside the one given."""
    parts = rows[["m_g_intersection_um", "m_g_orientation_um"]].astype(float) ** 2
    rays, bent = np.sqrt(parts.mean())
    shown = image_component(rows, block.flights[flight])
    if not np.isfinite(shown.estimated):
        return []
    return [
        (
            f"m_g of the {flight.replace('_', ' ')}: given {number(shown.given)}, the "
            f"image residuals say {_estimated(shown)} µm for an image point, and "
            f"so {number(np.hypot(rays, bent))} µm for a model point ({number(rays)} "
            f"from the rays, {number(bent)} from the orientation)."
        )
    ]


def measured_errors(result) -> tuple[str, ...]:
    """Say what m_g of each flight the measurements show."""
    if result.components is None:
        return ()
    return tuple(
        f"m_g of the {flight.replace('_', ' ')}: given {number(component.given)}, "
        f"the data say {_estimated(component)} µm."
        for flight, component in (
            ("high_flight", result.components.high_flight),
            ("low_flight", result.components.low_flight),
        )
    )


def _estimated(component):
    return with_error(component.estimated, component.standard_error)
