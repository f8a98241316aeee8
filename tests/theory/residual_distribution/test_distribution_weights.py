"""Weights of residuals: against SciPy, against areas of Voronoi cells, at the edges."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator
from scipy.spatial import ConvexHull, Delaunay, Voronoi

from einschalt.theory.residual_distribution.distribution_weights import (
    DISTRIBUTIONS,
    HARDY,
    distribution_weights,
)
from einschalt.theory.residual_distribution.natural_neighbours import (
    natural_neighbour_weights,
)

METHODS = sorted(DISTRIBUTIONS)
FAR = np.array([700_000.0, 5_300_000.0])


@pytest.fixture(params=[5, 40, 400])
def known(request):
    rng = np.random.default_rng(request.param)
    return FAR + rng.uniform(0.0, 4000.0, (request.param, 2))


def points_among(known, count=200, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(known.min(axis=0) - 300.0, known.max(axis=0) + 300.0, (count, 2))


def voronoi_area(xy, place):
    """Area of the cell of one point; its cell must be bounded."""
    diagram = Voronoi(xy)
    region = diagram.regions[diagram.point_region[place]]
    assert -1 not in region
    return ConvexHull(diagram.vertices[region]).volume


@pytest.mark.parametrize("method", METHODS)
def test_rows_add_up_to_one(known, method):
    weights = distribution_weights(known, points_among(known), method)
    assert weights.shape == (200, len(known))
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_known_points_keep_their_own_residual(known, method):
    weights = distribution_weights(known, known, method).toarray()
    np.testing.assert_allclose(weights, np.eye(len(known)), atol=1e-7)


def test_natural_neighbours_take_areas_of_voronoi_cells():
    rng = np.random.default_rng(3)
    known = rng.uniform(-1.0, 1.0, (60, 2))
    for point in rng.uniform(-0.3, 0.3, (25, 2)):
        weights = natural_neighbour_weights(known, point[None]).toarray()[0]
        both = np.vstack([known, point])
        whole = voronoi_area(both, len(known))
        taken = [
            voronoi_area(known, place) - voronoi_area(both, place)
            for place in np.flatnonzero(weights)
        ]
        np.testing.assert_allclose(
            weights[weights != 0.0], np.divide(taken, whole), atol=1e-9
        )


def test_natural_neighbours_reproduce_linear_functions_within_the_hull(known):
    points = points_among(known)
    points = points[Delaunay(known - FAR).find_simplex(points - FAR) >= 0]
    assert len(points) > 20
    weights = natural_neighbour_weights(known, points)
    np.testing.assert_allclose(weights @ (known - FAR), points - FAR, atol=1e-4)


def test_natural_neighbours_on_a_grid_and_on_its_lines():
    # four points on every circle, and points on sides of triangles
    axis = np.arange(6.0)
    known = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    fine = np.arange(0.0, 5.01, 0.25)
    points = np.stack(np.meshgrid(fine, fine), -1).reshape(-1, 2)
    weights = natural_neighbour_weights(known, points)
    assert weights.data.min() > -1e-12
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    np.testing.assert_allclose(weights @ known, points, atol=1e-9)
    middle = natural_neighbour_weights(known, np.array([[2.5, 2.5]])).toarray()
    np.testing.assert_allclose(middle[middle > 1e-12], 0.25, atol=1e-9)


def test_beyond_the_hull_the_nearest_place_of_it_counts():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    points = np.array([[1.0, -7.0], [9.0, 9.0]])
    np.testing.assert_allclose(
        natural_neighbour_weights(square, points).toarray(),
        [[0.75, 0.25, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        atol=1e-12,
    )


def test_multiquadric_is_that_of_scipy():
    rng = np.random.default_rng(5)
    known, values = rng.uniform(0.0, 1000.0, (25, 2)), rng.normal(size=(25, 2))
    points = rng.uniform(0.0, 1000.0, (50, 2))
    gap = np.sort(np.linalg.norm(known[:, None] - known, axis=2), axis=1)[:, 1].mean()
    expected = RBFInterpolator(
        known, values, kernel="multiquadric", epsilon=1.0 / (HARDY * gap), degree=0
    )(points)
    weights = distribution_weights(known, points, "multiquadric")
    np.testing.assert_allclose(weights @ values, expected, atol=1e-9)


def test_inverse_distance_of_few_points_is_that_of_shepard():
    rng = np.random.default_rng(6)
    known, points = rng.uniform(0.0, 10.0, (9, 2)), rng.uniform(0.0, 10.0, (30, 2))
    square = ((points[:, None] - known) ** 2).sum(axis=2)
    expected = (1.0 / square) / (1.0 / square).sum(axis=1, keepdims=True)
    weights = distribution_weights(known, points, "inverse_distance").toarray()
    np.testing.assert_allclose(weights, expected, rtol=1e-12)


@pytest.mark.parametrize("method", ["natural_neighbour", "inverse_distance"])
def test_nothing_jumps_from_point_to_point(method):
    rng = np.random.default_rng(7)
    known, values = rng.uniform(0.0, 100.0, (80, 2)), rng.normal(size=80)
    line = np.stack([np.linspace(1.0, 99.0, 20_001), np.full(20_001, 47.3)], axis=1)
    found = distribution_weights(known, line, method) @ values
    assert np.abs(np.diff(found)).max() < 0.02


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n_known", [1, 2, 3])
def test_few_known_points_and_known_points_on_a_line(method, n_known):
    known = np.array([[0.0, 0.0], [10.0, 10.0], [20.0, 20.0]])[:n_known]
    points = np.array([[5.0, 5.0], [-3.0, 8.0], [30.0, 30.0]])
    weights = distribution_weights(known, points, method)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    if method == "natural_neighbour" and n_known > 1:
        np.testing.assert_allclose(weights.toarray()[0, :2], 0.5)


@pytest.mark.parametrize("method", METHODS)
def test_known_points_at_one_place_share_their_weight(method):
    known = np.array([[0.0, 0.0], [0.0, 0.0], [6.0, 0.0], [0.0, 6.0]])
    weights = distribution_weights(known, np.array([[0.0, 0.0]]), method)
    np.testing.assert_allclose(weights.toarray(), [[0.5, 0.5, 0.0, 0.0]], atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_no_points_are_no_rows(method):
    known = np.random.default_rng(8).uniform(size=(20, 2))
    assert distribution_weights(known, np.empty((0, 2)), method).shape == (0, 20)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("apart", [1e-6, 0.03, 2.0])
def test_two_control_points_side_by_side_make_no_slope(method, apart):
    """3 cm between them are 3 cm for all points, not metres."""
    rng = np.random.default_rng(9)
    known = FAR + np.stack(np.mgrid[:5, :5], axis=-1).reshape(-1, 2) * 500.0
    known = np.vstack([known, known[12] + [apart, 0.0]])
    values = rng.normal(0.0, 0.01, len(known))
    values[-1] = values[12] + 0.03
    found = distribution_weights(known, points_among(known), method) @ values
    assert np.abs(found).max() < 0.08


@pytest.mark.parametrize("n_pairs", [1, 2, 8])
def test_multiquadric_of_twin_marks_is_that_of_their_middles(n_pairs):
    rng = np.random.default_rng(10)
    middles = rng.uniform(0.0, 3000.0, (n_pairs, 2))
    offset = np.array([0.3, -0.4])
    known = np.concatenate([middles - offset, middles + offset])
    points = rng.uniform(0.0, 3000.0, (50, 2))
    weights = distribution_weights(known, points, "multiquadric").toarray()
    both = weights[:, :n_pairs] + weights[:, n_pairs:]
    expected = distribution_weights(middles, points, "multiquadric").toarray()
    np.testing.assert_allclose(both, expected, atol=1e-9)
