"""Residuals of the low flight by point, and how errors of all sources enter them."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segments
from einschalt.foundations.key_columns import rows_among
from einschalt.theory.adjustment.point_operator import (
    PointOperator,
    selection,
    weighted_mean,
)

KEY = ["coverage", "model_id", "point_id"]


@dataclass(frozen=True, eq=False)
class MeanResiduals:
    """Residuals of each point on the average of its models."""

    # shape (n_points, n_axes); transformed minus approximate [m]
    vectors: np.ndarray
    positions: np.ndarray  # shape (n_points, 2); easting, northing [m]
    places: np.ndarray  # shape (n_points,); which of the given points they are
    # they are ``of_values`` times the errors of the values less ``of_ground`` times
    # those of the approximate coordinates
    of_values: PointOperator
    of_ground: PointOperator


def mean_residuals(low, model, is_good) -> MeanResiduals:
    """Average the residuals of the low flight over the models of each point.

    ``low`` is the flight as it was fitted, ``model`` that of its errors, and
    ``is_good`` (n_fits,) what is averaged of the fitted points.
    """
    observed = low.observed
    rows, onto = observed.row_numbers[is_good], observed.ground_rows[is_good]
    places = model.places[onto]
    distinct, group = np.unique(places, return_inverse=True)
    sort = segments(group, len(distinct))
    n_rows, axes = len(rows), model.axes
    mean = weighted_mean(sort.order, np.ones(n_rows), sort.start, n_rows, axes)
    first = sort.order[sort.start[:-1]]
    return MeanResiduals(
        vectors=mean.of_vectors(low.fit.residuals[is_good]),
        positions=observed.target[is_good][first, :2],
        places=distinct,
        of_values=(mean @ selection(rows, model.low.measured.n_points, axes)).formed(),
        of_ground=selection(distinct, model.low.ground.n_sources, axes),
    )


def fits_without(low, suspects):
    """Fitted points of usable models with redundancy that are none of some, (n_fits,).

    ``suspects``: rows of ``low.residuals`` that are left out.
    """
    observed = low.observed
    is_usable = low.models["is_usable"].to_numpy(dtype=bool) & (low.fit.redundancy > 0)
    usable = np.repeat(is_usable, np.diff(observed.start))
    return usable & ~rows_among(observed.rows, suspects, KEY)
