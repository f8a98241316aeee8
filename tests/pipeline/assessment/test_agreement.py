"""Headline, claim, bound and tolerance agree, whatever is wrong with control."""

from dataclasses import replace

import pandas as pd
import pytest
from tests.changed_results import changed

from einschalt.pipeline.assessment.evidence.control.patterns import (
    NO_PATTERNS,
    ControlPatterns,
    FoundPattern,
)
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.systematic_errors import NetworkStrain
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.summary.verdict import verdict

pytestmark = pytest.mark.slow

# of the claimed figure: nothing, less than single points must move the rest by, more
SHARES = (0.0, 0.1, 3.0)
CHANCE, NO_CHANCE = 0.5, 0.005


def found_pattern(kind, names, moved, n_axes):
    return FoundPattern(
        kind=kind,
        flights=("high_flight",) if kind is Kind.SCALE else (),
        point_ids=tuple(names),
        n_control=17,
        amplitude=(0.05,) * n_axes,
        p_value=NO_CHANCE,
        moved=moved,
        wrong_ids=tuple(names) if kind is Kind.POINT else (),
    )


def in_plan(kind, names, moved):
    plan = None if kind is None else found_pattern(kind, names, moved, 2)
    return ControlPatterns(plan, None, moved_plan=moved, p_plan=NO_CHANCE, n_control=17)


def in_height(kind, names, moved):
    height = None if kind is None else found_pattern(kind, names, moved, 1)
    return ControlPatterns(
        None, height, moved_height=moved, p_height=NO_CHANCE, n_control=17
    )


def strain_of(size, p_value, names, *, is_smooth):
    moved = pd.DataFrame({"point_id": names, "easting": size, "northing": 0.0})
    return NetworkStrain(size, 2000.0, p_value, is_smooth, 17, moved)


def with_control(result, patterns=NO_PATTERNS, strain=None):
    """The result as if this had been found in its control, nothing else asked yet."""
    settings = Settings(method=result.settings.method, tolerance=1.0)
    fresh = replace(changed(result, settings=settings), compares_methods=False)
    for examined in (fresh.examination, fresh.examination.two_step):
        vars(examined).update(control_patterns=patterns, strain=strain)
    return fresh


@pytest.fixture(params=["two_step", "simultaneous"])
def result(request):
    names = {"two_step": "good_result", "simultaneous": "simultaneous_result"}
    return request.getfixturevalue(names[request.param])


def agreed(result):
    """Whether the plan of a result is a bound, as all say that tell it."""
    found, checked = result.assessment, result.examination.checked
    is_bound = found.credible.is_lower_bound
    headline = verdict(found).partition(";")[0]
    assert ("or worse" in headline) is is_bound
    assert found.claim_is_supported is not is_bound
    assert checked.is_supported is not is_bound
    good = result.points.loc[~result.points["is_suspect"], "is_within_tolerance"]
    assert good.any() == (not is_bound)
    is_grave = any(each.gravity is Gravity.GRAVE for each in found.findings)
    assert is_bound or not is_grave
    return is_bound


def codes(result):
    return [found.code for found in result.assessment.findings]


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("kind", [Kind.STEP, Kind.BEND, None])
def test_a_pattern_of_control_refutes_whatever_it_moves(result, kind, share):
    """Also one that moves points by less than chance in single points may."""
    moved = share * result.figures.mean_total
    names = result.block.control_points["point_id"].tolist()[:5]
    told = with_control(result, in_plan(kind, names, moved))
    is_unnamed = kind is None
    code = "contradicting_control" if is_unnamed else "broken_network"
    is_there = share > 0.0 or not is_unnamed
    assert (code in codes(told)) is is_there
    assert agreed(told) is is_there
    if is_there:
        assert told.assessment.credible.value >= result.figures.mean_total


@pytest.mark.parametrize("share", SHARES)
def test_a_single_point_of_control_refutes_where_it_matters(good_result, share):
    moved = share * good_result.figures.mean_total
    names = good_result.block.control_points["point_id"].tolist()[:1]
    told = with_control(good_result, in_plan(Kind.POINT, names, moved))
    assert agreed(told) is (share > 0.75)


@pytest.mark.parametrize("is_smooth", [True, False])
@pytest.mark.parametrize("share", SHARES[1:])
def test_a_strain_of_control_refutes_whatever_its_size(result, share, is_smooth):
    size = share * result.figures.mean_total
    names = result.block.control_points["point_id"].to_numpy()
    strain = strain_of(size, NO_CHANCE, names, is_smooth=is_smooth)
    told = with_control(result, strain=strain)
    code = "strained_network" if is_smooth else "contradicting_control"
    assert code in codes(told)
    assert agreed(told)
    by_chance = replace(strain, p_value=CHANCE)
    assert not agreed(with_control(result, strain=by_chance))


@pytest.mark.parametrize("share", SHARES[1:])
@pytest.mark.parametrize("kind", [Kind.STEP, Kind.GROUP, Kind.BEND, Kind.SCALE, None])
def test_a_pattern_of_heights_refutes_them_whatever_it_moves(
    spatial_result, kind, share
):
    stated = spatial_result.examination.stated_height
    names = spatial_result.block.control_points["point_id"].tolist()[:5]
    told = with_control(spatial_result, in_height(kind, names, share * stated))
    found = told.assessment
    assert found.credible_heights.is_lower_bound
    assert "heights" in verdict(found)
    assert found.claim_is_supported is False
    assert found.credible_heights.value > stated
