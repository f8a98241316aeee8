"""Points of Leica's GSI, Trimble's JobXML, and books of Sokkia and Nikon."""

import time

import pytest
from fuzz.foreign_files import READ

import einschalt as es
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import written_in
from einschalt.interfaces.programs.recognised import read_foreign


def read(folder, name, text):
    (folder / name).write_text(text)
    return read_foreign(folder / name)


def test_words_of_both_lengths_units_and_kinds_of_points(tmp_path):
    found = read(tmp_path, "a.gsi", READ["a.gsi"][0])
    table = found.tables["control_points"]
    assert table["point_id"].tolist() == ["P7", "1002"]
    assert table["easting"].tolist() == [1.5, 13.826]
    assert table["northing"].tolist() == [-2.25, 3.22]
    assert table["height"].iloc[0] == 3.5
    said = " ".join(found.notes)
    assert "a.gsi: 1 line without coordinates left out" in said
    assert "without the zeros that lead the names" in said


def test_digits_of_gsi_are_read_exactly(tmp_path):
    word = "81..10+0000000013826180"
    line = f"*110001+0000000000001001 {word} 82..10+0000000323236344\n"
    table = read(tmp_path, "a.gsi", line + line).tables["control_points"]
    assert table.to_numpy().tolist() == [["1001", 13826.18, 323236.344]]  # once


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("81..10+00001500", "81..11+00001500", "row 1: word 81..11.* is in feet"),
        ("81..10+00001500", "81..10+0000150", "row 1: '81..10.0000150' is no word"),
        ("81..10+00001500", "81..10+0000x500", "row 1: .* is no word of GSI"),
        ("81..10+00001500", "81..17+00001500", "row 1: word .* is in feet"),
        ("81..10+00001500", "21.102+00001500", "holds no coordinates: angles"),
        ("110001", "xx0001", "row 1: .* is no word of GSI"),
    ],
)
def test_what_is_no_coordinate_in_metres_is_refused(tmp_path, old, new, said):
    line = "110001+00001001 81..10+00001500 82..10+00002250\n"
    assert len(read(tmp_path, "a.gsi", line).tables["control_points"]) == 1
    with pytest.raises(EinschaltError, match=said):
        read(tmp_path, "a.gsi", line.replace(old, new))


ANGLES = "21.102+10000000 22.102+10000000 31..00+00100000"
OF_TARGET = "81..00+00100000 82..00+00200000 83..00+00050000"
OF_STATION = "84..00+00900000 85..00+00800000 86..00+00010000"


@pytest.mark.parametrize(
    ("words", "place"),
    [
        (f"{ANGLES} {OF_TARGET} {OF_STATION}", [100.0, 200.0, 50.0]),
        (f"{OF_STATION} {OF_TARGET}", [100.0, 200.0, 50.0]),
        (OF_STATION, [900.0, 800.0, 10.0]),
        ("81..00+00100000 82..00+00200000 86..00+00010000", [100.0, 200.0]),
    ],
)
def test_a_target_never_gets_coordinates_of_its_station(tmp_path, words, place):
    table = read(tmp_path, "a.gsi", f"110001+000000P1 {words}\n")
    assert table.tables["control_points"].iloc[0, 1:].tolist() == place


@pytest.mark.parametrize("index", ["21", "22", "31", "32", "33"])
def test_a_line_of_measurements_has_no_point_of_its_station(tmp_path, index):
    lines = f"110001+000000P1 {OF_TARGET}\n110003+000000P2 {index}..."
    found = read(tmp_path, "a.gsi", f"{lines}2+10000000 {OF_STATION}\n")
    assert found.tables["control_points"]["point_id"].tolist() == ["P1"]
    assert "a.gsi: 1 line without coordinates left out" in found.notes


@pytest.mark.parametrize(
    ("line", "name"),
    [
        (f"110001+00Baum 1 {OF_TARGET}", "Baum 1"),
        (f"110001+000000P1 71....+00Baum 1 {OF_TARGET}", "P1"),
        (f"110001+000000P1 71....+Baum 1   {OF_TARGET}", "P1"),
        (f"110001+000000P1 71....+Baum 1 {OF_TARGET}", "P1"),
        (f"110001+000000P1 {OF_TARGET} 71....+Baum 1", "P1"),
        (f"110001+000000P1  51....+0000+000  {OF_TARGET}", "P1"),
        (f"110001+00081..0 {OF_TARGET}", "81..0"),
    ],
)
def test_words_of_gsi_have_their_width_and_may_hold_blanks(tmp_path, line, name):
    table = read(tmp_path, "a.gsi", line + "\n").tables["control_points"]
    assert table.to_numpy().tolist() == [[name, 100.0, 200.0, 50.0]]


