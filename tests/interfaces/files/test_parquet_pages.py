"""Pages of Parquet files: how much they unpack to, before anything is unpacked."""

import json
import subprocess
import sys

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
import shapely
from pyarrow import parquet

from einschalt.foundations.errors import FileError
from einschalt.foundations.tables import CONTROL_POINTS, MODEL_POINTS, check_table
from einschalt.interfaces.files import parquet_columns, unpacked_sizes
from einschalt.interfaces.files.parquet_pages import texts_of
from einschalt.interfaces.files.parquet_tables import read_parquet, write_parquet

N_ROWS = 60_000


def pages_of(path, name="point_id"):
    metadata = parquet.read_metadata(path)
    place = metadata.schema.names.index(name)
    groups = range(metadata.num_row_groups)
    chunks = [metadata.row_group(group).column(place) for group in groups]
    return [texts_of(path.read_bytes(), chunk) for chunk in chunks]


def model_points():
    rows = np.arange(N_ROWS)
    return pd.DataFrame(
        {
            "coverage": np.where(rows % 2, "1", "2"),
            "model_id": [f"m{k // 50}" for k in rows],
            "point_id": [f"P{k}" for k in rows],
            "x": rows / 7.0,
            "y": rows * -1.5,
        }
    )


@pytest.mark.parametrize("compression", ["zstd", "snappy", "gzip", "brotli", "none"])
@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("is_coded", [True, False])
def test_bound_of_what_pages_unpack_to(tmp_path, compression, version, is_coded):
    """Never less than there is, and little more where lengths are alike."""
    path = tmp_path / "t.parquet"
    names = pa.array([None if k % 7 == 0 else f"P{k:06d}" for k in range(5000)])
    parquet.write_table(
        pa.table({"point_id": names}),
        path,
        compression=compression,
        data_page_version=version,
        use_dictionary=is_coded,
        row_group_size=2000,
        data_page_size=4096,
    )
    found = pages_of(path)
    given = sum(len(name) for name in names.to_pylist() if name)
    assert given <= sum(texts.most_bytes for texts in found) <= 3 * given
    n_names = sum(texts.n_names for texts in found)
    assert n_names == (names.drop_null().unique().__len__() if is_coded else 0)
    n_written_out = sum(texts.n_written_out for texts in found)
    assert n_written_out == (0 if is_coded else 5000)


def test_one_long_name_in_the_dictionary_counts_for_every_row(tmp_path):
    path = tmp_path / "t.parquet"
    names = pa.array(["x" * 10_000] + ["P1"] * 999)
    parquet.write_table(pa.table({"point_id": names}), path)
    (texts,) = pages_of(path)
    assert texts.most_bytes == 1000 * 10_000


@pytest.mark.parametrize("encoding", ["DELTA_BYTE_ARRAY", "DELTA_LENGTH_BYTE_ARRAY"])
def test_only_encodings_that_write_names_out_are_trusted(tmp_path, encoding):
    path = tmp_path / "t.parquet"
    parquet.write_table(
        pa.table({"point_id": [f"P{k}" for k in range(1000)]}),
        path,
        use_dictionary=False,
        column_encoding={"point_id": encoding},
    )
    is_known = encoding == "DELTA_LENGTH_BYTE_ARRAY"  # the other repeats beginnings
    assert (pages_of(path) != [None]) is is_known


@pytest.mark.slow
def test_headers_that_do_not_add_up_tell_nothing(tmp_path):
    path = tmp_path / "t.parquet"
    parquet.write_table(pa.table({"point_id": [f"P{k}" for k in range(1000)]}), path)
    chunk = parquet.read_metadata(path).row_group(0).column(0)
    whole = path.read_bytes()
    known = texts_of(whole, chunk)
    start, end = chunk.dictionary_page_offset, chunk.data_page_offset + 40
    found = set()
    for place in range(start, end):
        for value in (0, 0x0C, 0x15, 0x7F, 0xFF):
            changed = whole[:place] + bytes([value]) + whole[place + 1 :]
            found.add(texts_of(changed, chunk))
    assert None in found
    assert known in found  # the bytes of names themselves say nothing of it
    assert texts_of(whole[: start + 3], chunk) is None


@pytest.mark.slow
def test_long_tables_are_the_same_from_text_and_from_codes(tmp_path, monkeypatch):
    path, frame = tmp_path / "t.parquet", model_points()
    write_parquet(frame, path)
    read = read_parquet(path, MODEL_POINTS)
    pd.testing.assert_frame_equal(read.reset_index(drop=True), frame, check_dtype=False)
    monkeypatch.setattr(parquet_columns, "MANY", 2 * N_ROWS)  # then as codes
    pd.testing.assert_frame_equal(read_parquet(path, MODEL_POINTS), read)
    monkeypatch.setattr(parquet_columns, "n_cores", lambda: 1)
    pd.testing.assert_frame_equal(read_parquet(path, MODEL_POINTS), read)


