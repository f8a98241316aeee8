"""Points of spatial models on three points near one line, beyond the linear."""

import numpy as np
import pytest

from einschalt.theory.transformation.helmert_3d import fit_helmert_3d
from einschalt.theory.transformation.second_order import (
    FARTHEST,
    second_order_squares,
)
from einschalt.theory.transformation.sensitivity import (
    cofactors_of_rest,
    sensitivity,
)

NEAR_A_LINE = np.array([[-400.0, 0.0, 0.0], [400.0, 0.0, 0.0], [30.0, 1.5, 0.0]])
AWAY = np.array([[50.0, 300.0, 20.0]])
SIGMA = 0.1
N_DRAWS = 2000


def fit_onto(target):
    start = np.arange(0, len(target) + 1, len(NEAR_A_LINE))
    source = np.tile(NEAR_A_LINE, (len(start) - 1, 1))
    return fit_helmert_3d(source, target, np.ones(len(target)), start)


@pytest.fixture(scope="module")
def drawn():
    """Fits onto points with errors, and what they make of a point beside the line."""
    rng = np.random.default_rng(1)
    errors = rng.normal(scale=SIGMA, size=(N_DRAWS, *NEAR_A_LINE.shape))
    return fit_onto((NEAR_A_LINE + errors).reshape(-1, 3))


def test_squares_are_those_of_normal_errors_of_scale_and_rotation():
    rng = np.random.default_rng(2)
    fit = fit_onto(NEAR_A_LINE)
    root = rng.normal(scale=0.02, size=(4, 4))
    found = second_order_squares(
        fit, np.zeros(1, dtype=int), AWAY, (root @ root.T)[None]
    )[0]
    scale, *turn = root @ rng.standard_normal((4, 200_000))
    x = AWAY[0] - fit.centroid_model[0]
    once = np.cross(np.transpose(turn), x)
    second = scale[:, None] * once + np.cross(np.transpose(turn), once) / 2.0
    expected = second.T @ second / len(second)
    np.testing.assert_allclose(found, expected, atol=0.02 * np.trace(expected))


def test_errors_of_turned_models_are_covered(drawn):
    models = np.arange(N_DRAWS)
    points = np.repeat(AWAY, N_DRAWS, axis=0)
    turned = np.einsum("nij,nj->ni", drawn.rotation, points - drawn.centroid_model)
    values = drawn.centroid_ground + drawn.scale[:, None] * turned
    variance = SIGMA**2 * cofactors_of_rest(drawn)
    design = sensitivity(drawn, models, points)
    linear = design @ variance @ design.swapaxes(1, 2)
    linear += SIGMA**2 / len(NEAR_A_LINE) * np.eye(3)
    beyond = second_order_squares(drawn, models, points, variance)
    errors = (values - AWAY)[:, :, None]

    def typical(covariance):
        squares = errors.swapaxes(1, 2) @ np.linalg.solve(covariance, errors)
        return np.quantile(squares, 0.9)

    # 90 % of χ² with three degrees of freedom lie below 6.25; squares have longer tails
    assert typical(linear) > 50.0
    assert typical(linear + beyond) < 8.0


def test_no_rotation_moves_a_point_farther_than_around():
    fit = fit_onto(NEAR_A_LINE)
    squares = second_order_squares(
        fit, np.zeros(1, dtype=int), AWAY, 1e6 * np.eye(4)[None]
    )
    x = AWAY[0] - fit.centroid_model[0]
    assert np.trace(squares[0]) == pytest.approx(FARTHEST**2 * (x @ x))
