"""Points that are given twice, and one model in another unit: seen at once."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import ConsistencyError, EinschaltError
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.block.given_points import (
    KnownOfModels,
    heights_that_are_none,
)

PLAN = ["easting", "northing"]
M_0 = 0.09


def block_with(demo_block, seed=0, moved=(), metres=2.0, **facts):
    """The low flight onto given approximate points, some of them moved."""
    rng = np.random.default_rng(seed)
    points = demo_block.truth[["point_id", *PLAN]].copy()
    points[PLAN] += M_0 / np.sqrt(2.0) * rng.standard_normal((len(points), 2))
    points.loc[points["point_id"].isin(moved), "easting"] += metres
    if "group_errors_m" in facts:
        points["group"] = "all"
    given = {"approximate_m_0_m": M_0} | facts
    return Block(
        crs=demo_block.crs,
        control_points=demo_block.control_points,
        approximate_points=points,
        low_flight=demo_block.low_flight,
        **given,
    )


def notes_of(block):
    return [note for note in block.notes if "lie elsewhere" in note]


def test_a_region_that_is_off_is_noted_with_its_points(demo_block):
    names = demo_block.control_points["point_id"].iloc[:3].tolist()
    (note,) = notes_of(block_with(demo_block, moved=names))
    n_known = len(demo_block.control_points)
    assert f"3 of {n_known} points" in note
    assert all(name in note.rpartition(":")[2] for name in names)


@pytest.mark.parametrize("none", [-9999.0, -32768.0, -999.0, 9999.0])
def test_heights_that_stand_for_none_are_refused(none):
    table = heights_of(none, 481.0, 567.0)
    (problem,), notes = heights_that_are_none(table, "points.csv")
    assert not notes
    assert (problem.point, problem.file) == ("P0", "points.csv")
    assert problem.found.startswith(f"height = {none:g}, as programs write")
    assert problem.remedy == "Leave the cell empty"


def test_zeros_are_noted_where_all_other_heights_lie_above():
    problems, (note,) = heights_that_are_none(heights_of(481.0, 0.0, 567.0), "p.csv")
    assert not problems
    assert note.startswith("p.csv: 1 of 3 heights are 0, the others 481 to 567 m")
    assert note.endswith(": P1")


@pytest.mark.parametrize(
    "heights",
    [
        (0.0, 0.0, 500.0),  # a system of its own, with one point above it
        (0.0, 12.0, 500.0),  # from the sea
        (-999.0, -990.0, -1010.0),
        (np.nan, 400.0, 500.0),
    ],
)
def test_heights_that_may_be_are_left_alone(heights):
    assert heights_that_are_none(heights_of(*heights), "p.csv") == ([], [])


def heights_of(*values):
    names = [f"P{k}" for k in range(len(values))]
    return pd.DataFrame({"point_id": names, "height": values})


@pytest.mark.slow
def test_clean_blocks_have_no_note(demo_block):
    """Of 200 blocks fewer than one has it by chance."""
    noted = [notes_of(block_with(demo_block, seed)) for seed in range(200)]
    assert sum(map(bool, noted)) <= 2


def test_what_is_shared_or_not_stated_is_no_contradiction(demo_block):
    names = demo_block.control_points["point_id"].iloc[:3].tolist()
    shared = {"group_errors_m": {"approximate_points": 2.0}}
    assert not notes_of(block_with(demo_block, moved=names, **shared))
    unknown = {"approximate_m_0_m": None}
    assert not notes_of(block_with(demo_block, moved=names, **unknown))


def test_points_of_another_place_are_noted_where_their_errors_are_unknown(demo_block):
    """17 m beside the control points of their names, without a word."""
    names = demo_block.truth["point_id"].tolist()
    unknown = {"approximate_m_0_m": None}
    (note,) = notes_of(block_with(demo_block, moved=names, metres=17.0, **unknown))
    n_known = len(demo_block.control_points)
    assert f"the {n_known} points that control_points gives too lie elsewhere" in note
    assert re.search(r"by 1[67] m \(median\) and up to 17 m", note)
    assert not notes_of(block_with(demo_block, **unknown))


def test_one_model_in_another_unit_is_told_as_one(demo_block):
    flight = demo_block.high_flight
    points = flight.model_points.copy()
    is_one = points["model_id"] == points["model_id"].iloc[0]
    points.loc[is_one, ["x", "y"]] *= 1000.0
    with pytest.raises(ConsistencyError, match="is this one in another unit"):
        replace(demo_block, high_flight=replace(flight, model_points=points))


def renamed(flight, change):
    points = flight.model_points
    renamed = points["point_id"].map(change)
    return replace(flight, model_points=points.assign(point_id=renamed))


def test_names_written_otherwise_are_told_as_pairs_and_no_model_is_deleted(demo_block):
    def with_names(high, low):
        flights = {
            "high_flight": renamed(demo_block.high_flight, high),
            "low_flight": renamed(demo_block.low_flight, low),
        }
        with pytest.raises(EinschaltError) as caught:
            replace(demo_block, **flights)
        return getattr(caught.value, "problems", [caught.value])

    first = demo_block.control_points["point_id"].iloc[0]
    (problem,) = with_names("A{}".format, "A{}".format)
    assert "holds the point; " in problem.found
    (problem,) = with_names("0{}".format, "0{}".format)
    assert f"holds the point, but '0{first}'; " in problem.found
    assert problem.point == first
    (problem,) = with_names(str, "{}.0".format)
    name = demo_block.low_flight.model_points["point_id"].iloc[0]
    assert problem.remedy == f"Write '{name}.0' here as there, where it is '{name}'"


@pytest.mark.parametrize(
    ("suffix", "remedy"),
    [
        ("csv", "Correct the names of its points, or delete the model"),
        ("xlsx", "Write '1{}.5' here as there, where it is '1{}.50'"),
    ],
)
def test_a_workbook_that_took_the_zeros_of_all_names_is_told(
    demo_block, suffix, remedy
):
    control = demo_block.control_points
    names = control["point_id"].map("1{}.50".format)
    high = renamed(demo_block.high_flight, "1{}.50".format)
    low = renamed(demo_block.low_flight, "1{}.5".format)
    with pytest.raises(EinschaltError) as caught:
        replace(
            demo_block,
            control_points=control.assign(point_id=names),
            high_flight=high,
            low_flight=low,
            sources={"low_flight.model_points": f"low.{suffix}"},
        )
    (problem,) = getattr(caught.value, "problems", [caught.value])
    first = demo_block.low_flight.model_points["point_id"].iloc[0]
    assert problem.remedy == remedy.format(first, first)


def test_names_that_look_the_same_are_told_by_their_codes(demo_block):
    control = demo_block.control_points
    flights = {
        name: renamed(getattr(demo_block, name), "\u00fc{}".format)
        for name in ("high_flight", "low_flight")
    }
    first = control["point_id"].iloc[0]
    control = control.assign(point_id="u\u0308" + control["point_id"])
    with pytest.raises(EinschaltError, match="which looks the same") as caught:
        replace(demo_block, control_points=control, **flights)
    said = f"it is 'u\\u0308{first}' here and '\\xfc{first}' there"
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "advised"),
    [
        ("affine", "or merge it with its neighbour"),
        ("helmert_3d", "or determine more control points there"),
    ],
)
def test_photographs_are_not_to_be_merged(kind, advised):
    one = np.array([True])
    known = KnownOfModels(one, one, np.array([1]), 3, ~one, 20)
    assert known.lack(0, "control_points", kind)["remedy"].endswith(advised)
