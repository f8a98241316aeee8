"""Control that is wrong together, each the way it is found: one blunder, clean else."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom
from tests.judged_alone import judged_alone

from einschalt.pipeline.assessment.evidence.control.patterns import (
    FEWEST_ON_A_SIDE,
    _patterns,
    _wrong,
    find_control_patterns,
)
from einschalt.pipeline.assessment.evidence.control.signatures import (
    HEIGHT,
    PLAN,
    Kind,
    Pattern,
    Signatures,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.theory.adjustment.pattern_tests import examine_patterns
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE

METHODS = ("two_step", "simultaneous")


def is_east(control):
    return (control["easting"] > control["easting"].median()).to_numpy()


def with_control(block, **changes):
    control = block.control_points
    changed = {name: change(control) for name, change in changes.items()}
    return replace(block, control_points=control.assign(**changed))


def true_error(result, axes):
    new = result.points[result.points["role"] == "new"]
    truth = result.block.truth.set_index("point_id").loc[new["point_id"], axes]
    miss = new[axes].to_numpy() - truth.to_numpy()
    return float(np.sqrt(np.mean(np.sum(miss**2, axis=1))))


def densified(block, method):
    return densify(block, block.settings.updated({"method": method}))


def codes(result):
    return judged_alone(result)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_network_broken_in_two(demo_block, method):
    block = with_control(
        demo_block, northing=lambda c: c["northing"] + 0.2 * is_east(c)
    )
    result = densified(block, method)
    found = result.examination.control_patterns.plan
    assert found.kind is Kind.STEP
    # one part against the other: either may be the one that is wrong
    assert found.size == pytest.approx(0.2, abs=0.08)
    used = block.control_points["role"] == "control"
    east = set(
        block.control_points.loc[used & is_east(block.control_points), "point_id"]
    )
    west = set(block.control_points.loc[used, "point_id"]) - east
    assert set(found.point_ids) in (east, west)
    assert "broken_network" in codes(result)
    assert "contradicting_control" not in codes(result)
    true = true_error(result, ["easting", "northing"])
    assert true > 0.15
    credible = result.examination.credible
    assert credible.is_lower_bound
    assert 0.5 * true < credible.value < 2.0 * true


@pytest.mark.slow
def test_a_quadratic_strain(demo_block):
    def bent(control):
        x = control["easting"] - control["easting"].mean()
        return control["northing"] + 0.15 * ((x / x.std()) ** 2 - 1.0) / np.sqrt(2.0)

    result = densified(with_control(demo_block, northing=bent), "two_step")
    assert result.examination.control_patterns.plan.kind is Kind.BEND
    assert "broken_network" in codes(result)
    true = true_error(result, ["easting", "northing"])
    assert result.examination.credible.value > 0.5 * true


@pytest.mark.slow
def test_a_network_broken_in_two_beside_a_point_that_is_set_aside(demo_block):
    """A blunder that was taken out does not take the other one with it."""
    wrong = demo_block.control_points.query("role == 'control'")["point_id"].iloc[3]
    block = with_control(
        demo_block,
        northing=lambda c: (
            c["northing"] + 0.2 * is_east(c) + 3.0 * (c["point_id"] == wrong)
        ),
    )
    changed = {"method": "simultaneous", "outliers": "snoop"}
    result = densify(block, block.settings.updated(changed))
    control = result.examination.adjustment.control
    assert wrong in set(control.loc[control["is_set_aside"], "point_id"])
    found = result.examination.control_patterns.plan
    assert found.kind is Kind.STEP
    assert wrong not in found.point_ids
    assert found.size == pytest.approx(0.2, abs=0.08)
    true = true_error(result, ["easting", "northing"])
    assert 0.5 * true < result.examination.credible.value < 2.0 * true


@pytest.mark.slow
def test_two_points_with_each_others_name_are_as_wrong_together(demo_block):
    """What both of them do to the new points, though one alone is the clearest."""
    used = demo_block.control_points.query("role == 'control'")["point_id"]
    one, other = used.iloc[[2, 9]]
    names = demo_block.control_points["point_id"].replace({one: other, other: one})
    points = demo_block.control_points.assign(point_id=names)
    result = densify(replace(demo_block, control_points=points))
    found = result.examination.control_patterns
    true = true_error(result, ["easting", "northing"])
    assert found.plan.kind is Kind.POINT
    assert found.moved_plan == pytest.approx(true, rel=0.3)


@pytest.mark.slow
def test_a_point_that_is_set_aside_alone_leaves_no_pattern(demo_block):
    wrong = demo_block.control_points.query("role == 'control'")["point_id"].iloc[3]
    block = with_control(
        demo_block, northing=lambda c: c["northing"] + 3.0 * (c["point_id"] == wrong)
    )
    changed = {"method": "simultaneous", "outliers": "snoop"}
    result = densify(block, block.settings.updated(changed))
    assert result.examination.control_patterns.plan is None


def test_a_clean_block_has_no_pattern(demo_block, good_result, spatial_result):
    for result in (good_result, spatial_result):
        found = result.examination.control_patterns
        assert (found.plan, found.height) == (None, None)
        assert result.assessment.claim_is_supported


def test_every_division_is_made_once_and_leaves_points_on_either_side(demo_block):
    control = demo_block.control_points
    used = control.loc[control["role"] == "control", "point_id"]
    patterns = _patterns(control, used, (control["role"] != "check").to_numpy())
    steps = [p.of_control.astype(int) for p in patterns if p.kind is Kind.STEP]
    n_sides = [(row.sum(), len(used) - row.sum()) for row in steps]
    assert min(map(min, n_sides)) >= FEWEST_ON_A_SIDE
    assert len({tuple(row) for row in steps}) == len(steps) > 50
    is_check = (control["role"] == "check").to_numpy()
    assert not any(pattern.of_control[is_check].any() for pattern in patterns)


@pytest.mark.parametrize("axes", [PLAN, HEIGHT])
def test_false_alarms_do_not_exceed_alpha(spatial_result, axes):
    """400 draws of all errors of a block, with the family of patterns that it has."""
    examined = spatial_result.examination
    left_out = examined.left_out_control
    signatures = Signatures(examined, left_out)
    control = examined.block.control_points
    is_used = (control["role"] != "check").to_numpy()
    patterns = _patterns(control, left_out.point_ids, is_used)
    model = examined.error_model
    drawn = model.draw(400, seed=5).sources
    of_draws = sum(
        chain.apply(drawn[source]) for source, chain in left_out.chains.items()
    )
    vectors = model.axes.unpacked(of_draws)
    covariance, shown = signatures.covariance(axes), signatures.of(patterns, axes)
    n_alarms = 0
    for draw in range(400):
        observed = vectors[:, list(axes), draw].T.ravel()
        smallest = np.nanmin(examine_patterns(observed, covariance, shown).p_values)
        n_alarms += len(patterns) * smallest <= SYSTEMATIC_SIGNIFICANCE
    assert n_alarms <= binom.isf(0.001, 400, SYSTEMATIC_SIGNIFICANCE)


def test_signatures_are_what_an_error_of_control_does(spatial_block, spatial_result):
    """Densified again with the error: the differences change by the signature."""
    place, size = 4, 0.01
    row = np.zeros(len(spatial_block.control_points))
    row[place] = size
    examined = spatial_result.examination
    before = examined.left_out_control
    expected = Signatures(examined, before).of([Pattern(Kind.POINT, row)], HEIGHT)
    moved = with_control(spatial_block, height=lambda c: c["height"] + row)
    after = densify(moved).examination.left_out_control
    change = after.of_heights[0] - before.of_heights[0]
    np.testing.assert_allclose(change, expected[0, :, 0], atol=0.02 * size)


def test_few_control_points_tell_no_pattern(good_result):
    class Few:
        block = good_result.block
        left_out_control = given_heights = None

    found = find_control_patterns(Few)
    assert (found.plan, found.height) == (None, None)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("seed", "shift"), [(1, 0.6), (2, 0.6), (3, 1.2)])
def test_a_corner_of_few_points_counts_by_itself(seed, shift, method):
    block = simulate_block("demo", seed=seed)
    plan = block.control_points[["easting", "northing"]]
    is_corner = (plan < plan[block.control_points["role"] == "control"].median()).all(
        axis=1
    )

    def easting(control):
        return control["easting"] + np.where(is_corner, shift, 0.0)

    result = densify(
        with_control(block, easting=easting),
        block.settings.updated({"method": method}),
    )
    # three or four of 13 to 21 points
    assert result.examination.two_step.control_patterns.plan.kind is Kind.STEP
    figure = result.examination.credible.value
    assert 0.85 < figure / true_error(result, ["easting", "northing"]) < 1.3


def test_of_two_large_parts_either_may_be_the_wrong_one():
    is_used = np.array([True, True, True, False])
    step = Pattern(Kind.STEP, np.array([1.0, 1.0, 0.0, 0.0]))
    small, large = _wrong(step, is_used)
    assert small is step
    assert large.of_control.tolist() == [0.0, 0.0, 1.0, 0.0]
    # of one in three the others are right, as of a displaced region
    few = Pattern(Kind.STEP, np.array([1.0, 0.0, 0.0, 0.0]))
    assert _wrong(few, is_used) == (few,)
    bend = Pattern(Kind.BEND, np.ones(4))
    assert _wrong(bend, is_used) == (bend,)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("turned", "kind"), [(np.pi / 3.0, Kind.POINT), (0.0, Kind.STEP)]
)
def test_two_points_in_a_corner_are_a_part_if_they_move_together(
    demo_block, turned, kind
):
    used = demo_block.control_points.query("role == 'control'")
    corner = (used["easting"] + used["northing"]).nsmallest(2).index
    two = used.loc[corner, "point_id"].tolist()

    def moved(control, axis):
        ways = [axis(0.0), axis(turned)]
        return sum(
            0.6 * way * (control["point_id"] == name)
            for name, way in zip(two, ways, strict=True)
        )

    block = with_control(
        demo_block,
        easting=lambda c: c["easting"] + moved(c, np.cos),
        northing=lambda c: c["northing"] + moved(c, np.sin),
    )
    result = densified(block, "simultaneous")
    found = result.examination.control_patterns.plan
    assert found.kind is kind
    assert set(found.point_ids) <= set(two)
    if kind is Kind.POINT:
        assert set(two) <= set(found.wrong_ids)
        assert found.moved < 2.0 * true_error(result, ["easting", "northing"])
