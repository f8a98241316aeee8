"""Lists as offices of many countries head and write them."""

import numpy as np
import pytest

from einschalt.foundations.column_words import folded
from einschalt.foundations.errors import EinschaltError, TableError, raise_problems
from einschalt.foundations.projections import read_source_crs
from einschalt.foundations.tables import CONTROL_POINTS, MODEL_BASES, check_table
from einschalt.interfaces.files.csv_tables import understand_csv
from einschalt.interfaces.files.points_of_systems import schema_in
from einschalt.interfaces.files.understood_tables import Said

HEIGHT = 411.25
# header, encoding, system, whether the northing stands first, place
LISTS = {
    "Spanish": ("Nº Punto;Coord. X (m);Coord. Y (m);Cota (m)", "cp1252", 25830, 0),
    "Spanish words": ("Número de punto;Este;Norte;Elevación", "utf-8-sig", 25830, 0),
    "Portuguese": ("Vértice;M (m);P (m);Cota", "cp1252", 3763, 0),
    "Brazilian": ("Ponto;Leste (E);Norte (N);Altitude ortométrica", "utf-8", 31983, 0),
    "Polish": ("Nr punktu;X;Y;H", "utf-8", 2178, 1),
    "Polish words": (
        "Numer punktu;Współrzędna X [m];Współrzędna Y [m];Wysokość H [m]",
        *("cp1250", 2178, 1),
    ),
    "Hungarian": ("Pontszám;Y;X;Magasság", "cp1250", 23700, 0),
    "Hungarian system": ("Pont száma;EOV Y [m];EOV X [m];Z [m]", "cp1250", 23700, 0),
    "Slovene": ("Št. točke;E (m);N (m);H (m)", "cp1250", 3794, 0),
    "Croatian": ("Broj točke;E;N;Visina", "iso8859-2", 3765, 0),
    "Dutch": ("Puntnummer;X-RD;Y-RD;Hoogte NAP", "utf-8", 28992, 0),
    "Belgian": ("Punt;X (Lambert 72);Y (Lambert 72);Z (TAW)", "utf-8", 31370, 0),
    "Swedish": ("Punktnamn;N;E;Höjd", "cp1252", 3011, 1),
    "Norwegian": ("Punktnr;Nord;Øst;Høyde", "cp1252", 25832, 1),
    "Danish": ("Punktnr.;Y / Nord;X / Øst;Kote DVR90", "utf-8", 25832, 1),
    "Finnish": ("Pistenumero;Pohjoinen;Itä;Korkeus N2000", "utf-8", 3879, 1),
    "Turkish": ("Nokta No;Sağa (Y);Yukarı (X);Kot (H)", "utf-8", 5254, 0),
    "Romanian": ("Nr. pct.;X [m];Y [m];Z [m]", "utf-8", 3844, 1),
    "Japanese": ("点名;X座標;Y座標;標高", "cp932", 6677, 1),
    "Chinese": ("点号;X坐标;Y坐标;高程", "gbk", 4547, 1),
    "British": ("Stn;Eastings;Northings;Level (mAOD)", "utf-8", 27700, 0),
}
PLACES = {  # easting and northing in the area of each system
    25830: (430000.5, 4476000.25),
    3763: (-20000.5, -100000.25),
    31983: (610000.5, 7626000.25),
    2178: (7500000.5, 5826000.25),
    23700: (660000.5, 236000.25),
    3794: (460000.5, 100000.25),
    3765: (460000.5, 5050000.25),
    28992: (155000.5, 463000.25),
    31370: (155000.5, 163000.25),
    3011: (150000.5, 6580000.25),
    25832: (590000.5, 6640000.25),
    3879: (25490000.5, 6680000.25),
    5254: (510000.5, 4426000.25),
    3844: (500000.5, 480000.25),
    6677: (-20000.5, -35000.25),
    4547: (510000.5, 3426000.25),
    27700: (410000.5, 306000.25),
}


def read(tmp_path, text, crs=None, encoding="utf-8", **said):
    path = tmp_path / "list.csv"
    path.write_bytes(text.encode(encoding))
    return understand_csv(path, CONTROL_POINTS, Said(crs=crs, **said))


