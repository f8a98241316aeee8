"""The simultaneous adjustment of a block: both flights and the control at once."""

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.units import METRES_PER_UM
from einschalt.stages.block_tables import MeasuredFlight, code_block
from einschalt.stages.simultaneous_adjustment import (
    SIGNIFICANCE,
    AdjustmentOptions,
    simultaneous_adjustment,
)
from einschalt.stages.stage2_relative_orientation import relative_orientation
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.block_adjustment.common_parameters import AFFINITY, CommonTerms

FILM_AFFINITY = "helmert_film_affinity"
KINDS = ("affine", "helmert", FILM_AFFINITY)
WHICH = {
    "both": ("high_flight", "low_flight"),
    "high": ("high_flight",),
    "low": ("low_flight",),
}


def adjust_block(
    block,
    *,
    kind="affine",
    flights="both",
    deformation=(),
    outliers="keep",
    significance=SIGNIFICANCE,
):
    """Adjust all models of a block with its control at once.

    Every measured coordinate is an observation with the standard error m_g · scale
    number / √2 on the ground, smaller by the root of its settings; every control point
    is an observation with its own standard error, or held where it has none. Check
    points are adjusted as new points.

    Parameters
    ----------
    block : Block
    kind : {"affine", "helmert", "helmert_film_affinity"}
        Transformation of every model; the last is helmert with one film affinity that
        all models of a flight share.
    flights : {"both", "high", "low"}
    deformation : sequence of {"quadratic", "cubic"}
        Deformations of the model that all models of a flight share.
    outliers : {"keep", "snoop", "huber", "tukey"}
        What happens to gross errors: they are only named, taken out, or given less
        weight.
    significance : float
        Probability with which a model without gross errors has a suspect.

    Returns
    -------
    BlockAdjustment
        ``points``, ``models``, ``residuals``, ``control``, ``s_0``, ``failures``, …

    Raises
    ------
    GeometryError
        Nothing of the block can be determined.
    SettingsError
        An option is unknown, or the block has no such flight.
    """
    _require(kind, KINDS, "kind")
    _require(flights, tuple(WHICH), "flights")
    measured = {
        name: flight for name, flight in block.flights.items() if name in WHICH[flights]
    }
    if not measured:
        raise SettingsError(
            f"flights = {flights!r}, but the block has no {flights} flight",
            expected=" or ".join(
                name.removesuffix("_flight") for name in block.flights
            ),
        )
    oriented = {
        name: relative_orientation(f).model_points for name, f in measured.items()
    }
    kinds = dict.fromkeys(measured, "affine" if kind == "affine" else "helmert")
    families = (*((AFFINITY,) if kind == FILM_AFFINITY else ()), *deformation)
    tables = block_tables(block, oriented, kinds)
    options = AdjustmentOptions(
        common=common_terms(measured, families),
        outliers=outliers,
        significance=significance,
    )
    return simultaneous_adjustment(tables, options)


def _require(value, allowed, name):
    if value not in allowed:
        raise SettingsError(
            f"{name} = {value!r} is unknown", expected=" or ".join(allowed)
        )


def common_terms(flights, families):
    """Terms that the models of each flight share.

    Parameters
    ----------
    flights : sized
    families : tuple of str

    Returns
    -------
    tuple of CommonTerms
    """
    if not families:
        return ()
    return tuple(CommonTerms(place, families) for place in range(len(flights)))


def block_tables(block, model_points, kinds):
    """Observations of a block.

    Parameters
    ----------
    block : Block
    model_points : dict of str to DataFrame
        Of each flight that takes part, after its relative orientation.
    kinds : dict of str to str
        affine or helmert, of each flight.

    Returns
    -------
    BlockTables
    """
    measured = [
        MeasuredFlight(
            name, points, _standard_errors(block.flights[name], points), kinds[name]
        )
        for name, points in model_points.items()
    ]
    return code_block(measured, block.control_points)


def _standard_errors(flight, model_points):
    """Standard error of one measured coordinate on the ground; m_g is total [m]."""
    m_g_um = flight.m_g_um_of(model_points)
    return np.asarray(m_g_um) * METRES_PER_UM * flight.scale_number / SQRT2
