"""Gross errors of a flight, found where all its models hang together.

A model on five control points cannot say which of its corners is wrong: opposite ones
have the same residual. Its neighbours can, since they hold the same points. So each
flight is adjusted simultaneously for itself, and what data snooping refuses there takes
no part in the two steps. Each for itself: an m_g that was given wrongly then changes
nothing, since the test takes the size of the errors from the flight.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.key_columns import rows_among
from einschalt.pipeline.densification.simultaneous import (
    PLANE_KINDS,
    SearchedFlights,
    searched_flights,
)
from einschalt.stages.simultaneous.adjustment import AdjustmentOptions
from einschalt.stages.simultaneous.searches import Searches
from einschalt.stages.transformation_kinds import SPATIAL

HIGH = "high_flight"
KEY = ["coverage", "model_id", "point_id"]
COLUMNS = [
    *("flight", *KEY, "residual_easting", "residual_northing"),
    *("w", "p_value"),
]
IN_HEIGHT = "residual_height"
# rows of models of a block that is small enough to be computed once more; of a larger
# one what was searched is not kept in memory
MOST_KEPT = 20_000


@dataclass(frozen=True, eq=False)
class GrossMeasurements:
    """Measurements that contradict the other models of their flight."""

    # flight, coverage, model_id, point_id, residual_easting, residual_northing
    # [, residual_height] (what the model misses the point by) [m], w, p_value
    table: pd.DataFrame
    rows: dict  # of each flight, which of its model points they are
    # what an adjustment of all flights may share; None of a large block
    searched: SearchedFlights | None


def find_gross_measurements(
    block, flights, settings, searched=None
) -> GrossMeasurements:
    """Find the measurements that contradict the other models of their flight.

    All measurements of a point in the high flight where they contradict each other and
    none is confirmed, and the only one of a control point. None of a flight that cannot
    be adjusted simultaneously, and none with ``outliers = "keep"``. ``searched`` are
    SearchedFlights that an adjustment of these flights shares.
    """
    searched = searched_flights(block, flights, searched)
    found = [no_gross_measurements()]
    if settings.outliers != "keep":
        parts = [searched]
        if len(flights) > 1:
            none = Searches(are_kept=False)
            parts = [SearchedFlights(block, {k: flights[k]}, none) for k in flights]
        found = [_refused(part, settings.significance) for part in parts]
    table = pd.concat(found, ignore_index=True)
    rows = {
        name: is_gross(table, name, flight.model_points)
        for name, flight in flights.items()
    }
    return GrossMeasurements(table, rows, _if_small(searched))


def _if_small(searched):
    rows = (len(oriented.model_points) for oriented in searched.flights.values())
    return searched if sum(rows) <= MOST_KEPT else None


def no_gross_measurements():
    """Make a table without rows."""
    kinds = dict.fromkeys(COLUMNS[:4], object) | dict.fromkeys(COLUMNS[4:], float)
    return pd.DataFrame({name: np.empty(0, kind) for name, kind in kinds.items()})


def is_gross(table, flight, model_points):
    """Tell which rows of a flight are gross errors, shape (n_model_points,)."""
    is_own = table["flight"] == flight
    if not is_own.any():
        return np.zeros(len(model_points), dtype=bool)
    return rows_among(model_points, table.loc[is_own, KEY], KEY)


def _refused(searched, significance):
    """Gross errors of one flight."""
    block, (name,) = searched.block, searched.flights
    transformation = block.flights[name].transformation
    kinds = (*PLANE_KINDS, SPATIAL)
    if block.control_points is None or transformation not in kinds:
        return no_gross_measurements()
    options = AdjustmentOptions(outliers="snoop", significance=significance)
    try:
        residuals = searched.adjusted(options).residuals
    # too little hangs together: two steps ask for less
    except GeometryError:
        return no_gross_measurements()
    is_out = _chosen(residuals, block.control_points, name, significance)
    return residuals.loc[is_out, columns_of_gross(residuals)]


def columns_of_gross(residuals):
    """Columns of a table of gross measurements, by those of the residuals."""
    if IN_HEIGHT not in residuals:
        return COLUMNS
    place = COLUMNS.index("w")
    return [*COLUMNS[:place], IN_HEIGHT, *COLUMNS[place:]]


def _chosen(residuals, control_points, flight, significance):
    """Measurements that are to take no part."""
    suspect, point_id = residuals["is_suspect"], residuals["point_id"]
    # beside a gross error good points look wrong too, until all of them are out
    n_tested = residuals.groupby(KEY[:2])["p_value"].transform("count")
    is_refused = residuals["p_value"] * n_tested <= significance
    # a measurement that others check, and none refuses, tells who is wrong
    is_witness = ~suspect & residuals["p_value"].notna()
    has_witness = is_witness.groupby(point_id).transform("any")
    is_disputed = suspect.groupby(point_id).transform("any") & ~has_witness
    if flight != HIGH:
        # the approximate coordinates tell, model by model
        return suspect & is_refused & has_witness
    # the point can do without approximate coordinates; where several measurements of a
    # control point contradict it, its given coordinates are wrong
    is_control = point_id.isin(control_points["point_id"])
    is_several = residuals["p_value"].groupby(point_id).transform("count") > 1
    is_given_wrong = is_control & is_several
    return (suspect & is_refused & has_witness) | (is_disputed & ~is_given_wrong)
