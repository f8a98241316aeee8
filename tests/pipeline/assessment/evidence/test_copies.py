"""Measurements that were given twice, and coverages that agree too well."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.evidence.claim import (
    COVERAGES,
    RESIDUALS,
    Claim,
    ClaimTest,
)
from einschalt.pipeline.assessment.evidence.copies import find_copies, may_repeat
from einschalt.pipeline.densify import densify

METHODS = ("two_step", "simultaneous")


def with_low(block, points):
    return replace(block, low_flight=replace(block.low_flight, model_points=points))


@pytest.fixture(scope="module")
def copied_block(demo_block):
    """Coverage 2 of the low flight is a copy of coverage 1."""
    points = demo_block.low_flight.model_points
    first = points[points["coverage"] == "1"]
    return with_low(demo_block, pd.concat([first, first.assign(coverage="2")]))


@pytest.mark.parametrize("method", METHODS)
def test_a_coverage_that_is_a_copy(copied_block, method):
    result = densify(copied_block, copied_block.settings.updated({"method": method}))
    copies = result.examination.copies
    n_models = copied_block.low_flight.model_points["model_id"].nunique()
    assert len(copies.pairs) == n_models
    assert all(pair.n_equal == pair.n_common for pair in copies.pairs)
    assert copies.enlargement == pytest.approx(np.sqrt(2.0))
    credible = result.assessment.credible
    assert credible.is_lower_bound
    assert credible.value >= np.sqrt(2.0) * result.figures.mean_total * 0.999
    shown = {f.code for f in result.assessment.findings if not f.explained_by}
    assert "measurements_given_twice" in shown
    # m_g is not to be lowered because of it
    assert "wrong_measuring_errors" not in shown
    summary = " ".join(result.summary().split())
    assert "have identical coordinates to the last digit" in summary


def test_photographs_that_are_copies(image_block):
    flight = image_block.low_flight
    images = flight.image_points
    one, other = flight.models.iloc[0][["left_image", "right_image"]]
    held = images[images["image_id"] == one]
    copy = held.assign(image_id=other)
    points = pd.concat([images[images["image_id"] != other], copy])
    low = replace(flight, image_points=points)

    class Examined:
        block = replace(image_block, low_flight=low)

    (pair,) = find_copies(Examined).pairs
    assert {pair.first[2], pair.second[2]} == {one, other}
    assert pair.n_equal == pair.n_common == len(held)


def test_clean_blocks_have_no_copies(good_result, spatial_result):
    for result in (good_result, spatial_result):
        assert result.examination.copies.pairs == ()
        assert result.examination.copies.enlargement == 1.0


def test_a_few_equal_coordinates_are_no_copy(demo_block):
    """Coordinates of few digits are equal by chance."""
    points = demo_block.low_flight.model_points.copy()
    first = points[points["coverage"] == "1"].drop_duplicates("point_id")
    twin = points[points["coverage"] == "2"].drop_duplicates("point_id")
    both = first.merge(twin, on="point_id", suffixes=("", "_2")).iloc[0]
    row = points.index[
        (points["coverage"] == "2")
        & (points["model_id"] == both["model_id_2"])
        & (points["point_id"] == both["point_id"])
    ]
    points.loc[row, ["x", "y"]] = both[["x", "y"]].to_numpy(dtype=float)

    class Examined:
        block = with_low(demo_block, points)

    assert find_copies(Examined).pairs == ()


def test_coverages_that_agree_too_well(demo_block, good_result):
    """m_g three times too large: nothing is wrong with the points, but it is told."""
    flights = {
        name: replace(flight, m_g_um=3.0 * flight.m_g_um)
        for name, flight in demo_block.flights.items()
    }
    result = densify(replace(demo_block, **flights))
    found = next(
        f for f in result.assessment.findings if f.code.startswith("coverages_that_a")
    )
    assert found.observed < 0.5 * found.expected
    assert found.probability < 0.01
    assert result.claim.is_supported
    assert "Coverages agree better than" in " ".join(result.summary().split())
    codes = {f.code for f in good_result.assessment.findings}
    assert "coverages_that_agree_too_well" not in codes


def test_only_differences_of_what_was_measured_apart_can_be_too_small():
    tests = tuple(
        ClaimTest(name, 50, 0.01, 0.05, 1.0 - 1e-9) for name in (COVERAGES, RESIDUALS)
    )
    claim = Claim(tests, None)
    assert claim.too_small == tests[:1]
    assert claim.is_supported
    unknown = replace(tests[0], p_value=np.nan)
    assert Claim((unknown,), None).too_small == ()


def test_equal_coordinates_are_seen_by_their_bits():
    xy = np.random.default_rng(1).random((5000, 2)).round(3)
    lone = np.unique(xy, axis=0)
    assert not may_repeat([lone[:700], lone[700:]])
    assert may_repeat([lone, lone[[77]]])
    assert may_repeat([np.array([[0.0, 1.0]]), np.array([[-0.0, 1.0]])])
    assert may_repeat([np.array([[np.nan, 1.0]])])  # rows with names tell
    assert not may_repeat([np.array([[1.0, 2.0], [2.0, 1.0]]), np.empty((0, 2))])
