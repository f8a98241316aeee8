"""Workbooks of a few kilobytes that would fill the memory, and some that do not."""

import ctypes
import resource
import sqlite3
import zipfile
from pathlib import Path

import numpy as np
import pyogrio
import pytest
import shapely

from einschalt.foundations.errors import FileError
from einschalt.foundations.tables import CONTROL_POINTS
from einschalt.interfaces.files import workbook_sizes
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.files.understood_tables import Said

NAMESPACE = "http://schemas.openxmlformats.org/"
SHEET = NAMESPACE + "spreadsheetml/2006/main"
LINKS = NAMESPACE + "officeDocument/2006/relationships"
PACKAGE = NAMESPACE + "package/2006/"
KIND = "application/vnd.openxmlformats-officedocument.spreadsheetml"
KINDS = f"""<Types xmlns="{PACKAGE}content-types">
<Default Extension="xml" ContentType="application/xml"/>
<Override PartName="/xl/workbook.xml" ContentType="{KIND}.sheet.main+xml"/>
<Override PartName="/xl/worksheets/sheet1.xml" ContentType="{KIND}.worksheet+xml"/>
</Types>"""
ROOT = f"""<Relationships xmlns="{PACKAGE}relationships"><Relationship Id="a"
Type="{LINKS}/officeDocument" Target="xl/workbook.xml"/></Relationships>"""
BOOK = f"""<workbook xmlns="{SHEET}" xmlns:r="{LINKS}"><sheets>
<sheet name="S" sheetId="1" r:id="a"/></sheets></workbook>"""
PARTS = f"""<Relationships xmlns="{PACKAGE}relationships">
<Relationship Id="a" Type="{LINKS}/worksheet" Target="worksheets/sheet1.xml"/>
<Relationship Id="b" Type="{LINKS}/sharedStrings" Target="%s"/></Relationships>"""
MOST_MEGABYTES = 300


def write_book(path, rows, texts=(), part="sharedStrings.xml"):
    """A workbook of one sheet with such rows, and texts that its cells share."""
    shared = "".join(f"<si><t>{text}</t></si>" for text in texts)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("[Content_Types].xml", KINDS)
        book.writestr("_rels/.rels", ROOT)
        book.writestr("xl/workbook.xml", BOOK)
        book.writestr("xl/_rels/workbook.xml.rels", PARTS % part)
        sheet = f'<worksheet xmlns="{SHEET}"><sheetData>{rows}</sheetData></worksheet>'
        book.writestr("xl/worksheets/sheet1.xml", sheet)
        book.writestr(f"xl/{part}", f'<sst xmlns="{SHEET}">{shared}</sst>')


def rows_of(cells, n_rows):
    return "".join(
        f'<row r="{k}">{cells.format(k)}</row>' for k in range(1, n_rows + 1)
    )


FORGET_PEAK = Path("/proc/self/clear_refs")


def begin_to_measure():
    """Forget what other tests have taken, and give back what they have left free."""
    if FORGET_PEAK.exists():
        if hasattr(ctypes.pythonapi, "malloc_trim"):
            ctypes.pythonapi.malloc_trim(0)
        FORGET_PEAK.write_text("5")
    return peak_megabytes()


def peak_megabytes():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024


WIDE = rows_of('<c r="ALL{0}"><v>1</v></c>', 20_000)
FIRST_WIDE = f"<row>{'<c/>' * 900}</row>" + rows_of("<c><v>1</v></c>", 20_000)
HOSTILE = {
    "a last column": (WIDE, (), "a sheet has 20000 rows and 1000 columns"),
    "columns counted": (FIRST_WIDE, (), "a sheet has 20001 rows and 900 columns"),
    "a long cell": (
        f'<row><c t="inlineStr"><is><t>{"A" * 2**20}</t></is></c></row>',
        (),
        r"a cell holds 104\d+ bytes",
    ),
    "a shared text": (
        rows_of('<c r="A{0}" t="s"><v>1</v></c>', 10_000),
        ("a", "x" * 30_000),
        "cells share texts, 300190000 bytes in all",
    ),
    "in other signs": (
        rows_of("<c r='A{0}' t='&#115;'><v>&#49;</v></c>", 10_000),
        ("a", "x" * 30_000),
        "cells share texts, 300190000 bytes in all",
    ),
}


@pytest.mark.parametrize("kind", HOSTILE)
@pytest.mark.parametrize("part", ["sharedStrings.xml", "other.xml"])
def test_sheets_that_would_fill_the_memory_are_refused_before(tmp_path, kind, part):
    rows, texts, found = HOSTILE[kind]
    path = tmp_path / "t.xlsx"
    write_book(path, rows, texts, part)
    assert path.stat().st_size < 2**18
    before = begin_to_measure()
    with pytest.raises(FileError, match=rf"t\.xlsx: {found}; expected"):
        understand_table(path, CONTROL_POINTS)
    assert peak_megabytes() - before < MOST_MEGABYTES


