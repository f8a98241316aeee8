"""How the tables of a block fit each other."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.photographs_onto_control import one_flight

from einschalt.foundations.errors import BlockError, ConsistencyError, EinschaltError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import written_in
from einschalt.pipeline.adjust_block import adjust_block
from einschalt.pipeline.block.axis_order import where_problems
from einschalt.pipeline.block.block import check_block
from einschalt.pipeline.block.given_points import (
    ONE_ADJUSTMENT,
    known_of_models,
    points_in_no_model,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block


def with_control(block, change):
    return replace(block, control_points=change(block.control_points.copy()))


def with_low(block, change):
    points = change(block.low_flight.model_points.copy())
    return replace(block, low_flight=replace(block.low_flight, model_points=points))


def test_block_keeps_its_tables_as_checked(demo_block):
    def as_script(points):
        return points.assign(point_id=points["point_id"].astype(object), remark="x")

    block = with_low(demo_block, as_script)
    assert "remark" not in block.low_flight.model_points
    assert block.notes == ("low_flight.model_points: ignored column remark",)
    assert block.source("low_flight.model_points") == "low_flight.model_points"


def test_exchanged_axes_of_one_point(demo_block):
    def exchange(control):
        axes = ["easting", "northing"]
        control.loc[3, axes] = control.loc[3, axes[::-1]].tolist()
        return control

    name = demo_block.control_points["point_id"].iloc[3]
    with pytest.raises(ConsistencyError, match="Exchange the two columns") as caught:
        with_control(demo_block, exchange)
    assert (caught.value.row, caught.value.point) == (3, name)


def test_axes_without_system_are_believed(demo_block):
    frame = demo_block.control_points.rename(
        columns={"easting": "northing", "northing": "easting"}
    )
    for crs in (None, "EPSG:99999"):
        assert where_problems(frame, crs, "control.csv", list) == ([], [])


def test_points_far_outside_are_noted_and_most_of_them_an_error(demo_block):
    far = demo_block.control_points.copy()
    far.loc[far.index[:2], ["easting", "northing"]] = 9e6
    system, unmeasured = "EPSG:31255", list
    problems, notes = where_problems(far, system, "control.csv", unmeasured)
    assert problems == []
    label = "MGI / Austria GK Central (EPSG:31255)"
    said = f"2 of {len(far)} points lie outside the area of use of {label}"
    first, second = far["point_id"].iloc[:2]
    assert notes == [f"control.csv: {said}: {first}, {second}"]
    far = far.assign(easting=9e6, northing=9e6)
    (problem,), notes = where_problems(far, system, "control.csv", unmeasured)
    assert f"lie outside the area of use of {label}" in problem.found
    assert notes == []


@pytest.mark.parametrize(
    ("easting", "northing", "remedy"),
    [
        (646099.8, 1060562.1, "Write a minus before both"),
        (1060562.1, 646099.8, "Exchange the two columns, and write a minus before"),
    ],
)
def test_points_that_count_to_the_south_and_west(easting, northing, remedy):
    frame = pd.DataFrame({"point_id": ["1"], "easting": easting, "northing": northing})
    (problem,), _ = where_problems(frame, "EPSG:5514", "list.csv", list)
    assert remedy in problem.remedy


def test_standard_errors_in_millimetres(demo_block):
    with pytest.raises(
        EinschaltError, match=r"standard_error_m 30; .*Did you give mill"
    ):
        with_control(demo_block, lambda control: control.assign(standard_error_m=30.0))


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (
            1e3,
            r"Did you give micrometres\? Set model_unit = 'um'\.$|Did you give micro",
        ),
        (1e-3, r"Did you give metres\? Set model_unit = 'm'\.$|Did you give metres"),
        (1e9, r"Convert the coordinates to millimetres\.$"),
    ],
)
def test_coordinates_in_another_unit(demo_block, factor, said):
    def scale(points):
        return points.assign(x=points["x"] * factor, y=points["y"] * factor)

    with pytest.raises(ConsistencyError, match=said):
        with_low(demo_block, scale)


def test_one_height_at_all_points_is_none_where_models_show_relief():
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
    block = simulate_block("demo", seed=2, geometry=geometry)
    with pytest.raises(ConsistencyError, match=r"all \d+ points have height 0"):
        with_control(block, lambda control: control.assign(height=0.0))
    # a floor is flat, and a plane one may be tilted in the machine
    points = block.high_flight.model_points
    floor = points.assign(z=0.3 * points["x"] - 0.1 * points["y"])
    high = replace(block.high_flight, model_points=floor)
    control = block.control_points.assign(height=0.0)
    assert replace(block, high_flight=high, control_points=control).notes == block.notes


def test_unit_that_is_said_is_believed(demo_block):
    points = demo_block.low_flight.model_points
    points = points.assign(x=points["x"] * 1e3, y=points["y"] * 1e3)
    low = replace(demo_block.low_flight, model_points=points, model_unit="um")
    assert replace(demo_block, low_flight=low).low_flight.model_unit == "um"


def test_widest_model_is_looked_for_within_each_coverage(demo_block):
    """Two coverages may count their models alike, on machines of different origin."""

    def shift(points):
        second = points["coverage"] == "2"
        return points.assign(x=points["x"] + 1e5 * second)

    assert with_low(demo_block, shift).model_problems == ()


def test_misspelt_points_are_said_and_may_be_allowed(demo_block):
    name = demo_block.control_points.loc[1, "point_id"]
    wrong = f"0{name}"

    def rename(control):
        control.loc[1, "point_id"] = wrong
        return control

    with pytest.raises(
        ConsistencyError,
        match=f"point {wrong}: no model of the high flight holds .* but '{name}'",
    ):
        with_control(demo_block, rename)
    allowed = replace(demo_block, may_be_unmeasured=True)
    assert wrong in with_control(allowed, rename).control_points["point_id"].tolist()


def test_points_of_a_list_that_models_do_not_hold_are_counted(demo_block):
    """A list of control often holds more than a block, which is no error."""

    def rename(control):
        control.loc[[1, 3], "point_id"] = ["LOST", "A 17"]
        return control

    block = with_control(demo_block, rename)
    (note,) = [note for note in block.notes if "no model" in note]
    n = len(block.control_points)
    assert f"2 of {n} points lie in no model of the high flight" in note
    assert note.endswith("LOST, A 17")
    with written_in("de"):
        assert f"2 von {n} Punkten liegen in keinem Modell des Hochflug" in retold(note)
    result = densify(block)
    assert np.isfinite(result.points["easting"]).all()
    assert "LOST" not in set(result.points["point_id"])


def test_names_of_another_kind_are_an_error(demo_block):
    with pytest.raises(BlockError, match="no model of the high flight holds the point"):
        with_control(
            demo_block, lambda table: table.assign(point_id="X" + table["point_id"])
        )


def test_check_point_of_the_low_flight_alone(demo_block):
    control = demo_block.control_points
    name = control.loc[control["role"] == "check", "point_id"].iloc[0]
    high = demo_block.high_flight.model_points
    high = replace(demo_block.high_flight, model_points=high[high["point_id"] != name])
    assert replace(demo_block, high_flight=high).model_problems == ()


def test_models_without_common_points_are_found_but_do_not_stop(demo_block):
    def rename(points):
        lost = points["model_id"] == points["model_id"].iloc[0]
        points.loc[lost, "point_id"] = "X" + points.loc[lost, "point_id"]
        return points

    block = with_low(demo_block, rename)
    assert {problem.model for problem in block.model_problems} == {
        demo_block.low_flight.model_points["model_id"].iloc[0]
    }
    assert len(block.model_problems) == 2  # of two coverages
    assert block.model_problems[0].row == 0


def test_no_model_with_common_points_stops(demo_block):
    with pytest.raises(EinschaltError, match="none of its points has coordinates from"):
        with_low(
            demo_block, lambda points: points.assign(point_id="X" + points.point_id)
        )


def test_wrong_tables_are_not_compared(demo_block):
    """One misspelt column does not make every point lost."""
    wrong = demo_block.low_flight.model_points.rename(columns={"point_id": "pt"})
    low = replace(demo_block.low_flight, model_points=wrong)
    draft = type("Draft", (), vars(demo_block) | {"low_flight": low})()
    found = check_block(draft)
    assert len(found.problems) == 1
    assert "column 'point_id' is missing" in found.problems[0].found


def image_block(block):
    images = pd.DataFrame(
        {
            "image_id": np.repeat(["11", "12", "13"], 4),
            "point_id": np.tile(block.truth["point_id"].iloc[:4], 3),
            "x": np.tile([-90.0, 90.0, 90.0, -90.0], 3),
            "y": np.tile([-90.0, -90.0, 90.0, 90.0], 3),
        }
    )
    models = pd.DataFrame(
        {
            "model_id": ["11/12", "12/13"],
            "left_image": ["11", "12"],
            "right_image": ["12", "13"],
        }
    )
    return replace(
        block.low_flight,
        model_points=None,
        image_points=images,
        models=models,
        principal_distance_mm=153.0,
    )


def test_models_of_images_that_were_not_measured(demo_block):
    flight = image_block(demo_block)
    assert replace(demo_block, low_flight=flight).model_problems == ()
    flight.models.loc[1, "right_image"] = "14"
    with pytest.raises(ConsistencyError, match="right_image '14' has no image points"):
        replace(demo_block, low_flight=flight)


def test_image_coordinates_in_metres(demo_block):
    flight = image_block(demo_block)
    images = flight.image_points.assign(x=flight.image_points["x"] / 1e3, y=0.0)
    with pytest.raises(
        ConsistencyError, match=r"widest image extends over 0\.18 mm.*Give millimetres"
    ):
        replace(demo_block, low_flight=replace(flight, image_points=images))


@pytest.mark.parametrize(
    ("pixels_per_mm", "said"),
    [
        (
            20.0,
            r"image coordinates up to \d+ with a principal distance of 153; .*milli",
        ),
        (40.0, r"widest image extends over \d+ mm; expected 2 to 5000 mm\."),
    ],
)
def test_pixels_without_a_camera(demo_block, pixels_per_mm, said):
    flight = image_block(demo_block)
    xy = pixels_per_mm * (100.0 + flight.image_points[["x", "y"]].to_numpy())
    images = flight.image_points.assign(x=xy[:, 0], y=xy[:, 1])
    with pytest.raises(
        ConsistencyError, match=rf"{said}.*Are they pixels\? Name their camera"
    ):
        replace(demo_block, low_flight=replace(flight, image_points=images))


def test_many_lost_points_make_a_short_message(demo_block):
    names = demo_block.control_points["point_id"][:10]
    lost = pd.DataFrame(
        {
            "point_id": [f"{'0' * k}{name}" for k in range(1, 501) for name in names],
            "easting": 13_000.0,
            "northing": 322_000.0,
            "standard_error_m": 0.03,
            "role": "control",
        }
    )
    with pytest.raises(BlockError, match=r"point 0\w+: .* in 4999 more rows"):
        with_control(demo_block, lambda table: pd.concat([table[10:], lost]))


def test_what_check_advises_is_what_the_adjustment_says(demo_block):
    """A user was told to delete a model, and to merge it with its neighbour."""
    low = demo_block.low_flight
    points = low.model_points
    first = points.iloc[0][["coverage", "model_id"]]
    is_model = (points[["coverage", "model_id"]] == first).all(axis=1).to_numpy()
    kept = ~is_model | (np.cumsum(is_model) <= 2)
    few = replace(low, model_points=points[kept].reset_index(drop=True))
    block = replace(demo_block, low_flight=few)
    (problem,) = check_block(block).model_problems
    failures = adjust_block(block).failures
    assert problem.remedy == failures["remedy"].iloc[0]


def test_models_that_neighbours_tie_are_no_fault_in_one_adjustment():
    """They were told as models that nothing can use, and measured anew for nothing."""
    block = one_flight(seed=1, n_given=6)
    problems = block.model_problems
    assert len(problems) == 21
    (remedy,) = {problem.remedy for problem in problems}
    assert remedy == ONE_ADJUSTMENT
    together = replace(block, settings=Settings(method="auto"))
    assert together.model_problems == ()
    (note,) = set(together.notes) - set(block.notes)
    assert "fewer than 3 points" in note
    assert "in 21 of 23 models" in note


def test_fewer_known_points_than_a_model_needs_are_one_problem():
    """Of each model it was said that its names were wrong, or to delete it."""
    block = one_flight(seed=1, n_given=6)
    two = block.control_points[:2], block.approximate_points[:2]
    with pytest.raises(ConsistencyError) as caught:
        replace(block, control_points=two[0], approximate_points=two[1])
    assert caught.value.found == "models show 2 of these control points"
    assert caught.value.expected == "at least 3"


def test_approximate_points_are_not_adjusted():
    """They are no control, whatever ties the models that show few of them."""
    block = one_flight(seed=1, n_given=6)
    without = replace(block, control_points=None)
    remedies = {problem.remedy for problem in without.model_problems}
    assert remedies
    assert ONE_ADJUSTMENT not in remedies


def test_which_models_neighbours_tie():
    shown = {"a": "pqr", "b": "pqrxyz", "c": "stu"}  # c has no neighbour
    rows = [("1", model, point) for model in shown for point in shown[model]]
    table = pd.DataFrame(rows, columns=["coverage", "model_id", "point_id"])

    def lacking(known):
        found = known_of_models(table, known, least=3)
        models = table["model_id"]
        return set(models[found.is_lacking]), set(models[found.is_tied])

    assert lacking(["x", "y", "z"]) == ({"a", "c"}, {"a", "b"})
    assert lacking(["x", "y"]) == ({"a", "b", "c"}, set())  # too few for any way
    assert lacking(list("pqrstu")) == (set(), set())


def test_numbers_parted_otherwise_are_other_points():
    """A point 11-2 that is measured is no slip of the 1-12 that is not."""
    listed = pd.DataFrame({"point_id": ["1-1", "1-2", "1-12", "2-1"]})
    measured = np.array(["1-1", "1-2", "2-1", "11-2", "11-3"], dtype=object)
    is_lost = ~listed["point_id"].isin(measured).to_numpy()
    given = "control_points", "control.csv", "high_flight"
    errors, (note,) = points_in_no_model(listed, is_lost, measured, given)
    assert errors == []
    assert note.endswith("take no part: 1-12")


@pytest.mark.parametrize(
    ("file", "names", "n_told"),
    [
        ("t.xlsx", ["1.1", "1.2"], 1),
        ("t.csv", ["1.1", "1.2"], 0),  # which keeps what was typed
        ("t.xlsx", ["1.1", "1.10"], 0),  # both are known
        ("t.xlsx", ["1.2"], 0),  # the flight alone has two
    ],
)
def test_a_name_of_which_a_spreadsheet_may_have_made_another_is_told(
    file, names, n_told
):
    measured = np.array(["1.1", "1.2", "1.10", "P1.20"])
    listed, is_lost = (
        pd.DataFrame({"point_id": names}),
        np.zeros(len(names), dtype=bool),
    )
    given = "control_points", file, "high_flight"
    errors, notes = points_in_no_model(listed, is_lost, measured, given)
    assert (errors, len(notes)) == ([], n_told)
    said = f"{file}: 1 of {len(names)} points may be others that the high flight holds"
    assert all(n.startswith(said) and n.endswith(": '1.1' ('1.10')") for n in notes)


def test_all_names_of_which_a_number_may_have_been_made_are_counted():
    names = [f"{k}.1" for k in range(1, 8)]
    measured = np.array([*names, *(f"{name}0" for name in names)])
    listed, is_lost = pd.DataFrame({"point_id": names}), np.zeros(7, dtype=bool)
    given = "control_points", "t.xlsx", "high_flight"
    _, (note,) = points_in_no_model(listed, is_lost, measured, given)
    assert note.startswith("t.xlsx: 7 of 7 points may be others")
    assert note.endswith("'5.1' ('5.10') and 2 more")
    with written_in("de"):
        told = retold(note)
    assert told.startswith("t.xlsx: 7 von 7 Punkten können andere sein")
    assert told.endswith("'5.1' ('5.10') und noch 2")


@pytest.mark.parametrize(
    ("file", "measured_in", "n_errors"),
    [
        ("t.csv", "h.csv", 0),
        ("t.xlsx", "h.csv", 0),  # which would have lost the zero itself
        ("t.csv", "h.xlsx", 1),
    ],
)
def test_a_lost_point_is_another_only_where_a_workbook_may_have_made_it(
    file, measured_in, n_errors
):
    """Control 1.10 is not measured; the new point 1.1 is another one in text files."""
    listed = pd.DataFrame({"point_id": ["1", "2", "1.10"]})
    measured, is_lost = np.array(["1", "2", "1.1"]), np.array([False, False, True])
    given = "control_points", file, "high_flight"
    sources = {"high_flight.model_points": measured_in}
    errors, notes = points_in_no_model(listed, is_lost, measured, given, sources)
    assert (len(errors), len(notes)) == (n_errors, 1 - n_errors)
    assert all("holds the point, but '1.1'" in error.found for error in errors)


def test_points_of_a_block_with_and_without_a_zero_are_two(demo_block):
    """Of text files the block runs, with a note; of a workbook it is asked about."""
    control, high = demo_block.control_points, demo_block.high_flight.model_points
    new = next(n for n in high["point_id"] if n not in {*control["point_id"]})

    def renamed(flight):
        names = flight.model_points["point_id"].replace({new: "1.1"})
        points = flight.model_points.assign(point_id=names)
        return replace(flight, model_points=points)

    lost = control.iloc[[0]].assign(point_id="1.10")
    changed = {
        "control_points": pd.concat([control, lost], ignore_index=True),
        "high_flight": renamed(demo_block.high_flight),
        "low_flight": renamed(demo_block.low_flight),
    }
    sources = {"high_flight.model_points": "high.csv"}
    block = replace(demo_block, **changed, sources=sources)
    assert any(note.endswith("take no part: 1.10") for note in block.notes)
    sources = {"high_flight.model_points": "high.xlsx"}
    with pytest.raises(ConsistencyError, match=r"holds the point, but '1\.1'"):
        replace(demo_block, **changed, sources=sources)


def test_a_block_of_which_no_point_is_lost_tells_what_a_workbook_may_have_lost(
    demo_block,
):
    """The note came only where another point lay in no model."""
    control, high = demo_block.control_points, demo_block.high_flight.model_points
    known = control["point_id"].iloc[0]
    new = next(n for n in high["point_id"] if n not in {*control["point_id"]})
    names = {known: "1.1", new: "1.10"}

    def renamed(table):
        return table.assign(point_id=table["point_id"].replace(names))

    flights = {
        name: replace(flight, model_points=renamed(flight.model_points))
        for name in ("high_flight", "low_flight")
        for flight in [getattr(demo_block, name)]
    }
    told = {
        file: replace(
            demo_block,
            control_points=renamed(control),
            sources={"control_points": file},
            **flights,
        ).notes
        for file in ("c.csv", "c.xlsx")
    }
    said = f"c.xlsx: 1 of {len(control)} points may be others that the high flight"
    assert not any("may be others" in note for note in told["c.csv"])
    (note,) = (note for note in told["c.xlsx"] if "may be others" in note)
    assert note.startswith(said)


def test_models_whose_photographs_have_no_point_in_common(demo_block):
    flight = image_block(demo_block)
    flight.image_points.loc[8:, "point_id"] = list(demo_block.truth["point_id"][4:8])
    (problem,) = replace(demo_block, low_flight=flight).model_problems
    assert "photographs '12' and '13' have no point in common" in str(problem)
    assert problem.model == "12/13"
    assert "they may be exchanged" in problem.remedy


def test_a_model_of_one_photograph(demo_block):
    flight = image_block(demo_block)
    flight.models.loc[0, "right_image"] = flight.models.loc[0, "left_image"]
    (problem,) = replace(demo_block, low_flight=flight).model_problems
    name = flight.models.loc[0, "left_image"]
    assert f"left_image and right_image are both '{name}'" in str(problem)
    assert problem.model == flight.models.loc[0, "model_id"]