def test_hyphens_of_an_instrument_are_no_value(tmp_path):
    """So TPS instruments write a height that they do not have."""
    words = "81..10+0000000000100000 82..10+0000000000200000"
    lines = [
        f"*110001+00000000000000P1 {words} 83..10+0000000000050000",
        f"*110002+00000000000000P2 {words} 83..10+00000000000-----",
        f"*110003+00000000000000P3 {words.replace('200000', '0-----')}",
    ]
    found = read(tmp_path, "a.gsi", " \n".join(lines) + "\n")
    table = found.tables["control_points"].set_index("point_id")
    assert table.index.tolist() == ["P1", "P2"]
    assert table.loc["P1"].tolist() == [100.0, 200.0, 50.0]
    assert table.loc["P2", ["easting", "northing"]].tolist() == [100.0, 200.0]
    assert table["height"].isna().tolist() == [False, True]
    assert "a.gsi: 1 line without coordinates left out" in found.notes


def test_a_second_point_of_a_line_is_a_point_of_its_own(tmp_path):
    """Its words were taken for those of the first."""
    other = OF_TARGET.replace("+001", "+007")
    line = f"110001+000000P1 {OF_TARGET} 110002+000000P2 {other}\n"
    table = read(tmp_path, "a.gsi", line).tables["control_points"]
    assert table.to_numpy().tolist() == [
        ["P1", 100.0, 200.0, 50.0],
        ["P2", 700.0, 200.0, 50.0],
    ]


@pytest.mark.parametrize("is_later", [True, False])
def test_a_point_with_and_without_its_height_is_one(tmp_path, is_later):
    """It was two rows, of which the check said that one repeats the other."""
    bare = OF_TARGET.replace("+00050000", "+000-----")
    lines = [f"110001+000000P1 {one}\n" for one in (bare, OF_TARGET)]
    elsewhere = f"110003+000000P1 {bare.replace('+001', '+007')}\n"
    text = "".join(lines[:: 1 if is_later else -1])
    table = read(tmp_path, "a.gsi", text).tables["control_points"]
    assert table.to_numpy().tolist() == [["P1", 100.0, 200.0, 50.0]]
    # another place is another point, and heights that differ are told by the check
    other = lines[1].replace("+00050000", "+00060000")
    table = read(tmp_path, "a.gsi", text + elsewhere + other).tables["control_points"]
    assert table["easting"].tolist() == [100.0, 700.0, 100.0]
    assert table["height"].fillna(-1.0).tolist() == [50.0, -1.0, 60.0]


def test_a_point_without_coordinates_is_no_line_without(tmp_path):
    """A line that was read in part was said to be left out."""
    bare = OF_TARGET.replace("+00200000", "+000-----")
    line = f"110001+000000P1 {OF_TARGET} 110002+000000P2 {bare}\n"
    found = read(tmp_path, "a.gsi", line + "410003+00000001\n")
    assert found.tables["control_points"]["point_id"].tolist() == ["P1"]
    assert found.notes[1:] == (
        "a.gsi: 1 line without coordinates left out",
        "a.gsi: 1 point without coordinates left out",
    )


def test_a_line_of_blanks_takes_no_time(tmp_path):
    """Of 20 000 blanks each was the start of a search to the end of them."""
    remark, blanks = "71....+aaaaaaaaaa", " " * 100_000
    begin = time.process_time()
    table = read(tmp_path, "a.gsi", f"110001+000000P1 {OF_TARGET} {remark}{blanks}b\n")
    assert len(table.tables["control_points"]) == 1
    assert time.process_time() - begin < 5.0


def test_names_of_gsi_16_may_hold_blanks(tmp_path):
    line = "*110001+000000Alter Turm 81..00+0000000000100000 71....+0000000alte Mauer"
    found = read(tmp_path, "a.gsi", line + " 82..00-0000000000200000\n")
    table = found.tables["control_points"]
    assert table.to_numpy().tolist() == [["Alter Turm", 100.0, -200.0]]