@pytest.mark.parametrize("name", LISTS)
def test_lists_of_countries_are_read_as_they_are_meant(tmp_path, name):
    header, encoding, code, is_northing_first = LISTS[name]
    east, north = PLACES[code]
    first, second = (north, east) if is_northing_first else (east, north)
    rows = "".join(
        f"{point};{first + k};{second + k};{HEIGHT + k}\n"
        for k, point in enumerate(("007", "7/8"))
    )
    table = read(tmp_path, f"{header}\n{rows}", f"EPSG:{code}", encoding)
    frame = table.frame
    assert frame["point_id"].tolist() == ["007", "7/8"]
    assert frame["easting"].tolist() == [east, east + 1]
    assert frame["northing"].tolist() == [north, north + 1]
    assert frame["height"].tolist() == [HEIGHT, HEIGHT + 1]


@pytest.mark.parametrize(
    ("header", "y_is_east", "reason"),
    [
        ("Nr pkt;X;Y;H", True, "as Polish tables have them"),
        ("Pontszám;Y;X;Magasság", True, "as Hungarian tables have them"),
        ("Številka točke;Y;X;Nadmorska višina", True, "as Slovene tables have them"),
        ("点名;X座標;Y座標;標高", True, "as Japanese and Chinese tables have them"),
        ("Puntnummer;X;Y;Hoogte", False, "as Dutch tables have them"),
        ("Punktnummer;Y;X;Höhe", True, "as German tables have them"),
    ],
)
def test_letters_are_those_of_the_country_and_that_is_told(
    tmp_path, header, y_is_east, reason
):
    table = read(tmp_path, f"{header}\nA;1000.5;2000.25;3.5\n")
    letters = [
        name[-1] if "座標" not in name else name[0] for name in header.split(";")
    ]
    place = dict(zip(letters, (None, 1000.5, 2000.25, 3.5), strict=True))
    assert table.frame["easting"].tolist() == [place["Y" if y_is_east else "X"]]
    assert table.notes[-1].endswith(reason)


@pytest.mark.parametrize(
    ("header", "said"),
    [
        # both are in use
        ("Punkt;X;Y;Kote", "which of them is the easting"),
        ("Punktnr;X;Y;Høyde", "which of them is the easting"),
        ("Punkt;X;Y;Höjd", "which of them is the easting"),
        ("Piste;X;Y;Korkeus", "which of them is the easting"),
        ("Punto;X;Y;Cota", "which of them is the easting"),
        # to the south and west
        ("Číslo bodu;Y;X;Z", "Say crs, such as EPSG:5514 for S-JTSK"),
        # of no one language
        ("Punto;Y;X;Hoogte", "which of them is the easting"),
    ],
)
def test_letters_of_which_a_country_has_two_meanings_are_asked_about(
    tmp_path, header, said
):
    with pytest.raises(TableError, match=said):
        read(tmp_path, f"{header}\nA;1000.5;2000.25;3.5\n")


def test_signs_of_other_scripts_are_no_letters_of_ours(tmp_path):
    """A deviation was taken for the easting; now it is no column of the table."""
    assert folded("σE") == "σe"
    text = "Nr;Rechtswert;Hochwert;ΔN;σH\nA;1.5;2.5;0.1;0.2\n"
    table = read(tmp_path, text)
    assert list(table.frame)[3:] == ["ΔN", "σH"]
    frame = read(tmp_path, "Nr;σE;N\nA;1.5;2.5\n").frame
    (fault,) = check_table(frame, CONTROL_POINTS).problems
    assert "'easting' is missing" in fault.found


def test_names_of_points_are_those_of_the_encoding_of_the_header(tmp_path):
    text = "点名,X座標,Y座標\n基準点1,100.5,200.5\n"
    table = read(tmp_path, text, encoding="cp932")
    assert table.frame["point_id"].tolist() == ["基準点1"]
    assert "read as Shift-JIS text" in table.notes[0]
    # what no word speaks for stays Windows-1252
    table = read(tmp_path, "Nr;E;N\nMühle;1.5;2.5\n", encoding="cp1252")
    assert table.frame["point_id"].tolist() == ["Mühle"]
    assert "read as Windows-1252" in table.notes[0]


RULERS = """\
-----;-----;-----;----
Pkt;Rechtswert;Hochwert;H
-----;-----;-----;----
007;13000,1;322000,2;412,1
=====;=====;=====;
-1;13001,1;322000,2;412,1
─────;─────;─────;────
"""


