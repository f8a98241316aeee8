"""Parquet tables: other programs' kinds of columns, and files that are none."""

import datetime as dt
from decimal import Decimal

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from pyarrow import parquet

from einschalt.foundations.errors import FileError, TableError
from einschalt.foundations.tables import CONTROL_POINTS, MODEL_POINTS, check_table
from einschalt.interfaces.files import unpacked_sizes
from einschalt.interfaces.files.parquet_tables import read_parquet, write_parquet


def read_back(tmp_path, **columns):
    base = {"model_id": ["1/2", "1/2"], "point_id": ["A", "B"]}
    base |= {"x": [1.0, 2.0], "y": [3.0, 4.0]}
    path = tmp_path / "low.parquet"
    parquet.write_table(pa.table({**base, **columns}), path)
    return read_parquet(path, MODEL_POINTS)


@pytest.mark.parametrize(
    ("column", "names"),
    [
        (pa.array([7, 12]), ["7", "12"]),
        (pa.array([2**62 + 1, 12], pa.uint64()), [str(2**62 + 1), "12"]),
        (pa.array([7.0, 12.0]), ["7", "12"]),
        (pa.array([7.5, 12.0]), ["7.5", "12"]),
        (pa.array(["0012", "7/8"]).dictionary_encode(), ["0012", "7/8"]),
        (pa.array(["0012", "7/8"], pa.large_string()), ["0012", "7/8"]),
        (pa.array([Decimal(7), Decimal(12)], pa.decimal128(5, 0)), ["7", "12"]),
    ],
)
def test_names_become_text(tmp_path, column, names):
    frame = read_back(tmp_path, point_id=column)
    checked = check_table(frame, MODEL_POINTS)
    assert checked.problems == ()
    assert checked.frame["point_id"].tolist() == names


@pytest.mark.parametrize(
    "column",
    [
        pa.array([1, 2]),
        pa.array([1, 2], pa.int8()),
        pa.array([1, 2], pa.float32()),
        pa.array([Decimal("1.00"), Decimal("2.00")]),
        pa.array(["1", "2.0"]),
        pa.array([1.0, 2.0]).dictionary_encode(),
    ],
)
def test_numbers_of_every_kind_become_float(tmp_path, column):
    checked = check_table(read_back(tmp_path, x=column), MODEL_POINTS)
    assert checked.problems == ()
    assert checked.frame["x"].dtype == float
    assert checked.frame["x"].tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("column", "found"),
    [
        (pa.array([1.0, None]), "x is missing"),
        (pa.array([1.0, np.nan]), "x is missing"),
        (pa.array([1.0, np.inf]), "x 'inf' is infinite"),
        (pa.array([True, False]), "x 'true' is not a number"),
        (pa.array(["1.0", "2,5"]), "x '2,5' has a decimal comma"),
        (
            pa.array([dt.date(1971, 5, 1)] * 2),
            "x '1971-05-01' is a date or a time, and no number",
        ),
        (pa.array([b"1", b"2"]), "x \"b'1'\" is not a number"),
    ],
)
def test_what_is_no_number_is_quoted_with_its_row(tmp_path, column, found):
    checked = check_table(read_back(tmp_path, x=column), MODEL_POINTS)
    assert checked.problems[0].found == found
    last = checked.problems[-1]
    assert (last.row, last.point) == (2, "B")


def test_rows_are_counted_from_one(tmp_path):
    assert read_back(tmp_path).index.tolist() == [1, 2]


def test_round_trip_keeps_every_digit(tmp_path):
    frame = pd.DataFrame(
        {
            "model_id": ["1/2"] * 3,
            "point_id": ["0012", "Ö 7", 'a"b'],
            "x": [np.pi * 1e6, -0.0, 5e-324],
            "y": [1.0, 2.0, 3.0],
        }
    )
    write_parquet(frame, tmp_path / "a.parquet")
    back = read_parquet(tmp_path / "a.parquet", MODEL_POINTS)
    pd.testing.assert_frame_equal(back.reset_index(drop=True), frame, check_exact=True)


