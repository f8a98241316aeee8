import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from einschalt.theory.transformation.affine import affine_cofactors, fit_affine
from einschalt.theory.transformation.helmert import fit_helmert
from einschalt.theory.transformation.plane_fit import UNDETERMINED, USABLE

ONE = np.zeros(1, dtype=int)


def design(xy):
    """Rows of a0, a1, a2 for the easting; the northing has the same."""
    return np.column_stack([np.ones(len(xy)), xy])


def test_parameters_are_those_of_the_formula():
    xy = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0], [70.0, 30.0]])
    east = 7.0 + 2.0 * xy[:, 0] - 0.5 * xy[:, 1]
    north = -3.0 + 0.25 * xy[:, 0] + 1.5 * xy[:, 1]
    fit = fit_affine(xy, np.column_stack([east, north]), np.ones(4), np.array([0, 4]))
    assert fit.parameter_names == ("a0", "a1", "a2", "b0", "b1", "b2")
    np.testing.assert_allclose(
        fit.parameters[0], [7.0, 2.0, -0.5, -3.0, 0.25, 1.5], atol=1e-12
    )


def test_against_the_dense_solution(solver_named, make_models):
    models = make_models(solver_named("affine"), [20], seed=20)
    centred = models.target - models.target.mean(axis=0)
    fit = fit_affine(models.source, centred, models.weights, models.start)
    a, root = design(models.source), np.sqrt(models.weights)[:, None]
    wanted, *_ = np.linalg.lstsq(a * root, centred * root)
    np.testing.assert_allclose(fit.parameters[0], wanted.T.ravel(), rtol=1e-10)
    inverse = np.linalg.inv(a.T @ (models.weights[:, None] * a))
    np.testing.assert_allclose(affine_cofactors(fit)[0, :3, :3], inverse, rtol=1e-9)
    hat = np.einsum("ni,ij,nj->n", a, inverse, a) * models.weights
    np.testing.assert_allclose(fit.leverage, np.column_stack([hat, hat]), rtol=1e-9)


def test_easting_and_northing_are_uncorrelated(solver_named, make_models):
    fit = fit_affine(*make_models(solver_named("affine"), [9], seed=21))
    assert not affine_cofactors(fit)[0, :3, 3:].any()
    cofactors = fit.point_cofactors(ONE, np.array([[500.0, -300.0]]))[0]
    assert cofactors[0, 1] == 0.0
    assert cofactors[0, 0] == cofactors[1, 1]


def test_leverage_of_an_evenly_filled_rectangle(filled_rectangle):
    points, special = filled_rectangle
    n = len(points)
    fit = fit_affine(points, points, np.ones(n), np.array([0, n]))
    cofactors = fit.point_cofactors(np.zeros(4, dtype=int), special)
    # 1 in the centre, 4 in the middle of an edge, 7 in the corner, whatever the aspect
    np.testing.assert_allclose(n * cofactors[:, 0, 0], [1, 4, 4, 7], rtol=0.02)
    assert np.mean(n * fit.leverage[:, 0]) == pytest.approx(3.0, rel=1e-9)


@pytest.mark.parametrize("corner", [(2, 2), (5, 4), (11, 7)])
def test_leverage_in_the_corner_of_a_lattice(corner):
    k, m = corner
    x, y = np.meshgrid(np.arange(k), np.arange(m))
    lattice = np.column_stack([x.ravel(), y.ravel()]).astype(float)
    fit = fit_affine(lattice, lattice, np.ones(k * m), np.array([0, k * m]))
    wanted = 1 + 3 * (k - 1) / (k + 1) + 3 * (m - 1) / (m + 1)
    np.testing.assert_allclose(k * m * fit.leverage[0, 0], wanted, rtol=1e-12)


def test_corner_of_five_points_is_hardly_checked():
    # a square with its centre: blunders in the corners stay hidden
    xy = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1], [0, 0]])
    fit = fit_affine(xy, xy, np.ones(5), np.array([0, 5]))
    np.testing.assert_allclose(1 - fit.leverage[:4, 0], 0.3, rtol=1e-12)
    np.testing.assert_allclose(1 - fit.leverage[4, 0], 0.8, rtol=1e-12)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1))
def test_any_linear_map_of_the_model_is_irrelevant(solver_named, make_models, seed):
    models = make_models(solver_named("affine"), [10], seed=seed)
    rng = np.random.default_rng(seed)
    u, _, v = np.linalg.svd(rng.normal(size=(2, 2)))
    sheared = models.source @ (u @ np.diag(rng.uniform(0.2, 5.0, 2)) @ v).T
    fit = fit_affine(*models)
    other = fit_affine(sheared, models.target, models.weights, models.start)
    np.testing.assert_allclose(other.residuals, fit.residuals, rtol=0, atol=1e-8)
    np.testing.assert_allclose(other.leverage, fit.leverage, rtol=1e-8)


def test_helmert_is_affine_on_conformal_data(solver_named, make_models):
    models = make_models(solver_named("helmert"), [12], seed=22, noise=0.0)
    affine, helmert = fit_affine(*models), fit_helmert(*models)
    a0, a1, a2, b0, b1, b2 = affine.parameters[0]
    a, b, te, tn = helmert.parameters[0]
    np.testing.assert_allclose([a1, -a2, b2, b1], [a, b, a, b], rtol=0, atol=1e-10)
    np.testing.assert_allclose([a0, b0], [te, tn], rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("width", "status"), [(1e-2, USABLE), (1e-4, USABLE), (1e-7, UNDETERMINED)]
)
def test_strip_of_points(width, status):
    # a strip is refused below 10⁻⁵ of its length, where rounding would decide
    along = np.linspace(-1.0, 1.0, 21)
    across = width * np.where(np.arange(21) % 2, 1.0, -1.0)
    c, s = 0.6, 0.8
    strip = np.column_stack([c * along - s * across, s * along + c * across])
    strip = 1000.0 * strip + 5e3
    fit = fit_affine(strip, strip, np.ones(21), np.array([0, 21]))
    assert fit.status[0] == status
    if status == USABLE:
        np.testing.assert_allclose(fit.parameters[0, [1, 2]], [1, 0], atol=1e-5)
