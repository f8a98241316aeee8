"""What an adjustment knows of the heights of its control, against known answers."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.theory.adjustment.pattern_tests import examine_scores
from einschalt.theory.block_adjustment.control_heights import height_scores

HEIGHT = 2
STEP = 0.04


@pytest.fixture(scope="module")
def block():
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
    return simulate_block("demo", seed=3, geometry=geometry)


@pytest.fixture(scope="module")
def solution(block):
    return es.adjust_block(block, kind="helmert_3d").solution


@pytest.fixture(scope="module")
def known(solution):
    return height_scores(solution, 1.0)


def test_information_is_that_of_the_cofactors(solution, known):
    control = np.flatnonzero(solution.observations.is_control)
    weight = solution.observations.control_weight[control, HEIGHT, HEIGHT]
    cofactor = solution.point_cofactors[control, HEIGHT, HEIGHT]
    expected = weight - weight**2 * cofactor
    np.testing.assert_allclose(np.diag(known.information), expected, rtol=1e-6)


def test_a_shift_of_everything_is_not_known(known):
    everything = np.ones(len(known.scores))
    of_shift = everything @ known.information @ everything
    assert of_shift < 1e-6 * np.trace(known.information)


def test_scores_and_points_follow_a_step(solution, known):
    """As in an adjustment with other heights, but for what is not linear."""
    given = solution.observations
    control = np.flatnonzero(given.is_control)
    step = STEP * (np.arange(len(control)) % 2)
    heights = given.control.copy()
    heights[control, HEIGHT] += step
    moved = solution.readjusted(replace(given, control=heights))
    again = height_scores(moved, 1.0)
    expected = known.information @ step
    size = np.abs(expected).max()
    np.testing.assert_allclose(again.scores - known.scores, expected, atol=1e-3 * size)
    change = moved.points[:, HEIGHT] - solution.points[:, HEIGHT]
    np.testing.assert_allclose(known.follows @ step, change, atol=1e-3 * STEP)


def test_a_drawn_covariance_says_what_independent_errors_say(solution, known):
    """That of the scores themselves, as if it were from very many draws."""
    drawn = height_scores(solution, 1.0, known.information, 10**9)
    np.testing.assert_allclose(drawn.information, known.information, atol=1e-3)
    np.testing.assert_allclose(drawn.scores, known.scores, atol=1e-3)


def test_larger_errors_make_the_same_amplitude_less_significant(solution, known):
    larger = height_scores(solution, 2.0)
    pattern = (np.arange(len(known.scores)) % 2)[None]
    found = [
        examine_scores(each.scores[:, None], each.information, pattern)
        for each in (known, larger)
    ]
    assert found[1].amplitudes == pytest.approx(found[0].amplitudes)
    assert found[1].squares == pytest.approx(found[0].squares / 4.0)
