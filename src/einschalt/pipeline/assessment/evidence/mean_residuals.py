"""Residuals of the low flight by point, and how errors of all sources enter them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import sparse

from einschalt.foundations.batches import segments
from einschalt.theory.adjustment.propagation import selection, weighted_mean

KEY = ["coverage", "model_id", "point_id"]


@dataclass(frozen=True, eq=False)
class MeanResiduals:
    """Residuals of each point on the average of its models.

    Attributes
    ----------
    vectors : ndarray, shape (n_points, 2)
        Transformed less approximate, easting and northing [m].
    positions : ndarray, shape (n_points, 2)
        Easting, northing [m].
    of_values, of_ground : sparse array
        They are ``of_values`` times the errors of the values less ``of_ground`` times
        those of the approximate coordinates.
    """

    vectors: np.ndarray
    positions: np.ndarray
    of_values: sparse.sparray
    of_ground: sparse.sparray


def mean_residuals(result, model, most_suspects) -> MeanResiduals:
    """Average the residuals of the low flight over the models of each point.

    Parameters
    ----------
    result : DensificationResult
    model : ErrorModel
        Of it.
    most_suspects : float
        Suspects are left out where their share is not larger than this.

    Returns
    -------
    MeanResiduals
    """
    low = result.low
    observed = low.observed
    is_good = _is_good(result, most_suspects)
    rows, onto = observed.row_numbers[is_good], observed.ground_rows[is_good]
    places = model.places[onto]
    distinct, group = np.unique(places, return_inverse=True)
    sort = segments(group, len(distinct))
    size = (len(rows), model.n_axes)
    mean = weighted_mean(
        np.arange(len(rows))[sort.order], np.ones(len(rows)), sort.start, size
    )
    n_values = model.low.measured.shape[0] // model.n_axes
    plan = weighted_mean(
        np.arange(len(rows))[sort.order], np.ones(len(rows)), sort.start, (len(rows), 1)
    ).tocsr()
    first = sort.order[sort.start[:-1]]
    return MeanResiduals(
        vectors=plan @ low.fit.residuals[is_good, :2],
        positions=observed.target[is_good][first, :2],
        of_values=mean @ selection(rows, n_values, model.n_axes),
        of_ground=selection(
            distinct, model.low.ground.shape[1] // model.n_axes, model.n_axes
        ),
    )


def _is_good(result, most_suspects):
    """Observations of usable models with redundancy that are no suspects."""
    low = result.low
    observed = low.observed
    is_usable = low.models["is_usable"].to_numpy() & (low.fit.redundancy > 0)
    usable = np.repeat(is_usable, np.diff(observed.start))
    residuals = low.residuals
    suspects = residuals.loc[residuals["is_suspect"], KEY]
    if len(suspects) > most_suspects * len(residuals):
        return usable
    is_suspect = pd.MultiIndex.from_frame(observed.rows[KEY]).isin(
        pd.MultiIndex.from_frame(suspects)
    )
    return usable & ~is_suspect
