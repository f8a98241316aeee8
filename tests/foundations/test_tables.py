"""Checks of tables: every fault with its row, and speed with many of them."""

import time

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.tables import (
    CONTROL_POINTS,
    LINE,
    MODEL_POINTS,
    Y_PARALLAXES,
    check_table,
)


def model_points(**columns):
    base = {"model_id": ["1/2"] * 3, "point_id": ["A", "B", "C"]}
    base |= {"x": [1.0, 2.0, 3.0], "y": [4.0, 5.0, 6.0]}
    return pd.DataFrame({**base, **columns})


def the_one(said):
    (text,) = said
    return text


def said_of(frame, schema=MODEL_POINTS):
    return [str(p) for p in check_table(frame, schema, source="low.csv").problems]


def test_sound_table_is_completed():
    checked = check_table(model_points(), MODEL_POINTS)
    assert checked.problems == checked.notes == ()
    assert list(checked.frame.columns) == ["coverage", "model_id", "point_id", "x", "y"]
    assert checked.frame["coverage"].tolist() == ["1", "1", "1"]


def test_columns_in_the_index_are_brought_back():
    """It was "Add it as 'point_id'" for a table that has it as its index."""
    frame = model_points().set_index(["model_id", "point_id"])
    assert the_one(said_of(frame)) == (
        "low.csv: the index of the table has model_id, point_id, no column; its "
        "columns are x, y; expected model_id, point_id, x, y. Give table.reset_index()."
    )
    assert said_of(frame.reset_index()) == []


def test_rows_that_share_labels_are_told_by_their_position():
    """After pandas.concat row 0 was said to repeat row 0."""
    frame = pd.concat([model_points(), model_points().iloc[1:2]])
    said = the_one(said_of(frame))
    assert "row 3, point B, model 1/2: the row repeats row 1; " in said


def test_an_empty_table_of_python_has_no_block_toml():
    said = the_one(said_of(model_points().iloc[:0]))
    assert said.endswith("expected at least one. Fill it, or leave it out.")


def test_columns_come_in_the_order_of_the_schema():
    frame = model_points()[["y", "point_id", "x", "model_id"]]
    checked = check_table(frame, MODEL_POINTS)
    assert list(checked.frame.columns)[1:] == ["model_id", "point_id", "x", "y"]


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ([1, 2, 3], ["1", "2", "3"]),
        ([1.0, 2.0, 3.5], ["1", "2", "3.5"]),
        (["0012", " B ", "7/8"], ["0012", "B", "7/8"]),
        ([1, "B", 2.0], ["1", "B", "2"]),
        (pd.Categorical(["x", "y", "z"]), ["x", "y", "z"]),
        (np.array(["x", "y", "z"], dtype=object), ["x", "y", "z"]),
        (pd.array([1, 2, 3], dtype="Int64"), ["1", "2", "3"]),
    ],
)
def test_names_become_text(names, expected):
    checked = check_table(model_points(point_id=names), MODEL_POINTS)
    assert checked.problems == ()
    assert checked.frame["point_id"].tolist() == expected


@pytest.mark.parametrize("missing", [None, np.nan, "", "  ", pd.NA])
def test_missing_name_is_said(missing):
    assert the_one(said_of(model_points(point_id=["A", missing, "C"]))) == (
        "low.csv, row 1, model 1/2: point_id is missing; expected a name. Give the "
        "name or delete the row."
    )


@pytest.mark.parametrize("sign", "\t\n\r\x0b\x85\u2028")
@pytest.mark.parametrize("kind", ["str", object])
def test_names_of_several_lines_are_refused(sign, kind):
    names = pd.Series(["A", f"B{sign}1", f" C{sign}"], dtype=kind)
    said = the_one(said_of(model_points(point_id=names)))
    assert said.startswith("low.csv, row 1, point B\\")
    assert "has a line break or a tab in it; expected a name in one line" in said


def test_other_names_of_all_scripts_are_none_of_several_lines():
    names = ["A 1", "Ä\u00a01", "点"]
    checked = check_table(model_points(point_id=names), MODEL_POINTS)
    assert checked.problems == ()
    assert checked.frame["point_id"].tolist() == names


def test_missing_names_are_not_repeated_rows_as_well():
    assert len(said_of(model_points(point_id=["", "", ""]))) == 3


@pytest.mark.parametrize(
    ("numbers", "found"),
    [
        (["1", "n/a", "3"], "x 'n/a' is not a number; expected millimetres. Give a"),
        ([1, None, 3], "x is missing; expected millimetres. Give a value or delete"),
        ([1, np.inf, 3], "x 'inf' is infinite; expected millimetres. Give a value"),
        ([1, True, 3], "x 'True' is not a number; expected millimetres. Give a value"),
    ],
)
def test_wrong_number_is_said_with_row_point_and_model(numbers, found):
    (said,) = said_of(model_points(x=numbers))
    assert said.startswith(f"low.csv, row 1, point B, model 1/2: {found}")


