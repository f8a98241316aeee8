"""What each flight measured, how well its models fit, and what m_g the data show."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.units import METRES_PER_MM, ground_from_image_um
from einschalt.pipeline.assessment.evidence.image_precision import (
    common_sigma_0,
    good_sigma_0,
    image_component,
)
from einschalt.pipeline.assessment.evidence.variance_components import Component
from einschalt.stages.curved_earth import is_worth_bending


@dataclass(frozen=True)
class OrientationFacts:
    """The relative orientations of one flight."""

    n_models: int
    # of one observation, all models together [m in the image]; NaN without redundancy
    sigma_0: float
    is_from_images: bool
    # m_g of the image points as given, and as their residuals show it; None where the
    # flight has none, or they have no redundancy
    image_points: Component | None
    # what intersection and orientation make of m_g, RMS over the models; NaN where
    # unknown
    m_g_intersection_um: float
    m_g_orientation_um: float


@dataclass(frozen=True)
class FlightFacts:
    """One flight."""

    name: str
    scale_number: float
    transformation: str
    n_models: int
    n_usable: int
    # as given, TOTAL [µm in the image; m]
    m_g_um: float
    m_g_ground: float
    m_0: float  # of all models together, TOTAL [m]
    orientation: OrientationFacts | None  # None where nothing was oriented
    # m_g as given and as the measurements of both flights show it [µm]
    shown_m_g: Component | None
    # whether the map is curved and scaled, and its spatial models were moved as it is
    is_curved: bool


@dataclass(frozen=True)
class ApproximationFacts:
    """Where the approximate coordinates come from, and how good they are."""

    n_points: int
    is_given: bool  # whether they were given, not computed from a high flight
    # as stated, or from the differences of the coverages, TOTAL [m]; NaN where unknown
    total: float


def flight_facts(examined) -> tuple[FlightFacts, ...]:
    """Collect the facts of every flight."""
    figures, components = examined.figures, examined.components
    is_treated = examined.settings.earth_curvature == "treated"
    m_0 = {"high_flight": figures.m_0_high, "low_flight": figures.m_0_low}
    is_usable = examined.models["is_usable"].astype(bool)
    usable = examined.models.loc[is_usable, "flight"].value_counts()
    return tuple(
        FlightFacts(
            name=name,
            scale_number=float(flight.scale_number),
            transformation=flight.transformation,
            n_models=flight.n_models,
            n_usable=int(usable.get(name, 0)),
            m_g_um=float(flight.m_g_um),
            m_g_ground=float(ground_from_image_um(flight.m_g_um, flight.scale_number)),
            m_0=float(m_0[name]),
            orientation=_orientation(examined, name, flight),
            shown_m_g=getattr(components, name, None),
            is_curved=is_treated
            and is_worth_bending(examined.block, name, flight.transformation),
        )
        for name, flight in examined.block.flights.items()
    )


def _orientation(examined, name, flight):
    rows = examined.orientations[examined.orientations["flight"] == name]
    if rows.empty:
        return None
    good = good_sigma_0(examined, name)
    sigma_0 = common_sigma_0(rows)[0] if good is None else good
    m_g = rows[["m_g_intersection_um", "m_g_orientation_um"]].astype(float)
    rays, bent = np.sqrt((m_g**2).mean())
    shown = image_component(rows, flight, good) if flight.has_images else None
    is_known = shown is not None and np.isfinite(shown.estimated)
    return OrientationFacts(
        n_models=len(rows),
        sigma_0=float(sigma_0 * METRES_PER_MM),
        is_from_images=flight.has_images,
        image_points=shown if is_known else None,
        m_g_intersection_um=float(rays),
        m_g_orientation_um=float(bent),
    )


def approximation_facts(examined) -> ApproximationFacts:
    """Say where the approximate coordinates come from and how good they are."""
    block = examined.block
    if block.high_flight is None:
        stated = block.approximate_m_0_m or np.nan
        return ApproximationFacts(len(block.approximate_points), True, float(stated))
    internal = examined.figures.approximation_internal
    return ApproximationFacts(len(examined.approximations), False, float(internal))
