"""Tables as people have them: their words, signs and kinds of files."""

import io
import json
import re
import zipfile

import numpy as np
import pandas as pd
import pyogrio
import pyproj
import pytest
import shapely
import xlsxwriter

import einschalt as es
from einschalt.foundations.errors import EinschaltError, FileError, TableError
from einschalt.foundations.projections import read_crs, read_source_crs
from einschalt.foundations.tables import CONTROL_POINTS, check_table
from einschalt.interfaces.files import unpacked_sizes, workbook_sizes
from einschalt.interfaces.files.block_folder import find_problems
from einschalt.interfaces.files.csv_tables import understand_csv, write_csv
from einschalt.interfaces.files.input_files import companions, read_once
from einschalt.interfaces.files.points_of_systems import schema_in
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.files.understood_tables import Said
from einschalt.interfaces.files.workbook_parts import formats_of_styles

KINDS = {"control": "Passpunkt", "check": "Kontrollpunkt"}
PLANE = ["easting", "northing"]
DRIVERS = {".gpkg": "GPKG", ".geojson": "GeoJSON", ".shp": "ESRI Shapefile"}


def columns_of(frame):
    """Columns as pyogrio takes them."""
    kinds = [float if frame[n].dtype == float else object for n in frame]
    return [frame[n].to_numpy(dtype=k) for n, k in zip(frame, kinds, strict=True)]


def write_workbook(frame, path, *more, sheet="Punkte"):
    """A workbook as GDAL writes it; ``more``: further sheets, each a frame."""
    driver = path.suffix[1:].upper()
    for place, one in enumerate((frame, *more)):
        names = {"layer": f"{sheet}{place or ''}", "driver": driver}
        options = {"geometry_type": None, "append": place > 0}
        pyogrio.raw.write(path, None, columns_of(one), list(one), **names, **options)


def write_layer(frame, xyz, path, crs="EPSG:31255"):
    options = {"layer": "Punkte", "driver": DRIVERS[path.suffix], "crs": crs}
    shapes = shapely.to_wkb(shapely.points(xyz))
    names = list(frame)
    options["geometry_type"] = "Point Z" if np.shape(xyz)[1] == 3 else "Point"
    pyogrio.raw.write(path, shapes, columns_of(frame), names, **options)


def write_geoparquet(frame, xyz, path):
    shapes = pd.Series(list(shapely.to_wkb(shapely.points(xyz))), frame.index)
    import pyarrow as pa
    from pyarrow import parquet

    table = pa.Table.from_pandas(frame.assign(geometry=shapes), preserve_index=False)
    crs = pyproj.CRS(31255).to_json_dict()
    column = {"encoding": "WKB", "geometry_types": ["Point"], "crs": crs}
    facts = {"primary_column": "geometry", "columns": {"geometry": column}}
    table = table.replace_schema_metadata({"geo": json.dumps(facts)})
    parquet.write_table(table, path)


def austrian(control):
    """What an Austrian office exports of control points."""
    return pd.DataFrame(
        {
            "Punktnummer": control["point_id"],
            "Rechtswert": control["easting"].round(4),
            "Hochwert": control["northing"].round(4),
            "Höhe": np.round(400.0 + control["northing"] % 7.0, 2),
            "Art": control["role"].map(KINDS),
        }
    )


def write_export(table, path):
    """The same table as a file of each kind."""
    rest = table[["Punktnummer", "Art"]].rename(columns={"Punktnummer": "Pkt-Nr"})
    xyz = table[["Rechtswert", "Hochwert", "Höhe"]].to_numpy()
    if path.suffix == ".csv":
        options = {"sep": ";", "decimal": ",", "encoding": "cp1252", "index": False}
        table.to_csv(path, **options)
    elif path.suffix in DRIVERS:
        write_layer(rest, xyz[:, :2] if path.suffix == ".shp" else xyz, path)
    elif path.suffix == ".parquet":
        write_geoparquet(rest, xyz, path)
    else:
        write_workbook(table, path)


@pytest.fixture(scope="module")
def blocks(tmp_path_factory, demo_block):
    """The demo block with its control as a plain table, and a place for others."""
    from dataclasses import replace

    from einschalt.interfaces.files.block_writing import write_block

    control = demo_block.control_points.round({"easting": 4, "northing": 4})
    block = replace(demo_block, control_points=control.drop(columns="standard_error_m"))
    folder = tmp_path_factory.mktemp("austria")
    write_block(block, folder)
    toml = (folder / "block.toml").read_text(encoding="utf-8")
    toml = toml.replace("[control_points]", "[control_points]\nstandard_error_m = 0.03")
    return folder, toml, block


SUFFIXES = [".csv", ".xlsx", ".ods", ".gpkg", ".geojson", ".shp", ".parquet"]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_austrian_export_is_the_plain_table(blocks, suffix):
    folder, toml, block = blocks
    table = austrian(block.control_points)
    write_export(table, folder / f"Punkte{suffix}")
    text = toml.replace("control_points.csv", f"Punkte{suffix}")
    (folder / "block.toml").write_text(text, encoding="utf-8")
    found = find_problems(folder)
    assert found.problems == ()
    read = found.block.control_points.set_index("point_id")
    plain = block.control_points.set_index("point_id")
    assert read["role"].equals(plain["role"])
    np.testing.assert_allclose(read[PLANE], plain[PLANE], rtol=0, atol=1e-9)
    if suffix != ".shp":
        heights = table.set_index("Punktnummer")["Höhe"]
        np.testing.assert_allclose(read["height"], heights, rtol=0, atol=1e-9)
    said = "\n".join(found.notes)
    assert "role 'Kontrollpunkt' = check, 'Passpunkt' = control" in said
    assert ("Windows-1252" in said) == (suffix == ".csv")
    assert ("of the geometry" in said) == (suffix in (*DRIVERS, ".parquet"))
    # what is signed for are all files of a shapefile
    assert (f"Punkte{suffix}".replace("shp", "dbf") in found.block.checksums) == (
        suffix in (".shp", *set(SUFFIXES) - {".shp"})
    )


def test_results_of_the_export_are_those_of_the_plain_table(blocks):
    """Cheap proof for densify: what it is given is the same to the last digit."""
    folder, toml, block = blocks
    frames = []
    for name in ("control_points.csv", "Punkte.csv"):
        write_export(austrian(block.control_points), folder / "Punkte.csv")
        text = toml.replace("control_points.csv", name)
        (folder / "block.toml").write_text(text, encoding="utf-8")
        control = find_problems(folder).block.control_points
        frames.append(control[["point_id", *PLANE, "standard_error_m", "role"]])
    pd.testing.assert_frame_equal(
        *(f.reset_index(drop=True) for f in frames), check_exact=True
    )


def read_text(tmp_path, text, said=None):
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    return understand_csv(tmp_path / "t.csv", CONTROL_POINTS, said or Said())


AUSTRIA, UTM = "EPSG:31255", "EPSG:25833"
LETTERS = "Nr;Y;X\nA;13000,1;322000,2\n"


