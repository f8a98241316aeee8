"""Points in another system than the others, and points beyond any block."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pyproj
import pytest

from einschalt.foundations.errors import EinschaltError, spread
from einschalt.foundations.language import written_in
from einschalt.foundations.likely_systems import likely_systems, systems_among
from einschalt.foundations.points_elsewhere import islands_of
from einschalt.foundations.told_errors import told
from einschalt.pipeline.block.axis_order import where_problems

PLANE = ["easting", "northing"]
TO_UTM = pyproj.Transformer.from_crs(31255, 25833, always_xy=True)
CASES = {
    "LV03": ("EPSG:2056", (2.6e6, 1.2e6), [-2e6, -1e6], "is given as LV03"),
    "LV95": ("EPSG:21781", (6e5, 2e5), [2e6, 1e6], "is given as LV95"),
    "LV03 in no system": (None, (2.6e6, 1.2e6), [-2e6, -1e6], "is given as LV03"),
    "zone": ("EPSG:25832", (5e5, 5.4e6), [32e6, 0.0], "without 32000000 for a zone"),
    "no zone": (None, (32.5e6, 5.4e6), [-32e6, 0.0], "with 32000000 for the zone"),
    "false northing": (None, (1e4, 2.4e5), [0.0, 5e6], "with -5000000 in northing"),
    "M31": (
        *("EPSG:31255", (1e4, 2.4e5), [4.5e5, 0.0]),
        r"if it is in MGI / Austria GK M31 \(EPSG:31258\)",
    ),
    "M34": (
        *(None, (7.5e5, 3.4e5), [-7.5e5, 5e6]),
        r"with \+750000 in easting and -5000000 in northing",
    ),
}


def moved(block, crs, middle, change, *, share):
    """The block with its control at another place, a part of it changed."""
    control = block.control_points.copy()
    control[PLANE] += np.array(middle) - control[PLANE].mean().to_numpy()
    rows = control.index[:1] if share == "one" else control.index[::3]
    control.loc[rows, PLANE] = change(control.loc[rows, PLANE].to_numpy())
    return replace(block, crs=crs, control_points=control)


@pytest.mark.parametrize("share", ["one", "a third"])
@pytest.mark.parametrize("case", CASES)
def test_points_in_another_system_are_refused_by_its_name(demo_block, case, share):
    crs, middle, shift, said = CASES[case]
    name = demo_block.control_points["point_id"].iloc[0]
    with pytest.raises(EinschaltError, match=said) as caught:
        moved(demo_block, crs, middle, lambda xy: xy + shift, share=share)
    first = getattr(caught.value, "problems", [caught.value])[0]
    assert (first.file, first.row, first.point) == ("control_points", 0, name)
    assert "km from the other points" in first.found
    assert "Transform it into the system of the others" in first.remedy


@pytest.mark.parametrize(
    ("crs", "change", "said"),
    [
        (None, lambda xy: xy[:, ::-1], "with easting and northing exchanged"),
        (None, lambda xy: xy / 1e3, "as kilometres"),
        (None, lambda xy: xy * 1e3, "as millimetres"),
        ("EPSG:31255", lambda xy: np.column_stack(TO_UTM.transform(*xy.T)), "25833"),
        (
            None,
            lambda xy: xy + np.array([1.3e6, 2.345e6]),
            "no block reaches over 1000 km",
        ),
    ],
)
def test_points_are_refused_for_what_they_look_like(demo_block, crs, change, said):
    with pytest.raises(EinschaltError, match=said):
        moved(demo_block, crs, (1.2e4, 2.4e5), change, share="one")


def test_half_of_the_points_are_no_wrong_scale_number(demo_block):
    control = demo_block.control_points.copy()
    control[PLANE] += [2.6e6, 1.0e6]
    control.loc[control.index[::2], PLANE] -= [2e6, 1e6]
    with pytest.raises(EinschaltError) as caught:
        replace(demo_block, crs=None, control_points=control)
    problems = caught.value.problems
    assert all("LV" in one.found for one in problems)
    with written_in("de"):
        assert "angegeben ist er als" in told(spread(problems)[0])


def test_islands_that_no_model_holds_are_noted_alone(demo_block):
    control = demo_block.control_points.copy()
    lone = control.tail(2).assign(point_id=["far/1", "far/2"])
    lone[PLANE] -= [2e6, 1e6]
    lone.index = [900, 901]
    control = pd.concat([control, lone])
    notes = replace(demo_block, crs=None, control_points=control).notes
    assert any("2 of" in note and "lie in no model" in note for note in notes)
    # nor are the measured ones refused where the others are more
    more = pd.concat(
        [lone.assign(point_id=lone["point_id"] + str(k)) for k in range(30)]
    )
    many = pd.concat([control, more], ignore_index=True)
    assert replace(demo_block, crs=None, control_points=many)


def test_a_large_block_is_one_island():
    across = np.arange(0.0, 4e6, 45_000.0)
    plan = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2)
    assert islands_of(plan, None) is None
    assert islands_of(plan[:1], None) is None
    assert islands_of(np.array([[0.0, 0.0], [1e30, 0.0]]), None) is None


def test_the_island_that_counts_lies_where_the_system_is_used():
    plan = np.array([[6e5, 2e5], [6.01e5, 2e5], [2.6e6, 1.2e6]])
    plan = np.concatenate([plan, plan[2:] + 100.0])
    assert islands_of(plan, None).distance(plan)[2] > 2e6
    found = islands_of(plan, pyproj.CRS("EPSG:2056"))
    assert found.distance(plan)[2] == 0.0
    # points that lie all apart are in another unit
    assert islands_of(plan * 1e3, None) is None
    assert [number for number, _ in found.others()] == [int(found.number[0])]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("crs", "middle", "shift"),
    [
        ("EPSG:25832", (5e5, 5.4e6), [120e3, 0.0]),
        ("EPSG:32633", (5e5, 5.4e6), [0.0, 160e3]),
        (None, (0.0, 0.0), [130e3, 0.0]),
        (None, (7e5, 3e5), [-120e3, 0.0]),
    ],
)
def test_a_second_island_that_models_hold_is_right(demo_block, crs, middle, shift):
    """-150000 in easting was said of one 120 km away, and millimetres of local ones."""
    control = demo_block.control_points.copy()
    control[PLANE] += np.array(middle) - control[PLANE].mean().to_numpy()
    control.loc[control.index[::3], PLANE] += np.array(shift)
    assert where_problems(control, crs, "c.csv", lambda: control["point_id"])[0] == []


def test_systems_that_proj_has_no_way_to_are_no_candidates():
    """EPSG lists grids of all UTM zones as one system."""
    bounds = np.array([[4e5, 5.3e6], [4.1e5, 5.31e6]])
    utm = pyproj.CRS("EPSG:32633")
    assert systems_among((5e5, 6e6), bounds, utm) == []
    # Levant Zone, the only other kind of its datum, is near-conformal
    levant = pyproj.CRS("EPSG:22770")
    assert levant.name.split(" / ")[0] == pyproj.CRS("EPSG:22700").name.split(" / ")[0]
    assert likely_systems(np.full(3, 9e6), np.full(3, 9e6), levant)[0] == []
    assert "EPSG:3395" in likely_systems(np.full(3, 9e6), np.full(3, 9e6), utm)[0][0]


def test_a_point_at_nothing_is_not_told_of_an_origin(demo_block):
    with pytest.raises(EinschaltError, match="no block reaches over 1000 km"):
        moved(demo_block, None, (5e5, 5e6), lambda xy: 0.0 * xy, share="one")
