"""What goes through the parameters of models, also where these are of two kinds."""

import numpy as np
import pytest
from scipy import sparse

from einschalt.stages.error_propagation.covariances import (
    SharedCovariances,
    covariances_of_pairs,
    propagate,
)
from einschalt.stages.error_propagation.propagation_steps import PropagationSteps
from einschalt.theory.adjustment.point_operator import Axes, PointOperator, selection

N_MODELS, N_CHANGES, N_FITTED = 7, 6, 4
LOST = 2  # a model that could not be transformed
AXES = [Axes.PLANE, Axes.SPACE]


def _numbers(rng, axes, n_rows, n_columns, pairs):
    """Operator with a small matrix for each pair of a row and a column."""
    blocks = rng.normal(size=(len(pairs), axes.value, axes.value))
    row, column = (axes.rows(part) for part in np.transpose(pairs))
    places = [
        np.broadcast_to(part, blocks.shape).ravel()
        for part in (row[:, :, None], column[:, None, :])
    ]
    shape = axes.size(n_rows), axes.size(n_columns)
    return PointOperator((sparse.csr_array((blocks.ravel(), places), shape),), axes)


def _chains(axes, in_model, *, without=()):
    """Of models from images: each point is measured, and all of a model turn it.

    Neighbouring models share a third of their image points.
    """
    rng = np.random.default_rng(8)
    model = np.repeat(np.arange(N_MODELS), in_model)
    n_values, n_sources = len(model), N_MODELS * in_model
    every, n_each = np.arange(n_values), N_CHANGES // axes.value
    source = (every + in_model // 3 * (every % 3 == 0)) % n_sources
    image = _numbers(rng, axes, n_values, n_sources, np.column_stack([every, source]))
    of_changes = n_each * model[:, None] + np.arange(n_each)
    pairs = np.column_stack([np.repeat(every, n_each), of_changes.ravel()])
    turned = _numbers(rng, axes, n_values, n_each * N_MODELS, pairs)
    pairs = np.column_stack([of_changes.ravel(), np.repeat(source, n_each)])
    changes = _numbers(rng, axes, n_each * N_MODELS, n_sources, pairs)
    measured = image + turned @ changes
    is_fitted = (every % in_model < N_FITTED) & ~np.isin(model, without)
    n_together = 3
    columns = n_together * model[:, None] + np.arange(n_together)
    kept = np.flatnonzero(~np.isin(model, without))
    pairs = np.column_stack([np.repeat(kept, n_together), columns[kept].ravel()])
    values = _numbers(rng, axes, n_values, n_together * N_MODELS, pairs)
    fitted = np.flatnonzero(is_fitted)
    pairs = np.column_stack([columns[fitted].ravel(), np.repeat(fitted, n_together)])
    onto = _numbers(rng, axes, n_together * N_MODELS, n_values, pairs)
    known = np.repeat(rng.integers(0, 9, len(fitted)), n_together)
    ground = np.column_stack([columns[fitted].ravel(), known])
    control = _numbers(rng, axes, n_together * N_MODELS, 9, ground)
    own = selection(every, n_values, axes)
    low = (own + values @ onto) @ measured
    return {"control": values @ control, "low_flight": low}


def _sizes(chains):
    return {
        name: np.linspace(0.5, 1.5, chain.n_sources) for name, chain in chains.items()
    }


def _whole(chains):
    """Covariances between all points, by the full matrices."""
    axes = next(iter(chains.values())).axes
    found = 0.0
    for name, chain in chains.items():
        rows = chain.matrix.toarray() * np.repeat(_sizes(chains)[name], axes.value)
        n = chain.n_points
        found = found + (rows @ rows.T).reshape(n, axes.value, n, axes.value)
    return found.swapaxes(1, 2)


@pytest.mark.parametrize("axes", AXES, ids=lambda axes: axes.name)
@pytest.mark.parametrize("without", [(), (LOST,)], ids=["all", "one_lost"])
def test_points_of_models_from_images(axes, without):
    chains = _chains(axes, 6, without=without)
    n = next(iter(chains.values())).n_points
    pairs = np.stack(np.meshgrid(np.arange(n), [0, 13, n - 1]), -1).reshape(-1, 2)
    found = covariances_of_pairs(chains, _sizes(chains), pairs)
    expected = _whole(chains)[pairs[:, 0], pairs[:, 1]]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("axes", AXES, ids=lambda axes: axes.name)
def test_their_means_with_what_values_share(axes):
    chains = _chains(axes, 6)
    n = next(iter(chains.values())).n_points
    pairs = np.column_stack([np.arange(n - 1), np.arange(1, n)])
    means = np.column_stack([pairs[:, 0] // 2, pairs[:, 0]])
    mean = _numbers(np.random.default_rng(3), axes, n // 2, n, means)
    known, sizes = SharedCovariances(), _sizes(chains)
    covariances_of_pairs(chains, sizes, pairs, known)
    to_means = {name: mean @ chain for name, chain in chains.items()}
    names = np.arange(n // 2).astype(str).astype(object)
    errors = propagate(names, to_means, sizes, known)
    whole = _whole(to_means)
    own = whole[range(n // 2), range(n // 2)]
    np.testing.assert_allclose(errors.covariance, own, rtol=1e-9, atol=1e-9)
    between = errors.covariance_between(["3", "8"], ["1", "8"])
    np.testing.assert_allclose(between, whole[[3, 8], [1, 8]], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("axes", AXES, ids=lambda axes: axes.name)
def test_points_of_a_model_cost_as_much_each_however_many_they_are(axes):
    """No matrix has an entry for every two points of a model."""
    few, many = (PropagationSteps.of(_chains(axes, in_model)) for in_model in (6, 60))
    for steps in (few, many):
        assert set(steps.through) == {"control", "low_flight"}
        # transformation and orientation of a model in one bundle
        assert steps.size == axes.size(3) + N_CHANGES
    in_row = [steps.direct["low_flight"].matrix.nnz for steps in (few, many)]
    assert in_row[1] == 10 * in_row[0]
    assert many.last.matrix.nnz == 10 * few.last.matrix.nnz
