"""The simultaneous adjustment of a block: both flights and the control at once."""

import numpy as np
import pandas as pd

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.units import METRES_PER_UM
from einschalt.stages.block_tables import MeasuredFlight, code_block
from einschalt.stages.residual_distribution import distribute_residuals
from einschalt.stages.simultaneous_adjustment import (
    DEFORMATIONS,
    SIGNIFICANCE,
    AdjustmentOptions,
    simultaneous_adjustment,
)
from einschalt.stages.stage2_relative_orientation import relative_orientation
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    DEGREE,
    CommonTerms,
)

FILM_AFFINITY = "helmert_film_affinity"
PLANE_KINDS = ("affine", "helmert")
STANDARD_ERRORS = [
    "standard_error_easting",
    "standard_error_northing",
    "covariance_en",
    "standard_error_total",
]
DIFFERENCES = ["difference_easting", "difference_northing"]
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
    deformation : sequence of {"quadratic", "cubic"}, or "modelled" or "tested"
        Deformations of the model that all models of a flight share: these; or those
        that a test finds; or none, but the test is made (``deformations``).
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
    searched = deformation if isinstance(deformation, str) else "ignored"
    _require(searched, DEFORMATIONS, "deformation")
    given = () if isinstance(deformation, str) else tuple(deformation)
    for family in given:
        _require(family, tuple(DEGREE), "deformation")
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
    _require_control(block)
    kinds = dict.fromkeys(measured, "affine" if kind == "affine" else "helmert")
    families = (*((AFFINITY,) if kind == FILM_AFFINITY else ()), *given)
    tables = block_tables(block, oriented, kinds)
    options = AdjustmentOptions(
        common=common_terms(measured, families),
        outliers=outliers,
        significance=significance,
        deformation=searched,
    )
    return simultaneous_adjustment(tables, options)


def require_adjustable(block):
    """Refuse what the simultaneous adjustment cannot do.

    Parameters
    ----------
    block : Block

    Raises
    ------
    SettingsError
        There is no control, or a flight has models of a kind that is not adjusted
        simultaneously.
    """
    _require_control(block)
    for name, flight in block.flights.items():
        if flight.transformation not in PLANE_KINDS:
            raise SettingsError(
                f"[{name}] transformation = {flight.transformation!r} with method = "
                '"simultaneous"',
                expected=" or ".join(PLANE_KINDS),
                remedy='Write one of these, or set method = "pipeline"',
            )


def _require_control(block):
    control = block.control_points
    if control is None or not (control["role"] != "check").any():
        raise SettingsError(
            "the block has no control points",
            expected="control_points that hold the adjusted models",
            remedy='Give control_points, or set method = "pipeline"',
        )


def adjust_flights(block, settings, flights):
    """Adjust all flights of a block as its settings say.

    Parameters
    ----------
    block : Block
    settings : Settings
    flights : dict of str to RelativeOrientation
        Every flight of the block after stage 2.

    Returns
    -------
    BlockAdjustment
    """
    kinds = {name: flight.transformation for name, flight in block.flights.items()}
    oriented = {name: flight.model_points for name, flight in flights.items()}
    options = AdjustmentOptions(
        outliers=settings.outliers,
        significance=settings.significance,
        deformation=settings.model_deformation,
    )
    return simultaneous_adjustment(block_tables(block, oriented, kinds), options)


def point_columns(block, adjusted, two_step):
    """Adjusted points with the columns of every densified point.

    Parameters
    ----------
    block : Block
    adjusted : BlockAdjustment
    two_step : DensificationResult or None

    Returns
    -------
    DataFrame
        A point is suspect with a residual or with given coordinates that contradict.
        ``standard_error_paper`` and ``standard_error_internal`` are those of two
        steps, ``two_step_easting``, ``two_step_northing`` its coordinates. Standard
        errors are left out where the size of a source of error is not known.
    """
    points = adjusted.points.drop(columns=["role", *DIFFERENCES])
    if not _has_known_errors(block):
        points = points.drop(columns=STANDARD_ERRORS)
    place = points.columns.get_loc("n_models")
    beside = _of_two_steps(points["point_id"], two_step)
    for k, name in enumerate(("standard_error_paper", "standard_error_internal")):
        points.insert(place + k, name, beside[name].to_numpy())
    points["is_suspect"] = points["point_id"].isin(_suspects(adjusted))
    for name in ("easting", "northing"):
        points[f"two_step_{name}"] = beside[name].to_numpy()
    return points


def _suspects(adjusted):
    tables = (adjusted.residuals, adjusted.control)
    return pd.concat([t.loc[t["is_suspect"], "point_id"] for t in tables]).unique()


def _of_two_steps(point_id, two_step):
    names = [
        *("easting", "northing"),
        *("standard_error_paper", "standard_error_internal"),
    ]
    if two_step is None:
        return pd.DataFrame(np.nan, index=point_id, columns=names)
    return two_step.points.set_index("point_id")[names].reindex(point_id)


def _has_known_errors(block):
    """Whether every source of error has a known size, as in two steps."""
    return "standard_error_m" in block.control_points and not any(
        flight.is_oriented_numerically for flight in block.flights.values()
    )


def distribute_adjusted(block, settings, points):
    """Distribute the residuals of control, where the settings ask for it.

    Parameters
    ----------
    block : Block
    settings : Settings
    points : DataFrame
        With roles and differences.

    Returns
    -------
    DataFrame
        After a distribution without standard errors: those of before do not hold for
        the points that were moved.
    """
    if settings.residual_distribution == "none":
        return points
    moved = distribute_residuals(
        points, block.control_points, settings.residual_distribution
    ).points
    return moved.drop(columns=STANDARD_ERRORS, errors="ignore")


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
