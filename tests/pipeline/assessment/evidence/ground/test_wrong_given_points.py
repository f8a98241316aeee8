"""A single approximate point that is given wrong: named, and in the figure."""

from dataclasses import replace

import numpy as np
import pytest
from tests.judged_alone import judged_alone
from tests.pipeline.assessment.evidence.ground.test_displaced_region import (
    PLAN,
    corner,
    densified,
    given,
    rms,
    true_errors,
)

from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.simulate_block import simulate_block

CODE = "wrong_approximate_points"
NAME, OTHER = "1045", "1072"


def spoilt(block, **shifts):
    """A block some approximate points of which are given too far in the east."""
    known = block.approximate_points.copy()
    for name, shift in shifts.items():
        known.loc[known["point_id"] == name[1:], "easting"] += shift
    return replace(block, approximate_points=known)


def found_in(result):
    return judged_alone(result).get(CODE)


@pytest.mark.slow
@pytest.mark.parametrize("shift", [1.0, 5.0, 100.0, 1000.0])
def test_it_is_named_and_its_effect_is_in_the_figure(shift):
    block, truth, _ = given(31)
    result = densified(spoilt(block, p1045=shift), tolerance=0.12)
    found = found_in(result)
    assert found.names == (NAME,)
    (point,) = found.facts["wrong_points"]
    allowed = 4.0 * point["standard_error"]
    assert point["easting"] == pytest.approx(shift, abs=allowed)
    assert point["northing"] == pytest.approx(0.0, abs=allowed)
    assert point["n_models"] >= 2
    new, miss = true_errors(result, truth)
    credible = result.examination.credible
    assert credible.reason is Reason.WRONG_POINTS
    assert 0.85 < rms(miss) / credible.value < 1.2
    # what no model with it holds is as good as ever
    assert credible.elsewhere < 0.06
    checked = new["standard_error_checked"].to_numpy()
    assert 0.7 < rms(miss / checked) < 1.3
    suspects = result.points[result.points["is_suspect"]]["point_id"]
    assert NAME in set(suspects)
    assert new["is_within_tolerance"].mean() > 0.3
    assert not (miss[new["is_within_tolerance"].to_numpy(bool)] > 0.3).any()


@pytest.mark.slow
def test_it_is_told_first_and_explains_what_it_spoils():
    result = densified(spoilt(given(31)[0], p1045=5.0))
    assert result.assessment.causes[0] == CODE
    left = [f.code for f in result.assessment.findings if not f.explained_by]
    assert left == [CODE, "no_check_points"]
    said = " ".join(result.summary().split())
    head = result.summary().splitlines()[0]
    assert "outside models with wrong approximate points; check approximate point " in (
        head
    )
    assert head.endswith(f"check approximate point {NAME} first")
    assert "Given elsewhere than all models have it: 1 approximate point of" in said
    assert f", by up to 5.0 m: {NAME}" in said
    assert f"{NAME}: given less measured, easting 5.0 m, northing " in said
    assert "or take these points out of the approximate points" in said


@pytest.mark.slow
def test_two_of_them_are_named_the_worse_one_in_the_first_line():
    block, truth, _ = given(31)
    result = densified(spoilt(block, p1045=1.0, p1072=-3.0))
    assert found_in(result).names == (OTHER, NAME)
    head = result.summary().splitlines()[0]
    assert f"points first, {OTHER} above all (2 are wrong)" in head
    _, miss = true_errors(result, truth)
    assert 0.85 < rms(miss) / result.examination.credible.value < 1.2


@pytest.mark.slow
def test_three_of_a_hundred_are_named():
    block, truth, _ = given(31)
    assert len(block.approximate_points) < 150
    result = densified(spoilt(block, p1045=4.0, p1072=-4.0, p1030=4.0))
    assert set(found_in(result).names) == {NAME, OTHER, "1030"}
    _, miss = true_errors(result, truth)
    assert 0.85 < rms(miss) / result.examination.credible.value < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["helmert", "helmert_3d", "images"])
