"""A region whose given coordinates are off: it is named, and is in the figure."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.judged_alone import judged_alone

from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.assessment.evidence.ground.displaced_region import (
    _missed_elsewhere,
)
from einschalt.pipeline.assessment.evidence.ground.given_region import (
    KnownPoints,
    told_region,
)
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.theory.adjustment.displaced_regions import DisplacedRegion

PLAN = ["easting", "northing"]
OWN = 0.09  # TOTAL error of the given coordinates [m]
SHIFT = np.array([0.24, -0.18])
METHODS = ("two_step", "simultaneous")


def given(seed, is_in=None, shift=SHIFT, moves_control=True, m_g=1.0):
    """A block onto approximate coordinates, those that ``is_in`` names displaced."""
    block = simulate_block("demo", seed=seed)
    rng = np.random.default_rng(seed)
    known = block.truth[["point_id", *PLAN]].copy()
    known[PLAN] += OWN / np.sqrt(2.0) * rng.standard_normal((len(known), 2))
    control = block.control_points
    control = control[control["role"] == "control"].reset_index(drop=True)
    names = set()
    if is_in is not None:
        names = set(known.loc[is_in(known), "point_id"])
        known.loc[known["point_id"].isin(names), PLAN] += shift
        if moves_control:
            control.loc[control["point_id"].isin(names), PLAN] += shift
    low = replace(block.low_flight, m_g_um=block.low_flight.m_g_um / m_g)
    given = Block(
        name="given",
        crs=block.crs,
        control_points=control,
        approximate_points=known,
        approximate_m_0_m=OWN,
        low_flight=low,
    )
    return given, block.truth.set_index("point_id"), names


def corner(points):
    """A quarter of the points, in the north-east."""
    e, n = (points[axis] - points[axis].min() for axis in PLAN)
    return np.hypot(e - e.max(), n - n.max()) < 0.57 * e.max()


def densified(block, method="two_step", **settings):
    return densify(block, block.settings.updated({"method": method, **settings}))


def true_errors(result, truth):
    new = result.points[result.points["role"] == "new"].set_index("point_id")
    miss = new[PLAN] - truth.loc[new.index, PLAN]
    return new, np.hypot(*miss.to_numpy().T)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def found_in(result):
    codes = {found.code: found for found in result.assessment.findings}
    return codes.get("displaced_region")


@pytest.fixture(scope="module")
def displaced():
    return given(31, corner)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_the_region_is_named_and_its_effect_is_in_the_figure(displaced, method):
    block, truth, names = displaced
    result = densified(block, method)
    found = found_in(result)
    named = set(found.names)
    assert len(named & names) > 0.85 * len(named | names)
    facts = found.facts
    shift = np.array([facts["easting"], facts["northing"]])
    assert shift == pytest.approx(SHIFT, abs=4.0 * facts["standard_error"])
    assert facts["control_is_alike"]
    assert set(facts["control"]) <= set(block.control_points["point_id"])
    credible = result.assessment.credible
    _, miss = true_errors(result, truth)
    assert credible.is_lower_bound
    assert credible.reason is Reason.DISPLACED
    assert 0.8 < rms(miss) / credible.value < 1.25
    assert result.assessment.claim_is_supported is False


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_other_points_are_not_punished(displaced, method):
    block, truth, names = displaced
    result = densified(block, method, tolerance=0.12)
    new, miss = true_errors(result, truth)
    is_in = new.index.isin(names)
    checked = new["standard_error_checked"].to_numpy()
    assert rms(checked[~is_in]) < 0.4 * rms(checked[is_in])
    assert 0.7 < rms(miss[is_in] / checked[is_in]) < 1.3
    elsewhere = result.assessment.credible.elsewhere
    assert 0.75 < rms(miss[~is_in]) / elsewhere < 1.25
    assert 0.75 < rms(checked[~is_in]) / elsewhere < 1.25
    assert not new["is_within_tolerance"][is_in].any()
    assert new["is_within_tolerance"][~is_in].mean() > 0.7
    assert new["is_suspect"][is_in].mean() > 0.85
    said = " ".join(result.summary().split())
    assert "what these do to each point. None passes" not in said
    assert "what these do to each point." in said


@pytest.mark.slow
def test_what_follows_is_told_under_it(displaced):
    result = densified(displaced[0])
    codes = {found.code: found for found in result.assessment.findings}
    assert codes["claim_that_does_not_stand"].explained_by == "displaced_region"
    assert result.assessment.causes[0] == "displaced_region"
    head = result.summary().splitlines()[0]
    assert "outside displaced regions; check the displaced points first" in head
    assert "approximate points are displaced together" in " ".join(
        result.summary().split()
    )


@pytest.mark.slow
def test_control_that_is_right_is_told_apart():
    """One adjustment of all models follows control: it is as good as without."""
    block, truth, _ = given(32, corner, moves_control=False)
    found = found_in(densified(block))
    assert not found.facts["control_is_alike"]
    adjusted = densified(block, "simultaneous")
    assert found_in(adjusted) is None
    _, miss = true_errors(adjusted, truth)
    assert rms(miss) < 0.06


def in_strips(seed, size=0.2):
    """A block onto points of three strips, beside control that is right.

    The middle and the northern one are displaced: the southern one agrees with control,
    and is a region against the others.
    """
    block, truth, _ = given(seed)
    known = block.approximate_points
    strip = np.ceil(3.0 * known["northing"].rank(pct=True)).astype(int) - 1
    shift = np.array([0.0, size, -size])[strip]
    known = known.assign(easting=known["easting"] + shift)
    return replace(block, approximate_points=known), truth


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(35, 38))
def test_strips_that_an_adjustment_does_not_use_do_not_accuse_it(seed):
    """Control in a strip that is given right is not displaced against the others."""
    block, truth = in_strips(seed)
    in_two_steps = densified(block).examination.displaced_regions
    assert in_two_steps
    assert not any(region.control_is_alike for region in in_two_steps)
    adjusted = densified(block, "simultaneous")
    assert found_in(adjusted) is None
    _, miss = true_errors(adjusted, truth)
    assert not adjusted.assessment.credible.is_lower_bound
    assert rms(miss) / adjusted.assessment.credible.value == pytest.approx(1, abs=0.3)


@pytest.mark.parametrize(
    ("inside", "usual", "is_alike"),
    [
        ((0.0, 0.0), (0.0, 0.0), True),
        ((0.2, 0.1), (0.0, 0.0), False),
        # control in no region is missed by as much the other way: all of it is right
        ((0.0, 0.0), (-0.2, -0.1), False),
        ((0.2, 0.1), (0.2, 0.1), True),
    ],
)
def test_control_is_displaced_where_it_agrees_as_control_elsewhere_does(
    inside, usual, is_alike
):
    known = pd.DataFrame({"point_id": list("abcd"), "easting": [0.0, 1.0, 2.0, 3.0]})
    known["northing"] = [0.0, 1.0, 0.0, 1.0]
    found = DisplacedRegion(np.arange(2), np.array([0.2, 0.1]), 0.01, 0.001)
    names = np.array(["a", "b", "d"], dtype=object)
    is_inside = np.array([True, True, False])
    misses = np.array([inside, inside, usual])
    others = KnownPoints(names, is_inside, misses, np.full(3, 0.02))
    how = {"is_of_control": False, "is_decided": False}
    region = told_region(known, found, 2, others, usual=usual, **how)
    assert region.control_is_alike is is_alike
    assert region.control_ids == ("a", "b")
    np.testing.assert_array_equal(_missed_elsewhere([others]), usual)


@pytest.mark.slow
def test_of_two_parts_about_alike_nothing_tells_which():
    def half(points):
        return points["easting"] > points["easting"].quantile(0.6)

    block, truth, _ = given(33, half)
    result = densified(block, tolerance=0.12)
    found = found_in(result)
    assert found.remedy == "compare_both_parts"
    _, miss = true_errors(result, truth)
    assert result.examination.credible.value > 0.9 * rms(miss)
    assert not result.points["is_within_tolerance"].any()
    # the points of either part, whichever is named
    new, _ = true_errors(result, truth)
    assert rms(miss[miss > 0.2] / new["standard_error_checked"][miss > 0.2]) < 1.3
    assert np.isnan(result.examination.credible.elsewhere)
    said = " ".join(result.summary().split())
    assert "outside displaced regions" not in said
    assert "None passes, since nothing tells which part is displaced." in said


def west(points):
    return points["easting"] <= points["easting"].quantile(0.6)


def east(points):
    return ~west(points)


@pytest.mark.slow
@pytest.mark.parametrize("is_in", [west, east])
@pytest.mark.parametrize("where", ["both", "east", "west"])
def test_control_tells_which_of_two_halves_is_off(is_in, where):
    block, truth, names = given(33, is_in, moves_control=False)
    control = block.control_points
    if where != "both":
        lies_east = control["easting"] > truth["easting"].quantile(0.6)
        control = control[lies_east == (where == "east")]
        block = replace(block, control_points=control.reset_index(drop=True))
    result = densified(block)
    found = found_in(result)
    assert found.remedy == "correct_region_or_give_group"
    named = set(found.names)
    assert len(named & names) > 0.9 * len(named | names)
    shift = np.array([found.facts[axis] for axis in PLAN])
    assert shift == pytest.approx(SHIFT, abs=4.0 * found.facts["standard_error"])
    new, miss = true_errors(result, truth)
    is_off = new.index.isin(names)
    assert rms(new["standard_error_checked"][~is_off]) < 0.12
    assert 0.8 < rms(miss) / result.examination.credible.value < 1.25


@pytest.mark.parametrize("seed", range(40, 46))
def test_nothing_is_found_in_clean_blocks(seed):
    result = densified(given(seed)[0])
    assert result.examination.displaced_regions == ()
    assert np.isnan(result.examination.credible.elsewhere)


@pytest.mark.parametrize("seed", range(46, 50))
def test_m_g_that_is_too_small_is_no_region(seed):
    assert found_in(densified(given(seed, m_g=1.5)[0])) is None


@pytest.mark.parametrize("seed", [44, 46, 48])
def test_m_g_that_is_too_small_is_not_taken_for_shared_errors(seed):
    """Both coverages have what approximate points share: they do not differ by it."""
    result = densified(given(seed, m_g=1.5)[0])
    codes = judged_alone(result)
    doubted = codes["claim_that_does_not_stand"]
    (test,) = doubted.facts["rejected"]
    assert test["quantity"] == "coverage differences"
    assert doubted.remedy == "doubt_sizes_of_errors"


@pytest.mark.slow
def test_points_with_groups_or_a_high_flight_are_not_looked_at(displaced, good_result):
    assert good_result.examination.displaced_regions == ()
    block, _, names = displaced
    known = block.approximate_points
    group = np.where(known["point_id"].isin(names), "corner", "")
    grouped = replace(block, approximate_points=known.assign(group=group))
    sized = replace(grouped, group_errors_m={"approximate_points": 0.3})
    assert densified(sized).examination.displaced_regions == ()
    # a group whose size nobody tells says nothing of how far it is off
    (region,) = densified(grouped).examination.displaced_regions
    assert len(set(region.point_ids) & names) > 0.85 * len(names)


@pytest.mark.slow
def test_a_region_off_by_no_more_than_is_stated_contradicts_the_claim():
    """Neighbours may share what is stated of each: the figure then includes that."""
    block, truth, _ = given(30, corner, shift=0.57 * SHIFT)
    result = densified(block, tolerance=0.12)
    assert found_in(result) is None
    assert result.assessment.claim_is_supported is False
    _, miss = true_errors(result, truth)
    assert result.assessment.credible.value > rms(miss)
    assert not result.points["is_within_tolerance"].any()
    said = " ".join(result.summary().split())
    assert "given points of a region are displaced together against the others" in said


@pytest.mark.slow
def test_an_error_that_is_stated_too_small_hides_no_region(displaced):
    block, truth, names = displaced
    result = densified(replace(block, approximate_m_0_m=OWN / 3.0))
    named = set(found_in(result).names)
    assert len(named & names) > 0.85 * len(named | names)
    _, miss = true_errors(result, truth)
    assert 0.8 < rms(miss) / result.examination.credible.value < 1.25


@pytest.mark.slow
def test_what_was_not_looked_for_is_said():
    oriented = simulate_block(
        "demo", seed=3, geometry=BlockGeometry(measurement="parallaxes")
    )
    known = oriented.truth[["point_id", *PLAN]]
    low = {"low_flight": oriented.low_flight, "approximate_m_0_m": OWN}
    block = Block(name="given", approximate_points=known, **low)
    said = " ".join(densified(block).summary().split())
    assert "Not tested: whether the given coordinates of a region are displaced" in said


@pytest.mark.slow
def test_of_several_passes_the_first_is_looked_at(displaced):
    block, _, names = displaced
    found = found_in(densified(block, iterations=3))
    assert len(set(found.names) & names) > 0.85 * len(names)


def two_regions(seed):
    """Two corners that are off, in different directions."""
    first, truth, names = given(seed, corner)
    points = first.approximate_points

    def opposite(table):
        apart = table[PLAN] - points[PLAN].min()
        return np.hypot(*apart.to_numpy().T) < 1100.0

    far = set(points.loc[opposite(points), "point_id"])
    moved = {}
    for table in ("approximate_points", "control_points"):
        frame = getattr(first, table).copy()
        frame.loc[frame["point_id"].isin(far), PLAN] += [0.1, 0.28]
        moved[table] = frame
    return replace(first, **moved), truth, (names, far)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_two_regions_are_named_in_one_finding(method):
    block, truth, regions = two_regions(34)
    result = densified(block, method, tolerance=0.15)
    facts = found_in(result).facts
    assert len(facts["further_regions"]) == 1
    both = regions[0] | regions[1]
    named = set(found_in(result).names)
    assert len(named & both) > 0.85 * len(named | both)
    new, miss = true_errors(result, truth)
    assert 0.8 < rms(miss) / result.examination.credible.value < 1.25
    is_in = new.index.isin(both)
    checked = new["standard_error_checked"].to_numpy()
    assert 0.7 < rms(miss[is_in] / checked[is_in]) < 1.3
    assert not new["is_within_tolerance"][is_in].any()
    said = " ".join(result.summary().split())
    assert "2 regions of given coordinates are displaced" in said
    assert said.count("standard error of each") == 2


@pytest.mark.slow
def test_what_is_left_beside_a_region_is_told_without_it():
    """An m_g that is too small as well: nothing of errors that neighbours share."""
    result = densified(given(32, corner, m_g=1.5)[0])
    codes = {found.code: found for found in result.assessment.findings}
    claim = codes["claim_that_does_not_stand"]
    assert not claim.explained_by
    assert claim.remedy == "doubt_sizes_of_errors"
    quantities = {test["quantity"] for test in claim.facts["rejected"]}
    assert quantities == {"coverage differences"}
    assert claim.statistic == "coverage differences"
    assert "share errors, such as" not in " ".join(result.summary().split())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(200, 203))
def test_an_edge_along_the_rim_of_models_is_seen(seed):
    """Three rows of points: a line one row beside the edge shows nothing of it."""

    def east(points):
        return points["easting"] > points["easting"].quantile(0.7)

    block, _, names = given(seed, east)
    named = set(found_in(densified(block)).names)
    assert len(named & names) > 0.85 * len(named | names)


@pytest.mark.slow
def test_what_would_not_be_noticed_is_said(displaced):
    """At the least favourable place, four of five times."""
    result = densified(given(41)[0])
    shift = result.assessment.claim.detectable_shift
    assert 0.1 < shift.median < shift.largest < 0.3
    said = " ".join(result.summary().split())
    assert "displaced together would be noticed from" in said
    assert densified(displaced[0]).assessment.claim.detectable_shift is None


def test_where_all_new_points_are_displaced_it_is_told_what_is_off():
    """The others are control; m_g is too small as well."""
    block, truth, names = given(32, corner, m_g=1.5)
    more = truth.loc[sorted(set(truth.index) - names)].reset_index()
    known = pd.DataFrame({"point_id": more["point_id"], "role": "control"})
    known = known.assign(**{axis: more[axis] for axis in PLAN}, standard_error_m=0.02)
    inside = block.control_points[block.control_points["point_id"].isin(names)]
    control = pd.concat([known, inside], ignore_index=True)
    held = replace(block, control_points=control)
    result = densified(held, tolerance=0.12)
    assert np.isnan(result.assessment.credible.elsewhere)
    said = " ".join(result.summary().split())
    assert "nothing tells which part is displaced" not in said
    assert "even so the stated precision is not supported" in said
