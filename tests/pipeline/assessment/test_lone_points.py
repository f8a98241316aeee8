"""A single known point that took no part and is far off: left aside, and named."""

from dataclasses import replace

import numpy as np
import pytest
from tests.given_approximations import beside_control

from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block

PLAN = ["easting", "northing"]
WAYS = ("two_step", "simultaneous")


@pytest.fixture(scope="module")
def simulated():
    return simulate_block("demo", seed=5)


@pytest.fixture(scope="module")
def onto_given_points(simulated):
    """The low flight alone, onto approximate coordinates: control takes no part."""
    return beside_control(simulated)


def with_wrong(block, role, by, row=3):
    """The block with one known point given wrong, and its name."""
    control = block.control_points.copy()
    index = control.index[control["role"] == role][row]
    control.loc[index, "easting"] += by
    return replace(block, control_points=control), control.loc[index, "point_id"]


def measured_worse(block):
    """The block with measurements five times as bad as it states."""
    flights = {
        name: replace(flight, m_g_um=0.2 * flight.m_g_um)
        for name, flight in (
            ("low_flight", block.low_flight),
            ("high_flight", block.high_flight),
        )
        if flight is not None
    }
    return replace(block, **flights)


def computed(block, **settings):
    return densify(block, block.settings.updated(settings))


def true_error(result, truth):
    """Of the new points, TOTAL, RMS [m]."""
    points = result.points
    new = points[points["role"] == "new"].set_index("point_id")[PLAN]
    off = new - truth.set_index("point_id")[PLAN].reindex(new.index)
    return float(np.sqrt((off**2).sum(axis=1).mean()))


@pytest.mark.parametrize("method", WAYS)
@pytest.mark.parametrize("by", [3.0, 300.0])
def test_a_wrong_check_point_leaves_the_figure_of_the_others(simulated, method, by):
    block, name = with_wrong(simulated, "check", by)
    right = computed(simulated, method=method, tolerance=0.2)
    wrong = computed(block, method=method, tolerance=0.2)
    credible = wrong.assessment.credible
    assert credible.left_aside == (name,)
    assert credible.left_aside_by == pytest.approx(by, abs=0.2)
    assert credible.value == pytest.approx(right.assessment.credible.value, rel=1e-9)
    assert not credible.is_lower_bound
    assert wrong.assessment.claim_is_supported is False  # until it is checked
    # and it alone passes no tolerance
    is_it = wrong.points["point_id"] == name
    assert not wrong.points.loc[is_it, "is_within_tolerance"].any()
    columns = ["is_suspect", "is_within_tolerance", "standard_error_checked"]
    others = wrong.points.loc[~is_it, columns]
    assert others.equals(right.points.loc[~is_it, columns])
    assert f"without point {name}, which is {by:.0f}" in wrong.summary()


@pytest.mark.parametrize("method", WAYS)
def test_two_wrong_check_points_of_six_are_not_left_aside(simulated, method):
    block, _ = with_wrong(simulated, "check", 3.0)
    block, _ = with_wrong(block, "check", 2.0, row=4)
    credible = computed(block, method=method).assessment.credible
    assert not credible.left_aside
    assert credible.is_lower_bound
    assert credible.value > 0.5