@pytest.mark.parametrize(
    ("name", "text"),
    [("a.gsi", f"110001+000000P1 {OF_TARGET}\n"), ("a.jxl", READ["a.jxl"][0])],
)
def test_metres_become_the_unit_of_the_system(tmp_path, name, text):
    read(tmp_path, name, text)
    metres = es.read_points(tmp_path / name, crs="EPSG:32618")
    feet = es.read_points(tmp_path / name, crs="EPSG:2263")  # US survey feet
    plane, foot = ["easting", "northing"], 1200.0 / 3937.0
    assert metres.loc[0, "height"] == feet.loc[0, "height"]
    expected = (metres.loc[0, plane] / foot).tolist()
    assert feet.loc[0, plane].tolist() == pytest.approx(expected, rel=1e-12)
    said = f"{name}: easting, northing converted from metres to US survey foot"
    assert said in feet.attrs["notes"]


def test_what_is_left_out_is_counted_in_both_forms():
    one, two = "a.gsi: 1 line without", "a.gsi: 2 lines without"
    with written_in("de"):
        told = [retold(f"{start} coordinates left out") for start in (one, two)]
        grid = retold("a.jxl: 1 point without grid left out")
    assert told == [
        "a.gsi: 1 Zeile ohne Koordinaten weggelassen",
        "a.gsi: 2 Zeilen ohne Koordinaten weggelassen",
    ]
    assert grid == "a.jxl: 1 Punkt ohne Gitterkoordinaten weggelassen"


@pytest.mark.parametrize(("east", "north"), [("NaN", "abc"), ("abc", "NaN")])
def test_each_word_of_a_grid_is_looked_at(tmp_path, east, north):
    text = READ["a.jxl"][0].replace("1.5</East>", f"{east}</East>")
    text = text.replace("2.25</North>", f"{north}</North>")
    assert north in text
    with pytest.raises(EinschaltError, match="'abc' of point P 1 is no number"):
        read(tmp_path, "a.jxl", text)


def test_points_without_a_grid_are_counted(tmp_path):
    text = READ["a.jxl"][0]
    found = read(tmp_path, "a.jxl", text)
    table = found.tables["control_points"]
    assert table.to_numpy().tolist() == [["P 1", 1.5, 2.25, 3.5]]
    assert any("a.jxl: 1 point without grid left out" in n for n in found.notes)
    with pytest.raises(EinschaltError, match="'wide' of point P 1 is no number"):
        read(tmp_path, "a.jxl", text.replace("1.5</East>", "wide</East>"))
    with pytest.raises(EinschaltError, match="Choose a coordinate system in the job"):
        read(tmp_path, "a.jxl", text.replace("East", "West"))
    with pytest.raises(EinschaltError, match="a point of the reductions has no name"):
        read(tmp_path, "a.jxl", text.replace("<Name>P2</Name>", ""))


# in the shape of the end of a job of the Survey Controller
SYSTEM = """<Environment><CoordinateSystem><SystemName>UTM</SystemName>
<ZoneName>33 North</ZoneName><DatumName>WGS 1984</DatumName>
<Ellipsoid><EarthRadius>6378137</EarthRadius><Flattening>0.00335281067183</Flattening>
</Ellipsoid><Projection><Type>TransverseMercator</Type><ShiftGridFileName/>
<CentralLatitude>0</CentralLatitude><CentralLongitude>15</CentralLongitude>
<FalseNorthing>0</FalseNorthing><FalseEasting>500000</FalseEasting><Scale>0.9996</Scale>
<SouthAzimuth>false</SouthAzimuth><GridOrientation>IncreasingNorthEast</GridOrientation>
</Projection><HorizontalAdjustment><Type>NoAdjustment</Type></HorizontalAdjustment>
</CoordinateSystem></Environment></JOBFile>"""
AUSTRIA = (
    SYSTEM.replace("UTM", "Austria")
    .replace("33 North", "Austria GK M34")
    .replace("6378137", "6377397.155")
    .replace("0.00335281067183", "0.00334277318217")
    .replace(">15<", "> 16.3333333333333<")
    .replace("<FalseNorthing>0", "<FalseNorthing>-5000000")
    .replace("500000<", "750000<")
    .replace("0.9996", "1")
)
POLAND = (
    SYSTEM.replace("UTM", "Polska")
    .replace("33 North", "2000/18")
    .replace(">15<", ">18<")
    .replace("500000", "6500000")
    .replace("0.9996", "0.999923")
)
RECORDS = (
    SYSTEM.replace("<Environment>", "<FieldBook>")
    .replace("</Environment>", "</FieldBook>")
    .replace("CoordinateSystem>", "CoordinateSystemRecord>")
    .replace("<Projection>", "</CoordinateSystemRecord><ProjectionRecord><Projection>")
    .replace("</Projection>", "</Projection></ProjectionRecord><A>")
    .replace("</CoordinateSystemRecord></FieldBook>", "</A></FieldBook>")
)


