"""A grid of shifts against scipy's interpolation, and its way back."""

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from einschalt.theory.residual_distribution.shift_grid import ShiftGrid, grid_layout

MATRIX = np.array([[0.9, -0.2], [0.2, 0.9]])
SHIFT = np.array([5e5, 5.2e6])


@pytest.fixture(scope="module")
def grid():
    rng = np.random.default_rng(7)
    values = rng.normal(size=(9, 12, 2)).astype(np.float32)
    sizes = rng.uniform(0.01, 0.02, (9, 12))
    shape = np.array([[1.0, 0.3], [0.3, 2.0]])
    corner = SHIFT + np.array([-50.0, 850.0])
    return ShiftGrid(MATRIX, SHIFT, corner, 100.0, values, sizes, shape)


@pytest.fixture(scope="module")
def inside(grid):
    west, south, east, north = grid.bounds
    low, high = np.array([west, south]) + 5.0, np.array([east, north]) - 5.0
    base = np.random.default_rng(8).uniform(low, high, (500, 2))
    return np.linalg.solve(MATRIX, (base - SHIFT).T).T, base


def test_shifts_and_variances_are_interpolated_as_scipy_does(grid, inside):
    xy, base = inside
    west, south, east, north = grid.bounds
    axes = np.linspace(south, north, 9), np.linspace(west, east, 12)
    shifts = RegularGridInterpolator(axes, grid.shifts[::-1].astype(float))
    np.testing.assert_allclose(grid.apply(xy), base + shifts(base[:, ::-1]), atol=1e-8)
    sizes = RegularGridInterpolator(axes, grid.variances[::-1])(base[:, ::-1])
    expected = sizes[:, None, None] * grid.shape
    np.testing.assert_allclose(grid.covariances(xy), expected, atol=1e-12)


def test_every_point_comes_back_and_outside_there_is_nothing(grid, inside):
    xy, _ = inside
    np.testing.assert_allclose(grid.invert(grid.apply(xy)), xy, atol=1e-6)
    far = np.array([[-1e4, 0.0], [np.nan, 0.0]])
    assert np.isnan(grid.apply(far)).all()
    assert np.isnan(grid.invert(far)).all()


def test_nodes_at_the_edges_belong_to_the_grid(grid):
    xy = np.linalg.solve(MATRIX, (grid.nodes - SHIFT).T).T
    found = grid.between(grid.shifts, grid.nodes)
    np.testing.assert_allclose(found, grid.shifts.reshape(-1, 2), atol=1e-12)
    assert len(xy) == 108


def test_a_cell_that_is_strained_too_much_is_named(grid):
    shifts = grid.shifts * 0.0
    shifts[4, 5, 0] = 30.0
    strained = ShiftGrid(**{**vars(grid), "shifts": shifts}).strained_cells()
    around = [[-50.0, 50.0], [50.0, 50.0], [-50.0, -50.0], [50.0, -50.0]]
    expected = grid.corner + np.array([500.0, -400.0]) + np.array(around)
    np.testing.assert_allclose(strained, expected)
    assert not len(grid.strained_cells())


def test_a_grid_holds_its_points_with_cells_around_them():
    points = np.array([[103.0, 207.0], [395.0, 299.9]])
    corner, shape = grid_layout(points, 50.0)
    np.testing.assert_allclose(corner, [-50.0, 450.0])
    assert shape == (9, 13)