@pytest.mark.parametrize("method", WAYS)
def test_a_check_point_and_a_new_one_under_each_others_name(simulated, method):
    """In all measurements: no residual shows it, and the new point is as far off."""
    control, truth = simulated.control_points, simulated.truth
    name = control.loc[control["role"] == "check", "point_id"].iloc[2]
    places = truth.set_index("point_id")[PLAN]
    measured = [set(f.model_points["point_id"]) for f in simulated.flights.values()]
    new = sorted(set.intersection(*measured) - set(control["point_id"]))
    apart = np.hypot(*(places.loc[new] - places.loc[name]).to_numpy().T)
    other = new[int(np.argmin(apart))]
    names = {name: other, other: name}

    def exchanged(flight):
        points = flight.model_points
        points = points.assign(point_id=points["point_id"].replace(names))
        return replace(flight, model_points=points)

    block = replace(
        simulated,
        high_flight=exchanged(simulated.high_flight),
        low_flight=exchanged(simulated.low_flight),
    )
    right, wrong = (computed(each, method=method) for each in (simulated, block))
    credible = wrong.assessment.credible
    assert credible.reason is Reason.EXCHANGED_NAMES
    assert credible.value == pytest.approx(true_error(wrong, truth), rel=0.02)
    assert credible.is_lower_bound
    clean = right.assessment.credible.value
    assert credible.elsewhere == pytest.approx(clean, rel=0.05)
    found = wrong.assessment.findings[0]
    assert found.code == "lone_wrong_check_point"
    assert list(found.names) == [name, other]
    assert found.remedy == "correct_check_name"
    assert found.facts["away"] < 0.3
    shown = wrong.points.set_index("point_id")["is_suspect"]
    assert shown[[name, other]].all()
    assert shown.mean() < 0.1  # and not the whole block
    checked = wrong.points.set_index("point_id")["standard_error_checked"]
    assert checked[other] == pytest.approx(apart.min(), rel=0.01)
    assert checked.drop(other).max() < 1.0
    assert "with its name put right" in wrong.summary()


@pytest.mark.parametrize("role", ["check", "control"])
@pytest.mark.parametrize("by", [3.0, 300.0])
def test_onto_given_points_a_wrong_control_point_is_left_aside(
    onto_given_points, role, by
):
    block, name = with_wrong(onto_given_points, role, by)
    right, wrong = (computed(each) for each in (onto_given_points, block))
    credible = wrong.assessment.credible
    assert credible.left_aside == (name,)
    assert credible.value == pytest.approx(right.assessment.credible.value, rel=1e-9)
    error = true_error(wrong, onto_given_points.truth)
    assert 0.8 < credible.value / error < 1.25
    told = wrong.assessment.findings[0]
    assert told.names[0] == name


def test_several_points_of_which_others_lie_beside_are_left_aside(onto_given_points):
    """One shift or several: models that hold them lie right by other known points."""
    block, first = with_wrong(onto_given_points, "control", 300.0, row=4)
    block, second = with_wrong(block, "control", 3.0, row=9)
    block, third = with_wrong(block, "check", 300.5)
    wrong = computed(block)
    credible = wrong.assessment.credible
    assert set(credible.left_aside) == {first, second, third}
    assert credible.left_aside[-1] == second  # the least last
    assert credible.left_aside_by == pytest.approx(300.5, abs=0.3)
    right = computed(onto_given_points).assessment.credible
    assert credible.value == pytest.approx(right.value, rel=1e-9)
    assert "without points" in wrong.summary()
    assert wrong.assessment.claim_is_supported is False


def test_known_points_of_a_displaced_part_are_not_left_aside(onto_given_points):
    """Neighbours that are off alike may be right, and the block displaced there."""
    control, truth = onto_given_points.control_points, onto_given_points.truth
    corner = truth[PLAN].min() + 0.3 * (truth[PLAN].max() - truth[PLAN].min())
    is_there = (control[PLAN] < corner).all(axis=1)
    assert 1 < is_there.sum() < 0.25 * len(control)
    moved = control.assign(easting=control["easting"] + 3.0 * is_there)
    block = replace(onto_given_points, control_points=moved)
    credible = computed(block).assessment.credible
    assert not credible.left_aside
    assert credible.value > 1.0


def test_of_both_ways_the_one_is_taken_that_wrong_control_does_not_move(
    onto_given_points,
):
    block, name = with_wrong(onto_given_points, "control", 300.0)
    result = computed(block, method="auto")
    assert result.choice.method == "two_step"
    assert result.assessment.credible.left_aside == (name,)
    assert true_error(result, onto_given_points.truth) < 0.1


