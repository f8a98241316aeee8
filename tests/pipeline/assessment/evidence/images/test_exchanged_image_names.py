"""Names that were exchanged in one photograph."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.assessment.evidence.images.exchanged_image_names import (
    find_exchanged_image_names,
    with_exchanged_names,
)
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.stages.stage2_relative_orientation import image_pairs

GEOMETRY = replace(PRESETS["demo"].geometry, measurement="images")


@pytest.fixture(scope="module")
def block():
    return simulate_block("demo", seed=15, geometry=GEOMETRY)


def exchanged(block, flight, image, pair):
    """A block with two names exchanged in a photograph."""
    measured = getattr(block, flight)
    points = measured.image_points.copy()
    names = points["point_id"]
    is_its = (points["image_id"] == image) & names.isin(pair)
    one, other = pair
    points["point_id"] = names.where(~is_its, names.map({one: other, other: one}))
    return replace(block, **{flight: replace(measured, image_points=points)})


def common_points(flight, place):
    """Both photographs of a model, and the names of the points that they share."""
    model = flight.models.iloc[[place]]
    points = image_pairs(flight.image_coordinates(), model)["point_id"]
    return tuple(model[["left_image", "right_image"]].iloc[0]), sorted(points)


@pytest.mark.slow
def test_clean_photographs_have_no_exchanged_names(block):
    assert find_exchanged_image_names(densify(block).examination) == ()


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_the_pair_and_its_photograph_are_named_as_the_cause(block, outliers):
    """Wrong control and m_g stood there, or points that contradict, one by one."""
    middle = len(block.low_flight.models) // 2
    images, names = common_points(block.low_flight, middle)
    pair = (names[2], names[-3])
    spoilt = exchanged(block, "low_flight", images[0], pair)
    result = densify(spoilt, spoilt.settings.updated({"outliers": outliers}))
    judged = result.assessment
    found = judged.findings[0]
    assert found.code == "exchanged_image_names"
    assert set(found.names) == set(pair)
    assert found.observed > 5.0 * found.expected
    (exchange,) = found.facts["exchanges"]
    assert images[0] in exchange["images"]
    assert judged.causes == ("exchanged_image_names",)
    is_in = exchange["takes_part"]
    assert found.gravity is (Gravity.GRAVE if is_in else Gravity.WARNING)
    if is_in:
        assert judged.claim_is_supported is not True
    others = [f for f in judged.findings if f.gravity is Gravity.GRAVE and f != found]
    assert {f.explained_by for f in others} <= {"exchanged_image_names"}


@pytest.mark.slow
def test_the_neighbour_tells_the_photograph(block):
    """A pair in both models of a photograph: in either, both orientations are bad."""
    flight = block.high_flight
    held = [
        (common_points(flight, k), common_points(flight, k + 1))
        for k in range(len(flight.models) - 1)
    ]
    images, pair = next(
        (one[0], shared[:2])
        for one, other in held
        if one[0][1] == other[0][0]
        and len(shared := sorted(set(one[1]) & set(other[1]))) > 1
    )
    spoilt = exchanged(block, "high_flight", images[1], pair)
    (found,) = find_exchanged_image_names(densify(spoilt).examination)
    assert found.images == (images[1],)
    assert set(found.points) == set(pair)
    assert len(found.models) > 1


@pytest.mark.slow
def test_a_gross_error_of_one_image_point_is_no_exchange(block):
    measured = block.low_flight
    points = measured.image_points.copy()
    images, names = common_points(measured, len(measured.models) // 2)
    row = points.index[
        (points["image_id"] == images[0]) & (points["point_id"] == names[3])
    ]
    points.loc[row, "y"] += np.array([3.0])
    spoilt = replace(block, low_flight=replace(measured, image_points=points))
    assert find_exchanged_image_names(densify(spoilt).examination) == ()


@pytest.fixture(scope="module")
def with_names_far_apart():
    """Two names exchanged in a photograph, as one adjustment and two steps see it."""
    clean = simulate_block("demo", seed=7300, geometry=GEOMETRY)
    spoilt = exchanged(clean, "low_flight", "1/2/4", ("1046", "1029"))
    return densify(spoilt, spoilt.settings.updated({"method": "simultaneous"}))


@pytest.mark.slow
def test_one_adjustment_is_told_by_the_names_first(with_names_far_apart):
    """It did not converge before second derivatives were counted."""
    result = with_names_far_apart
    assert result.assessment.causes[0] == "exchanged_image_names"
    head, *_, first = result.summary().splitlines()[:4]
    assert head.endswith("correct the exchanged names first")
    assert "1046 and 1029 in photograph 1/2/4" in first
    both = result.points.merge(result.block.truth, on="point_id", suffixes=("", "_t"))
    new = both[both["role"] == "new"]
    off = [new[axis] - new[f"{axis}_t"] for axis in ("easting", "northing")]
    true = np.sqrt(np.mean(np.hypot(*off) ** 2))
    assert result.assessment.credible.value == pytest.approx(true, rel=0.2)
    # and they pass for no bends of photographs
    assert result.solution.adjustment.deformations["own_p_value"].isna().all()


@pytest.mark.slow
def test_an_adjustment_that_is_refused_names_them(with_names_far_apart):
    flights = with_names_far_apart.examination.two_step.solution.flights
    error = GeometryError("does not converge", expected="models", remedy="Look")
    told = with_exchanged_names(error, with_names_far_apart.block, flights)
    assert isinstance(told, GeometryError)
    assert "1029, 1046 (1/2/4)" in str(told) or "1046, 1029 (1/2/4)" in str(told)
