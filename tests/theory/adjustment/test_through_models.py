import numpy as np
import pytest
from scipy import sparse

from einschalt.theory.adjustment.joint_covariance import BundlePairs
from einschalt.theory.adjustment.point_operator import Axes, PointOperator
from einschalt.theory.adjustment.through_models import joint_through_models

SIZE, N_MODELS, N_FITTED, N_POINTS, N_BUNDLES = 2, 5, 6, 12, 4
N_ERRORS = N_MODELS * N_FITTED


def _filled(rng, is_filled):
    numbers = rng.normal(size=(2, *is_filled.shape))
    return sparse.csr_array((numbers[0] + 1j * numbers[1]) * is_filled)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@pytest.fixture
def steps(rng):
    """G, X, P and M: each model is fitted on its own errors, a point has its own."""
    error = np.arange(N_ERRORS)
    of_model = np.repeat(np.arange(N_MODELS), SIZE)[:, None] == error // N_FITTED
    of_point = np.arange(N_POINTS)[:, None] == rng.permutation(error) % N_POINTS
    ground = rng.random((N_BUNDLES, N_POINTS)) < 0.5
    to_points = np.ones((N_POINTS, N_MODELS * SIZE))
    patterns = np.repeat(ground, SIZE, axis=0), to_points, of_model, of_point
    return [_filled(rng, pattern) for pattern in patterns]


def _chain(steps, axes=Axes.COMPLEX):
    ground, to_points, of_models, of_points = steps
    products = (ground, to_points, of_models), (ground, of_points)
    return PointOperator.sum_of([PointOperator(one, axes) for one in products])


def _joint(chain, standard_errors):
    def rows_of(product):
        return sparse.bsr_array(sparse.csr_array(product.matrix), blocksize=(SIZE, 1))

    every = BundlePairs.of(np.ones((N_BUNDLES, N_BUNDLES), dtype=bool))
    return joint_through_models(rows_of, chain, every, SIZE, standard_errors)


def test_it_is_the_covariance_of_all_errors(steps, rng):
    chain, each = _chain(steps), rng.uniform(0.5, 2.0, N_ERRORS)
    rows = chain.matrix.toarray() * each
    whole = (rows @ rows.conj().T).reshape(N_BUNDLES, SIZE, N_BUNDLES, SIZE)
    later, earlier = np.tril_indices(N_BUNDLES)
    found = _joint(chain, each)
    expected = whole[later, :, earlier]
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


def test_measurements_without_errors_go_another_way(steps):
    assert _joint(_chain(steps), np.zeros(N_ERRORS)) is None


@pytest.mark.parametrize("place", [2, 3])
def test_models_and_points_that_share_errors_go_another_way(steps, rng, place):
    steps[place] = _filled(rng, np.ones(steps[place].shape))
    assert _joint(_chain(steps), np.ones(N_ERRORS)) is None


def test_other_chains_go_another_way(steps):
    ground, to_points, of_models, of_points = steps
    one = PointOperator((ground, of_points), Axes.COMPLEX)
    copied = PointOperator((ground.copy(), to_points, of_models), Axes.COMPLEX)
    for chain in (one, PointOperator.sum_of([one, copied])):
        assert _joint(chain, np.ones(N_ERRORS)) is None