def job(folder, system):
    text = READ["a.jxl"][0].replace("</JOBFile>", system)
    return read(folder, "a.jxl", text)


@pytest.mark.parametrize(
    ("system", "code", "noted"),
    [
        (SYSTEM, "EPSG:32633", "UTM, 33 North, is WGS 84 / UTM zone 33N (EPSG:32633)"),
        (RECORDS, "EPSG:32633", "UTM, 33 North, is WGS 84 / UTM zone 33N (EPSG:32633)"),
        (AUSTRIA, "EPSG:31259", "is MGI / Austria GK M34 (EPSG:31259)"),
        (
            SYSTEM.replace("<DatumName>", "<EPSGCode>32633</EPSGCode><DatumName>"),
            "EPSG:32633",
            "(EPSG:32633)",
        ),
        # a number alone is no code, and names that are much alike are not the same
        (SYSTEM.replace("33 North", "2056"), None, "UTM, 2056, is none that is known"),
        (SYSTEM.replace("500000", "5500000"), None, "is none that is known by this"),
        (SYSTEM.replace("6378137", "6378388"), None, "is none that is known by this"),
        (SYSTEM.replace("NorthEast", "SouthWest"), None, "is none that is known by"),
        (SYSTEM.replace("NoAdj", "PlaneAdj"), None, "fitted to its site (PlaneAdj"),
        (
            POLAND,
            None,
            "projection is TransverseMercator, CentralLatitude 0, CentralLongitude 18",
        ),
    ],
)
def test_the_system_of_a_job_is_told(tmp_path, system, code, noted):
    found = job(tmp_path, system)
    assert found.crs == code
    (note,) = [one for one in found.notes if "system" in one]
    assert noted in note
    with written_in("de"):
        assert "das System des Projekts" in retold(note)


def test_a_job_without_a_system_states_none(tmp_path):
    found = job(tmp_path, "</JOBFile>")
    assert found.crs is None
    assert not [one for one in found.notes if "system" in one]


def record(name, *numbers, widths=(16, 16), kind="08KI"):
    """A point of a book of SDR."""
    width, of_number = widths
    return f"{kind}{name:>{width}}" + "".join(f"{n:<{of_number}}" for n in numbers)


@pytest.mark.parametrize(
    ("version", "widths"),
    [("SDR33 V04-04.34", (16, 16)), ("SDR20     V03-05", (4, 10))],
)
@pytest.mark.parametrize("order", [1, 2])  # northing, easting or easting, northing
def test_the_header_of_sdr_tells_which_coordinate_comes_first(
    tmp_path, version, widths, order
):
    values = [(5.0, 7.0, 9.0), (6.0, 8.0, "")]
    if order == 1:
        values = [(north, east, height) for east, north, height in values]
    names = ["0012", "B-1"]
    points = [record(n, *v, widths=widths) for n, v in zip(names, values, strict=True)]
    header = f"\x0200NM{version}  25-Sep-10 22:10 1131{order}1"
    text = "\n".join([header, *points, points[0], record("C", "", "", widths=widths)])
    found = read(tmp_path, "a.sdr", f"{text}\n")
    table = found.tables["control_points"]
    assert table["point_id"].tolist() == names  # each once
    assert table["easting"].tolist() == [5.0, 6.0]
    assert table["northing"].tolist() == [7.0, 8.0]
    assert table["height"].fillna(-1.0).tolist() == [9.0, -1.0]
    first = "northing" if order == 1 else "easting"
    said = " ".join(found.notes)
    assert f"the {first} comes first, as the header has it" in said
    assert "1 point without coordinates left out" in said