def test_dictionaries_are_written_where_they_make_the_file_smaller(tmp_path):
    path = tmp_path / "t.parquet"
    write_parquet(model_points(), path)
    group = parquet.read_metadata(path).row_group(0)
    columns = [group.column(k) for k in range(5)]
    coded = {c.path_in_schema for c in columns if c.has_dictionary_page}
    assert coded == {"coverage", "model_id"}


@pytest.mark.parametrize(
    ("n_rows", "kind", "length"),
    [
        (1000, pa.string(), 2**19),  # a short table, read as codes
        (N_ROWS, pa.string(), 2**13),
        (N_ROWS, pa.binary(2**12), 2**12),  # all of one length: there are no codes
    ],
)
def test_a_name_that_would_fill_the_memory_is_refused(tmp_path, n_rows, kind, length):
    codes = pa.array(np.zeros(n_rows, dtype=np.int32))
    name = pa.array([b"x" * length]).cast(kind)
    column = pa.DictionaryArray.from_arrays(codes, name)
    column = column if kind == pa.string() else column.cast(kind)
    x = pa.array(np.zeros(n_rows))
    table = pa.table({"model_id": column, "point_id": column, "x": x, "y": x})
    path = tmp_path / "t.parquet"
    parquet.write_table(table, path, dictionary_pagesize_limit=2**30)
    with pytest.raises(FileError, match=r"t\.parquet: \d+ bytes would unpack to"):
        read_parquet(path, MODEL_POINTS)


DELTAS = ("DELTA_BYTE_ARRAY", "DELTA_LENGTH_BYTE_ARRAY")


@pytest.mark.parametrize("encoding", DELTAS)
@pytest.mark.parametrize("n_rows", [0, 1, 100, N_ROWS])
@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_names_of_delta_encodings_are_read(tmp_path, encoding, n_rows, version):
    frame = model_points().head(n_rows)
    path = tmp_path / "t.parquet"
    names = ["coverage", "model_id", "point_id"]
    parquet.write_table(
        pa.Table.from_pandas(frame, preserve_index=False),
        path,
        use_dictionary=False,
        column_encoding=dict.fromkeys(names, encoding),
        data_page_version=version,
        row_group_size=25_000,
    )
    read = read_parquet(path, MODEL_POINTS).reset_index(drop=True)
    pd.testing.assert_frame_equal(read, frame, check_dtype=False)


@pytest.mark.parametrize("encoding", DELTAS)
def test_geometries_of_delta_encodings_are_read(tmp_path, encoding):
    path = tmp_path / "t.parquet"
    points = shapely.to_wkb(shapely.points([[1.0, 2.0], [3.0, 4.0]]))
    facts = {"encoding": "WKB", "geometry_types": [], "crs": None}
    geo = {"primary_column": "geometry", "columns": {"geometry": facts}}
    table = pa.table({"point_id": ["P1", "P2"], "geometry": list(points)})
    parquet.write_table(
        table.replace_schema_metadata({b"geo": json.dumps(geo).encode()}),
        path,
        use_dictionary=False,
        column_encoding=dict.fromkeys(table.column_names, encoding),
    )
    read = read_parquet(path, CONTROL_POINTS)
    assert read[["easting", "northing"]].to_numpy().tolist() == [[1, 2], [3, 4]]


def test_a_table_of_nothing_but_delta_names_is_read(tmp_path):
    path = tmp_path / "t.parquet"
    parquet.write_table(
        pa.table({"point_id": ["P1", None, "P3"]}),
        path,
        use_dictionary=False,
        column_encoding={"point_id": "DELTA_BYTE_ARRAY"},
    )
    read = read_parquet(path, MODEL_POINTS)["point_id"]
    assert read.fillna("-").tolist() == ["P1", "-", "P3"]