def test_a_height_that_is_no_number_takes_no_row_along():
    control = pd.DataFrame(
        {"point_id": ["A"], "easting": [1.0], "northing": [2.0], "height": ["k.A."]}
    )
    (problem,) = check_table(control, CONTROL_POINTS).problems
    assert problem.remedy == "Give a value, or leave the cell empty"


def test_truth_values_and_dates_are_no_numbers():
    assert len(said_of(model_points(x=[True, False, True]))) == 3
    dates = pd.to_datetime(["1971-05-01"] * 3)
    told = "x '1971-05-01 00:00:00' is a date or a time, and no number"
    assert told in said_of(model_points(x=dates))[0]


def test_numbers_may_be_text_or_of_any_kind():
    for numbers in (["1", " 2.5", "+3e0"], np.float32([1, 2.5, 3]), [1, 2, 3]):
        checked = check_table(model_points(x=numbers), MODEL_POINTS)
        assert checked.problems == ()
        assert checked.frame["x"].dtype == float


def test_a_number_that_signals_itself_is_none_and_no_warning():
    """In a damaged file: a warning would be an error here."""
    signal = np.array([0x7FF0000000000001], dtype=np.uint64).view(float)
    x = np.concatenate([signal, [np.nan, 1.5, -np.inf]])
    names = {"model_id": "1", "point_id": list("ABCD")}
    frame = pd.DataFrame({**names, "x": x, "y": 0.0})
    problems = check_table(frame, MODEL_POINTS).problems
    assert [problem.row for problem in problems] == [0, 1, 3]


def test_positive_columns():
    (said,) = said_of(model_points(n_settings=[1.0, 0.0, 2.0]))
    assert "n_settings '0.0' is not above 0; expected numbers, above 0" in said


def test_heights_may_be_missing():
    frame = pd.DataFrame(
        {"point_id": ["A", "B"], "easting": [1.0, 2.0], "northing": [3.0, 4.0]}
    )
    checked = check_table(frame.assign(height=["7", ""]), CONTROL_POINTS)
    assert checked.problems == ()
    np.testing.assert_array_equal(checked.frame["height"], [7.0, np.nan])
    (said,) = said_of(frame.assign(height=["7", "x"]), CONTROL_POINTS)
    assert "point B: height 'x' is not a number" in said


@pytest.mark.parametrize(
    ("roles", "expected"),
    [
        (["control", "check"], ["control", "check"]),
        (["", None], ["control", "control"]),
        ([" check ", np.nan], ["check", "control"]),
    ],
)
def test_roles(roles, expected):
    frame = pd.DataFrame({"point_id": ["A", "B"], "easting": 1.0, "northing": 2.0})
    checked = check_table(frame.assign(role=roles), CONTROL_POINTS)
    assert checked.problems == ()
    assert checked.frame["role"].tolist() == expected


def test_unknown_role_is_said():
    frame = pd.DataFrame({"point_id": ["A"], "easting": 1.0, "northing": 2.0})
    assert the_one(said_of(frame.assign(role=["CHECK"]), CONTROL_POINTS)) == (
        "low.csv, row 0, point A: role 'CHECK' is unknown; expected control or check. "
        "Write check."
    )


def test_missing_columns_and_wrong_values_come_together():
    frame = model_points(x=["1", "n/a", "3"]).rename(columns={"y": "Y "})
    frame.index = pd.Index([2, 3, 4], name=LINE)
    said = said_of(frame)
    assert said[0] == (
        "low.csv, row 1: column 'y' is missing, found model_id, point_id, x, Y ; "
        "expected model_id, point_id, x, y. Rename 'Y ' to 'y'."
    )
    assert said[1].startswith("low.csv, row 3, point B, model 1/2: x 'n/a' is not")


@pytest.mark.parametrize(
    ("given", "remedy"),
    [("pointid", "Rename 'pointid' to 'point_id'"), ("Point_ID", "Rename 'Point_ID'")],
)
def test_near_column_is_proposed(given, remedy):
    frame = model_points().rename(columns={"point_id": given})
    assert remedy in said_of(frame)[0]


@pytest.mark.parametrize("unit", ["um", "cm", "µm"])
def test_a_column_in_another_unit_is_not_to_be_renamed(unit):
    frame = model_points().rename(columns={"x": f"x [{unit}]"})
    told = unit.replace("µ", "u")
    assert f"'x [{unit}]' is in {told}; expected millimetres" in said_of(frame)[0]
    frame = model_points().rename(columns={"point_id": "point_id [mm]"})
    assert "Rename 'point_id [mm]' to 'point_id'" in said_of(frame)[0]


def test_row_is_said_as_line_only_of_files():
    """A frame of a script has no header line."""
    (said,) = said_of(model_points().drop(columns="x"))
    assert said.startswith("low.csv: column 'x' is missing")


def test_double_column():
    frame = pd.concat([model_points(), model_points()[["x"]]], axis=1)
    assert the_one(said_of(frame)) == (
        "low.csv: column 'x' stands twice; expected each column once. Delete or "
        "rename one of them."
    )