@pytest.mark.parametrize(
    ("text", "said", "reason"),
    [
        (
            LETTERS,
            Said(crs=AUSTRIA),
            "as MGI / Austria GK Central (EPSG:31255) names its axes",
        ),
        (LETTERS.replace("Nr", "Punktnummer"), Said(), "as German tables have them"),
        (
            "no;x;y\nA;13000.1;322000.2\n",
            Said(crs="EPSG:2154"),
            "as RGF93 v1 / Lambert-93 (EPSG:2154) names its axes",
        ),
        (
            "Punktnummer;X;Y\nA;500000.1;5322000.2\n",
            Said(crs=UTM),
            "in the area of ETRS89 / UTM zone 33N (EPSG:25833)",
        ),
        (LETTERS, Said({"easting": "Y", "northing": "X"}), None),
        ("Nr;R;H;Z\nA;13000,1;322000,2;3,5\n", Said(), None),
    ],
)
def test_which_letter_is_the_easting(tmp_path, text, said, reason):
    table = read_text(tmp_path, text, said)
    east, north = table.frame[PLANE].iloc[0].astype(float)
    assert east < north
    assert reason is None or table.notes[-1].endswith(reason)


@pytest.mark.parametrize(
    "header",
    [
        "Nr;Rechtswert (Y);Hochwert (X);Höhe (H)",
        "Nr;Y (Ost);X (Nord);Z",
        "Nr;Y(E);X(N);H",
        "Nr;E (Y);N (X);Z [m]",
        "Nr;Y/Rechtswert;X/Hochwert;Höhe (NHN)",
        "Point;Easting (X) [m];Northing (Y) [m];Elevation (Z) [m]",
        "Name;X_East;Y_North;Elev",
        "Point Id;Easting;Northing;Ortho. Height [m]",
    ],
)
def test_a_letter_may_stand_beside_the_word(tmp_path, header):
    table = read_text(tmp_path, f"{header}\n07;600000.1;5340000.2;300.5\n")
    assert table.frame.iloc[0].tolist()[:4] == ["07", 600000.1, 5340000.2, 300.5]
    assert list(table.frame)[1:4] == [*PLANE, "height"]
    assert len(table.notes) == 1


def test_letters_that_contradict_each_other_are_no_coordinates(tmp_path):
    # a covariance, a height or a Hochwert
    text = "Nr;Rechtswert;Hochwert;E (N);E_N;y (H)\nA;600000.1;5340000.2;1;2;3\n"
    frame = read_text(tmp_path, text).frame
    assert list(frame)[1:] == [*PLANE, "E (N)", "E_N", "y (H)"]


@pytest.mark.parametrize("crs", [None, UTM])
def test_geocentric_coordinates_are_no_plane_ones(tmp_path, crs):
    text = "Punktnummer;X;Y;Z\nA;4085000,123;1200000,234;4730000,345\n"
    with pytest.raises(TableError, match="X, Y and Z are geocentric, 6364 km from"):
        read_text(tmp_path, text, Said(crs=crs))
    # of Sweden, as far from the origin of its plane system
    plane = "Punktnummer;X;Y;Z\nA;6330000,1;620000,2;112,3\n"
    frame = read_text(tmp_path, plane, Said(crs=crs)).frame
    assert frame["northing"].tolist() == [6330000.1]


def test_letters_that_the_area_contradicts_are_asked_about(tmp_path):
    # a list of a map program: X to the east, which the system calls Y
    text = "Nr;X;Y\nA;13000.1;322000.2\n"
    with pytest.raises(TableError, match=r"'Y' is the easting as .* two exchanged"):
        read_text(tmp_path, text, Said(crs=AUSTRIA))
    said = Said({"easting": "X", "northing": "Y"}, crs=AUSTRIA)
    assert read_text(tmp_path, text, said).frame["easting"].tolist() == [13000.1]


def test_letters_of_krovak_that_lie_nowhere_are_asked_about(tmp_path):
    text = "ID;Y;X\nA;646099.5;1060562.5\n"  # of Bohemia, and the system of Slovakia
    with pytest.raises(TableError, match="which of them is the easting"):
        read_text(tmp_path, text, Said(crs="EPSG:8353"))


def test_letters_of_czech_surveyors_with_the_signs_of_maps(tmp_path):
    text = "ID;Y;X\nA;-646099.5;-1060562.5\n"
    table = read_text(tmp_path, text, Said(crs="EPSG:5514"))
    assert table.frame["easting"].tolist() == [-646099.5]
    assert "since only so the points lie in the area of " in table.notes[-1]


@pytest.mark.parametrize(
    ("header", "names"), [("ID Y X Z\n", "'Y'"), ("", "'column 2'")]
)
def test_krovak_counted_to_the_west_and_south(tmp_path, header, names):
    rows = "0001 646099.78 1060562.13 219.88\n0002 646095.99 1060561.02 219.99\n"
    table = read_text(tmp_path, header + rows, Said(crs="EPSG:5514"))
    assert table.frame["easting"].tolist() == [-646099.78, -646095.99]
    assert table.frame["northing"].tolist() == [-1060562.13, -1060561.02]
    assert table.frame["height"].tolist() == [219.88, 219.99]
    assert f"{names} counts to the west" in table.notes[-1]
    # what is no number is said with its row
    wrong = read_text(
        tmp_path, header + rows.replace("095.99", "?"), Said(crs="EPSG:5514")
    )
    (fault,) = check_table(wrong.frame, CONTROL_POINTS).problems
    assert "easting '646?' is not a number" in fault.found


IN_FEET = "EPSG:3436"  # Illinois West, US survey feet
ROVER = "Name,Easting,Northing,Elevation\nTCU1,2434191.346,1475350.261,570.143\n"


@pytest.mark.parametrize(
    ("text", "mend"),
    [
        (ROVER, r"\+6360; if they are metres, call the column 'Elevation \[m\]'"),
        (
            "1,1475350.261,2434191.346,570.143,CP\n2,1475450.2,2434291.3,571.1,CP\n",
            r"write a line of names above the values, with height \[m\]",
        ),
    ],
)
def test_heights_beside_feet_are_asked_about(tmp_path, text, mend):
    with pytest.raises(
        TableError, match=rf"in US survey foot units: in which are the heights.*{mend}"
    ):
        read_text(tmp_path, text, Said(crs=IN_FEET))


@pytest.mark.parametrize(
    ("text", "crs"),
    [
        (ROVER, f"{IN_FEET}+6360"),  # their system has a unit
        (ROVER.replace("Elevation", "Elevation [m]"), IN_FEET),
        (ROVER.replace("Elevation", "height"), IN_FEET),  # as docs/columns.md says
        (ROVER, None),
    ],
)
def test_heights_with_a_unit_stay_beside_feet(tmp_path, text, crs):
    frame = read_text(tmp_path, text, Said(crs=crs)).frame
    assert frame["height"].tolist() == [570.143]