@pytest.mark.parametrize("n_rows", [1000, N_ROWS])
def test_a_name_that_each_row_repeats_is_refused_before_it_fills_the_memory(
    tmp_path, n_rows, monkeypatch
):
    """Each name shares all of its bytes with the one before it."""
    path = tmp_path / "t.parquet"
    parquet.write_table(
        pa.table({"point_id": ["x" * (2**27 // n_rows)] * n_rows}),
        path,
        use_dictionary=False,
        column_encoding={"point_id": "DELTA_BYTE_ARRAY"},
        compression="zstd",
    )
    assert path.stat().st_size < 2**17
    monkeypatch.setattr(unpacked_sizes, "HARMLESS_BYTES", 2**22)
    before = pa.total_allocated_bytes()
    most, refuse_it = [], unpacked_sizes.refuse_unpacked

    def refuse(*facts):
        most.append(pa.total_allocated_bytes() - before)
        refuse_it(*facts)

    monkeypatch.setattr(unpacked_sizes, "refuse_unpacked", refuse)
    with pytest.raises(FileError, match=r"t\.parquet: \d+ bytes would unpack to"):
        read_parquet(path, MODEL_POINTS)
    assert 2**22 < max(most) < 2**25


LONG = "1" * 2**13


def longs():
    """Half a gigabyte, more than twice of what reading may take."""
    return pa.array([LONG] * N_ROWS)


def lists():
    """As much in numbers."""
    starts = np.arange(N_ROWS + 1, dtype=np.int32) * 1000
    return pa.ListArray.from_arrays(starts, pa.array(np.ones(starts[-1])))


# made by the test that reads them: all of them would fill the memory of each worker
OF_LONG = {
    "a text of a dictionary": longs,
    "bytes": lambda: pa.array([LONG.encode()] * N_ROWS),
    "a text of DELTA": longs,
    "codes": lambda: longs().dictionary_encode(),
    "lists": lists,
    "lists of texts": lambda: pa.array([[LONG]] * N_ROWS),
    "structures": lambda: pa.StructArray.from_arrays([longs()], ["a"]),
}
NESTED = {"lists", "lists of texts", "structures"}
# ru_maxrss of a new process would begin with what the one that started it has had
READ = """
import re, sys
from pathlib import Path
from einschalt.foundations.errors import FileError
from einschalt.foundations.tables import MODEL_POINTS
from einschalt.interfaces.files.parquet_tables import read_parquet

def most_kilobytes():
    status = Path("/proc/self/status").read_text()
    return int(re.search(r"VmHWM:\\s*(\\d+) kB", status)[1])

before = most_kilobytes()
try:
    read_parquet(sys.argv[1], MODEL_POINTS)
except FileError as error:
    print(error)
print((most_kilobytes() - before) // 1024)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="asks /proc")
@pytest.mark.parametrize("kind", OF_LONG)
def test_numbers_that_would_fill_the_memory_are_refused_before(tmp_path, kind):
    """A few hundred kilobytes, which would be half a gigabyte in memory."""
    path = tmp_path / "t.parquet"
    names = pa.array([f"P{k}" for k in range(N_ROWS)])
    y = pa.array(np.zeros(N_ROWS))
    table = {"model_id": names, "point_id": names, "y": y, "x": OF_LONG[kind]()}
    is_coded = "DELTA" not in kind
    parquet.write_table(
        pa.table(table),
        path,
        compression="zstd",
        dictionary_pagesize_limit=2**30,
        use_dictionary=True if is_coded else ["model_id"],
        column_encoding=None if is_coded else {"x": "DELTA_BYTE_ARRAY"},
    )
    assert path.stat().st_size < 2**20
    command = [sys.executable, "-c", READ, path]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    told, n_megabytes = ran.stdout.splitlines()
    found = f"more than {100 * N_ROWS} bytes of text in {N_ROWS} rows"
    found = "lists or structures" if kind in NESTED else found
    assert told.startswith(f"t.parquet: column 'x' holds {found}; expected")
    assert int(n_megabytes) < 200


def test_long_texts_in_a_few_rows_are_quoted_as_no_numbers(tmp_path):
    path = tmp_path / "t.parquet"
    columns = {"model_id": ["1"], "point_id": ["P1"], "x": [LONG], "y": [1.0]}
    parquet.write_table(pa.table(columns), path)
    checked = check_table(read_parquet(path, MODEL_POINTS), MODEL_POINTS)
    assert "is not a number" in checked.problems[0].found


def test_no_column_of_values_in_every_row_may_add_up_to_a_monster(tmp_path):
    """Each column of one value is a few bytes, and eight of them a gigabyte."""
    n_rows = 5 * 10**6
    path, one = tmp_path / "t.parquet", pa.array([1.0]).dictionary_encode()
    codes = pa.array(np.zeros(n_rows, np.int8))
    column = pa.DictionaryArray.from_arrays(codes, one.dictionary)
    table = pa.table(dict.fromkeys(["model_id", "point_id", "x", "y"], column))
    parquet.write_table(table, path)
    assert path.stat().st_size < 10**5
    with pytest.raises(FileError, match="would unpack to 160000000 bytes"):
        read_parquet(path, MODEL_POINTS)
