"""Collocation against the whole system, solved by numpy."""

import numpy as np
import pytest
from tests.simulated_shifts import simulated_shifts

from einschalt.theory.residual_distribution.collocation import (
    N_NEAREST,
    collocate,
    collocate_left_out,
)
from einschalt.theory.residual_distribution.covariance_function import (
    CovarianceFunction,
    estimate_covariance,
)

FUNCTION = CovarianceFunction(0.01, np.array([0.2, 1.0]), np.array([80.0, 400.0]))


def kriged(known, shifts, places, function=FUNCTION):
    """Ordinary kriging by the bordered system of all known points."""
    n_known = len(known)
    between = np.linalg.norm(known[:, None] - known, axis=2)
    system = np.ones((n_known + 1, n_known + 1))
    system[:-1, :-1] = function(between) + function.nugget * np.eye(n_known)
    system[-1, -1] = 0.0
    right = np.ones((n_known + 1, len(places)))
    right[:-1] = function(np.linalg.norm(known[:, None] - places, axis=2))
    solved = np.linalg.solve(system, right)
    return solved[:-1].T @ shifts, function.variance - (solved * right).sum(axis=0)


@pytest.fixture(scope="module")
def known():
    rng = np.random.default_rng(1)
    xy = np.array([4.5e6, 5.6e6]) + rng.uniform(0.0, 500.0, (N_NEAREST, 2))
    return xy, rng.normal(size=(N_NEAREST, 2))


def test_few_points_are_collocated_as_by_the_whole_system(known):
    # far ones as well, whose distances are not tabulated
    places = known[0][0] + np.array([[0.0, 0.0], [3.0, -8.0], [200.0, 90.0], [3e4, 0]])
    found, variances = collocate(*known, places, FUNCTION)
    shifts, expected = kriged(*known, places)
    np.testing.assert_allclose(found, shifts, atol=1e-8)
    np.testing.assert_allclose(variances, expected, atol=1e-8)


def test_a_point_left_out_is_collocated_from_the_others(known):
    xy, shifts = known
    trusted = np.arange(len(xy)) != 3
    found, variances = collocate_left_out(xy, shifts, FUNCTION, trusted)
    for row in (3, 5):  # one that nobody trusts is predicted as well
        others = trusted & (np.arange(len(xy)) != row)
        expected = kriged(xy[others], shifts[others], xy[[row]])
        np.testing.assert_allclose(found[row], expected[0][0], atol=1e-8)
        np.testing.assert_allclose(variances[row], expected[1][0], atol=1e-8)


def test_points_at_one_place_share_their_weight():
    xy = np.array([[0.0, 0.0], [0.0, 0.0], [900.0, 0.0]])
    shifts = np.array([[0.0, 1.0], [0.0, 3.0], [0.0, 2.0]])
    found, _ = collocate(xy, shifts, xy[:1], FUNCTION)
    assert found[0, 1] == pytest.approx(2.0, abs=1e-6)


def test_the_covariance_function_is_found():
    rng = np.random.default_rng(2)
    xy, shifts, _ = simulated_shifts(
        rng, 4000, extent=5e3, reach=800.0, signal=0.3, noise=0.03
    )
    function = estimate_covariance(xy, shifts)
    distance = np.array([100.0, 200.0, 400.0, 800.0])
    found = function.variance - function(distance)
    # one field alone: its variogram is known to some per cent at short distances
    expected = 0.03**2 + 0.3**2 * (1.0 - np.exp(-distance / 800.0))
    np.testing.assert_allclose(found[:3], expected[:3], rtol=0.25)
    assert np.all(np.diff(function(np.linspace(0.0, 5e3, 50))) < 0.0)


def test_shifts_that_are_all_alike_have_no_covariance():
    xy = np.random.default_rng(3).uniform(0.0, 1.0, (30, 2))
    found, variances = collocate(
        xy, np.ones((30, 2)), xy, estimate_covariance(xy, np.ones((30, 2)))
    )
    np.testing.assert_allclose(found, 1.0, atol=1e-12)
    assert variances.max() < 1e-12
