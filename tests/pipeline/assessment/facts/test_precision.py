"""Figures of precision, beside those that follow from the table of points."""

import numpy as np
import pytest

from einschalt.pipeline.assessment.facts.precision import (
    Carried,
    Shared,
    Unstated,
    simultaneous_precision,
    two_step_precision,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings


def rms_of_new(points, name):
    return np.sqrt(np.mean(points.loc[points["role"] == "new", name] ** 2))


@pytest.mark.parametrize("name", ["good", "faulty", "unchecked"])
def test_figures_of_two_steps_are_those_of_the_new_points(name, request):
    result = request.getfixturevalue(f"{name}_result")
    facts, points = two_step_precision(result.examination), result.points
    total = rms_of_new(points, "standard_error_total")
    assert facts.mean.total == pytest.approx(total)
    paper = rms_of_new(points, "standard_error_paper")
    assert facts.mean.paper == pytest.approx(paper)
    assert facts.n_new == (points["role"] == "new").sum()
    assert facts.n_coverages == points["n_coverages"].max() == 2
    assert np.isnan(facts.single.total)
    assert facts.carried is Carried.MEASUREMENTS
    assert facts.shared is Shared.HIGH_FLIGHT
    assert facts.heights is None


def test_given_approximations_propagate_nothing(given_approximations_result):
    facts = two_step_precision(given_approximations_result.examination)
    assert np.isnan(facts.mean.total)
    assert facts.carried is None
    assert facts.shared is Shared.NEIGHBOURS_GIVEN


def test_errors_of_orientations_are_carried_too(parallaxes_result):
    facts = two_step_precision(parallaxes_result.examination)
    assert facts.carried is Carried.ORIENTATIONS


def test_one_adjustment_beside_two_steps(good_result, simultaneous_result):
    facts = simultaneous_precision(simultaneous_result.examination)
    points = simultaneous_result.points
    total = rms_of_new(points, "standard_error_total")
    assert facts.total == pytest.approx(total)
    both = points.merge(good_result.points, on="point_id", suffixes=("", "_two"))
    apart = np.hypot(
        both["easting"] - both["easting_two"], both["northing"] - both["northing_two"]
    )
    assert facts.comparison.rms == pytest.approx(np.sqrt(np.mean(apart**2)))
    assert facts.comparison.largest == pytest.approx(apart.max())
    assert facts.comparison.worst == both["point_id"][apart.idxmax()]
    beside = two_step_precision(good_result.examination)
    assert facts.two_steps == beside.mean
    assert facts.s_0 == pytest.approx(1.0, abs=0.2)
    assert facts.estimated is None
    assert (facts.heights, facts.height_errors, facts.n_centres) == (None, (), 0)
    assert facts.unstated == ""


def test_why_there_are_no_standard_errors_is_said(demo_block):
    settings = Settings(
        method="simultaneous", residual_distribution="natural_neighbour"
    )
    facts = simultaneous_precision(densify(demo_block, settings).examination)
    assert np.isnan(facts.total)
    assert facts.unstated == Unstated.MOVED


def test_estimated_groups_have_their_sizes(demo_block):
    settings = Settings(method="simultaneous", variance_components="estimated")
    result = densify(demo_block, settings)
    facts = simultaneous_precision(result.examination)
    table = result.simultaneous.components.set_index("group")
    assert facts.estimated
    for group, size in facts.estimated:
        assert table.loc[group, "is_estimated"]
        assert size == table.loc[group, "standard_error_m"]
    # 5 µm at 1:8000, total: of one coordinate less by √2
    low = dict(facts.estimated)["low_flight"]
    assert low == pytest.approx(0.04 / np.sqrt(2.0), rel=0.15)
