"""The suffix of a table tells its format."""

import re

import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import FileError
from einschalt.foundations.tables import Column, Schema
from einschalt.interfaces.files.geopackage import write_geopackage
from einschalt.interfaces.files.tables_by_suffix import (
    read_table,
    understand_table,
    write_table,
)
from einschalt.interfaces.files.understood_tables import Said

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
    ("text", "said", "remedy"),
    [
        ("point_id,Y,X\nA,1,2\n", {}, "columns={"),
        (
            "point_id,east,northing\nA,1,2\n",
            {"columns": {"easting": "E"}},
            "Correct col",
        ),
        ("point_id;easting;northing\nA;1,234;2,345\n", {}, 'Give decimal=","'),
    ],
)
def test_python_is_told_its_arguments_and_not_block_toml(text, said, remedy, tmp_path):
    path = tmp_path / "points.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(es.EinschaltError) as refused:
        es.read_points(path, **said)
    assert remedy in refused.value.remedy
    assert "block.toml" not in str(refused.value)


def test_a_layer_of_several_is_asked_for_by_its_argument(tmp_path, good_result):
    write_geopackage(good_result, tmp_path / "block.gpkg")
    for layer in (None, "point"):
        with pytest.raises(es.EinschaltError, match="Say which by the argument layer"):
            es.read_points(tmp_path / "block.gpkg", layer=layer)


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


@pytest.mark.parametrize(
    ("key", "suffix", "kinds"),
    [
        ("layer", ".csv", ".gpkg or .shp or .geojson"),
        ("layer", ".parquet", ".gpkg or .shp or .geojson"),
        ("sheet", ".csv", ".xlsx or .ods"),
    ],
)
def test_a_part_of_a_file_that_has_none_is_refused(tmp_path, key, suffix, kinds):
    write_table(FRAME, tmp_path / f"t{suffix}")
    said = (
        f"t{suffix}: {key} = 'x' is said of a {suffix} file, which has none; expected "
        f"{key} of {kinds} alone. Leave {key} out"
    )
    with pytest.raises(FileError, match=re.escape(said)):
        es.read_points(tmp_path / f"t{suffix}", **{key: "x"})
    with pytest.raises(FileError, match=re.escape(said)):
        understand_table(tmp_path / f"t{suffix}", SCHEMA, Said(**{key: "x"}))
