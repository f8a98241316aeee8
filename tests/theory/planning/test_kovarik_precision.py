"""Kovarik's planning formulas: scale laws, turning points, balances."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from einschalt.theory.planning.kovarik_precision import (
    EDGES,
    PlannedModel,
    best_scale,
    mean_of_coverages,
    planned_precision,
    settings_that_balance,
    spacing_that_balances,
)

KINDS = ("affine", "helmert", "rigid")


@pytest.mark.parametrize("edge", EDGES)
@pytest.mark.parametrize("kind", KINDS)
def test_transformation_error_depends_on_spacing_over_scale_only(kind, edge):
    # why the printed 16 cm contradicts the printed 9
    model = PlannedModel(kind, edge)
    large = planned_precision(6000.0, 200.0, 0.2, 1e-5, model)
    small = planned_precision(12000.0, 400.0, 0.2, 1e-5, model)
    assert large.m_t_edge == pytest.approx(small.m_t_edge, rel=1e-12)
    assert large.m_t_centre == pytest.approx(small.m_t_centre, rel=1e-12)


@pytest.mark.parametrize("edge", EDGES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("image_format", [(0.23, 0.23), (0.068, 0.1058)])
def test_best_scale_is_the_minimum(kind, edge, image_format):
    model = PlannedModel(kind, edge, image_format)
    found = float(best_scale(300.0, 0.1, 1e-5, model))

    def edge_error(log_scale):
        planned = planned_precision(np.exp(log_scale), 300.0, 0.1, 1e-5, model)
        return min(float(planned.M_edge), 1e3)  # a lattice may determine nothing

    searched = minimize_scalar(
        edge_error, bounds=np.log([found / 1.2, found * 1.2]), method="bounded"
    )
    assert edge_error(np.log(found)) <= searched.fun * (1 + 1e-9)
    everywhere = [edge_error(np.log(value)) for value in np.geomspace(2e3, 2e5, 2000)]
    assert edge_error(np.log(found)) <= min(everywhere) * (1 + 1e-9)


def test_parts_are_equal_at_the_best_scale():
    model = PlannedModel()
    scale = best_scale([200.0, 300.0, 400.0], 0.1, 1e-5, model)
    planned = planned_precision(
        scale, np.array([200.0, 300.0, 400.0]), 0.1, 1e-5, model
    )
    np.testing.assert_allclose(planned.m_t_edge, planned.m_g_ground, rtol=1e-12)
    np.testing.assert_allclose(planned.M_edge, np.sqrt(2) * planned.m_g_ground)


def test_best_scale_of_the_lattice_takes_any_shape():
    model = PlannedModel(edge="lattice")
    m_0 = np.array([[0.1], [0.2]])
    many = best_scale([200.0, 300.0], m_0, 1e-5, model)
    assert many.shape == (2, 2)
    one = best_scale(300.0, 0.2, 1e-5, model)
    assert many[1, 1] == pytest.approx(float(one), rel=1e-12)


def test_settings_balance_where_the_parts_are_equal():
    planned = planned_precision(8000.0, 300.0, 0.1, 1e-5, PlannedModel())
    k = settings_that_balance(planned.m_g_ground, planned.m_t_edge)
    assert planned.m_g_ground / np.sqrt(k) == pytest.approx(planned.m_t_edge)


def test_mean_of_coverages_divides_variances():
    assert mean_of_coverages(0.03, 0.04, 2) == pytest.approx(0.025)
    assert mean_of_coverages(0.03, 0.03, 4) == pytest.approx(0.015)


def test_at_break_even_both_parts_are_equal():
    planned = planned_precision(8000.0, 300.0, 0.1, 10e-6, PlannedModel())
    ground, m_t = planned.m_g_ground, planned.m_t_edge
    settings = settings_that_balance(ground, m_t)
    again = planned_precision(
        8000.0, 300.0, 0.1, 10e-6 / np.sqrt(settings), PlannedModel()
    )
    assert again.m_g_ground == pytest.approx(again.m_t_edge)
    spacing = spacing_that_balances(300.0, ground, m_t)
    again = planned_precision(8000.0, spacing, 0.1, 10e-6, PlannedModel())
    assert again.m_t_edge == pytest.approx(again.m_g_ground)