@pytest.mark.slow
@pytest.mark.skipif(not FORGET_PEAK.exists(), reason="asks /proc")
def test_memory_is_measured_whatever_was_taken_before():
    """Otherwise the bound above holds wherever another test has taken as much."""
    for _ in range(2):
        before = begin_to_measure()
        # a kernel adds up the pages of each thread now and then: some MB are not seen
        taken = np.ones(410 * 2**17)
        assert peak_megabytes() - before >= 400
        del taken


CELLS = "<row>" + "<c><v>1</v></c>" * 15 + "</row>"


def read_measured(path):
    """What is said of a table, and the memory that it took [MB]."""
    before = begin_to_measure()
    with pytest.raises(FileError) as refused:
        understand_table(path, CONTROL_POINTS)
    return str(refused.value), peak_megabytes() - before


@pytest.mark.slow
def test_many_cells_that_are_all_alike_are_refused(tmp_path):
    """They took 1.4 GB: a small file with 13.5 million of them, each a real one."""
    path = tmp_path / "t.xlsx"
    write_book(path, CELLS * 900_000)
    n_bytes = path.stat().st_size
    assert n_bytes < 2**20
    said, megabytes = read_measured(path)
    assert said.startswith(f"t.xlsx: {n_bytes} bytes would unpack to 13500000 cells; ")
    assert "expected at most 2097152 cells in a workbook of this size" in said
    assert megabytes < 500


def test_cells_of_all_sheets_count_and_so_does_the_memory(monkeypatch):
    sheet = (CELLS * 1000).encode()
    one, two = {"a.xml": sheet}, {"a.xml": sheet, "b.xml": sheet}
    monkeypatch.setattr(workbook_sizes, "HARMLESS_CELLS", 20_000)
    workbook_sizes.refuse_cells(one, 100, "t.xlsx")
    workbook_sizes.refuse_cells(two, 30_000, "t.xlsx")  # packed as measured ones are
    with pytest.raises(FileError, match="100 bytes would unpack to 30000 cells; expe"):
        workbook_sizes.refuse_cells(two, 100, "t.xlsx")
    monkeypatch.setattr(workbook_sizes, "allowed_bytes", lambda: 2e6)
    with pytest.raises(FileError, match="15000 cells; expected at most 9090 cells in"):
        workbook_sizes.refuse_cells(one, 30_000, "t.xlsx")


def test_rows_of_few_cells_below_many_names_are_read(tmp_path):
    """60 names above 4 columns: cells that no row has are not held against a file."""
    names = ("point_id", "easting", "northing", *(f"note{k}" for k in range(57)))
    head = "".join(f'<c t="s"><v>{k}</v></c>' for k in range(len(names)))
    cells = "<c><v>{0}</v></c><c><v>4.5</v></c><c><v>{0}.25</v></c>"
    path = tmp_path / "t.xlsx"
    write_book(path, f"<row>{head}</row>{rows_of(cells, 40_000)}", names)
    assert path.stat().st_size < 2**20
    frame = understand_table(path, CONTROL_POINTS).frame
    assert len(frame) == 40_000


def test_empty_cells_are_bounded_by_bytes_and_memory(monkeypatch):
    wide = "<row>" + "<c/>" * 900 + "</row>"
    sheet = {"a.xml": (wide + "<row><c/></row>" * 12_000).encode()}
    workbook_sizes.refuse_cells(sheet, 2**21, "t.xlsx")
    said = "rows of 9 bytes would be filled up with 10788000 empty cells; expected at"
    with pytest.raises(FileError, match=said):
        workbook_sizes.refuse_cells(sheet, 9, "t.xlsx")
    monkeypatch.setattr(workbook_sizes, "allowed_bytes", lambda: 2e8)
    with pytest.raises(FileError, match="at most 1792381 empty cells in a workbook"):
        workbook_sizes.refuse_cells(sheet, 2**21, "t.xlsx")


