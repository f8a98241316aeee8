"""One wrong point of little control: what it does to photographs that go onto it."""

import numpy as np
import pytest
from tests.photographs_onto_control import AXES, one_flight, with_wrong_control

from einschalt.pipeline.assessment.evidence.claim import RESIDUALS
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

pytestmark = pytest.mark.slow

WRONG = np.array([1.05, -1.25, -1.15])


def true_errors(result, block):
    """Of the new points: TOTAL in plan and in height, RMS [m]."""
    new = result.points[result.points["role"] == "new"].set_index("point_id")
    true = block.truth.set_index("point_id").loc[new.index, AXES]
    squares = np.mean((new[AXES] - true).to_numpy() ** 2, axis=0)
    return np.sqrt(squares[:2].sum()), np.sqrt(squares[2])


@pytest.mark.parametrize(("seed", "n_given"), [(1, 6), (2, 6), (3, 10), (5, 10)])
def test_it_is_told_as_the_adjustment_without_it_shows_it(seed, n_given):
    """Two steps of the same block lean on it as much, and moved heights by 20 m."""
    block = with_wrong_control(one_flight(seed, n_given), 3, WRONG)
    result = densify(block, Settings(method="auto"))
    assert result.choice.method == "simultaneous"
    plan, height = true_errors(result, block)
    told, heights = result.assessment.credible, result.assessment.credible_heights
    assert told.is_lower_bound
    assert 0.7 < told.value / plan < 1.6
    assert heights.is_lower_bound
    assert 0.6 < heights.value / height < 1.8
    suspects = {n for f in result.assessment.findings for n in f.names}
    assert block.control_points["point_id"][3] in suspects


def test_a_wrong_height_is_told_as_large_as_it_is():
    """It was "by up to 2.4 cm", which is what it does in plan."""
    block = with_wrong_control(one_flight(2, 8), 4, np.array([0.0, 0.0, 2.0]))
    told = densify(block, Settings(method="auto")).assessment
    (found,) = (f for f in told.findings if f.code == "control_against_block")
    assert found.names == (block.control_points["point_id"][4],)
    assert found.facts["largest"] == pytest.approx(2.0, abs=0.3)
    assert told.credible_heights.is_lower_bound


def test_of_three_points_none_is_singled_out():
    """Any of them may be the wrong one; without it two are left, which tell nothing."""
    block = with_wrong_control(one_flight(1, 3), 0, WRONG)
    for outliers in ("keep", "snoop"):
        settings = Settings(method="simultaneous", outliers=outliers)
        result = densify(block, settings)
        control = result.solution.adjustment.control
        assert not control[["is_suspect", "is_set_aside"]].any(axis=None)
        # how much of the error the two others follow nobody can tell
        told, stated = result.examination.credible, result.figures.mean_total
        assert told.is_lower_bound
        assert told.value > 2.0 * stated


def test_where_it_takes_no_part_it_moves_nothing():
    block = with_wrong_control(one_flight(1, 6), 3, WRONG)
    result = densify(block, Settings(method="simultaneous", outliers="snoop"))
    assert result.solution.adjustment.without_suspects.empty
    plan, height = true_errors(result, block)
    told, heights = result.examination.credible, result.examination.credible_heights
    assert not told.is_lower_bound
    assert 0.5 < told.value / plan < 2.0
    # heights hang on five points
    assert 0.4 < heights.value / height < 2.5


def test_residuals_at_fewer_than_ten_points_are_tested_as_well():
    """Two steps passed with 6 cm where one wrong point of six made 58."""
    block = one_flight(1, 6)
    two_step = Settings(method="two_step")
    sound = densify(block, two_step, compares_methods=False).examination.claim
    assert sound.is_supported
    assert sound.of(RESIDUALS).n_points < 10
    wrong = with_wrong_control(block, 5, WRONG)
    result = densify(wrong, two_step, compares_methods=False)
    told = result.examination.credible
    assert [test.name for test in result.examination.claim.rejected] == [RESIDUALS]
    assert told.is_lower_bound
    assert 0.5 < told.value / true_errors(result, block)[0] < 3.0