def test_equal_tables_are_equal_files_that_tell_nothing_of_their_writer(tmp_path):
    frame = pd.DataFrame({"point_id": ["A"], "x": [1.0]}, index=[7])
    for name in ("a.parquet", "b.parquet"):
        write_parquet(frame, tmp_path / name)
    data = (tmp_path / "a.parquet").read_bytes()
    assert data == (tmp_path / "b.parquet").read_bytes()
    assert b"pandas" not in data
    assert parquet.read_schema(tmp_path / "a.parquet").names == ["point_id", "x"]


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda data: data[: len(data) // 2], "the file is truncated"),
        (lambda data: data[:10] + bytes(200) + b"PAR1", "the file is damaged"),
        (lambda _: b"point_id,x\n", r"is no Parquet file, it begins with 'point_id,x"),
        (lambda _: b"", "is empty"),
    ],
)
def test_file_that_is_no_parquet_file(tmp_path, spoil, said):
    path = tmp_path / "low.parquet"
    parquet.write_table(pa.table({"x": [1.0]}), path)
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(
        FileError, match=rf"^low\.parquet: {said}.*; expected a Parquet"
    ):
        read_parquet(path, MODEL_POINTS)


def test_folders_like_those_of_data_sets_add_no_columns(tmp_path):
    folder = tmp_path / "x=5"
    folder.mkdir()
    assert list(read_back(folder).columns) == ["model_id", "point_id", "x", "y"]


@pytest.mark.parametrize(
    "column",
    [
        pa.array([[1.0], [2.0]]),
        pa.array([{"a": 1.0}, {"a": 2.0}]),
        pa.array([[("a", 1.0)], []], pa.map_(pa.string(), pa.float64())),
        pa.array([[1.0, 2.0], None], pa.list_(pa.float64(), 2)),
    ],
)
@pytest.mark.parametrize("name", ["x", "z", "point_id"])
def test_lists_and_structures_are_no_values(tmp_path, name, column):
    told = f"column '{name}' holds lists or structures; expected one value in each row"
    with pytest.raises(FileError, match=told):
        read_back(tmp_path, **{name: column})


def test_other_columns_may_hold_lists(tmp_path):
    assert len(read_back(tmp_path, rays=pa.array([[1.0], [2.0]]))) == 2


@pytest.mark.parametrize(
    "geo",
    [
        "[" * 100_000,
        '{"primary_column": "x", "columns": {"x": {"encoding": "WKB", "crs": '
        + '{"a": ' * 100_000,
    ],
)
def test_nested_facts_of_a_geometry_are_those_of_none(tmp_path, geo):
    table = pa.table({"model_id": ["1"], "point_id": ["A"], "x": [1.0], "y": [2.0]})
    table = table.replace_schema_metadata({b"geo": geo.encode()})
    parquet.write_table(table, tmp_path / "t.parquet")
    frame = read_parquet(tmp_path / "t.parquet", MODEL_POINTS)
    assert frame.to_numpy().tolist() == [["1", "A", 1.0, 2.0]]


def test_more_groups_of_rows_than_are_counted_are_refused(tmp_path, monkeypatch):
    names = [str(k) for k in range(5)]
    table = {"model_id": names, "point_id": names, "x": [1.0] * 5, "y": [1.0] * 5}
    path = tmp_path / "t.parquet"
    parquet.write_table(pa.table(table), path, row_group_size=1)
    monkeypatch.setattr(unpacked_sizes, "MOST_GROUPS", 5)
    assert len(read_parquet(path, MODEL_POINTS)) == 5
    monkeypatch.setattr(unpacked_sizes, "MOST_GROUPS", 4)
    with pytest.raises(FileError, match="5 groups of rows; expected at most 4"):
        read_parquet(path, MODEL_POINTS)


@pytest.mark.parametrize(
    "names",
    [
        pa.array([dt.datetime(2024, 1, 7)], pa.timestamp("us")),
        pa.array([dt.date(2024, 1, 7)]),
        pa.array([dt.time(7, 30)]),
        pa.array([True]),
    ],
)
def test_names_that_are_kept_as_dates_are_refused(tmp_path, names):
    plane = {"easting": [1.5], "northing": [2.5]}
    parquet.write_table(pa.table({"point_id": names, **plane}), tmp_path / "t.parquet")
    with pytest.raises(TableError, match="names in column point_id are of the type"):
        read_parquet(tmp_path / "t.parquet", CONTROL_POINTS)
