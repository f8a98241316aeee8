"""One blunder in a clean block: named as the cause, or covered by the headline."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.foundations.errors import ConsistencyError
from einschalt.pipeline.assessment.evidence.ground.frame import Doubt
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

PLAN = ["easting", "northing"]
FEET = 0.3048
METHODS = ("two_step", "simultaneous")


def shifted_names(control):
    return control.assign(point_id=np.roll(control["point_id"].to_numpy(), 1))


def in_feet(control):
    return control.assign(**{axis: control[axis] / FEET for axis in PLAN})


def mirrored(control):
    return control.assign(easting=-control["easting"])


def exchanged_axes(control):
    east, north = (control[axis].to_numpy() for axis in PLAN)
    return control.assign(easting=north, northing=east)


def with_a_thousands_point(control):
    """326.802 for 326 802."""
    return control.assign(northing=control["northing"] / 1000.0)


def with_an_axis_of_one_per_cent(control):
    return control.assign(northing=1.01 * control["northing"])


def in_the_neighbouring_strip(control):
    return control.assign(easting=control["easting"] + 223_000.0)


def with_control(block, change, **facts):
    return replace(block, control_points=change(block.control_points.copy()), **facts)


def with_exchanged_names(block, share=0.05, seed=0):
    """One in twenty names of the low flight exchanged within its model."""
    rng = np.random.default_rng(seed)
    points = block.low_flight.model_points.copy()
    names = points["point_id"].to_numpy(copy=True)
    for rows in points.groupby(["coverage", "model_id"]).indices.values():
        for _ in range(rng.binomial(len(rows), share / 2.0)):
            pair = rng.choice(rows, 2, replace=False)
            names[pair] = names[pair[::-1]]
    low = replace(block.low_flight, model_points=points.assign(point_id=names))
    return replace(block, low_flight=low)


def true_error(result):
    """TOTAL error of the new points, RMS [m]."""
    new = result.points[result.points["role"] == "new"]
    truth = result.block.truth.set_index("point_id").loc[new["point_id"], PLAN]
    miss = new[PLAN].to_numpy() - truth.to_numpy()
    return float(np.sqrt(np.mean(np.sum(miss**2, axis=1))))


def assert_told(result):
    """What is told never signs for less than half of the true error."""
    judged = result.assessment
    assert not judged.claim_is_supported
    assert judged.credible.is_lower_bound
    assert "or worse" in result.summary().splitlines()[0]
    new = result.points[result.points["role"] == "new"]
    checked = np.sqrt(np.mean(new["standard_error_checked"] ** 2))
    assert checked > 0.99 * judged.credible.value


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("spoil", [shifted_names, None])
def test_wrong_names_enlarge_the_headline(demo_block, method, spoil, request):
    if spoil is shifted_names and method == "simultaneous":
        result = request.getfixturevalue("shifted_names_result")
    elif spoil is shifted_names:
        block = with_control(demo_block, spoil)
        result = densify(block, block.settings.updated({"method": method}))
    else:
        block = with_exchanged_names(demo_block)
        result = densify(block, block.settings.updated({"method": method}))
    assert_told(result)
    true = true_error(result)
    assert true > 10.0
    assert result.assessment.credible.value > 0.5 * true
    assert result.points["is_suspect"].any()


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("spoil", "doubt", "said"),
    [
        (in_feet, Doubt.LARGER_THAN_FILM, "control not in metres?"),
        (with_a_thousands_point, Doubt.STRETCHED, "a wrong unit or decimal point?"),
        (with_an_axis_of_one_per_cent, Doubt.STRETCHED, "unit or decimal point?"),
        (mirrored, Doubt.MIRRORED, "easting and northing exchanged?"),
        (exchanged_axes, Doubt.MIRRORED, "easting and northing exchanged?"),
    ],
)
def test_wrong_units_and_axes_are_named(demo_block, method, spoil, doubt, said):
    block = with_control(demo_block, spoil, crs=None)
    result = densify(block, block.settings.updated({"method": method}))
    assert_told(result)
    assert result.assessment.credible.doubt is doubt
    assert result.summary().splitlines()[0].endswith(said)


def test_the_neighbouring_strip_is_refused_where_a_system_tells(demo_block):
    with pytest.raises(ConsistencyError, match="outside the area of use"):
        with_control(demo_block, in_the_neighbouring_strip)


@pytest.mark.parametrize("clean", ["good_result", "simultaneous_result"])
def test_a_clean_block_keeps_its_claim(clean, request):
    result = request.getfixturevalue(clean)
    assert result.assessment.claim_is_supported
    points = result.points
    new = points[points["role"] == "new"]
    checked = np.sqrt(np.mean(new["standard_error_checked"] ** 2))
    assert checked == pytest.approx(result.assessment.credible.value)
    assert "is_within_tolerance" not in points


def test_a_single_wrong_check_point_is_a_suspect(good_result):
    control = good_result.block.control_points.copy()
    check = control.index[control["role"] == "check"][2]
    control.loc[check, "northing"] += 0.5
    result = densify(replace(good_result.block, control_points=control))
    points = result.points.set_index("point_id")
    wrong = control.loc[check, "point_id"]
    assert points.loc[wrong, "is_suspect"]
    assert not good_result.points.set_index("point_id").loc[wrong, "is_suspect"]
    assert points["is_suspect"].sum() == good_result.points["is_suspect"].sum() + 1


@pytest.mark.slow
@pytest.mark.parametrize("has_check_points", [True, False])
def test_check_points_tell_which_of_control_off_alike_is_right(
    demo_block, has_check_points
):
    """Three points 300 m off to the east: 65 m were told of points good to 5 cm."""
    control = demo_block.control_points.copy()
    rows = control.index[control["role"] != "check"][[2, 7, 12]]
    control.loc[rows, "easting"] += 300.0
    if not has_check_points:
        control = control[control["role"] != "check"]
    block = replace(demo_block, control_points=control)
    result = densify(block, Settings(method="simultaneous", outliers="snoop"))
    found, claimed = result.assessment.credible, result.figures.mean_total
    adjusted = result.examination.adjustment.control
    assert adjusted["is_set_aside"].sum() == 3
    if has_check_points:
        assert found.value < 1.5 * claimed
    else:  # nothing tells which part of the network is right
        assert found.is_lower_bound
        assert found.value > 1.0