@pytest.mark.parametrize("method", WAYS)
def test_a_check_point_of_a_single_model_is_not_left_aside(simulated, method):
    """What is wrong there may be its measurement, and new points have such too."""
    block, name = with_wrong(simulated, "check", 3.0)
    points = block.low_flight.model_points
    is_it = points["point_id"] == name
    first = points.index[is_it][0]
    points = points[~is_it | (points.index == first)].reset_index(drop=True)
    low = replace(block.low_flight, model_points=points)
    block = replace(block, low_flight=low)
    credible = computed(block, method=method).assessment.credible
    assert not credible.left_aside
    assert credible.value > 0.5


def test_wrong_control_that_takes_part_is_never_left_aside(simulated):
    block, _ = with_wrong(simulated, "control", 3.0)
    for method in WAYS:
        assert not computed(block, method=method).assessment.credible.left_aside


@pytest.mark.parametrize("method", WAYS)
def test_a_suspect_check_point_is_told_also_if_all_together_agree(simulated, method):
    """A point that passes no tolerance is never one of which nothing is said."""
    block, name = with_wrong(simulated, "check", 0.15, row=2)
    while True:
        result = computed(block, method=method)
        if result.points.set_index("point_id").loc[name, "is_suspect"]:
            break
        block, _ = with_wrong(block, "check", 0.02, row=2)
    found = result.assessment.findings[0]
    assert found.code == "suspect_check_points"
    assert found.names == (name,)
    known = result.examination.known_check
    miss = np.hypot(*known.differences[known.point_ids == name][0])
    assert found.facts["largest"] == pytest.approx(miss)
    assert not known.are_beyond
    assert f"Check point {name} differs by" in result.summary()


def test_control_and_a_new_point_under_each_others_name(onto_given_points):
    """The new point is named, and it and the control point alone pass no tolerance."""
    truth = onto_given_points.truth.set_index("point_id")[PLAN]
    control = onto_given_points.control_points.copy()
    index = control.index[control["role"] == "control"][3]
    name = control.loc[index, "point_id"]
    new = truth.drop(control["point_id"])
    other = new.index[np.argmin(np.hypot(*(new - truth.loc[name]).to_numpy().T))]
    control.loc[index, PLAN] = truth.loc[other].to_numpy()
    block = replace(onto_given_points, control_points=control)
    result = computed(block, tolerance=0.2)
    credible = result.assessment.credible
    assert credible.left_aside == (name,)
    assert credible.is_lower_bound
    assert credible.is_bound_by_names
    told = {found.code: found.names for found in result.assessment.findings}
    assert told["control_under_another_name"] == (name, other)
    right = computed(onto_given_points, tolerance=0.2).points
    passed = result.points["is_within_tolerance"]
    is_named = result.points["point_id"].isin([name, other])
    assert not passed[is_named].any()
    assert passed[~is_named].equals(right["is_within_tolerance"][~is_named])


def test_without_check_points_nothing_warns(onto_given_points):
    block, name = with_wrong(onto_given_points, "control", 300.0)
    control = block.control_points
    is_check = (control["role"] == "check").to_numpy()
    block = replace(block, control_points=control[~is_check].reset_index(drop=True))
    assert computed(block).assessment.credible.left_aside == (name,)


@pytest.mark.parametrize("method", WAYS)
@pytest.mark.parametrize(("by", "is_aside"), [(0.3, False), (30.0, True)])
def test_beside_errors_larger_than_stated_only_what_is_far_beyond_is_left_aside(
    simulated, onto_given_points, method, by, is_aside
):
    """Sizes of errors do not make one point of six lie 30 m off; 30 cm they may."""
    block = simulated if method == "simultaneous" else onto_given_points
    block, name = with_wrong(block, "check", by)
    result = computed(measured_worse(block), method=method)
    credible = result.assessment.credible
    assert credible.is_lower_bound
    assert credible.left_aside == ((name,) if is_aside else ())
    assert 0.7 < credible.value / true_error(result, simulated.truth) < 3.0
    assert result.assessment.claim_is_supported is False