BOOK = f"00NMSDR33 V04-04.34 25-Nov-15 12:33 111111\n{record('A', 5.0, 7.0, 9.0)}\n"
RAW = READ["a.raw"][0]


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.sdr", BOOK.replace("111111", "121111"), "row 1: the book is in feet"),
        (
            "a.sdr",
            BOOK.replace("111111", "111131"),
            "row 1: the header .* does not tell",
        ),
        ("a.sdr", BOOK.replace("111111", ""), "row 1: the header .* does not tell"),
        ("a.sdr", BOOK.replace("7.0", "7,0"), "row 2: the point 'A' has '7,0'"),
        ("a.sdr", BOOK.replace("7.0", "   "), "row 2: the point 'A' has one coord"),
        ("a.sdr", BOOK.replace("   A", "    "), "row 2: a point has no name"),
        ("a.sdr", BOOK.replace("08KI", "09F1"), "holds no coordinates"),
        ("a.raw", RAW.replace("Metres", "Feet"), "row 2: the book is in feet"),
        ("a.raw", RAW.replace("NEZ", "XYZ"), "row 3: the order of the coordinates"),
        ("a.raw", RAW.replace("1.500", ""), "row 4: the point 'P 7' has one coord"),
    ],
)
def test_books_without_coordinates_in_metres_are_refused(tmp_path, name, text, said):
    with pytest.raises(EinschaltError, match=said):
        read(tmp_path, name, text)


def test_eastings_may_come_first_in_books_of_ruide(tmp_path):
    text = RAW.replace("Nikon RAW data format", "Ruide Raw data").replace("NEZ", "ENZ")
    for name in ("a.sdr", "a.txt"):  # as the instrument calls it, and as it is renamed
        table = read(tmp_path, name, text).tables["control_points"]
        assert table.iloc[0].tolist() == ["P 7", -2.25, 1.5, 3.5]


def test_an_order_or_a_unit_that_changes_is_refused(tmp_path):
    head, point = "CO,Nikon RAW data format V2.00\n", "UP,1,,10.000,20.000,5.000,\n"
    ordered = f"{head}CO,Coord Order: NEZ\n"
    for more in ("CO,Coord Order: XYZ", "CO,Coord Order: ENZ"):
        with pytest.raises(EinschaltError, match="order of the coordinates"):
            read(tmp_path, "a.raw", f"{ordered}{point}{more}\n{point}")
    assert read(tmp_path, "a.raw", f"{ordered}CO,Dist Units: meters\n{point}")
    for unit, said in (("US Feet", "in feet"), ("cubits", "unit of lengths")):
        with pytest.raises(EinschaltError, match=said):
            read(tmp_path, "a.raw", f"{ordered}CO,Dist Units: {unit}\n{point}")


@pytest.mark.parametrize("encoding", ["cp932", "utf-8", "utf-8-sig"])
def test_points_of_sima_with_names_of_japanese(tmp_path, encoding):
    text = "G00,03,現場,\nZ00,座標ﾃﾞｰﾀ,\nA00,\nA01,1,基準点 1,-2.250,1.500,3.500,\n"
    text += "A01,2,,10.0,20.0\nA99,\nD00,1,12-3,1,\nB01,1,2,\n"
    (tmp_path / "a.sim").write_bytes(text.encode(encoding))
    found = read_foreign(tmp_path / "a.sim")
    table = found.tables["control_points"]
    assert table["point_id"].tolist() == ["基準点 1", "2"]
    assert table["easting"].tolist() == [1.5, 20.0]  # Y
    assert table["northing"].tolist() == [-2.25, 10.0]  # X
    assert table["height"].iloc[0] == 3.5
    assert "a.sim: 2 lines of parcels and routes left out" in found.notes


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("A01,1,P,1.0,x,", "row 4: 'A01,1,P,1.0,x,' is no point"),
        ("A01,1,P,1.0", "row 4: .* is no point"),
        ("A01,,,1.0,2.0,", "row 4: .* is no point"),
        ("B01,1,2,", "holds no points"),
    ],
)
def test_what_is_no_point_of_sima_is_refused(tmp_path, line, said):
    (tmp_path / "a.sim").write_text(f"G00,01,a,\nZ00,b,\nA00,\n{line}\nA99,\n")
    with pytest.raises(EinschaltError, match=said):
        read_foreign(tmp_path / "a.sim")
