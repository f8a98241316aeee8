"""Differences at known points share what the propagation says that they share."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.assessment.evidence import known_differences
from einschalt.pipeline.assessment.evidence.control.signatures import PLAN
from einschalt.pipeline.assessment.evidence.known_differences import (
    Densified,
    covariance_of_differences,
    shared_differences,
)
from einschalt.pipeline.assessment.findings import known_points as judges
from einschalt.stages.error_propagation.given_points import errors_of_control
from einschalt.theory.adjustment.point_operator import Axes

# seven high-flight models, on which 20 control points and 8 check points hang
GEOMETRY = es.BlockGeometry(
    width=6e3,
    height=5e3,
    high_scale_number=25_000,
    low_scale_number=8_000,
    point_spacing=400,
    n_check=8,
)
NOISE = es.BlockNoise(high_m_g_um=10, low_m_g_um=10, control_standard_error=0.02)
N_BLOCKS = 40


@pytest.fixture(scope="module")
def results():
    settings = es.Settings(method="two_step")
    return [
        es.densify(
            es.simulate_block("demo", seed=seed, geometry=GEOMETRY, noise=NOISE),
            settings,
        )
        for seed in range(N_BLOCKS)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("role", ["known_check", "known_control"])
def test_sizes_of_differences_vary_as_their_degrees_of_freedom_say(results, role):
    known = [getattr(result.examination, role) for result in results]
    squares = np.array([one.ratio**2 for one in known])
    degrees = np.mean([one.degrees for one in known])
    assert degrees < 0.9 * 2 * known[0].count
    expected = np.sqrt(2.0 / degrees)
    # a standard deviation of 40 blocks is known to 11 %, the mean to that of one
    assert squares.std(ddof=1) == pytest.approx(expected, rel=0.35)
    assert squares.mean() == pytest.approx(1.0, abs=3.5 * expected / N_BLOCKS**0.5)


@pytest.mark.parametrize("role", ["known_check", "known_control"])
def test_mean_differences_are_as_large_as_what_is_shared_makes_them(results, role):
    known = [getattr(result.examination, role) for result in results]
    means = np.array([one.differences.mean(axis=0) for one in known])
    expected = np.mean([np.trace(one.covariance_of_mean) for one in known])
    assert np.mean(np.sum(means**2, axis=1)) == pytest.approx(expected, rel=0.6)
    alone = np.mean([one.claimed**2 / one.count for one in known])
    if role == "known_check":  # independent ones would have a far smaller mean
        assert expected > 1.5 * alone
    p_values = [one.shift_p_value for one in known]
    assert np.mean(np.array(p_values) < 0.05) <= 0.1


@pytest.mark.slow
def test_clean_blocks_are_told_to_be_clean(results):
    wrong = [
        judge.__name__
        for result in results
        for judge in judges.TWO_STEP
        if judge(result.examination) is not None
    ]
    # of 200 judgements on a level of 0.001
    assert len(wrong) <= 1


def test_a_shift_of_the_control_is_found(results):
    examined = results[0].examination
    known = examined.known_control
    assert known.shift_p_value > 0.001
    moved = np.add(known.differences, [0.6, 0.0])
    shifted = type(known)(**{**vars(known), "differences": moved})
    assert shifted.shift_p_value < 0.001


def test_of_many_points_some_tell_of_all(results, monkeypatch):
    examined = results[0].examination
    names = examined.points["point_id"].to_numpy(dtype=object)
    given = examined.block.control_points["point_id"]
    names = names[np.isin(names, given)]
    whole = shared_differences(examined, names)
    monkeypatch.setattr(known_differences, "MOST_POINTS", len(names) // 2)
    half = shared_differences(examined, names)
    assert half.degrees == pytest.approx(whole.degrees, rel=0.25)
    trace = np.trace(whole.covariance_of_mean)
    assert np.trace(half.covariance_of_mean) == pytest.approx(trace, rel=0.4)


def test_one_adjustment_takes_what_two_steps_share(results):
    settings = es.Settings(method="simultaneous")
    block = es.simulate_block("demo", seed=0, geometry=GEOMETRY, noise=NOISE)
    examined = es.densify(block, settings).examination
    known = examined.known_check
    assert known.degrees == pytest.approx(results[0].examination.known_check.degrees)


def test_points_of_another_solution_share_nothing_that_is_known(results):
    examined = results[0].examination
    names = examined.known_check.point_ids.copy()
    names[0] = "somewhere else"
    assert shared_differences(examined, names) is None


def test_single_points_share_nothing(results):
    examined = results[0].examination
    assert shared_differences(examined, examined.known_check.point_ids[:1]) is None


def test_unknown_shifts_of_groups_are_told_by_errors_formed_once(monkeypatch):
    """For heights they were formed once more, to ask for the shifts of groups."""
    block = es.simulate_block("demo", seed=4)
    control = block.control_points.assign(group="A")
    formed = []

    def counted(*given):
        formed.append(given)
        return errors_of_control(*given)

    monkeypatch.setattr(known_differences, "errors_of_control", counted)
    ids = control["point_id"].to_numpy(dtype=object)[:3]
    nothing = Densified({}, {}, np.nan, is_group_error_known=False)
    grouped = replace(block, control_points=control)
    what = (ids, Axes.COMPLEX, PLAN, nothing)
    # shifts of groups whose size nobody has stated: nothing is guessed
    assert covariance_of_differences(grouped, *what) is None
    assert covariance_of_differences(block, *what) is not None
    assert len(formed) == 2
