"""After stage 5, if wanted: residuals of control, distributed to the points between.

For a cadastre that must fit: control keeps the coordinates that it was given, and every
point between takes its share of the corrections. The result is linear in the adjusted
and the given coordinates, so that its covariance follows by propagation.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import sparse

from einschalt.foundations.frame_columns import values_of
from einschalt.stages.error_propagation.covariances import propagate
from einschalt.theory.adjustment.point_operator import by_coordinate, selection
from einschalt.theory.residual_distribution.distribution_weights import (
    distribution_weights,
    with_unit_rows,
)

PLANE = ("easting", "northing")


@dataclass(frozen=True, eq=False)
class Distribution:
    """Points after the distribution of residuals."""

    # as given, with ``easting`` and ``northing`` after the distribution and the part of
    # it in ``distributed_easting``, ``distributed_northing`` [m]. Differences of check
    # points are those of the new coordinates, differences of control points stay what
    # they were: they are what was distributed
    points: pd.DataFrame
    # (n_points, n_used): share of each point in the residual of each control point
    weights: sparse.csr_array
    # control_places, control_sources: (n_used,): where the control points that were
    # used stand among the points, and in the table of control points
    control_places: np.ndarray
    control_sources: np.ndarray


def distribute_residuals(points, control_points, method) -> Distribution:
    """Distribute the residuals of control points to all points.

    ``points`` has point_id, easting, northing, role, difference_easting,
    difference_northing [m]. ``method`` is "natural_neighbour" (beyond the hull of the
    control points a point takes what the nearest place of the hull takes),
    "inverse_distance" or "multiquadric". Control takes its given coordinates; without
    any that has coordinates nothing is distributed.
    """
    differences = values_of(points, [f"difference_{name}" for name in PLANE])
    xy = values_of(points, PLANE)
    is_used = (points["role"] == "control").to_numpy() & np.isfinite(differences).all(1)
    places = np.flatnonzero(is_used)
    if len(places):
        given = np.where(is_used[:, None], xy - differences, xy)
        weights = distribution_weights(given[places], given, method)
        # beside another control point it would take of that one's, and miss the given
        weights = with_unit_rows(weights, places, np.arange(len(places)))
    else:
        weights = sparse.csr_array((len(points), 0))
    shift = -(weights @ differences[places])
    is_check = (points["role"] == "check").to_numpy()[:, None]
    moved = np.where(is_check, differences + shift, differences)
    columns = {}
    for axis, name in enumerate(PLANE):
        columns[name] = xy[:, axis] + shift[:, axis]
        columns[f"difference_{name}"] = moved[:, axis]
        columns[f"distributed_{name}"] = shift[:, axis]
    sources = pd.Index(control_points["point_id"]).get_indexer(
        points["point_id"].iloc[places]
    )
    return Distribution(points.assign(**columns), weights, places, sources)


def errors_after_distribution(errors, distribution):
    """Covariances of the points after the distribution.

    A point's error is its own less the weighted errors of the control points' densified
    coordinates, plus those of their given coordinates.
    """
    axes, n_points = errors.axes, len(errors.point_ids)
    # heights stay what they were
    weights = by_coordinate(distribution.weights, axes, is_plan_only=True)
    densified = selection(distribution.control_places, n_points, axes)
    every = selection(np.arange(n_points), n_points, axes)
    left = every.tocsr() - (weights @ densified).formed()
    chains = {name: left @ chain for name, chain in errors.chains.items()}
    n_control = len(errors.standard_errors["control"])
    given = selection(distribution.control_sources, n_control, axes)
    chains["control"] = chains["control"] + (weights @ given).formed()
    return propagate(errors.point_ids, chains, errors.standard_errors)
