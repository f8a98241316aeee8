"""Screening of a block's points by the differences of their coverages."""

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.stages.coverage_screening import coverage_differences, screen_coverages
from einschalt.stages.error_propagation.covariances import propagate


def screen_block(means, errors, settings, model):
    """Find the points whose low-flight coverages differ by more than they may.

    ``errors`` and the ``model`` of errors are None where these cannot be propagated.
    """
    differences = coverage_differences(means)
    covariance = None
    if errors is not None and settings.screening == "propagated":
        needed = differences.needed()
        covariance = difference_covariance(needed, errors)
        if len(needed.table) and model.low.turned is not None:
            covariance = covariance + _beyond_linear(needed, model)
        covariance = differences.with_others(covariance)
    return screen_coverages(
        differences, covariance, settings.screening, settings.significance
    )


def difference_covariance(differences, errors):
    """Covariance of differences of the low flight's coverages, all correlations kept.

    Easting and northing, and height of spatial models [m²], shape (n_rows, n_axes,
    n_axes). ``errors`` are those of the means
    of the same values: the difference takes the place of the mean.
    """
    n_rows = len(differences.table)
    if n_rows == 0:
        return np.empty((0, 2, 2))
    n_values = next(iter(errors.chains.values())).last_step.n_sources
    operator = differences.operator(n_values, errors.axes)
    chains = {n: chain.with_last_step(operator) for n, chain in errors.chains.items()}
    names = np.arange(n_rows).astype(object)
    found = propagate(names, chains, errors.standard_errors, errors.known)
    return found.covariance


def _beyond_linear(differences, model):
    """What differences of spatial models miss the linear by, (n_rows, 3, 3) [m²]."""
    squares = model.beyond_linear(differences.rows)
    shares = model.axes.blocks_of(differences.shares)
    parts = shares @ squares @ shares.swapaxes(1, 2)
    return segment_sum(parts, differences.start)


def with_suspects(points, screening):
    """Mark the points whose coverages differ by more than they may: ``is_suspect``."""
    return points.assign(is_suspect=points["point_id"].isin(screening.suspects))