@pytest.mark.parametrize("sign", [";", "\t", "|"])
def test_rulers_between_separators_are_no_rows(tmp_path, sign):
    table = read(tmp_path, RULERS.replace(";", sign))
    frame = check_table(table.frame, CONTROL_POINTS).frame
    assert frame["point_id"].tolist() == ["007", "-1"]
    assert frame["northing"].tolist() == [322000.2, 322000.2]
    assert any("rows of dashes left out: 3, 5, 7" in note for note in table.notes)


PAGES = """\
LFP3-Liste Gemeinde Muster 2024    Seite 1

Punkt-Nr.      E [m]           N [m]        H [m]
---------  ------------  ------------  -------
      007  2'600'009.37  1'200'002.00   300.00
     10 A  2'600'280.37  1'199'995.28   342.07

LFP3-Liste Gemeinde Muster 2024    Seite 2

Punkt-Nr.      E [m]           N [m]        H [m]
---------  ------------  ------------  -------
     1042  2'600'526.62  1'200'006.52   345.46
"""


def test_titles_of_pages_and_names_with_blanks(tmp_path):
    table = read(tmp_path, PAGES, "EPSG:2056")
    frame = check_table(table.frame, CONTROL_POINTS).frame
    assert frame["point_id"].tolist() == ["007", "10 A", "1042"]
    assert frame["easting"].tolist() == [2600009.37, 2600280.37, 2600526.62]
    assert any("repeating the title left out: 8, 10" in note for note in table.notes)
    # another line of words is not passed over
    with pytest.raises(EinschaltError, match="row 13"):
        read(tmp_path, f"{PAGES}Ende der Liste von Muster\n", "EPSG:2056")


def test_a_header_whose_names_have_blanks_between_gaps(tmp_path):
    text = (
        "Seznam souřadnic S-JTSK, Bpv\n---------------------------\n"
        "  Číslo bodu        Y            X          Z\n"
        "        0001    646099.78   1060562.13   219.88\n"
    )
    table = read(tmp_path, text, "EPSG:5514", "cp1250")
    assert table.frame.iloc[0].tolist() == ["0001", -646099.78, -1060562.13, 219.88]
    assert "'Y' counts to the west" in " ".join(table.notes)


COUNTED = "Punto;Est;Nord;Quota\n1;16,25;49,5;400,1\n2;17,5;49,75;-\n"


@pytest.mark.parametrize(
    "last", ["Totale punti: 2", "Totale: 2;;;", "Totale;2;;", "n. punti: 2 (due)"]
)
def test_a_last_line_that_counts_the_rows_is_none(tmp_path, last):
    table = read(tmp_path, f"{COUNTED}{last}\n")
    frame = check_table(table.frame, CONTROL_POINTS).frame
    assert frame["point_id"].tolist() == ["1", "2"]
    assert any("the last row, " in note for note in table.notes)


@pytest.mark.parametrize(
    "last", ["Totale punti: 3", "Totale: 3;;;", "2", "vedi foglio 1 di 2", "P2;3,5;;"]
)
def test_a_last_line_that_may_be_a_point_is_refused(tmp_path, last):
    with pytest.raises(EinschaltError, match="row 4"):
        raise_problems(
            check_table(
                read(tmp_path, f"{COUNTED}{last}\n").frame, CONTROL_POINTS, source="a"
            ).problems
        )


def test_a_row_of_a_table_of_two_columns_counts_nothing(tmp_path):
    path = tmp_path / "bases.csv"
    path.write_text("model_id;base\n1/2;91,5\n2/3;92,5\nstrip;2\n", encoding="utf-8")
    frame = understand_csv(path, MODEL_BASES, Said()).frame
    assert frame["model_id"].tolist() == ["1/2", "2/3", "strip"]