@pytest.mark.parametrize("crs", [None, UTM])
def test_letters_that_nothing_explains_are_asked_about(tmp_path, crs):
    with pytest.raises(
        TableError, match=r"'Y' and 'X': which of them is the easting\?"
    ):
        read_text(tmp_path, LETTERS, Said(crs=crs))


def test_a_comma_of_two_meanings_is_asked_about_and_can_be_answered(tmp_path):
    text = "point_id;easting;northing\nA;7;412\nB;1,234;322,000\n"
    with pytest.raises(TableError, match=r"row 3: .*'1,234': is it 1\.234 or 1234\?"):
        read_text(tmp_path, text)
    frame = read_text(tmp_path, text, Said(decimal=",")).frame
    assert frame["easting"].tolist() == [7.0, 1.234]
    # another number that can have one meaning only speaks for both
    frame = read_text(tmp_path, text.replace("7;", "0,030;")).frame
    assert frame["easting"].tolist() == [0.03, 1.234]
    # a decimal point beside it speaks against: the fault is that of the one value
    table = read_text(tmp_path, text.replace("7;", "7.5;"))
    faults = check_table(table.frame, CONTROL_POINTS).problems
    assert "'1,234' has a comma" in faults[0].found


@pytest.mark.parametrize("said", [Said(), Said(decimal=",")])
def test_points_between_thousands_leave_a_comma_one_meaning(tmp_path, said):
    text = "point_id;easting;northing\nA;10.009,370;5.326.127,5\nB;-7,5;999,25\n"
    table = read_text(tmp_path, text, said)
    assert table.frame["easting"].tolist() == [10009.37, -7.5]
    assert table.frame["northing"].tolist() == [5326127.5, 999.25]
    assert "read with decimal commas" in " ".join(table.notes)
    # what is no group of three is no number
    wrong = read_text(tmp_path, text.replace("10.009,370", "10.09,370"), said)
    faults = check_table(wrong.frame, CONTROL_POINTS).problems
    assert "10.09,370" in faults[0].found
    assert faults[0].row == 2


@pytest.mark.parametrize(
    ("row", "said"), [("13,5;1.234", Said()), ("13.000;7", Said(decimal=","))]
)
def test_points_beside_decimal_commas_are_asked_about(tmp_path, row, said):
    text = f"point_id;easting;northing\nA;{row}\n"
    with pytest.raises(TableError, match=r"row 2: .*: is it 1\d?\.\d+ or 1\d+\?"):
        read_text(tmp_path, text, said)
    # another number of the column can be nothing but decimal
    if said == Said():
        frame = read_text(tmp_path, f"{text}B;1,5;0.5\n").frame
        assert frame["northing"].astype(float).tolist() == [1.234, 0.5]


@pytest.mark.parametrize("said", [Said(), Said(decimal=",")])
def test_a_few_points_among_decimal_commas_are_named_by_their_row(tmp_path, said):
    rows = "".join(f"A{k};{k},25;{k},5\n" for k in range(30))
    text = f"point_id;easting;northing\n{rows}B;31.25;7,5\nC;32,25;8,5\nD;33.5;9,5\n"
    with pytest.raises(TableError) as error:
        read_text(tmp_path, text, said)
    assert error.value.row == 32
    assert error.value.found.startswith("easting '31.25' has a point")
    assert error.value.found.endswith("in 2 rows")
    # where points are the most, each comma is a fault of its own
    one = text.replace(",", ".").replace("12.25", "12,25")
    (fault,) = check_table(read_text(tmp_path, one).frame, CONTROL_POINTS).problems
    assert fault.row == 14


def test_two_columns_that_could_be_meant_are_asked_about(tmp_path):
    text = "Punktnr;Rechtswert;Ostwert;Hochwert\nA;1.0;2.0;3.0\n"
    with pytest.raises(TableError, match="'Rechtswert' and 'Ostwert' could both be"):
        read_text(tmp_path, text)
    table = read_text(tmp_path, text, Said({"easting": "Ostwert"}))
    assert table.frame["easting"].tolist() == [2.0]
    with pytest.raises(TableError, match="column 'Ost', named for easting, is missing"):
        read_text(tmp_path, text, Said({"easting": "Ost"}))


def test_new_points_are_no_control_and_other_kinds_of_kinds_no_roles(tmp_path):
    head = "point_id,easting,northing,Art\n"
    table = read_text(tmp_path, f"{head}A,1,2,Paßpunkt\nB,1,2,Neupunkt\n")
    assert table.frame["point_id"].tolist() == ["A"]
    assert "1 row of role Neupunkt left out" in table.notes[-1]
    with pytest.raises(TableError, match=r"all points have the role Neupunkt, new;"):
        read_text(tmp_path, f"{head}A,1,2,new\nB,1,2,Neupunkt\n")
    table = read_text(tmp_path, f"{head}A,1,2,Bolzen\nB,1,2,Stein\n")
    assert list(table.frame) == ["point_id", "easting", "northing", "Art"]
    assert table.notes == ()


def test_a_length_in_another_unit_is_not_taken_for_metres(tmp_path):
    with pytest.raises(TableError, match=r"is in mm, column 'Hochwert \[m\]' in"):
        read_text(tmp_path, "Nr;Rechtswert [mm];Hochwert [m]\nA;1.0;2.0\n")
    with pytest.raises(TableError, match="'Hochwert' states no unit"):
        read_text(tmp_path, "Nr;Rechtswert [km];Hochwert\nA;1.0;2.0\n")
    text = "Nr;Y [km];X_km;Höhe cm\nA;13.0001;322.0002;41150\n"
    table = read_text(tmp_path, text, Said(crs=AUSTRIA))
    values = table.frame[["easting", "northing", "height"]].to_numpy()
    assert values.tolist() == [[13000.1, 322000.2, 411.5]]
    (note,) = [one for one in table.notes if "converted to m: " in one]
    assert "'Y [km]' (km)" in note
    assert "'Höhe cm' (cm)" in note
    text = "Nr;Rechtswert [ft];Hochwert [m]\nA;1.0;2.0\n"
    (fault,) = check_table(read_text(tmp_path, text).frame, CONTROL_POINTS).problems
    assert fault.found == "column 'easting' is missing; 'Rechtswert [ft]' is in ft"
    assert fault.expected == "metres"
    feet = LETTERS.replace("Y;X", "Y [ft];X [ft]")
    assert list(read_text(tmp_path, feet).frame) == ["point_id", "Y [ft]", "X [ft]"]
    metres = read_text(tmp_path, feet.replace("ft", "m"), Said(crs=AUSTRIA)).frame
    assert set(metres) == {"point_id", *PLANE}