def test_columns_that_are_no_text():
    frame = model_points().assign(**{"7": 1.0}).rename(columns={"7": 7})
    checked = check_table(frame, MODEL_POINTS, source="low.csv")
    assert checked.notes == ("low.csv: ignored column 7",)


def test_empty_table_of_a_file():
    frame = model_points().iloc[:0].rename_axis(LINE)
    assert the_one(said_of(frame)) == (
        "low.csv: the table has no rows; expected at least one. Fill it, or take its "
        "key out of block.toml."
    )


def test_repeated_row_names_the_first():
    frame = model_points(point_id=["A", "B", "A"])
    assert the_one(said_of(frame)) == (
        "low.csv, row 2, point A, model 1/2: the row repeats row 0; expected each "
        "coverage + model_id + point_id once. Delete one of the two, or rename it."
    )


def test_equal_model_names_of_two_coverages_are_no_repetition():
    frame = model_points(point_id=["A", "A", "A"], coverage=["1", "2", "3"])
    assert said_of(frame) == []


def test_index_that_repeats_itself():
    """Frames of scripts are often put together of several."""
    frame = pd.concat([model_points(), model_points(point_id=["D", "E", ""])])
    said = said_of(frame)
    assert len(said) == 1
    assert said[0].startswith("low.csv, row 5, model 1/2: point_id is missing")


def test_index_of_names_is_not_said_as_row():
    frame = model_points(x=["1", "n/a", "3"])
    frame.index = ["p", "q", "r"]
    (said,) = said_of(frame)
    assert said.startswith("low.csv, point B, model 1/2: x 'n/a'")


def test_a_fault_of_many_rows_is_said_once_with_their_number():
    n = 10_000
    frame = pd.DataFrame(
        {"model_id": "1/2", "point_id": np.arange(n), "x": "1,5", "y": 0.0}
    )
    (problem,) = check_table(frame, MODEL_POINTS, source="low.csv").problems
    assert problem.found == (
        "x '1,5' has a decimal comma; x is wrong in 9999 more rows (1, 2, 3, 4, 5, …)"
    )
    assert problem.stands_for == n


def large_table(n):
    names = [f"P{k % (n // 5):07d}" for k in range(n)]
    models = [f"{k // 7}/{k // 7 + 1}" for k in range(n)]
    x = np.linspace(-115, 115, n)
    frame = pd.DataFrame({"model_id": models, "point_id": names, "x": x, "y": x})
    return frame.assign(coverage=np.repeat(["1", "2"], n // 2))


@pytest.fixture(scope="module")
def million_rows():
    return large_table(1_000_000)


def seconds_of_check(frame, schema):
    started = time.process_time()
    checked = check_table(frame, schema)
    return time.process_time() - started, checked


@pytest.mark.slow
def test_a_million_sound_rows_take_less_than_a_second(million_rows):
    seconds, checked = seconds_of_check(million_rows, MODEL_POINTS)
    assert checked.problems == ()
    assert seconds < 3.0  # usually 0.35 s


@pytest.mark.slow
def test_a_million_repeated_rows_are_found_in_time(million_rows):
    """Each row once more: not quadratic in their number."""
    doubled = pd.concat([million_rows, million_rows], ignore_index=True)
    seconds, checked = seconds_of_check(doubled, MODEL_POINTS)
    assert sum(problem.stands_for for problem in checked.problems) == 1_000_000
    assert checked.problems[0].found.startswith("the row repeats row 0; ")
    assert seconds < 10.0  # usually 1 s


@pytest.mark.slow
def test_a_million_wrong_numbers_are_said_in_time(million_rows):
    text = million_rows["x"].map("{:.3f}".format).str.replace(".", ",")
    seconds, checked = seconds_of_check(million_rows.assign(x=text), MODEL_POINTS)
    assert sum(problem.stands_for for problem in checked.problems) == 1_000_000
    assert seconds < 6.0  # usually 0.6 s


def test_names_of_all_tables_are_distinct():
    for schema in (CONTROL_POINTS, MODEL_POINTS, Y_PARALLAXES):
        assert len(set(schema.names)) == len(schema.names)
        assert set(schema.key) <= set(schema.id_names)
        assert not set(schema.number_names) & set(schema.id_names)


def test_a_checked_table_stays_as_it_was_checked():
    """It shares columns with the table that was given, until one is written to."""
    given = pd.DataFrame({"model_id": ["1", "2"], "point_id": ["A", "B"]})
    given = given.assign(x=[1.0, 2.0], y=[3.0, 4.0])
    checked = check_table(given, MODEL_POINTS).frame
    given.loc[0, ["x", "point_id"]] = 99.0, "Z"
    assert checked.loc[0, ["x", "point_id"]].tolist() == [1.0, "A"]
    checked.loc[1, "y"] = -1.0
    assert given["y"].tolist() == [3.0, 4.0]