def test_models_of_all_kinds_tell_it(kind):
    geometry = {"images": {"transformation": "helmert_3d", "measurement": "images"}}
    geometry = BlockGeometry(**geometry.get(kind, {"transformation": kind}))
    simulated = simulate_block("demo", seed=3, geometry=geometry)
    known = simulated.truth.copy()
    rng = np.random.default_rng(3)
    known[PLAN] += 0.07 * rng.standard_normal((len(known), 2))
    block = replace(
        simulated, high_flight=None, approximate_points=known, approximate_m_0_m=0.1
    )
    assert found_in(densify(block)) is None
    name = str(known["point_id"].iloc[len(known) // 2])
    result = densify(spoilt(block, **{f"p{name}": 5.0}))
    assert found_in(result).names == (name,)


@pytest.mark.parametrize("seed", range(40, 46))
def test_nothing_is_found_in_clean_blocks(seed):
    assert densified(given(seed)[0]).examination.wrong_given_points == ()


@pytest.mark.slow
def test_a_measurement_that_is_wrong_is_no_wrong_point():
    """Other models of the point do not agree with it."""
    block, _, _ = given(31)
    low = block.low_flight
    points = low.model_points.copy()
    row = np.flatnonzero(points["point_id"] == NAME)[0]
    points.loc[points.index[row], "x"] += 0.05 * points["x"].std()
    result = densified(replace(block, low_flight=replace(low, model_points=points)))
    assert found_in(result) is None
    assert result.assessment.causes[0] == "kept_gross_measurements"


@pytest.mark.slow
def test_points_of_a_displaced_region_are_no_single_ones():
    block, _, names = given(31, corner, shift=np.array([0.8, -0.6]))
    result = densified(block)
    assert found_in(result) is None
    (region,) = result.examination.displaced_regions
    assert len(set(region.point_ids) & names) > 0.85 * len(names)


@pytest.mark.slow
@pytest.mark.parametrize("is_in", [True, False])
def test_beside_a_displaced_region_both_are_named(is_in):
    """What m_0 has of the gross error does not hide the region."""
    block, truth, names = given(32, corner)
    measured = set(block.low_flight.model_points["point_id"])
    some = [n for n in truth.index if (n in names) == is_in and n in measured]
    name = some[len(some) // 2]
    result = densified(spoilt(block, **{f"p{name}": 5.0}))
    assert found_in(result).names == (name,)
    (region,) = result.examination.displaced_regions
    assert len(set(region.point_ids) & names) > 0.85 * len(names)
    _, miss = true_errors(result, truth)
    assert 0.85 < rms(miss) / result.examination.credible.value < 1.2
    head = result.summary().splitlines()[0]
    assert "outside displaced regions and models with wrong approximate points" in head


@pytest.mark.slow
def test_names_exchanged_in_all_measurements_are_in_the_figure():
    """Nothing tells whether the list or the measurements have them exchanged."""
    block, truth, _ = given(31)
    one, two = "1038", "1063"  # in no model together, which would tell more
    low = block.low_flight
    other = {one: two, two: one}
    renamed = low.model_points.assign(
        point_id=low.model_points["point_id"].replace(other)
    )
    result = densified(replace(block, low_flight=replace(low, model_points=renamed)))
    assert set(found_in(result).names) == {one, two}
    said = " ".join(result.summary().split())
    assert f"It lies where {one} is given, and {one} where {two} is" in said
    new, miss = true_errors(result, truth)
    assert 0.85 < rms(miss) / result.examination.credible.value < 1.2
    checked = new["standard_error_checked"][[one, two]].to_numpy()
    assert miss[new.index.isin([one, two])] == pytest.approx(checked, rel=0.1)


@pytest.mark.slow
def test_an_adjustment_does_not_follow_given_points():
    block, truth, _ = given(31)
    result = densified(spoilt(block, p1045=5.0), "simultaneous")
    assert found_in(result) is None
    _, miss = true_errors(result, truth)
    assert rms(miss) < 0.06


def half_off(block, shift):
    """A block the western half of the approximate points of which is off."""
    known = block.approximate_points.copy()
    is_west = known["easting"] < known["easting"].median()
    known.loc[is_west, "northing"] += shift
    return replace(block, approximate_points=known)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [31, 41])
def test_a_region_hides_no_single_wrong_point(seed):
    simulated, truth, _ = given(seed)
    block = half_off(simulated, 1.5)
    # its models hold points of both halves
    known = block.approximate_points
    east = known["easting"] - known["easting"].median()
    name = str(known.loc[east[east > 0.0].idxmin(), "point_id"])
    result = densified(spoilt(block, **{f"p{name}": 6.0}))
    assert found_in(result).names == (name,)
    codes = [found.code for found in result.assessment.findings]
    assert "displaced_region" in codes
    _, miss = true_errors(result, truth)
    assert 0.85 < rms(miss) / result.examination.credible.value < 1.2
    # nothing is named where a region alone is off
    assert found_in(densified(block)) is None


def test_an_adjustment_is_not_apart_from_what_given_points_do_to_two_steps():
    simulated, truth, _ = given(31)
    result = densified(half_off(simulated, 1.5), "simultaneous")
    _, miss = true_errors(result, truth)
    assert rms(miss) < 0.05
    # the two steps follow their half by 1.5 m: 1.1 m in the mean
    assert result.examination.apart_from_two_steps.plan < 0.05


@pytest.mark.slow
def test_a_region_of_photographs_is_no_single_wrong_point():
    geometry = BlockGeometry(
        width=4200.0,
        height=3600.0,
        point_spacing=300.0,
        transformation="helmert_3d",
        measurement="images",
    )
    simulated = simulate_block("demo", seed=71, geometry=geometry)
    known = simulated.truth[["point_id", *PLAN, "height"]].copy()
    rng = np.random.default_rng(71)
    known[PLAN] += 0.07 * rng.standard_normal((len(known), 2))
    middle = known[PLAN].median()
    is_off = (known[PLAN] < middle).all(axis=1)
    known.loc[is_off, PLAN] += [-4.8, -3.6]
    block = replace(
        simulated, high_flight=None, approximate_points=known, approximate_m_0_m=0.1
    )
    assert found_in(densify(block)) is None