def test_comments_are_said_and_names_that_look_like_them_are_kept(tmp_path):
    names = pd.DataFrame({"point_id": ["#7", "B"], "easting": 1.0, "northing": 2.0})
    write_csv(names, tmp_path / "t.csv")
    text = (tmp_path / "t.csv").read_text(encoding="utf-8")
    table = read_text(tmp_path, f"# by hand\n{text}#C,1,2\n")
    assert table.frame["point_id"].tolist() == ["#7", "B"]
    assert table.notes == ("t.csv: rows that begin with # are comments: 5",)
    assert table.frame.index.tolist() == [3, 4]


def test_a_flight_can_say_what_its_columns_are_called(small_block):
    low = small_block.read("low_flight.csv").replace("x,y", "u,v")
    small_block.write("low_flight.csv", low)
    small_block.replace(
        "block.toml",
        '"low_flight.csv"',
        '{file = "low_flight.csv", columns = {x = "u", y = "v"}}',
    )
    found = find_problems(small_block.path)
    assert found.problems == ()
    assert "low_flight.csv: column 'u' = x, 'v' = y" in found.notes


POINTS = pd.DataFrame({"Nr": ["0012", "7/8"], "Ost": [1.5, 2.0], "Nord": [3.0, 4.0]})


def changed_workbook(path, change, member="xl/worksheets/sheet1.xml"):
    """The same workbook with another text in one of its files."""
    packed = io.BytesIO()
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(packed, "w", 8) as new:
        for name in old.namelist():
            data = old.read(name)
            new.writestr(name, change(data) if name == member else data)
    path.write_bytes(packed.getvalue())


def test_the_sheet_with_the_table_is_found_below_its_title_or_asked_for(tmp_path):
    path = tmp_path / "t.xlsx"
    other = pd.DataFrame({"Bemerkung": ["Befund"]})
    write_workbook(other, path, POINTS)
    table = understand_table(path, CONTROL_POINTS)
    assert table.frame["point_id"].tolist() == ["0012", "7/8"]
    assert table.notes[0].startswith("t.xlsx: sheet 'Punkte1' alone has the columns")
    write_workbook(POINTS, tmp_path / "two.xlsx", POINTS)
    with pytest.raises(FileError, match='Say which: sheet = "Punkte"'):
        understand_table(tmp_path / "two.xlsx", CONTROL_POINTS)
    said = Said(sheet="Punkte1")
    assert len(understand_table(tmp_path / "two.xlsx", CONTROL_POINTS, said).frame) == 2


EMPTY = b'<table:table-cell table:formula="of:=IF(A1>0;1;2)"/>'
OF_TEXT = (
    b'<table:table-cell table:formula="of:=&quot;&quot;" office:value-type="string">'
    b"<text:p/></table:table-cell>"
)
SAVED = (
    b'<table:table-cell table:formula="of:=2+2" office:value-type="float" '
    b'office:value="5"/>'
)


def with_ods_row(path, cells):
    """A workbook of points with another row: a name and such cells."""
    write_workbook(POINTS, path)
    name = b"<table:table-cell><text:p>F</text:p></table:table-cell>"
    row = b"<table:table-row>" + name + cells + b"</table:table-row></table:table>"
    changed_workbook(path, lambda d: d.replace(b"</table:table>", row), "content.xml")


def test_formulas_are_values_that_were_saved_and_never_computed(tmp_path):
    path = tmp_path / "t.ods"
    with_ods_row(path, OF_TEXT + SAVED)
    frame = understand_table(path, CONTROL_POINTS).frame
    assert frame[PLANE].iloc[-1].tolist() == ["", "5"]


FORMULA = "easting is a formula without a value: no spreadsheet has computed it"
REMEDY = "Open the workbook in Excel or LibreOffice, and save it there"


def test_formulas_that_nobody_computed_are_no_missing_values(tmp_path):
    path = tmp_path / "t.ods"
    with_ods_row(path, EMPTY + SAVED)
    with pytest.raises(TableError, match=f"row 4: {FORMULA}.*{REMEDY}"):
        understand_table(path, CONTROL_POINTS)


# the value in the second column of the first point, as programs write it
VALUE = re.compile(rb'<c r="B2"([^>]*)>\s*<v>[^<]*</v>\s*</c>')


@pytest.mark.parametrize(
    "cell",
    [
        b'<c r="B2"><f>A1+1</f></c>',
        b'<c r="B2" s="1"><f>A1+1</f><v></v></c>',
        b'<c r="B2"><f t="shared" si="0"/><v/></c>',
        b'<c r="B2" t="n"><f>IF(A1&lt;2,1,2)</f></c>',
    ],
)
def test_formulas_of_programs_that_compute_none(tmp_path, cell):
    path = tmp_path / "t.xlsx"
    write_workbook(POINTS, path)
    changed_workbook(path, lambda d: VALUE.sub(cell, d))
    told = rf"t\.xlsx, sheet Punkte, row 2: {FORMULA}.*{REMEDY}"
    with pytest.raises(TableError, match=told):
        understand_table(path, CONTROL_POINTS)


def test_a_formula_of_no_letters_or_in_a_column_that_is_not_read(tmp_path):
    """The text "" is a value: what the spreadsheet has computed."""
    path = tmp_path / "t.xlsx"
    points = pd.DataFrame({"Nr": ["A", "B"], "Bem": [1.0, 2.0], "Rechts": [5.0, 6.0]})
    write_workbook(points.assign(Hoch=[7.0, 8.0]), path)
    changed_workbook(path, lambda d: VALUE.sub(b'<c r="B2"><f>A1+1</f></c>', d))
    said = Said(columns={"point_id": "Nr", "easting": "Rechts", "northing": "Hoch"})
    assert understand_table(path, CONTROL_POINTS, said).frame["Bem"].iloc[0] == ""
    write_workbook(POINTS, path)
    text = b'<c r="B2" t="str"><f>IF(A1,1,"")</f><v></v></c>'
    changed_workbook(path, lambda d: VALUE.sub(text, d))
    assert understand_table(path, CONTROL_POINTS).frame["easting"].iloc[0] == ""


def hide(path, name):
    """Hide a sheet, as spreadsheets do."""
    if path.suffix == ".xlsx":
        tag = re.compile(rb'(name="%s"[^>]*?)\sstate="[^"]*"' % name.encode())
        hidden, part = rb'\1 state="hidden"', "xl/workbook.xml"
        changed_workbook(path, lambda d: tag.sub(hidden, d), part)
        return
    style = (
        b'<style:style style:name="off" style:family="table"><style:table-properties '
        b'table:display="false"/></style:style></office:automatic-styles>'
    )
    tag = b'table:name="%s"' % name.encode()
    own = re.compile(rb'\stable:style-name="[^"]*"(?=[^>]*%s)' % tag)

    def change(data):
        data = own.sub(b"", data).replace(tag, tag + b' table:style-name="off"')
        return data.replace(b"</office:automatic-styles>", style)

    changed_workbook(path, change, "content.xml")