def test_beside_control_in_doubt_no_check_point_is_left_aside(simulated):
    """The figure is that of all known points, and every point a suspect."""
    block, _ = with_wrong(simulated, "check", 30.0)
    result = computed(measured_worse(block))
    credible = result.assessment.credible
    assert not credible.left_aside
    assert credible.is_lower_bound
    assert credible.value > 3.0
    assert result.points["is_suspect"].all()


def test_control_of_one_model_is_left_aside_where_its_own_place_confirms_it(
    onto_given_points,
):
    """A gross error of its measurement would show in its approximate coordinates."""
    low = onto_given_points.low_flight
    points = low.model_points
    block = replace(
        onto_given_points,
        low_flight=replace(
            low, model_points=points[points["coverage"] == points["coverage"].iloc[0]]
        ),
    )
    n_models = block.low_flight.model_points["point_id"].value_counts()
    control = block.control_points
    is_one = (control["role"] == "control") & (control["point_id"].map(n_models) == 1)
    moved = control.copy()
    index = control.index[is_one][0]
    moved.loc[index, "easting"] += 3.0
    wrong = computed(replace(block, control_points=moved))
    credible = wrong.assessment.credible
    assert credible.left_aside == (control.loc[index, "point_id"],)
    right = computed(block).assessment.credible
    assert credible.value == pytest.approx(right.value, rel=1e-9)
    # what its measurement is off by shows as little in its difference
    points = block.low_flight.model_points.copy()
    is_it = points["point_id"] == control.loc[index, "point_id"]
    points.loc[is_it, "x"] += 0.5
    spoilt = replace(block, low_flight=replace(low, model_points=points))
    assert not computed(spoilt).assessment.credible.left_aside


def test_control_beside_control_that_is_stated_too_good(onto_given_points):
    """What most of the others show is what one is held against."""
    block, name = with_wrong(onto_given_points, "control", 3.0)
    rng = np.random.default_rng(8)
    control = block.control_points.copy()
    control[PLAN] += rng.normal(0.0, 0.06, (len(control), 2))
    block = replace(block, control_points=control)
    result = computed(block)
    credible = result.assessment.credible
    assert credible.left_aside == (name,)
    assert credible.is_lower_bound
    assert credible.value < 0.15  # the others differ by that


def test_a_point_that_no_model_of_the_high_flight_holds_is_in_doubt(simulated):
    """Where nothing confirms control its low models may hang on a wrong one."""
    block, name = with_wrong(simulated, "check", 3.0)
    points = block.high_flight.model_points
    points = points[points["point_id"] != name].reset_index(drop=True)
    block = replace(block, high_flight=replace(block.high_flight, model_points=points))
    result = computed(block, iterations=2)
    assert result.examination.left_out_differences.empty
    assert not result.assessment.credible.left_aside
    assert result.assessment.credible.value > 0.5


def test_control_that_is_approximate_took_part(onto_given_points):
    """It is no known point that models are compared with: they are fitted onto it."""
    control = onto_given_points.control_points
    given = onto_given_points.approximate_points.set_index("point_id")
    is_held = control["role"] == "control"
    names = control.loc[is_held, "point_id"]
    given.loc[names, PLAN] = control.loc[is_held, PLAN].to_numpy()
    index = names.iloc[3]
    given.loc[index, "easting"] += 3.0
    control = control.copy()
    control.loc[control["point_id"] == index, "easting"] += 3.0
    block = replace(
        onto_given_points,
        approximate_points=given.reset_index(),
        control_points=control,
    )
    result = computed(block)
    assert not result.examination.lone_points
    assert index in {n for f in result.assessment.findings for n in f.names}
