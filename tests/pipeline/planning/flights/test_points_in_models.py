"""Too few points in models: the advice has numbers that are enough, and no more."""

import re
from dataclasses import replace

import numpy as np
import pytest

from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.points_in_models import downwards, upwards
from einschalt.pipeline.planning.tables.precision_table import plan_precision

UAV = CAMERAS["uav_one_inch"]
CHOICES = PlanChoices(
    scale_number=(2000, 4500), spacing=(60, 100), m_g_um=(1,), high_over_low=(1.25, 2)
)
FRAME = PlanFrame(
    image_format=UAV.image_format,
    principal_distance=UAV.principal_distance,
    forward_overlap=0.8,
    side_overlap=0.6,
)


def refused(call, *given):
    with pytest.raises(GeometryError) as caught:
        call(*given)
    return caught.value


def numbers_in(text):
    return [float(number) for number in re.findall(r"(?<![:\d])\d+(?:\.\d+)?", text)]


def table(scales, spacings):
    return plan_precision(scales, spacings, 0.1, 10)


@pytest.mark.parametrize("spacing", [300, 180])
def test_a_table_names_both_ways_out(spacing):
    """180 m lie within a model, but too few of them."""
    error = refused(table, [1200, 8000], [50, spacing])
    scale, smaller = re.search(
        r"scale numbers of at least (\d+), or for 1:1200 spacings of at most (\S+) m",
        error.remedy,
    ).groups()
    assert f"For {spacing} m" in error.remedy
    assert len(table([int(scale), 8000], [50, spacing])) == 4
    assert len(table([1200, 8000], [50, float(smaller)])) == 4


def test_no_spacing_is_advised_that_is_refused():
    assert "spacings of at most" not in refused(table_of_uav, 100, 0.9).remedy
    assert "spacings of at most 6.9 m" in refused(table, [100], [50]).remedy


def test_no_scale_number_is_advised_that_is_refused():
    """Narrow models would hold the points at 1:790000."""
    narrow = {"forward_overlap": 0.95, "side_overlap": 0.9}
    error = refused(lambda: plan_precision(100_000, 9000, 0.1, 10, **narrow))
    assert error.remedy == "For 1:100000 give spacings of at most 1100 m"


def table_of_uav(scale, spacing):
    given = {"image_format": UAV.image_format, "side_overlap": 0.6}
    return plan_precision(scale, spacing, 0.1, 10, **given)


def test_a_search_says_how_far_both_ways_lead():
    error = refused(find_plans, 0.5, CHOICES, FRAME)
    spacing, scale = numbers_in(error.remedy)
    assert error.remedy == (
        f"Give spacings of at most {spacing:g} m, or scale numbers of at least "
        f"{scale:g}"
    )
    assert len(found(spacing=(spacing,))) > 0
    assert len(found(scale_number=(scale,))) > 0
    # and not much farther than needed
    refused(found_with, {"spacing": (1.1 * spacing,)})
    refused(found_with, {"scale_number": (0.9 * scale,)})


def found(frame=FRAME, **changes):
    # control is allowed for whatever part of the points it takes
    return find_plans(0.5, replace(CHOICES, **changes), frame).plans


def found_with(changes):
    return found(**changes)


@pytest.fixture(autouse=True)
def _much_control(monkeypatch):
    module = "einschalt.pipeline.planning.estimate.work.MOST_ON_THE_GROUND"
    monkeypatch.setattr(module, 1e9)


def test_scales_that_a_limit_of_height_forbids_are_not_advised():
    low = replace(FRAME, max_height=60.0)
    error = refused(find_plans, 0.5, CHOICES, low)
    spacing, scale, height = numbers_in(error.remedy)
    assert error.remedy.startswith(f"Give spacings of at most {spacing:g} m: ")
    assert "flown too high for --max-height" in error.remedy
    assert len(found(low, spacing=(spacing,))) > 0
    assert len(found(replace(low, max_height=height), scale_number=(scale,))) > 0


def test_what_is_low_enough_must_have_points_enough():
    low = replace(FRAME, max_height=30.0)
    # points enough, but the lowest high flight is at 22 m
    error = refused(lambda: found(low_with(20.0), spacing=(1.0,)))
    scale, height = numbers_in(error.remedy)
    assert "or a --max-height of at least" in error.remedy
    assert len(found(low_with(20.0), spacing=(1.0,), scale_number=(scale,))) > 0
    assert len(found(low_with(height), spacing=(1.0,))) > 0
    # too few points below the limit
    error = refused(lambda: found(low_with(20.0), spacing=(60.0,)))
    scale, spacing = numbers_in(error.remedy)
    assert "--max-height" not in error.remedy
    changes = {"spacing": (spacing,), "scale_number": (scale,)}
    assert len(found(low_with(20.0), **changes)) > 0
    assert len(found(low, spacing=(5.0,))) > 0


def low_with(max_height):
    return replace(FRAME, max_height=max_height)


def test_too_much_control_is_told_with_the_spacing_that_helps(monkeypatch):
    module = "einschalt.pipeline.planning.estimate.work.MOST_ON_THE_GROUND"
    monkeypatch.setattr(module, 0.5)
    error = refused(lambda: found(spacing=(10.0,), scale_number=(4500,)))
    (spacing,) = numbers_in(error.remedy)
    assert "less than 50 %" in error.expected
    assert "larger scale numbers of the high flight" in error.remedy
    assert len(found(spacing=(spacing,), scale_number=(4500,))) > 0
    low = refused(lambda: found(low_with(60.0), spacing=(10.0,), scale_number=(4500,)))
    assert "which cannot be larger below --max-height" in low.remedy


