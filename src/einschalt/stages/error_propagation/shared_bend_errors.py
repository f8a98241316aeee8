"""Errors of the bends that models were corrected by as a source of the propagation."""

from dataclasses import replace

import numpy as np

from einschalt.stages.error_propagation.error_model import HIGH, LOW
from einschalt.theory.adjustment.point_operator import Axes, PointOperator
from einschalt.theory.adjustment.propagation import scattered

SHARED_BEND = "shared_bend"


def with_shared_bends(errors, model, bends, fits):
    """Propagated errors with those of the bends among their sources.

    ``errors`` and ``model`` (ErrorModel) are of final points of spatial models; either
    may be None, and ``errors`` is returned as it is then. ``bends`` are the BentFlights
    that the models were corrected by, or None; ``fits`` are the transformations of each
    flight.
    """
    if errors is None or model is None or bends is None or not bends.tests:
        return errors
    values = _of_columns(model.low.measured, bends, fits[LOW], LOW)
    if model.high is not None:
        onto = model.low.ground @ model.high.mean @ model.high.operator.measured
        values = values + _of_columns(onto, bends, fits[HIGH], HIGH)
    squares, vectors = np.linalg.eigh(bends.covariance)
    root = vectors * np.sqrt(np.maximum(squares, 0.0))
    chain = model.final @ _operator(values @ root)
    size = np.ones(root.shape[1])
    return replace(
        errors,
        parts={**errors.parts, SHARED_BEND: chain.covariances(size)},
        chains={**errors.chains, SHARED_BEND: chain},
        standard_errors={**errors.standard_errors, SHARED_BEND: size},
    )


def _of_columns(operator, bends, fit, flight):
    """What coefficients of 1 of a flight do to the values, (n_values, 3, n_terms)."""
    linear = fit.fit.linear[fit.observed.models.codes]
    columns = bends.columns[flight][: len(linear)]
    on_ground = np.nan_to_num(linear @ columns)
    return np.stack(
        [operator.of_vectors(term) for term in np.moveaxis(on_ground, 2, 0)], axis=2
    )


def _operator(columns):
    """Operator from independent errors of variance 1: the first axis of each source."""
    n_points, _, n_terms = columns.shape
    axes = Axes.SPACE
    blocks = np.zeros((n_points, 3, n_terms, 3))
    blocks[:, :, :, 0] = columns
    rows = axes.rows(np.arange(n_points))
    sources = axes.rows(np.arange(n_terms)).reshape(1, -1)
    sources = np.broadcast_to(sources, (n_points, 3 * n_terms))
    shape = axes.size(n_points), axes.size(n_terms)
    whole = scattered(blocks.reshape(n_points, 3, -1), rows, sources, shape)
    return PointOperator((whole,), axes)