@pytest.mark.parametrize("suffix", [".xlsx", ".ods"])
def test_hidden_sheets_are_read_if_they_are_named(tmp_path, suffix):
    path = tmp_path / f"t{suffix}"
    write_workbook(POINTS, path, POINTS.head(1))
    hide(path, "Punkte1")
    table = understand_table(path, CONTROL_POINTS)
    assert len(table.frame) == 2
    assert table.notes[0] == f"t{suffix}: hidden sheet Punkte1 is not read"
    table = understand_table(path, CONTROL_POINTS, Said(sheet="Punkte1"))
    assert len(table.frame) == 1
    assert table.notes[0] == f"t{suffix}: sheet 'Punkte1' is hidden"
    hide(path, "Punkte")
    with pytest.raises(FileError, match="all sheets with anything in them are hidden"):
        understand_table(path, CONTROL_POINTS)


def test_a_name_that_became_a_date_is_refused(tmp_path):
    path = tmp_path / "t.ods"
    write_workbook(POINTS, path)
    cell = b'office:value-type="date" office:date-value="2026-08-07"'
    changed_workbook(
        path,
        lambda d: d.replace(
            b'office:value-type="string">\n<text:p>7/8', cell + b">\n<text:p>7/8"
        ),
        "content.xml",
    )
    with pytest.raises(TableError, match=r"row 3: point_id '2026.08.07' is a date"):
        understand_table(path, CONTROL_POINTS)


def sheet_of_names(path, name, look="General"):
    """A workbook of two points, of which the second has such a name."""
    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet("Punkte")
        metres = book.add_format({"num_format": "0.000"})
        sheet.write_row(0, 0, ["Nr", "Ost", "Nord"])
        sheet.write_row(1, 0, ["A", 1.5, 2.5], metres)
        sheet.write(2, 0, name, book.add_format({"num_format": look}))
        sheet.write_row(2, 1, [3.5, 4.5], metres)
    return path


@pytest.mark.parametrize(
    ("name", "look", "told"),
    [
        (45146, 14, "is a date or a time"),
        (45146, "d. mmm", "is a date or a time"),
        (45146, "d/m", "is a date or a time"),
        (45146, '[$-407]d. mmmm "im Jahr" yyyy;@', "is a date or a time"),
        (0.3125, 20, "is a date or a time"),
        (0.3125, "[h]:mm", "is a date or a time"),
        (100000, 11, "'100000' is shown as a power of ten"),
        (100000, "0.00E+00", "'100000' is shown as a power of ten"),
        (True, "General", "is TRUE or FALSE"),
        (1234567890123456, "0", "is a number of 16 digits or more"),
    ],
)
def test_a_name_that_the_spreadsheet_may_have_changed_is_refused(
    tmp_path, name, look, told
):
    path = sheet_of_names(tmp_path / "t.xlsx", name, look)
    with pytest.raises(TableError, match=told) as caught:
        understand_table(path, CONTROL_POINTS)
    (problem,) = getattr(caught.value, "problems", [caught.value])
    assert problem.row == 3
    assert problem.remedy.startswith("Give the column the format Text")


@pytest.mark.parametrize(
    ("name", "look", "read"),
    [
        (12, "0000", "12"),
        (112, "0-00", "112"),
        (1.1, "0.00", "1.1"),
        (0.875, "# ?/?", "0.875"),
        (7, '"P"0', "7"),
        (1001, "#,##0", "1001"),
        (5, 5, "5"),  # of money
    ],
)
def test_names_that_are_looks_of_numbers_are_said(tmp_path, name, look, read):
    """A cell that shows 1-12 holds 112, and that was read without a word."""
    path = sheet_of_names(tmp_path / "t.xlsx", name, look)
    table = understand_table(path, CONTROL_POINTS)
    assert table.frame["point_id"].tolist() == ["A", read]
    (said,) = [note for note in table.notes if "give names the format Text" in note]
    assert f"point_id '{read}' in row 3 is a number" in said


@pytest.mark.parametrize(
    ("name", "look"),
    [
        ("0012", "0000"),  # a text, whatever its format
        ("2024-01-07", "@"),
        ("7:30", "General"),
        (1.1, "General"),
        (1.1, "0.0"),
        (12, "0"),
        (12, "@"),
        (999, "#,##0"),
    ],
)
def test_names_that_look_as_they_are_read(tmp_path, name, look):
    path = sheet_of_names(tmp_path / "t.xlsx", name, look)
    table = understand_table(path, CONTROL_POINTS)
    assert table.frame["point_id"].tolist() == ["A", str(name)]
    assert not any("format Text" in note for note in table.notes)


def of_ods(path, kind, shown):
    """The workbook of points, its second name a value that is shown so."""
    write_workbook(POINTS, path)
    old = b'office:value-type="string">\n<text:p>7/8'
    cell = b"%s>\n<text:p>%s" % (kind, shown)
    changed_workbook(path, lambda d: d.replace(old, cell), "content.xml")
    return path


@pytest.mark.parametrize(
    ("kind", "shown", "told"),
    [
        (b'"time" office:time-value="PT07H30M00S"', b"07:30", "is a date or a time"),
        (b'"boolean" office:boolean-value="true"', b"WAHR", "is TRUE or FALSE"),
        (b'"float" office:value="100000"', b"1,00E+05", "is shown as a power of ten"),
    ],
)
def test_names_that_an_ods_holds_as_something_else(tmp_path, kind, shown, told):
    path = of_ods(tmp_path / "t.ods", b"office:value-type=" + kind, shown)
    with pytest.raises(TableError, match=f"row 3: point_id .*{told}"):
        understand_table(path, CONTROL_POINTS)


def test_names_that_an_ods_shows_otherwise_are_said(tmp_path):
    kind = b'office:value-type="float" office:value="1.1"'
    table = understand_table(of_ods(tmp_path / "t.ods", kind, b"1,10"), CONTROL_POINTS)
    (said,) = [note for note in table.notes if "give names the format Text" in note]
    assert "point_id '1.1' in row 3 is a number that the cell may show" in said
    table = understand_table(of_ods(tmp_path / "u.ods", kind, b"1,1"), CONTROL_POINTS)
    assert not any("format Text" in note for note in table.notes)


def test_a_zero_of_a_program_that_computes_none_is_no_value(tmp_path):
    """It asks the spreadsheet to compute all when it opens the workbook."""
    path = tmp_path / "t.xlsx"
    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet("Punkte")
        sheet.write_row(0, 0, ["Nr", "Ost", "Nord"])
        sheet.write_row(1, 0, ["A", 1.5, 2.5])
        sheet.write_formula(1, 1, "=1+1")
        sheet.write_formula(1, 2, "=1+2", None, 3)
    with pytest.raises(TableError, match=f"row 2: {FORMULA}.*{REMEDY}") as caught:
        understand_table(path, CONTROL_POINTS)
    assert "northing" not in str(caught.value)
    computed = re.compile(rb' fullCalcOnLoad="1"')
    changed_workbook(path, lambda d: computed.sub(b"", d), "xl/workbook.xml")
    frame = understand_table(path, CONTROL_POINTS).frame
    assert frame[PLANE].to_numpy().tolist() == [["0", "3"]]