OPEN_DOCUMENT = "urn:oasis:names:tc:opendocument:xmlns:"
ODS_PARTS = {
    "mimetype": "application/vnd.oasis.opendocument.spreadsheet",
    "META-INF/manifest.xml": f'<m:manifest xmlns:m="{OPEN_DOCUMENT}manifest:1.0"/>',
}
ODS = f"""<office:document-content xmlns:office="{OPEN_DOCUMENT}office:1.0"
xmlns:table="{OPEN_DOCUMENT}table:1.0"><office:body><office:spreadsheet>
<table:table table:name="S">%s</table:table>
</office:spreadsheet></office:body></office:document-content>"""
ODS_CELL = '<table:table-cell office:value-type="float" office:value="1"%s/>'
ODS_ROW = "<table:table-row>%s</table:table-row>"
ODS_SHEETS = {
    "real cells": (ODS_ROW % (ODS_CELL % "" * 10) * 80_000, 800_000),
    "repeated": (
        ODS_ROW % (ODS_CELL % ' table:number-columns-repeated="900"') * 20_000,
        20_000,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ODS_SHEETS)
def test_an_ods_of_too_many_cells_is_refused_in_words(tmp_path, kind):
    rows, n_cells = ODS_SHEETS[kind]
    path = tmp_path / "t.ods"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        for name, text in {**ODS_PARTS, "content.xml": ODS % rows}.items():
            book.writestr(name, text)
    said, megabytes = read_measured(path)
    assert said.startswith(f"t.ods: has {n_cells} cells, some of them perhaps repeated")
    assert said.endswith("Save the table as .xlsx or as CSV.")
    assert megabytes < MOST_MEGABYTES


def test_long_remarks_beside_many_short_names_are_read(tmp_path):
    """The longest text times all cells would be too much; the cells are not."""
    texts = ("point_id", "easting", "northing", "note", "P", "x" * 30_000)
    cells = '<c t="s"><v>4</v></c><c><v>1.5</v></c><c><v>2.5</v></c>'
    head = "".join(f'<c t="s"><v>{k}</v></c>' for k in range(4))
    long = f'<row>{cells}<c t="s"><v>5</v></c></row>'
    path = tmp_path / "t.xlsx"
    write_book(path, f"<row>{head}</row>{rows_of(cells, 5000)}{long}", texts)
    frame = understand_table(path, CONTROL_POINTS).frame
    assert frame["point_id"].eq("P").sum() == 5001


def test_parts_in_other_letters_are_refused(tmp_path):
    path = tmp_path / "t.xlsx"
    write_book(path, "<row><c><v>1</v></c></row>")
    with zipfile.ZipFile(path) as book:
        parts = {name: book.read(name) for name in book.namelist()}
    with zipfile.ZipFile(path, "w") as book:
        for name, data in parts.items():
            is_sheet = name.endswith("sheet1.xml")
            text = data.decode().encode("utf-16") if is_sheet else data
            book.writestr(name, text)
    with pytest.raises(FileError, match="no UTF-8 text inside"):
        understand_table(path, CONTROL_POINTS)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (b'<row><c r="A1"/><c r="AB1"/></row>', (12, 28, 2)),
        (b"<row><c/><c><v>1</v></c><c /></row><row><c/></row>", (6, 3, 4)),
        (b'<dimension ref="A1:XFD1"/><cols><col min="7"/></cols>', (26, 0, 0)),
        (b"<v>" + b"7" * 50, (53, 0, 0)),
        (b"", (0, 0, 0)),
    ],
)
def test_extent_of_a_sheet(text, expected):
    assert workbook_sizes._extent(np.frombuffer(text, np.uint8)) == expected


@pytest.mark.parametrize("kind", ["VIRTUAL", "STORED"])
def test_columns_of_a_layer_that_are_computed_are_refused(tmp_path, kind):
    """100 kB, of which each row would be a text of 400 MB."""
    path = tmp_path / "t.gpkg"
    points = shapely.to_wkb(shapely.points(np.zeros((10, 2))))
    names = [np.array([f"P{k}" for k in range(10)], dtype=object)]
    facts = {"layer": "l", "driver": "GPKG", "geometry_type": "Point"}
    pyogrio.raw.write(path, points, names, ["point_id"], crs="EPSG:31255", **facts)
    connection = sqlite3.connect(path)
    if kind == "VIRTUAL":
        column = "z TEXT GENERATED ALWAYS AS (hex(zeroblob(200000000))) VIRTUAL"
        connection.execute(f"ALTER TABLE l ADD COLUMN {column}")
    else:
        connection.execute("ALTER TABLE l RENAME TO old")
        columns = "fid INTEGER PRIMARY KEY, geom BLOB, point_id TEXT"
        column = "z INT GENERATED ALWAYS AS (fid + 1) STORED"
        connection.execute(f"CREATE TABLE l ({columns}, {column})")
    connection.commit()
    connection.close()
    with pytest.raises(FileError, match="'l' has columns that are computed when"):
        understand_table(path, CONTROL_POINTS, Said(layer="l"))
