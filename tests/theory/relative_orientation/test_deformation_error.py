"""What bends a model: against brute force, and against repeated measurements."""

import numpy as np
import pandas as pd
import pytest

from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.theory.relative_orientation.deformation_error import (
    correction_derivatives,
    deformation_variance,
)
from einschalt.theory.relative_orientation.model_correction import correct_model
from einschalt.theory.relative_orientation.parallax_equations import CASES

SIGMA = 5e-3
N_RUNS, N_POINTS = 1500, 12


def test_equals_brute_force():
    rng = np.random.default_rng(1)
    start = np.array([0, 9, 9, 14, 30])
    xy = rng.uniform([4_900.0, 200.0], [5_100.0, 400.0], (30, 2))
    derivatives = rng.normal(size=(30, 2, 6))
    roots = rng.normal(size=(4, 6, 6))
    cofactor = roots @ roots.transpose(0, 2, 1)
    found = deformation_variance(derivatives, cofactor, xy, start)
    assert np.isnan(found[1])
    for k in (0, 2, 3):
        rows = slice(start[k], start[k + 1])
        columns = np.column_stack([np.ones(start[k + 1] - start[k]), xy[rows]])
        rest = np.eye(len(columns)) - columns @ np.linalg.pinv(columns)
        bent = np.einsum("ij,jap->iap", rest, derivatives[rows])
        whole = bent.reshape(-1, 6) @ cofactor[k] @ bent.reshape(-1, 6).T
        assert found[k] == pytest.approx(np.trace(whole) / len(columns), rel=1e-9)


@pytest.mark.parametrize("n_points", [2, 5])
def test_points_on_a_line_have_no_figure(n_points):
    xy = np.outer(np.arange(n_points), [1.0, 2.0])
    derivatives = np.ones((n_points, 2, 5))
    start = np.array([0, n_points])
    assert np.isnan(deformation_variance(derivatives, np.eye(5)[None], xy, start)[0])
    none = deformation_variance(np.empty((0, 2, 5)), np.empty((0, 5, 5)), xy[:0], [0])
    assert none.shape == (0,)


@pytest.mark.parametrize("case", CASES)
def test_derivatives_of_the_correction(case):
    rng = np.random.default_rng(2)
    xyz = np.column_stack([rng.uniform(-90.0, 90.0, (20, 2)), np.full(20, -150.0)])
    base, elements = np.full(20, 92.0), rng.normal(scale=1e-3, size=(20, 5))
    derivatives = correction_derivatives(xyz, base, elements, case)
    change = rng.normal(scale=1e-6, size=5)
    moved = correct_model(xyz, base, elements + change, case)
    expected = moved - correct_model(xyz, base, elements, case)
    # of second order in the change
    np.testing.assert_allclose(derivatives @ change, expected, atol=1e-8)


def test_repeated_measurements_scatter_as_was_said(make_pairs):
    """Errors of model points after an affine fit: rays and orientation together."""
    geometry = make_pairs.geometry(
        n_points=(N_POINTS, N_POINTS), tilt_deg=2.0, relief=0.2
    )
    made = make_pairs(1, 5, geometry, noise=0.0)
    rng = np.random.default_rng(3)
    noise = rng.normal(scale=SIGMA, size=(N_RUNS, N_POINTS, 4))
    measured = (made.image + noise).reshape(-1, 4)
    pairs = table_of(measured, N_RUNS)
    oriented = orient_from_images(pairs, 153.0, case="independent")
    exact = orient_from_images(table_of(made.image, 1), 153.0, case="independent")
    assert oriented.failures.empty
    true = exact.model_points[["x", "y"]].to_numpy()
    found = oriented.model_points[["x", "y"]].to_numpy().reshape(N_RUNS, N_POINTS, 2)
    columns = np.column_stack([np.ones(N_POINTS), true])
    rest = np.eye(N_POINTS) - columns @ np.linalg.pinv(columns)
    errors = np.einsum("ij,rja->ria", rest, found - true)
    to_um = 1e3 * 153.0 / np.abs(exact.model_points["z"]).mean()
    scatter = np.sqrt((errors**2).sum(axis=2).mean()) * to_um
    said = oriented.measuring_error**2
    # an affine fit takes up its part of what each point has by itself, too
    own = said["m_g_intersection_um"] * np.trace(rest) / N_POINTS
    claimed = np.sqrt((own + said["m_g_orientation_um"]).mean())
    assert claimed == pytest.approx(scatter, rel=0.03)
    assert said["m_g_orientation_um"].mean() > 0.02 * own.mean()


def table_of(image, n_pairs):
    names = ["x_left", "y_left", "x_right", "y_right"]
    table = pd.DataFrame(image, columns=names)
    models = np.repeat([f"m{k:05d}" for k in range(n_pairs)], N_POINTS)
    points = np.tile([f"p{k}" for k in range(N_POINTS)], n_pairs)
    return table.assign(model_id=models, point_id=points)
