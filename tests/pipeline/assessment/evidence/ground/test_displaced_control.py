"""A part of control that is displaced: it is named first, and not single points."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.evidence.ground.given_region import (
    KnownPoints,
    told_region,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.theory.adjustment.displaced_regions import DisplacedRegion

pytestmark = pytest.mark.slow

PLAN = ["easting", "northing"]
SHIFT = np.array([1.2, 0.9])


def simulated(seed=1, transformation="affine"):
    geometry = replace(
        PRESETS["demo"].geometry,
        width=4200.0,
        height=3600.0,
        point_spacing=300.0,
        n_check=10,
        transformation=transformation,
    )
    return simulate_block("demo", seed=seed, geometry=geometry)


def south_west(points):
    return (points[PLAN] < points[PLAN].median()).all(axis=1)


def displaced(block, is_in=south_west):
    """Control and check points of a part off, and the names of this control."""
    control = block.control_points.copy()
    rows = is_in(control).to_numpy()
    control.loc[rows, PLAN] += SHIFT
    is_control = (control["role"] == "control").to_numpy()
    names = [
        set(control.loc[rows & of, "point_id"]) for of in (is_control, ~is_control)
    ]
    return replace(block, control_points=control), *names


def rms(result, truth):
    new = result.points[result.points["role"] == "new"].set_index("point_id")
    miss = new[PLAN] - truth.set_index("point_id").loc[new.index, PLAN]
    return float(np.sqrt(np.mean(np.sum(miss.to_numpy() ** 2, axis=1))))


@pytest.mark.parametrize("transformation", ["affine", "helmert", "helmert_3d"])
def test_a_quarter_is_named_first(transformation):
    block, names, checks = displaced(simulated(transformation=transformation))
    result = densify(block, Settings())
    told, (first, *others) = result.assessment, result.assessment.findings
    assert first.code == "displaced_region"
    assert set(first.names) == names
    assert first.remedy == "correct_control"
    shift = [first.facts[axis] for axis in PLAN]
    assert shift == pytest.approx(SHIFT, abs=4.0 * first.facts["standard_error"])
    assert told.causes[0] == "displaced_region"
    head, *_ = result.summary().splitlines()
    assert "; check the control points in the south-west first" in head
    alone = {found.code for found in others if not found.explained_by}
    assert not {"control_that_contradicts", "broken_network"} & alone
    assert "other_targets" not in {found.code for found in others}
    true = rms(result, block.truth)
    assert told.credible.value == pytest.approx(true, rel=0.1)
    assert told.credible.elsewhere < 0.15
    assert set(first.facts["control"]) == checks


@pytest.mark.parametrize("transformation", ["affine", "helmert_3d"])
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_points_of_another_list_among_the_others_are_named(transformation, method):
    """Two lists of another system in one table: no line and no region parts them."""
    block = simulated(transformation=transformation)
    names = block.control_points.loc[block.control_points["role"] == "control"]
    names = set(names["point_id"].sample(frac=0.3, random_state=4))

    def of_the_other_list(points):
        return points["point_id"].isin(names)

    mixed, names, _ = displaced(block, of_the_other_list)
    result = densify(mixed, Settings(method=method))
    told, (first, *_) = result.assessment, result.assessment.findings
    assert first.code == "displaced_region"
    assert set(first.names) == names
    assert first.facts["is_scattered"]
    shift = [first.facts[axis] for axis in PLAN]
    assert shift == pytest.approx(SHIFT, abs=4.0 * first.facts["standard_error"])
    assert told.credible.value == pytest.approx(rms(result, block.truth), rel=0.1)
    summary = result.summary()
    assert "; check the displaced control points first" in summary.splitlines()[0]
    assert "which lie among the others" in " ".join(summary.split())


def test_of_two_corners_the_headline_says_how_many():
    def north_east(points):
        return (points[PLAN] > points[PLAN].quantile(0.6)).all(axis=1)

    block, *_ = displaced(simulated())
    control = block.control_points.copy()
    rows = north_east(control).to_numpy()
    control.loc[rows, PLAN] -= 1.5 * SHIFT[::-1]
    result = densify(replace(block, control_points=control), Settings())
    first = result.assessment.findings[0]
    assert first.code == "displaced_region"
    assert len(first.facts["further_regions"]) == 1
    head, *_ = result.summary().splitlines()
    assert "; check the control points of 2 displaced regions first" in head


def test_of_two_halves_that_check_points_follow_nothing_tells():
    def west(points):
        return points["easting"] < points["easting"].median()

    block, *_ = displaced(simulated(), west)
    result = densify(block, Settings())
    first = next(f for f in result.assessment.findings if not f.explained_by)
    assert (first.code, first.remedy) == ("displaced_region", "compare_both_parts")
    head, *_ = result.summary().splitlines()
    assert "; compare both parts of the control network first" in head
    # these flights are parted by control, and have measured the same targets
    assert "other_targets" not in {f.code for f in result.assessment.findings}


def test_of_two_halves_check_points_tell_that_do_not_follow():
    def west(points):
        is_control = points["role"] == "control"
        return is_control & (points["easting"] < points["easting"].median())

    block, names, _ = displaced(simulated(), west)
    result = densify(block, Settings())
    first = next(f for f in result.assessment.findings if not f.explained_by)
    assert (first.code, first.remedy) == ("displaced_region", "correct_control")
    assert set(first.names) == names
    head, *_ = result.summary().splitlines()
    assert "; check the control points in the west first" in head


def test_another_target_beside_a_displaced_part_is_named():
    block, names, _ = displaced(simulated())
    points = block.low_flight.model_points
    east = block.truth["easting"] > block.truth["easting"].quantile(0.7)
    known = block.control_points["point_id"]
    new = block.truth.loc[east & ~block.truth["point_id"].isin(known), "point_id"]
    name = points.loc[points["point_id"].isin(new), "point_id"].value_counts().idxmax()
    moved = points.copy()
    is_it = moved["point_id"] == name
    moved.loc[is_it, "x"] += 1000.0 / block.low_flight.scale_number
    low = replace(block.low_flight, model_points=moved)
    result = densify(replace(block, low_flight=low), Settings())
    found = {each.code: each for each in result.assessment.findings}
    assert found["other_targets"].names == (name,)
    assert not found["other_targets"].explained_by
    assert set(found["displaced_region"].names) == names


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_single_wrong_points_are_no_region(seed):
    block = simulated(seed)
    control = block.control_points.copy()
    rows = control.index[control["role"] == "control"][::11]
    control.loc[rows, "easting"] += [1.0, -0.7, 0.5, 0.9][: len(rows)]
    result = densify(replace(block, control_points=control), Settings())
    assert result.examination.displaced_regions == ()
    assert densify(block, Settings()).examination.displaced_regions == ()


@pytest.mark.parametrize(
    ("n_alike", "n_others", "is_open"), [(3, 3, True), (0, 6, False), (0, 0, False)]
)
def test_check_points_count_for_the_part_with_which_they_moved(
    n_alike, n_others, is_open
):
    """5 of 17 control points are few; with 3 of 6 check points nothing tells."""
    control = pd.DataFrame({"point_id": [f"C{k}" for k in range(17)]})
    control[PLAN] = np.random.default_rng(1).uniform(0.0, 3000.0, (17, 2))
    part = DisplacedRegion(np.arange(5), np.array([0.3, 0.0]), 0.03, 1e-9)
    n = n_alike + n_others
    check = KnownPoints(
        np.array([f"K{k}" for k in range(n)], dtype=object),
        np.arange(n) < n_alike,
        np.zeros((n, 2)),
        np.full(n, 0.05),
    )
    region = told_region(control, part, 12, check, is_of_control=True, is_decided=False)
    assert region.may_be_the_others == is_open
    # known points beside approximate ones are of another kind
    given = told_region(control, part, 12, check, is_of_control=False, is_decided=False)
    assert not given.may_be_the_others
