"""Models that failed or are weak, each with the block that shows it."""

from dataclasses import replace

import pandas as pd
import pytest
from tests.changed_results import changed

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings import models as judges


def with_points(result, **columns):
    """The result with columns of its points replaced by functions of the points."""
    points = result.solution.points.copy()
    for name, change in columns.items():
        points[name] = change(points)
    return changed(result, points=points).examination


def with_models(result, change):
    models = result.models.copy()
    change(models)
    return changed(result, models=models).examination


def test_failed_models_are_counted_by_reason(faulty_result):
    facts = judges.failed_models(faulty_result.examination).facts
    assert (facts["n_failed"], facts["n_models"], facts["n_reasons"]) == (3, 30, 2)
    first = facts["reasons"][0]
    assert (first["flight"], first["n_models"]) == ("low_flight", 2)
    assert first["models"] == ("1/1", "1/2")
    assert first["reason"]


def test_facts_stay_small_where_much_failed(good_result):
    rows = [
        ("low_flight", "1", f"{k}", "stage3_model_transformation", f"reason {k % 99}")
        for k in range(5000)
    ]
    columns = list(good_result.failures.columns)
    failures = pd.DataFrame([(*row, "") for row in rows], columns=columns)
    found = judges.failed_models(changed(good_result, failures=failures).examination)
    assert found.observed == 5000.0
    assert found.facts["n_reasons"] == 99
    assert len(found.facts["reasons"]) == judges.MOST_REASONS
    assert sum(len(reason["models"]) for reason in found.facts["reasons"]) <= 200
    assert len(found.names) == 100


def test_measured_points_without_coordinates_are_named(good_result):
    lost = changed(good_result, points=good_result.points.iloc[2:]).examination
    found = judges.points_without_coordinates(lost)
    assert found.names == tuple(good_result.points["point_id"][:2])
    assert found.facts == {"n_points": 2}
    assert judges.points_without_coordinates(good_result.examination) is None


def test_models_with_large_m_0_are_named(good_result):
    def enlarge(models):
        models.loc[models.index[-1], "m_0"] = 5.0

    found = judges.models_with_large_m_0(with_models(good_result, enlarge))
    name = good_result.models["model_id"].iloc[-1]
    assert found.facts["models"] == (("low_flight", name),)
    assert found.observed == found.facts["largest_m_0"] == 5.0
    assert found.observed > judges.LARGE_M_0 * found.expected > 0.0
    assert judges.models_with_large_m_0(good_result.examination) is None


def test_mirrored_models_are_told_apart_from_mirrored_axes(good_result):
    def mirror_one(models):
        models.loc[models.index[0], ["a1", "b1"]] *= -1.0

    def mirror_all(models):
        models[["a1", "b1"]] *= -1.0

    one = judges.mirrored_models(with_models(good_result, mirror_one))
    assert one.code == "mirrored_models"
    assert (one.facts["n_mirrored"], one.facts["n_affine"]) == (1, 30)
    assert one.facts["models"][0][0] == "high_flight"
    everyone = judges.mirrored_models(with_models(good_result, mirror_all))
    assert everyone.code == "all_models_mirrored"
    assert everyone.gravity is Gravity.NOTE
    assert everyone.facts["n_mirrored"] == everyone.facts["n_affine"] == 30
    assert judges.mirrored_models(good_result.examination) is None


def test_points_in_one_coverage_or_model(good_result):
    is_first = good_result.points.index < 3
    weak = with_points(
        good_result,
        n_coverages=lambda p: p["n_coverages"].where(~is_first, 1),
        n_models=lambda p: p["n_models"].where(p.index != 0, 1),
    )
    found = judges.points_in_one_coverage(weak)
    assert found.names == tuple(good_result.points["point_id"][:3])
    assert found.facts == {"n_points": 3, "n_in_one_model": 1}
    assert judges.points_in_one_model(weak) is None


def test_in_a_flight_of_one_coverage_only_single_models_count(good_result):
    low = good_result.block.low_flight
    one = low.model_points[low.model_points["coverage"] == "1"]
    block = replace(good_result.block, low_flight=replace(low, model_points=one))
    weak = with_points(
        changed(good_result, block=block),
        n_coverages=lambda p: p["n_coverages"].clip(upper=1),
        n_models=lambda p: p["n_models"].clip(lower=2).where(p.index != 0, 1),
    )
    found = judges.points_in_one_model(weak)
    assert found.names == (good_result.points["point_id"].iloc[0],)
    assert found.facts == {"n_points": 1}
    assert judges.points_in_one_coverage(weak) is None


def test_models_without_redundancy_are_named(good_result):
    def exhaust(models):
        models.loc[models.index[-1], "redundancy"] = 0

    found = judges.models_without_redundancy(with_models(good_result, exhaust))
    assert found.facts["n_models"] == 1
    assert found.facts["models"][0][0] == "low_flight"
    assert judges.models_without_redundancy(good_result.examination) is None


@pytest.mark.parametrize("judge", judges.TWO_STEP)
def test_a_good_block_has_none(good_result, judge):
    assert judge(good_result.examination) is None
