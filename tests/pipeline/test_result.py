"""Results keep what was computed for them, and how long it took."""

import warnings

import numpy as np
import pandas as pd
import pytest
from tests.changed_results import changed

import einschalt as es
from einschalt.pipeline.assessment import examination
from einschalt.pipeline.densify import densify
from einschalt.pipeline.result import DensificationResult, Stopwatch
from einschalt.pipeline.settings import Settings

OF_TWO_STEPS = (
    *("high", "low", "means", "model_points"),
    *("propagation", "iteration", "screening"),
)


@pytest.fixture(scope="module")
def simultaneous_result(demo_block):
    return densify(demo_block, Settings(method="simultaneous"))


@pytest.mark.parametrize("name", OF_TWO_STEPS)
def test_former_names_warn_and_give_the_same(good_result, name):
    with pytest.warns(DeprecationWarning, match=rf"result\.solution\.{name}$") as said:
        found = getattr(good_result, name)
    assert said[0].filename == __file__
    assert found is getattr(good_result.solution, name)


@pytest.mark.parametrize("name", OF_TWO_STEPS)
def test_former_names_of_an_adjustment_are_those_of_its_two_steps(
    simultaneous_result, name
):
    steps = simultaneous_result.solution.two_step
    where = rf"result\.solution\.two_step\.{name}$"
    with pytest.warns(DeprecationWarning, match=where):
        found = getattr(simultaneous_result, name)
    assert found is getattr(steps, name)


def test_other_names_are_refused_without_a_warning(good_result):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(AttributeError, match="has no attribute 'heigh'"):
            _ = good_result.heigh
        assert not hasattr(good_result, "lows")


@pytest.mark.slow
@pytest.mark.parametrize("compute", [densify, es.densify])
def test_what_was_computed_survives_a_tolerance_and_the_interface(monkeypatch, compute):
    claims = []
    examine_claim = examination.examine_claim

    def counted(examined):
        claims.append(examined)
        return examine_claim(examined)

    monkeypatch.setattr(examination, "examine_claim", counted)
    result = compute(es.simulate_block("demo", seed=1), Settings(tolerance=0.05))
    assert claims == []
    assert "is_within_tolerance" in result.points
    # the tolerance asked for the claim, and everybody after it has the same
    claim = result.claim
    assert result.assessment.claim is claim is result.examination.claim
    assert np.shares_memory(result.points["easting"], result.points["easting"])
    assert result.assessment is result.assessment
    assert "Is the stated precision supported?" in result.summary()
    assert len(claims) == 1


@pytest.mark.parametrize("name", ["points", "residuals", "models", "failures"])
def test_whoever_changes_a_table_changes_his_own(good_result, name):
    before = getattr(good_result, name)
    mine = getattr(good_result, name)
    mine["point_id"] = "mine"
    if name == "points":
        mine["easting"] += 500.0
        mine.loc[0, "northing"] = 0.0
    after = getattr(good_result, name)
    pd.testing.assert_frame_equal(after, before)
    assert not (after.get("point_id", pd.Series(dtype=str)) == "mine").any()
    with pytest.raises(AttributeError, match=name):
        setattr(good_result, name, mine)


def test_a_changed_solution_is_examined_anew(good_result):
    other = changed(good_result, points=good_result.points.iloc[:5])
    assert other.examination is not good_result.examination
    assert len(other.points) == 5
    assert len(good_result.points) > 5


@pytest.mark.slow
def test_seconds_grow_while_a_result_is_assessed_and_then_no_more(demo_block):
    result = densify(demo_block)
    computed = result.seconds
    assert computed > 0.0
    result.assessment  # noqa: B018
    assessed = result.seconds
    assert assessed > computed
    result.summary()
    assert result.seconds == assessed


@pytest.mark.slow
def test_the_interface_adds_writing_and_loses_nothing(tmp_path, demo_block):
    result = es.densify(demo_block)
    assert isinstance(result, es.DensificationResult)
    assert isinstance(result, DensificationResult)
    examined = result.examination
    result.write(tmp_path)
    assert result.examination is examined


def test_a_stopwatch_adds_up_also_where_the_work_fails():
    watch = Stopwatch()
    with watch.running():
        pass
    first = watch.seconds
    with pytest.raises(ValueError, match="wrong"), watch.running():
        raise ValueError("wrong")
    assert watch.seconds > first > 0.0
