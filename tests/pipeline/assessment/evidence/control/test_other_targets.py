"""Points for which two flights have measured different targets."""

from dataclasses import replace

import numpy as np
import pytest
from tests.changed_results import changed
from tests.judged_alone import judged_alone

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

pytestmark = pytest.mark.slow

MM = 1000.0


def with_another_target(block, flight, name, metres=1.0):
    """A point a metre off in all models of a flight."""
    measured = getattr(block, flight)
    points = measured.model_points.copy()
    is_it = points["point_id"] == name
    points.loc[is_it, "x"] += metres * MM / measured.scale_number
    return replace(block, **{flight: replace(measured, model_points=points)})


def point_of(block, role):
    """A point that many models of both flights hold."""
    control = block.control_points
    known = control.loc[control["role"] == "control", "point_id"]
    counts = [f.model_points["point_id"].value_counts() for f in block.flights.values()]
    least = np.minimum(*(counts[0].align(counts[1], fill_value=0)))
    is_wanted = least.index.isin(known)
    if role == "new":
        is_wanted = ~least.index.isin(control["point_id"])
    return least[is_wanted].sort_index().idxmax()


@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
@pytest.mark.parametrize("flight", ["low_flight", "high_flight"])
@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_a_new_point_is_named_and_the_flight_left_open(
    demo_block, method, flight, outliers
):
    name = point_of(demo_block, "new")
    block = with_another_target(demo_block, flight, name)
    result = densify(block, Settings(method=method, outliers=outliers))
    first, *others = result.assessment.findings
    assert first.code == "other_targets"
    assert first.names == (name,)
    assert first.facts["flight"] == ""
    assert first.observed == pytest.approx(1.0, abs=0.3)
    assert result.assessment.claim_is_supported is False
    grave = [f.code for f in others if f.gravity.name == "GRAVE" and not f.explained_by]
    assert not grave
    assert "nothing tells which" in " ".join(result.summary().split())


@pytest.mark.parametrize("flight", ["low_flight", "high_flight"])
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_given_coordinates_tell_which_flight_it_is(demo_block, flight, method):
    """Models of the high flight are drawn to given coordinates that they miss."""
    name = point_of(demo_block, "control")
    block = with_another_target(demo_block, flight, name)
    result = densify(block, block.settings.updated({"method": method}))
    first = result.assessment.findings[0]
    assert (first.code, first.names) == ("other_targets", (name,))
    assert first.facts["flight"] == flight
    assert first.observed == pytest.approx(1.0, abs=0.3)
    words = f"the {flight.replace('_', ' ')} measured another target"
    assert words in " ".join(result.summary().split())
    assert result.assessment.causes == ("other_targets",)
    # neither the control point nor its neighbours are blamed
    alone = [f.code for f in result.assessment.findings if not f.explained_by]
    assert not {"control_that_contradicts", "control_points_beyond_claim"} & set(alone)


def test_a_point_that_one_flight_alone_has_is_no_other_target(demo_block):
    """As those that further passes give approximate coordinates: an IndexError once."""
    name = point_of(demo_block, "new")
    result = densify(with_another_target(demo_block, "low_flight", name))
    assert [each.point_id for each in result.examination.other_targets] == [name]
    there = result.approximations
    without = changed(result, approximations=there[there["point_id"] != name])
    assert without.examination.other_targets == ()


def test_clean_blocks_have_none(demo_block, good_result, given_approximations_result):
    assert good_result.examination.other_targets == ()
    assert given_approximations_result.examination.other_targets == ()


def test_wrong_given_coordinates_are_no_other_target(demo_block):
    name = point_of(demo_block, "control")
    control = demo_block.control_points.copy()
    control.loc[control["point_id"] == name, "easting"] += 1.0
    result = densify(replace(demo_block, control_points=control))
    assert "other_targets" not in judged_alone(result)