def test_an_area_is_named_over_which_control_is_shared(monkeypatch):
    """A drone whose images overlap much, below 120 m."""
    module = "einschalt.pipeline.planning.estimate.work.MOST_ON_THE_GROUND"
    monkeypatch.setattr(module, 0.5)
    camera = CAMERAS["uav_full_frame"]
    names = ("image_format", "principal_distance", "forward_overlap", "side_overlap")
    frame = PlanFrame(max_height=120.0, **{n: getattr(camera, n) for n in names})
    choices = replace(CHOICES, spacing=(18.0,), scale_number=camera.scale_numbers)
    error = refused(find_plans, 0.02, choices, frame)
    assert "at the corners and in the middle of each model" in error.found
    assert error.remedy.startswith("Give the area (--area)")
    assert len(find_plans(0.02, choices, replace(frame, shares_control=True)).plans)
    # nothing of it where over an area it would be as much
    closer = replace(frame, shares_control=True)
    apart = replace(choices, spacing=(70.0,))
    error = refused(find_plans, 0.02, apart, closer)
    assert "--area" not in error.remedy


def test_limits_are_rounded_to_their_safe_side():
    assert [downwards(value) for value in (6.99, 1299.0, 0.0678)] == [
        *("6.9", "1200", "0.067"),
    ]
    assert [upwards(value) for value in (6.91, 1201.0, 60.0)] == ["7.0", "1300", "60"]


@pytest.mark.parametrize("spacing", [497, 560, 600, 680])
def test_points_in_a_model_are_fewer_than_the_expected(spacing):
    """Of those that are low enough and determined: others have 9 points, and 8.96."""
    choices = PlanChoices(
        scale_number=(4000, 8000),
        spacing=(spacing,),
        m_g_um=(5,),
        high_over_low=(1.25, 3.0),
        control_per_model=(9,),
    )
    error = refused(find_plans, 0.5, choices, PlanFrame(max_height=0.152 * 12_100))
    most, wanted = numbers_in(error.found), numbers_in(error.expected)
    assert wanted == [9.0]
    assert 0.5 < most[0] < 9.0
    (nearer, *_) = numbers_in(error.remedy)
    again = replace(choices, spacing=(nearer,))
    assert len(find_plans(0.5, again, PlanFrame(max_height=0.152 * 12_100)).plans) > 0


WHAT_HELPS = {
    "spacing": r"spacings of at most ([\d.]+) m",
    "scale_number": r"scale numbers of at most ([\d.]+)",
    "larger": r"(?:or|Give) scale numbers of at least ([\d.]+)",
    "max_height": r"--max-height of at least ([\d.]+) m",
}


def test_whatever_is_advised_finds_plans(monkeypatch):
    """Nothing is named that is then refused for too much control, or too few points."""
    module = "einschalt.pipeline.planning.estimate.work.MOST_ON_THE_GROUND"
    monkeypatch.setattr(module, 0.5)
    rng = np.random.default_rng(11)
    n_followed = 0
    for name in (*CAMERAS, *CAMERAS, *CAMERAS):
        camera = CAMERAS[name]
        frame = PlanFrame(
            image_format=camera.image_format,
            principal_distance=camera.principal_distance,
            forward_overlap=camera.forward_overlap,
            side_overlap=camera.side_overlap,
            max_height=rng.choice([None, 60.0, 120.0, 500.0, 1500.0]),
            shares_control=bool(rng.random() < 0.5),
        )
        choices = PlanChoices(
            scale_number=tuple(np.array(camera.scale_numbers) * rng.uniform(0.6, 1.6)),
            spacing=(max(camera.spacings) * rng.choice([1.0, 2.0, 4.0, 8.0]),),
            m_g_um=camera.m_g_um[:1],
        )
        for changed, below in _advised(choices, frame):
            n_followed += 1
            assert len(find_plans(0.5, changed, below).plans) > 0
    assert n_followed > 20


def _advised(choices, frame):
    """Choices and frames that a refusal names instead."""
    try:
        find_plans(0.5, choices, frame)
    except GeometryError as error:
        found = {n: re.search(text, error.remedy) for n, text in WHAT_HELPS.items()}
    else:
        return
    said = {name: float(one[1]) for name, one in found.items() if one}
    at_once = {n: (said[n],) for n in ("spacing", "scale_number") if n in said}
    if at_once:
        yield replace(choices, **at_once), frame
    if "larger" in said:
        yield replace(choices, scale_number=(said["larger"],)), frame
    if "max_height" in said:
        yield choices, replace(frame, max_height=said["max_height"])


def test_no_height_is_advised_that_is_refused():
    """Cameras that would have to fly above what planes reach."""
    high = replace(CHOICES, scale_number=(150_000,), spacing=(300,))
    error = refused(lambda: found_below(500.0, high))
    assert "--max-height of at least" not in error.remedy


def found_below(max_height, choices):
    frame = replace(FRAME, principal_distance=0.152, max_height=max_height)
    return find_plans(0.5, choices, frame).plans
