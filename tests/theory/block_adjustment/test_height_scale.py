"""Heights of spatial models that are out of scale, as all points show it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from tests.theory.block_adjustment.test_shared_bend import (
    a_bent_block,
    all_terms,
    with_flights,
)
from tests.theory.block_adjustment.test_spatial_solution import a_block

from einschalt.theory.block_adjustment import height_scale
from einschalt.theory.block_adjustment.height_scale import examine_scales
from einschalt.theory.block_adjustment.shared_bend import (
    AnswerToBends,
    MadeByErrors,
    border_of,
    examine_bends,
    untested,
)
from einschalt.theory.block_adjustment.spatial_solution import adjust_spatially


def with_heights(observations, times):
    xyz = observations.xyz.copy()
    xyz[:, 2] *= times
    return replace(observations, xyz=xyz)


def given_to_tests(observations):
    solution, terms = adjust_spatially(observations), all_terms(observations)
    answer = AnswerToBends.of(solution, terms)
    return solution, terms, answer, MadeByErrors(answer.normals, 1.0)


def examined(observations):
    given = given_to_tests(observations)
    return examine_scales(*given, given[0])


@pytest.mark.parametrize("ratio", [0.01, -0.02])
def test_the_ratio_is_that_of_the_heights_and_moves_points_as_told(ratio):
    ratios = []
    for seed in range(6):
        straight, _ = a_block(seed=seed)
        stretched = with_heights(straight, 1.0 + ratio)
        (scale,) = examined(stretched)
        ratios.append(scale.ratio)
        before, after = map(adjust_spatially, (straight, stretched))
        moved = (after.points - before.points)[~straight.is_control, 2]
        of_that = np.sqrt(np.mean(moved**2)) * abs(scale.ratio / ratio)
        assert scale.moved == pytest.approx(of_that, rel=0.05)
        assert scale.p_value < height_scale.SIGNIFICANCE
        assert scale.is_told_apart
    assert np.mean(ratios) == pytest.approx(ratio, abs=0.002)


def test_p_values_of_heights_in_scale_are_uniform():
    p_values = []
    for seed in range(60):
        solution, terms, answer, made = given_to_tests(
            with_flights(a_block(seed=seed)[0])
        )
        border = border_of(solution, answer, made, np.ones(len(terms.flight), bool))
        places = np.flatnonzero(terms.is_scale)
        every = np.arange(len(border.used))
        p_values += [border.p_value(every == place) for place in places]
    assert stats.kstest(p_values, "uniform").pvalue > 0.01


def test_control_heights_that_are_worse_than_stated_are_no_scale():
    for seed in range(12):
        observations, _ = a_block(seed=seed)
        worse = observations.control.copy()
        n_given = np.count_nonzero(observations.is_control)
        rng = np.random.default_rng(seed)
        worse[observations.is_control, 2] += rng.normal(0.0, 0.3, n_given)
        found = examined(replace(observations, control=worse))
        assert not any(scale.is_told_apart for scale in found)


def test_another_scale_looks_like_a_bend():
    """In a valley, and a bend would hide a part of it."""
    for seed in (1, 2, 3):
        straight = a_block(seed=seed, valley=200.0, relief=0.0)[0]
        given = given_to_tests(with_heights(straight, 1.01))
        (bend,), _ = examine_bends(*given, 0.001)
        assert bend.p_value < 0.001
        (scale,) = examine_scales(*given, given[0])
        assert scale.p_value < bend.p_value
        (not_believed,) = untested(given[1])
        assert np.isnan(not_believed.p_value)
        assert not_believed.n_terms == bend.n_terms


def test_a_bend_is_not_taken_for_another_scale():
    for seed in range(4):
        assert not examined(a_bent_block(seed, valley=60.0)[0])


def test_the_flight_whose_heights_are_out_of_scale_is_found():
    observations = with_flights(a_block(seed=3)[0])
    is_second = observations.flight[observations.model] == 1
    xyz = observations.xyz.copy()
    xyz[is_second, 2] *= 1.03
    (scale,) = examined(replace(observations, xyz=xyz))
    assert scale.flight == 1
    assert scale.ratio == pytest.approx(0.03, abs=0.005)


@pytest.mark.parametrize("relief", [0.0, 1.0])
def test_flat_ground_shows_no_scale(relief):
    """Heights of models are errors there."""
    for seed in range(6):
        observations, _ = a_block(seed=seed, relief=relief)
        assert not examined(observations)
        level, _ = a_block(seed=seed, relief=relief, tilt=0.0)
        assert not examined(with_heights(level, 1.5))


def test_flights_that_are_out_of_scale_together_move_points_together():
    """Each alone moves them against the other one."""
    straight = with_flights(a_block(seed=3)[0])
    stretched = with_heights(straight, 1.02)
    scales = examined(stretched)
    assert sorted(scale.flight for scale in scales) == [0, 1]
    before, after = map(adjust_spatially, (straight, stretched))
    moved = (after.points - before.points)[~straight.is_control, 2]
    expected = np.sqrt(np.mean(moved**2))
    for scale in scales:
        assert scale.ratio == pytest.approx(0.02, abs=0.006)
        assert scale.moved == pytest.approx(expected, rel=0.3)
