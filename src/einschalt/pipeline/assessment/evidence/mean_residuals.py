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

    # shape (n_points, 2); transformed minus approximate, easting and northing [m]
    vectors: np.ndarray
    positions: np.ndarray  # shape (n_points, 2); easting, northing [m]
    # they are ``of_values`` times the errors of the values less ``of_ground`` times
    # those of the approximate coordinates
    of_values: PointOperator
    of_ground: PointOperator


def mean_residuals(examined, model, most_suspects) -> MeanResiduals:
    """Average the residuals of the low flight over the models of each point.

    Suspects are left out where their share is not larger than ``most_suspects``.
    """
    low = examined.low
    observed = low.observed
    is_good = _is_good(examined, most_suspects)
    rows, onto = observed.row_numbers[is_good], observed.ground_rows[is_good]
    places = model.places[onto]
    distinct, group = np.unique(places, return_inverse=True)
    sort = segments(group, len(distinct))
    n_rows, axes = len(rows), model.axes
    mean = weighted_mean(sort.order, np.ones(n_rows), sort.start, n_rows, axes)
    first = sort.order[sort.start[:-1]]
    return MeanResiduals(
        vectors=mean.of_vectors(low.fit.residuals[is_good])[:, :2],
        positions=observed.target[is_good][first, :2],
        of_values=(mean @ selection(rows, model.low.measured.n_points, axes)).formed(),
        of_ground=selection(distinct, model.low.ground.n_sources, axes),
    )


def _is_good(examined, most_suspects):
    """Observations of usable models with redundancy that are no suspects."""
    low = examined.low
    observed = low.observed
    is_usable = low.models["is_usable"].to_numpy() & (low.fit.redundancy > 0)
    usable = np.repeat(is_usable, np.diff(observed.start))
    residuals = low.residuals
    suspects = residuals.loc[residuals["is_suspect"], KEY]
    if len(suspects) > most_suspects * len(residuals):
        return usable
    return usable & ~rows_among(observed.rows, suspects, KEY)