@pytest.mark.parametrize("filler", ["-", "--", "–", "n/a", "N.A.", "k. A.", "#NV"])
def test_a_hyphen_for_a_height_is_none(tmp_path, filler):
    table = read(tmp_path, f"Pkt;E;N;H\n1;16,25;49,5;400,1\n2;17,5;49,75;{filler}\n")
    frame = check_table(table.frame, CONTROL_POINTS).frame
    assert frame["height"].isna().tolist() == [False, True]
    assert f"list.csv: taken for missing values: height {filler!r}" in table.notes
    # a coordinate cannot be missing
    table = read(tmp_path, f"Pkt;E;N;H\n1;16,25;49,5;400,1\n2;17,5;{filler};2,5\n")
    (fault,) = check_table(table.frame, CONTROL_POINTS).problems
    assert "northing" in fault.found


GEOGRAPHIC = schema_in(CONTROL_POINTS, read_source_crs("EPSG:4326"))
ANGLES = np.array([47.2096, 47.2191, 47.2344, 47.2509, 47.2688, 47.2823, 47.2996])


def packed(angles):
    """Angles as pocket calculators write them."""
    seconds = np.round(angles * 3600.0, 6)
    degrees, rest = np.divmod(seconds, 3600.0)
    minutes, seconds = np.divmod(rest, 60.0)
    return [
        f"{int(d)}.{int(m):02d}{round(s * 1e6):08d}"
        for d, m, s in zip(degrees, minutes, seconds, strict=True)
    ]


def read_angles(tmp_path, head, latitudes, angles=None, decimal="."):
    rows = [
        f"{k};{lat};{lon}\n"
        for k, (lat, lon) in enumerate(
            zip(latitudes, latitudes[::-1], strict=True), start=1
        )
    ]
    path = tmp_path / "list.csv"
    path.write_text(f"{head}\n{''.join(rows).replace('.', decimal)}", encoding="utf-8")
    said = Said(crs="EPSG:4326", angles=angles)
    return understand_csv(path, GEOGRAPHIC, said)


@pytest.mark.parametrize(
    ("head", "angles", "decimal"),
    [
        ("Point;Lat (D.MMSS);Long (D.MMSS)", None, "."),
        ("PNT;LATITUDE DDD.MMSSsss;LONGITUDE DDD.MMSSsss", None, "."),
        ("Pkt;Breite [ddd.mmssss];Länge [ddd.mmssss]", None, ","),
        ("Point;Lat_dms;Long_dms", None, "."),
        ("Punto;Latitud;Longitud\n;[gg.mmss];[gg.mmss]", None, "."),
        ("Point;Lat;Long", "D.MMSS", "."),
    ],
)
def test_packed_angles_are_read_where_something_tells_them(
    tmp_path, head, angles, decimal
):
    table = read_angles(tmp_path, head, packed(ANGLES), angles, decimal)
    np.testing.assert_allclose(table.frame["latitude"], ANGLES, rtol=1e-13)
    np.testing.assert_allclose(table.frame["longitude"], ANGLES[::-1], rtol=1e-13)
    assert any("as degrees, minutes and seconds (D.MMSS)" in n for n in table.notes)


def test_angles_that_could_be_packed_are_asked_about(tmp_path):
    head = "Point;Lat;Long"
    with pytest.raises(TableError, match="decimal degrees, or degrees, minutes and"):
        read_angles(tmp_path, head, packed(ANGLES))
    # the answer, and a unit in the header
    for name, angles in ((head, "degrees"), ("Point;Lat [deg];Long [deg]", None)):
        table = read_angles(tmp_path, name, packed(ANGLES), angles)
        assert table.frame["latitude"].tolist() == list(map(float, packed(ANGLES)))
    # of a few nothing can be told, which is noted
    table = read_angles(tmp_path, head, packed(ANGLES[:3]))
    assert any("could be degrees, minutes and seconds" in note for note in table.notes)
    # a minute of 60 or more shows decimal degrees
    table = read_angles(tmp_path, head, [f"{angle:.8f}" for angle in ANGLES + 0.47])
    assert not any("could be" in note for note in table.notes)


def test_packed_angles_that_cannot_be_are_refused(tmp_path):
    with pytest.raises(TableError, match=r"row 3: .*47\.6601 has minutes or seconds"):
        read_angles(tmp_path, "P;Lat;Long", ["47.1212", "47.6601", "47.2255"], "D.MMSS")
    with pytest.raises(
        TableError, match=r"'Long' and 'Lat .D.MMSS.' do not both state"
    ):
        read_angles(tmp_path, "Point;Lat (D.MMSS);Long", packed(ANGLES))