def test_hidden_rows_are_read_and_said(tmp_path):
    path = tmp_path / "t.xlsx"
    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet("Punkte")
        for k, row in enumerate([["Nr", "Ost", "Nord"], ["A", 1, 2], ["B", 3, 4]]):
            sheet.write_row(k, 0, row)
        sheet.set_row(2, None, None, {"hidden": True})
        sheet.set_row(7, None, None, {"hidden": True})  # of no point
    table = understand_table(path, CONTROL_POINTS)
    said = "t.xlsx, sheet Punkte: hidden rows are read as well: 3"
    assert (said in table.notes, len(table.frame)) == (True, 2)
    path = tmp_path / "t.ods"
    write_workbook(POINTS, path)
    assert not any("hidden" in n for n in understand_table(path, CONTROL_POINTS).notes)
    row = re.compile(rb"(<table:table-row)(?=[^<]*(?:<(?!/?table:table-row)[^<]*)*7/8)")
    filtered = rb'\1 table:visibility="filter"'
    changed_workbook(path, lambda d: row.sub(filtered, d), "content.xml")
    said = "t.ods, sheet Punkte: hidden rows are read as well: 3"
    assert said in understand_table(path, CONTROL_POINTS).notes


def test_hidden_columns_are_read_and_said(tmp_path):
    path = tmp_path / "t.xlsx"
    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet("Punkte")
        for k, row in enumerate([["Nr", "Ost", "Nord", "Notiz"], ["A", 1, 2, "x"]]):
            sheet.write_row(k, 0, row)
        sheet.set_column(1, 1, None, None, {"hidden": True})
        sheet.set_column(3, 5, None, None, {"hidden": True})  # of no table
    table = understand_table(path, CONTROL_POINTS)
    said = "t.xlsx, sheet Punkte: hidden columns are read as well: 'Ost'"
    assert (said in table.notes, table.frame["easting"].tolist()) == (True, ["1"])
    path = tmp_path / "t.ods"
    write_workbook(POINTS, path)
    assert not any("hidden" in n for n in understand_table(path, CONTROL_POINTS).notes)
    columns = (
        rb'<table:table-column/><table:table-column table:visibility="collapse" '
        rb'table:number-columns-repeated="1"/>'
    )
    first = re.compile(rb"(<table:table [^<>]*>)")
    changed_workbook(path, lambda d: first.sub(rb"\1" + columns, d), "content.xml")
    notes = understand_table(path, CONTROL_POINTS).notes
    assert any("t.ods, sheet Punkte: hidden columns are read" in n for n in notes)


def test_what_stands_below_an_empty_row_is_said(tmp_path):
    path = tmp_path / "t.xlsx"
    rows = [["Nr", "Ost", "Nord"], ["A", 1, 2], [], [], ["B", 3, 4], [], ["C", 5, 6]]
    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet("Punkte")
        for k, row in enumerate(rows):
            sheet.write_row(k, 0, row)
    table = understand_table(path, CONTROL_POINTS)
    said = "t.xlsx, sheet Punkte: what stands below the empty row 3 is read as well"
    assert (said in table.notes, len(table.frame)) == (True, 3)


def test_names_that_a_spreadsheet_has_made_one_are_told_with_the_remedy(tmp_path):
    path = tmp_path / "t.xlsx"
    points = pd.DataFrame({"Nr": [1.1, 1.2, 1.1], "Ost": [1.0, 2, 3], "Nord": 4.0})
    write_workbook(points, path)
    frame = understand_table(path, CONTROL_POINTS).frame
    (problem,) = check_table(frame, CONTROL_POINTS, source="t.xlsx").problems
    assert problem.found == "the row repeats row 2"
    assert problem.remedy.startswith("If one of the two was '1.10', of which a")
    # of a text both rows have what was typed
    (problem,) = check_table(frame, CONTROL_POINTS, source="t.csv").problems
    assert problem.remedy == "Delete one of the two, or rename it"


def test_texts_with_commas_of_two_meanings_beside_numbers_of_cells(tmp_path):
    """Each number of a cell has a point, which says nothing of texts."""
    path = tmp_path / "t.xlsx"
    points = pd.DataFrame({"Nr": ["A", "B"], "Ost": ["10,500", "11,555"]})
    points = points.assign(Nord=["20,250", "22,555"], H=[512.3, 3.0])
    write_workbook(points, path)
    with pytest.raises(TableError, match=r'10\.500 or 10500.*decimal = ","'):
        understand_table(path, CONTROL_POINTS)
    frame = understand_table(path, CONTROL_POINTS, Said(decimal=",")).frame
    assert frame["easting"].tolist() == [10.5, 11.555]


def test_number_formats_of_a_monster_are_read_in_no_time():
    styles = b"<numFmt " + b'formatCode="x ' * 100_000 + b"/>"
    assert formats_of_styles(styles) == ({}, {})


ENTITY = b'<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><worksheet'


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.replace(b"<worksheet", ENTITY), "defines XML entities"),
        (lambda d: d + b" " * 2**24, "bytes would unpack to"),
        (
            lambda d: d.replace(
                b"</sheetData>",
                b'<row r="9"><c r="XFD9"><v>1</v></c></row></sheetData>',
            ),
            "columns",
        ),
    ],
)
def test_hostile_workbooks_are_refused_in_words(tmp_path, monkeypatch, change, said):
    # of a real one there would be hundreds of megabytes
    monkeypatch.setattr(workbook_sizes, "HARMLESS_BYTES", 2**22)
    path = tmp_path / "t.xlsx"
    write_workbook(POINTS, path)
    changed_workbook(path, change)
    with pytest.raises(FileError, match=said):
        understand_table(path, CONTROL_POINTS)


def test_a_geometry_that_would_fill_the_memory_is_refused(tmp_path, monkeypatch):
    """One shape of a megabyte in every row packs to next to nothing."""
    import pyarrow as pa
    from pyarrow import parquet

    shape = shapely.to_wkb(shapely.linestrings(np.zeros((2**15, 2))))
    facts = {"encoding": "WKB", "geometry_types": []}
    geo = {"primary_column": "geometry", "columns": {"geometry": facts}}
    table = pa.table({"point_id": list("abcdefgh"), "geometry": [shape] * 8})
    table = table.replace_schema_metadata({b"geo": json.dumps(geo).encode()})
    parquet.write_table(table, tmp_path / "t.parquet", compression="zstd")
    # of a real one there would be thousands of rows
    monkeypatch.setattr(unpacked_sizes, "HARMLESS_BYTES", 2**21)
    monkeypatch.setattr(unpacked_sizes, "MOST_PACKED", 4)
    with pytest.raises(FileError, match=r"t\.parquet: \d+ bytes would unpack to"):
        understand_table(tmp_path / "t.parquet", CONTROL_POINTS)


