"""Tables that stand one below the other in a sheet."""

import pyarrow as pa
import pyogrio
import pytest
import xlsxwriter

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.tables import (
    CONTROL_POINTS,
    IMAGE_POINTS,
    MEASURED_MODEL_POINTS,
)
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.files.understood_tables import Said
from einschalt.interfaces.new_block.looked_at import look_at

CONTROL = [
    ["Punktnummer", "Rechtswert", "Hochwert", "Höhe"],
    ["P1", "13000.5", "322000.25", "411.5"],
    ["P2", "13100.5", "322100.25", "412.5"],
]
MODELS = [
    ["Modell", "Punkt", "x", "y"],
    ["7/8 a", "P1", "10.5", "20.5"],
    ["7/8 a", "P2", "30.5", "40.5"],
    ["8/9 a", "P2", "31.5", "41.5"],
]
EMPTY = [["", "", "", ""]]
TITLE = [["Hochflug", "", "", ""]]


def write(path, rows):
    if path.suffix == ".xlsx":
        book = xlsxwriter.Workbook(path)
        sheet = book.add_worksheet("Blatt")
        for place, row in enumerate(rows):
            sheet.write_row(place, 0, row)
        book.close()
        return path
    head, *rest = rows
    columns = [pa.array(column) for column in zip(*rest, strict=True)]
    table = pa.table(columns, names=head)
    options = {"layer": "Blatt", "driver": "ODS", "geometry_name": None}
    pyogrio.write_arrow(table, path, **options)
    return path


def names(path, schema, column="point_id"):
    return understand_table(path, schema).frame[column].tolist()


@pytest.mark.parametrize("suffix", [".xlsx", ".ods"])
@pytest.mark.parametrize("title", [[], TITLE])
@pytest.mark.parametrize("n_empty", [1, 3])
def test_the_table_that_fits_is_read(tmp_path, suffix, title, n_empty):
    for rows in (
        [*CONTROL, *EMPTY * n_empty, *title, *MODELS],
        [*MODELS, *EMPTY * n_empty, *title, *CONTROL],
    ):
        path = write(tmp_path / f"t{suffix}", rows)
        assert names(path, CONTROL_POINTS) == ["P1", "P2"]
        points = understand_table(path, MEASURED_MODEL_POINTS)
        assert points.frame["model_id"].tolist() == ["7/8 a", "7/8 a", "8/9 a"]
        first = 1 if rows[0] is MODELS[0] else len(rows) - len(MODELS) - len(title) + 1
        last = len(rows) if first > 1 else len(MODELS)
        told = "sheet 'Blatt' has 2 tables, one below the other; read are the rows "
        assert f"t{suffix}: {told}{first} to {last}" in points.notes


@pytest.mark.slow
def test_init_sees_every_table_of_a_sheet(tmp_path):
    path = write(tmp_path / "t.xlsx", [*CONTROL, *EMPTY, *MODELS])
    found = {one.kind: len(one.frame) for one in look_at(path, Said())}
    assert found == {"ground": 2, "model_points": 3}
    path = write(tmp_path / "one.xlsx", MODELS)
    assert [one.kind for one in look_at(path, Said())] == ["model_points"]


def test_two_tables_of_one_kind_are_asked_about(tmp_path):
    again = [["8/9 b", "P3", "1.5", "2.5"]]
    path = write(tmp_path / "t.xlsx", [*MODELS, *EMPTY, *TITLE, MODELS[0], *again])
    said = (
        r"t\.xlsx: sheet 'Blatt' has 2 tables that could be meant, in the rows 1 to 4, "
        r"6 to 8; expected one table that has these columns\. Put each of them on"
    )
    with pytest.raises(EinschaltError, match=said):
        understand_table(path, MEASURED_MODEL_POINTS)
    with pytest.raises(EinschaltError, match="could be meant"):
        look_at(path, Said())


def test_a_header_once_more_and_empty_rows_part_no_table(tmp_path):
    more = [["P3", "13200.5", "322200.25", "413.5"]]
    for rows in (
        [*CONTROL, *EMPTY, *more],
        [*CONTROL, *EMPTY, CONTROL[0], *more],
        [*TITLE, *EMPTY, *CONTROL, *EMPTY * 2, *more],
    ):
        path = write(tmp_path / "t.xlsx", rows)
        table = understand_table(path, CONTROL_POINTS)
        assert table.frame["point_id"].tolist() == ["P1", "P2", "P3"]
        assert table.n_beside == 0
        assert not [note for note in table.notes if "one below" in note]


def test_a_sheet_without_such_a_table_is_refused_as_before(tmp_path):
    path = write(tmp_path / "t.xlsx", [*CONTROL, *EMPTY, *MODELS])
    table = understand_table(path, IMAGE_POINTS)
    assert "image_id" not in table.frame
