"""The suffix of a table tells its format."""

import pandas as pd
import pytest

from einschalt.foundations.errors import FileError
from einschalt.foundations.tables import Column, Schema
from einschalt.interfaces.files.tables_by_suffix import read_table, write_table

SCHEMA = Schema("points", (Column("point_id", "id"), Column("x")), key=("point_id",))


FRAME = pd.DataFrame({"point_id": ["0012", "7/8"], "x": [0.1, -2.0]})


@pytest.mark.parametrize("suffix", [".csv", ".CSV", ".parquet"])
def test_written_tables_come_back(tmp_path, suffix):
    write_table(FRAME, tmp_path / f"t{suffix}")
    back = read_table(tmp_path / f"t{suffix}", SCHEMA)
    pd.testing.assert_frame_equal(back.reset_index(drop=True), FRAME)


@pytest.mark.parametrize(
    ("written", "read"), [(".csv", ".txt"), (".csv", ".tsv"), (".parquet", ".pq")]
)
def test_other_usual_suffixes_are_read(tmp_path, written, read):
    write_table(FRAME, tmp_path / f"t{written}")
    (tmp_path / f"t{written}").rename(tmp_path / f"t{read}")
    back = read_table(tmp_path / f"t{read}", SCHEMA)
    pd.testing.assert_frame_equal(back.reset_index(drop=True), FRAME)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("t.xls", r"t\.xls: suffix '\.xls' is unknown; expected \.csv, \."),
        ("t", r"t: the suffix is missing; expected .*\. Save the table as CSV UTF-8"),
    ],
)
def test_other_suffixes_are_refused(tmp_path, name, said):
    with pytest.raises(FileError, match=said):
        read_table(tmp_path / name, SCHEMA)
    with pytest.raises(FileError, match=said):
        write_table(pd.DataFrame({"x": [1.0]}), tmp_path / name)
    assert list(tmp_path.iterdir()) == []