@pytest.mark.parametrize("suffix", [".xlsx", ".gpkg", ".geojson", ".shp"])
def test_truncated_and_misnamed_files_are_refused_in_words(tmp_path, suffix):
    path = tmp_path / f"t{suffix}"
    write_export(austrian_of_two(), path)
    whole = path.read_bytes()
    for data in (whole[: len(whole) // 2], b"<OGRVRTDataSource/>", b""):
        path.write_bytes(data)
        with pytest.raises(EinschaltError, match=rf"t{suffix}"):
            check_sound(understand_table(path, CONTROL_POINTS))


def test_the_system_of_a_shapefile_may_have_old_letters(tmp_path):
    """ArcView wrote names of systems in the letters of its country."""
    table = austrian_of_two()[["Rechtswert", "Hochwert"]].assign(Name=["A", "B"])
    xy = table[["Rechtswert", "Hochwert"]].to_numpy()
    write_layer(table[["Name"]], xy, tmp_path / "t.shp")
    file = tmp_path / "t.prj"
    file.write_bytes(file.read_bytes().replace(b"Greenwich", b"Gr\xfcnwich"))
    beside = [read_once(one, one.name) for one in companions(tmp_path / "t.shp")]
    found = understand_table(tmp_path / "t.shp", CONTROL_POINTS, beside=beside)
    assert found.frame["point_id"].tolist() == ["A", "B"]
    assert "Austria" in read_crs(found.crs).name


def check_sound(table):
    """Half a shapefile may be read: then its rows are missing."""
    assert len(table.frame) == 2, "t.shp"


def austrian_of_two():
    control = pd.DataFrame({"point_id": ["A", "B"], "easting": [13e3, 14e3]})
    return austrian(control.assign(northing=322e3, role="control"))


def test_the_system_of_a_layer_counts_and_may_not_be_contradicted(blocks):
    folder, toml, block = blocks
    write_export(austrian(block.control_points), folder / "Punkte.gpkg")
    text = toml.replace("control_points.csv", "Punkte.gpkg")
    other = text.replace("[control_points]", '[control_points]\ncrs = "EPSG:31254"')
    (folder / "block.toml").write_text(other, encoding="utf-8")
    said = "\n".join(str(problem) for problem in find_problems(folder).problems)
    assert "crs = MGI / Austria GK West (EPSG:31254), but Punkte.gpkg says MGI" in said


def test_attributes_that_contradict_the_geometry_are_asked_about(tmp_path):
    table = austrian_of_two().drop(columns=["Höhe", "Art"])
    xyz = table[["Rechtswert", "Hochwert"]].to_numpy()
    write_layer(table, xyz + np.array([[0.0, 0.0], [0.0, 0.5]]), tmp_path / "t.gpkg")
    with pytest.raises(TableError, match="row 2: the columns easting and northing and"):
        understand_table(tmp_path / "t.gpkg", CONTROL_POINTS)
    said = Said({"easting": "Rechtswert", "northing": "Hochwert"})
    frame = understand_table(tmp_path / "t.gpkg", CONTROL_POINTS, said).frame
    assert frame["northing"].tolist() == [322e3, 322e3]


@pytest.mark.parametrize("crs", ["EPSG:31255", "EPSG:4326"])
def test_named_columns_are_not_in_the_system_of_the_geometry(tmp_path, crs):
    table = austrian_of_two().drop(columns=["Höhe", "Art"])
    places = [[13.5, 48.25], [13.6, 48.5]]
    write_layer(table, np.array(places), tmp_path / "t.gpkg", crs)
    said = Said({"easting": "Rechtswert", "northing": "Hochwert"})
    read = understand_table(tmp_path / "t.gpkg", CONTROL_POINTS, said)
    assert read.crs is None
    assert read.frame[PLANE].to_numpy().tolist() == [[13e3, 322e3], [14e3, 322e3]]
    assert {"longitude", "latitude"}.isdisjoint(read.frame)


def test_points_are_read_by_one_call_and_say_how(tmp_path):
    table = austrian_of_two()
    write_export(table, tmp_path / "t.csv")
    frame = es.read_points(tmp_path / "t.csv")
    assert frame.columns.tolist() == ["point_id", *PLANE, "height", "role"]
    assert "t.csv: read with decimal commas" in frame.attrs["notes"]
    degrees = np.array([[13.5, 48.25], [13.6, 48.5]])
    write_layer(table[["Punktnummer"]], degrees, tmp_path / "t.gpkg", "EPSG:4326")
    frame = es.read_points(tmp_path / "t.gpkg")
    assert frame[["longitude", "latitude"]].to_numpy().tolist() == degrees.tolist()
    assert frame.attrs["crs"] == "EPSG:4326"


def test_what_is_said_of_points_must_be_known(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("Nr,L,B\nA,2.5,50\n")
    own = {"longitude": "L", "latitude": "B"}
    frame = es.read_points(path, columns=own, crs="EPSG:4326")
    assert frame[["longitude", "latitude"]].to_numpy().tolist() == [[2.5, 50.0]]
    with pytest.raises(EinschaltError, match="crs = 'EPSG:1' is unknown"):
        es.read_points(path, columns=own, crs="EPSG:1")
    with pytest.raises(EinschaltError, match="decimal = ';' is unknown"):
        es.read_points(path, columns=own, decimal=";")
    path.write_text("Nr,easting,northing\nA,2.5,50\n")
    with pytest.raises(TableError, match="is geographic, but the columns are"):
        es.read_points(path, crs="EPSG:4326")
    path.write_text("Nr,E [ft],N [ft]\nA,2.5,50\n")
    assert es.read_points(path, crs="EPSG:2263")["easting"].tolist() == [2.5]


def test_features_that_would_make_a_huge_table_are_refused(tmp_path):
    point = {"type": "Point", "coordinates": [13.5, 48.25]}
    features = [{"geometry": point, "properties": {f"n{k}": k}} for k in range(9000)]
    text = json.dumps({"type": "FeatureCollection", "features": features})
    (tmp_path / "t.geojson").write_text(text, encoding="utf-8")
    with pytest.raises(FileError, match="9000 rows or more of 9000 columns"):
        understand_table(tmp_path / "t.geojson", CONTROL_POINTS)


@pytest.mark.parametrize("place", ["coordinates", "height"])
def test_integers_that_no_float_holds_are_a_sentence(place, tmp_path):
    point = {"type": "Point", "coordinates": [13.5, 48.25]}
    facts = {"point_id": "A"}
    huge = 10**400
    if place == "coordinates":
        point[place][0] = huge
    else:
        facts[place] = huge
    features = [{"type": "Feature", "geometry": point, "properties": facts}]
    text = json.dumps({"type": "FeatureCollection", "features": features})
    (tmp_path / "t.geojson").write_text(text, encoding="utf-8")
    with pytest.raises(EinschaltError, match=r"t\.geojson, row 1, point A: .* inf"):
        es.read_points(tmp_path / "t.geojson")


def test_new_points_of_our_own_results_are_no_control(good_result, tmp_path):
    path = tmp_path / "points.csv"
    good_result.points.to_csv(path, index=False)
    points = es.read_points(path)
    known = good_result.points[good_result.points["role"] != "new"]
    assert points["point_id"].tolist() == known["point_id"].tolist()
    n_new = len(good_result.points) - len(known)
    note = f"points.csv: {n_new} rows of role new left out: new points are no control."
    assert any(one.startswith(note) for one in points.attrs["notes"])


def geojson(path, *features, crs=None):
    """A GeoJSON of geometries and their attributes."""
    content = {"type": "FeatureCollection", "features": []}
    if crs:
        content["crs"] = {"type": "name", "properties": {"name": crs}}
    for kind, place, attributes in features:
        shape = {"type": kind, "coordinates": place}
        one = {"type": "Feature", "geometry": shape, "properties": attributes}
        content["features"].append(one)
    path.write_text(json.dumps(content))
    return understand_table(path, CONTROL_POINTS)


def test_an_only_point_of_a_multipoint_of_geojson_is_a_point(tmp_path):
    path, name = tmp_path / "a.geojson", {"name": "1"}
    place = [600000.5, 5340000.25]
    table = geojson(path, ("MultiPoint", [place], name), crs=UTM)
    assert table.frame[PLANE].iloc[0].tolist() == place
    with pytest.raises(FileError, match="geometry of feature 1 is MultiPoint"):
        geojson(path, ("MultiPoint", [place, place], name), crs=UTM)


def test_plane_columns_beside_longitudes_of_a_layer_are_told_as_left_out(tmp_path):
    # of a rover, drawn on a map of the web
    row = {"Point ID": "S1", "North": 1542209.0, "East": 299865.5, "H [cm]": 33001.0}
    crs = "urn:ogc:def:crs:OGC:1.3:CRS84"
    table = geojson(tmp_path / "a.geojson", ("Point", [121.14, 13.94], row), crs=crs)
    assert {"North", "East"} <= set(table.frame)
    assert table.frame[["longitude", "latitude"]].iloc[0].tolist() == [121.14, 13.94]
    assert table.frame["height"].tolist() == [330.01]
    said = " ".join(table.notes)
    assert "'Point ID' = point_id, 'H [cm]' = height" in said
    assert "northing" not in said


def test_a_unit_of_heights_stays_beside_letters_of_a_layer(tmp_path):
    row = {"Nr": "1", "Y": 600000.5, "X": 5340000.0, "H [cm]": 33001.0}
    place = [600000.5, 5340000.0]
    table = geojson(tmp_path / "a.geojson", ("Point", place, row), crs=UTM)
    assert table.frame["height"].tolist() == [330.01]


ANGLES = "Point;Latitude;Longitude\nA;{};{}\nB;{};{}\n"


def read_angles(tmp_path, *texts):
    (tmp_path / "t.csv").write_text(ANGLES.format(*texts), encoding="utf-8")
    schema = schema_in(CONTROL_POINTS, read_source_crs("EPSG:4326"))
    return understand_csv(tmp_path / "t.csv", schema, Said(crs="EPSG:4326")), schema


@pytest.mark.parametrize(
    "texts",
    [
        ("48°12'36.0\"N", "16°30'00\"W", "48°12'37.5\"N", "16°30'\"W".replace('"', "")),
        ("N48 12 36,0", "W16 30 0", "N48 12 37,5", "W16 30 00,0"),
        ("48-12-36.0", "-16-30-00.0", "48-12-37.5", "-16-30-00.0"),
        ("48 12 36 N", "16 30 00 W", "48 12 37.5 N", "16 30 00.0 W"),
    ],
)
def test_degrees_minutes_and_seconds_are_read(tmp_path, texts):
    table, _ = read_angles(tmp_path, *texts)
    expected = [48.21, 48.0 + 12.0 / 60.0 + 37.5 / 3600.0]
    np.testing.assert_allclose(table.frame["latitude"], expected, rtol=1e-15)
    assert table.frame["longitude"].tolist() == [-16.5, -16.5]
    assert any("read as degrees, minutes and seconds: " in note for note in table.notes)


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        (("48°12'36\"N", "16.5", "48.21", "16.5"), "has degrees and minutes"),  # mixed
        (("16 30 00 E", "48 12 36 N", "16 30 1 E", "48 12 37 N"), "has degrees and"),
        (("48 12 36", "16 30 00 O", "48 12 37", "16 30 00 O"), "is not a number"),
        (("48:12:36", "16:30:00", "48:12:37", "16:30:00"), "is a date or a time"),
        (("48 12 61", "16 30 00", "48 12 62", "16 30 00"), "is not a number"),
    ],
)
def test_angles_that_are_mixed_or_of_another_side_are_told(tmp_path, texts, said):
    table, schema = read_angles(tmp_path, *texts)
    faults = check_table(table.frame, schema).problems
    assert said in faults[0].found


BY_BLANKS = """\
  Pkt     Y        X       H
---------------------------
 007  13000.1 322000.2 412.1
-1  13001.1 322000.2 412.1
=====
"""
BY_BARS = """\
 Pkt |    Y    |    X     | H
-----+---------+----------+-----
 007 | 13000.1 | 322000.2 | 412.1
 -1 | 13001.1 | 322000.2 | 412.1
"""


@pytest.mark.parametrize(("text", "rows"), [(BY_BLANKS, "2, 5"), (BY_BARS, "2")])
def test_rules_of_a_printed_list_are_no_rows(tmp_path, text, rows):
    table = read_text(tmp_path, text, Said(crs=AUSTRIA))
    frame = check_table(table.frame, CONTROL_POINTS).frame
    assert frame["point_id"].tolist() == ["007", "-1"]
    assert frame["height"].tolist() == [412.1, 412.1]
    assert f"t.csv: rows of dashes left out: {rows}" in table.notes
    # what has one value is no rule
    with pytest.raises(EinschaltError, match="the row has 1 values"):
        read_text(tmp_path, f"{text}---A---\n", Said(crs=AUSTRIA))


def test_names_that_a_sheet_keeps_by_a_formula(tmp_path):
    text = 'Nr;Rechtswert;Hochwert\n="0012";1,5;2,5\n="7=";1,5;3,5\n\'="8";1,5;4,5\n'
    names = read_text(tmp_path, text).frame["point_id"]
    # the last one is written so here, for a name that is one
    assert names.tolist() == ["0012", "7=", '="8"']


@pytest.mark.parametrize(
    ("suffix", "remedy"),
    [(".rw5", "Export the points from the instrument"), (".asc", "Save the table as")],
)
def test_a_field_book_is_to_be_exported_as_a_list(tmp_path, suffix, remedy):
    path = tmp_path / f"a{suffix}"
    path.write_text("JB,NMJOB\nSP,PN1,N 2.0,E 1.0,EL 3.0\n")
    with pytest.raises(FileError, match=f"suffix '{suffix}' is unknown.*{remedy}"):
        understand_table(path, CONTROL_POINTS)
