"""What an adjustment knows of the places of its control, against known answers."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.theory.block_adjustment.control_in_plan import IN_PLAN, plan_scores
from einschalt.theory.block_adjustment.control_scores import scores_of_control

STEP = np.array([0.04, -0.03])


@pytest.fixture(scope="module", params=["affine", "helmert", "helmert_3d"])
def solution(request):
    geometry = replace(PRESETS["demo"].geometry, transformation=request.param)
    block = simulate_block("demo", seed=3, geometry=geometry)
    return es.adjust_block(block, kind=request.param).solution


@pytest.fixture(scope="module")
def known(solution):
    return plan_scores(solution, 1.0)


def control_of(solution):
    return np.flatnonzero(solution.observations.is_control)


def shown_of(known, errors):
    """Numbers that errors of control (n_control, 2) make."""
    return np.einsum("nca,ca->n", known.shown, errors)


def test_information_is_that_of_the_cofactors(solution, known):
    control = control_of(solution)
    for axis in (0, 1):
        weight = solution.observations.control_weight[control, axis, axis]
        cofactor = solution.point_cofactors[control, axis, axis]
        found = np.sum(known.shown[:, :, axis] ** 2, axis=0)
        expected = weight - weight**2 * cofactor
        np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_a_shift_and_a_turn_of_everything_are_not_known(solution, known):
    xy = solution.points[control_of(solution), :2]
    xy = xy - xy.mean(axis=0)
    for everything in (np.ones_like(xy), xy[:, ::-1] * [-1.0, 1.0] / np.abs(xy).max()):
        left = np.sum(shown_of(known, everything) ** 2)
        assert left < 1e-4 * np.sum(known.shown**2)


def test_numbers_and_points_follow_a_step(solution, known):
    """As in an adjustment with other places, but for what is not linear."""
    given, control = solution.observations, control_of(solution)
    step = np.outer(np.arange(len(control)) % 2, STEP)
    places = given.control.copy()
    places[control, :2] += step
    moved = solution.readjusted(replace(given, control=places))
    expected = np.sum(shown_of(known, step) ** 2)
    before, found = (
        scores_of_control(each, each.control_residuals[:, :, None], IN_PLAN)
        for each in (solution, moved)
    )
    difference = (found - before).reshape(2, -1).T
    assert np.sum(difference * step) == pytest.approx(expected, rel=1e-3)
    change = (moved.points - solution.points)[:, :2]
    follows = np.einsum("nbca,ca->nb", known.follows, step)
    np.testing.assert_allclose(follows, change, atol=1e-3 * np.abs(STEP).max())


def test_a_drawn_covariance_says_what_independent_errors_say(solution, known):
    """That of the scores themselves, as if it were from very many draws."""
    control = control_of(solution)
    n = 2 * len(control)
    shown = np.moveaxis(known.shown, 2, 1).reshape(-1, n)
    drawn = plan_scores(solution, 1.0, shown.T @ shown, 10**9)
    step = np.outer(np.arange(len(control)) % 2, STEP)
    for each in (drawn, plan_scores(solution, 0.5)):
        square = np.sum(shown_of(each, step) ** 2)
        assert square == pytest.approx(np.sum(shown_of(known, step) ** 2), rel=1e-4)
    larger = plan_scores(solution, 2.0)
    square = np.sum(shown_of(known, step) ** 2)
    assert np.sum(shown_of(larger, step) ** 2) == pytest.approx(square / 4.0)


def test_good_control_has_numbers_of_variance_one(known):
    n = len(known.observed)
    square = np.sum(known.observed**2)
    assert abs(square - n) < 4.0 * np.sqrt(2.0 * n)
