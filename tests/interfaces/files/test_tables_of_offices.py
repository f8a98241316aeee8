"""Tables as offices have them: read as they were meant, or refused with a question."""

import time
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyogrio
import pytest

from einschalt.foundations.errors import (
    EinschaltError,
    FileError,
    TableError,
    raise_problems,
)
from einschalt.foundations.tables import (
    CONTROL_POINTS,
    IMAGE_POINTS,
    MODEL_POINTS,
    check_table,
)
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.files.understood_tables import Said

AUSTRIA = Said(crs="EPSG:31255")
POINTS = {"7/8": (13000.25, 326802.003, 411.5), "0012": (13082.674, 326844.209, 9.75)}
POINTS["A 1"] = (9.37, 326795.285, 1234.5)
HEAD = "Punktnummer;Rechtswert;Hochwert;Höhe;Art\n"
TEXT = "".join(
    f"{name};{e};{n};{h};Passpunkt\n".replace(".", ",")
    for name, (e, n, h) in POINTS.items()
)
PLAIN = HEAD + TEXT
WITHOUT_BLANKS = TEXT.replace("A 1", "A1")


def in_groups(sign, decimal):
    """The table with signs between thousands."""
    text = HEAD
    for name, numbers in POINTS.items():
        cells = [f"{number:,.3f}" for number in numbers]
        cells = [c.replace(".", "_").replace(",", sign) for c in cells]
        cells = [c.replace("_", decimal) for c in cells]
        text += ";".join([name, *cells, "PP"]) + "\n"
    return text


def as_list(sign, decimal):
    text = in_groups(sign, decimal).removeprefix(HEAD)
    return text.replace("A 1", "A1").replace(";", "  ")


def as_blanks(text):
    return text.replace(";", "   ").replace(",", ".")


TABLES = {
    "plain": PLAIN,
    "title": 'Büro "Huber\nProjekt: Neukirchen, 12.3.2024; Lage\n\n' + PLAIN,
    "line for Excel": "sep=;\r\n" + PLAIN.replace("\n", "\r\n"),
    "bars": PLAIN.replace(";", "|"),
    "comments of other programs": "% of X\n// of Y\n! of Z\n" + PLAIN,
    "separator at the end of values": PLAIN.replace("punkt\n", "punkt;\n"),
    "separators at the end of all": PLAIN.replace("\n", ";;\n"),
    "Ctrl-Z": PLAIN + "\x1a",
    "units": PLAIN.replace("\n", "\n;[m];[m];[m];\n", 1),
    "bare units": PLAIN.replace("\n", "\n-;m;m;m;-\n", 1),
    "names in two lines": "Punkt;Koordinaten;;Höhe;Art\nNr;Rechtswert;Hochwert;;\n"
    + TEXT,
    "names in two lines and units": (
        "Punktnummer;Lage;;Höhe;Art\n;Rechtswert;Hochwert;;\n;m;m;m;\n" + TEXT
    ),
    "names in two lines, heights above the Adriatic": (
        "Punktnummer;Lage;;Höhe;Art\n;Rechtswert;Hochwert;[m ü. A.];\n" + TEXT
    ),
    "names in two lines, bare units": (
        "Punktnummer;Lage;;Höhe;Art\n;Rechtswert;Hochwert;m ü.M.;\n" + TEXT
    ),
    "units, heights above NHN": PLAIN.replace("\n", "\n;[m];[m];[m ü. NHN];\n", 1),
    "heights above their system in brackets": PLAIN.replace("Höhe", "Höhe [m s.l.m.]"),
    "heights above their system": PLAIN.replace("Höhe", "Höhe m u\u0308. NN"),
    "Swiss thousands": in_groups("'", "."),
    "curly thousands": in_groups("’", "."),
    "blank thousands": in_groups(" ", ","),
    "hard thousands": in_groups("\xa0", ","),
    "narrow thousands": in_groups("\u202f", ","),
    "English thousands": in_groups(",", ".").replace(";", "\t"),
    "German thousands": in_groups(".", ","),
    "list with English thousands": in_groups(",", ".").removeprefix(HEAD),
    "list with Swiss thousands": in_groups("'", ".").removeprefix(HEAD),
    "list parted by blanks with English thousands": as_list(",", "."),
    "list parted by blanks with decimal commas": as_list("", ","),
    "names in a comment, decimal commas": "# Nr Rechtswert Hochwert H Art\n"
    + as_list("", ","),
    "all quoted": "".join(
        ",".join(f'"{cell}"' for cell in line.split(";")) + "\n"
        for line in PLAIN.splitlines()
    ),
    "R and H with units": PLAIN.replace(
        "Rechtswert;Hochwert;Höhe", "R [m];H [m];Höhe [m]"
    ),
    "with their system": PLAIN.replace(
        "Rechtswert;Hochwert;Höhe", "E_GNSS;N_GNSS;H_GNSS"
    ),
    "Y and X with their system": PLAIN.replace(
        "Rechtswert;Hochwert;Höhe", "Y GK M34;X GK M34;H Adria"
    ),
    "no names": TEXT,
    "no names, separated by blanks": as_blanks(WITHOUT_BLANKS),
    "no names below a comment": "# exported by X\n" + TEXT,
    "no names, first the northing": "".join(
        ";".join([c[0], c[2], c[1], *c[3:]]) + "\n"
        for c in (line.split(";") for line in TEXT.splitlines())
    ),
}


def read(tmp_path, text, said=AUSTRIA, schema=CONTROL_POINTS):
    path = tmp_path / "P.txt"
    path.write_bytes(text.encode("utf-8") if isinstance(text, str) else text)
    return understand_table(path, schema, said)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_is_read_as_it_was_meant(tmp_path, name):
    table = read(tmp_path, TABLES[name])
    checked = check_table(table.frame, CONTROL_POINTS)
    assert not checked.problems
    frame = checked.frame
    names = frame["point_id"].str.replace("A1", "A 1").tolist()
    assert names == list(POINTS)
    np.testing.assert_array_equal(
        frame[["easting", "northing", "height"]], list(POINTS.values())
    )
    assert set(frame["role"]) == {"control"}
    # rows are the lines of the file
    lines = TABLES[name].splitlines()
    first = next(k for k, line in enumerate(lines, 1) if "7/8" in line)
    assert frame.index.tolist() == [first, first + 1, first + 2]
    said = [note for note in table.notes if "between thousands" in note]
    is_grouped = "thousands" in name and name != "German thousands"
    assert bool(said) is is_grouped


REFUSED = {
    "one group of commas": (
        HEAD + "7/8;1,234;322,001;9,500;PP\n",
        "is it 1.234 or 1234?",
    ),
    "other unit": (
        PLAIN.replace("\n", "\n;cm;m;m;\n", 1),
        r"'Rechtswert \[cm\]' is in cm, column",
    ),
    "sum at the end": (PLAIN + "Summe: 4 Punkte;;;;\n", "row 5, point Summe: 4 Punkte"),
    "a cell too many": (PLAIN.replace("411,5", "411,5;x"), "row 2: the row has 6 val"),
    "a list of three numbers that are no place": (
        "1;2,5;3,5\n2;3,5;4,5\n",
        "columns have no names: which of 'column 2' and 'column 3' is the easting",
    ),
    "two systems": (
        "Nr;E_UTM;N_UTM;E_GK;N_GK\n7/8;1.5;2.5;3.5;4.5\n",
        "'E_UTM' and 'E_GK' could both be easting",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_two_meanings_is_asked_about(tmp_path, name):
    text, said = REFUSED[name]
    with pytest.raises(EinschaltError, match=said):
        require_sound(tmp_path, text)


def require_sound(tmp_path, text):
    table = read(tmp_path, text)
    raise_problems(check_table(table.frame, CONTROL_POINTS, source="P.txt").problems)


def test_one_decimal_comma_among_grouped_points_is_a_fault(tmp_path):
    """Signs between thousands say nothing of a comma in another row."""
    rows = ["A;10'009.37;1.5", "B;12.5;1'322.5", "C;2,5;3.5"]
    table = read(tmp_path, "Nr;E;N\n" + "\n".join(rows) + "\n")
    (problem,) = check_table(table.frame, CONTROL_POINTS, source="P.txt").problems
    assert str(problem).startswith("P.txt, row 4, point C: easting '2,5' has a decimal")


SHOWN = "commas separate thousands, as {} shows: {} is read as {}"
OF_THOUSANDS = {
    "in another column": (
        "Nr;E;N\nA;1,234;2,345.5\nB;-5,111;12\n",
        [[1234.0, 2345.5], [-5111.0, 12.0]],
        SHOWN.format("northing '2,345.5'", "easting '1,234'", "1234"),
    ),
    "in its column": (
        "Nr;E;N\nA;1,234;7.5\nB;2,345.5;8.25\n",
        [[1234.0, 7.5], [2345.5, 8.25]],
        SHOWN.format("easting '2,345.5'", "easting '1,234'", "1234"),
    ),
    "two of them": (
        "Nr\tE\tN\nA\t1,234,567\t234,567\n",
        [[1234567.0, 234567.0]],
        SHOWN.format("easting '1,234,567'", "northing '234,567'", "234567"),
    ),
    "in quotes": (
        'Nr,E,N\nA,"1,234","2,345.5"\n',
        [[1234.0, 2345.5]],
        SHOWN.format("northing '2,345.5'", "easting '1,234'", "1234"),
    ),
    "with the minus of typesetters": (
        "Nr;E;N\nA;\u22121,234;\u22122,345.5\n",
        [[-1234.0, -2345.5]],
        SHOWN.format("northing '-2,345.5'", "easting '-1,234'", "-1234"),
    ),
}


@pytest.mark.parametrize("decimal", [None, "."])
@pytest.mark.parametrize("name", OF_THOUSANDS)
def test_one_comma_that_can_only_part_thousands_tells_of_all(tmp_path, name, decimal):
    text, expected, said = OF_THOUSANDS[name]
    table = read(tmp_path, text, Said(decimal=decimal))
    # what is written with a point alone is still text, which check_table takes
    found = table.frame[["easting", "northing"]].astype(float)
    assert found.to_numpy().tolist() == expected
    assert f"P.txt: {said}" in table.notes


def test_a_list_in_which_one_comma_tells_of_all(tmp_path):
    own = Said(columns={"easting": "column 2", "northing": "column 3"})
    for sign in (";", "\t", " ", "|"):
        text = "A;1,234;1,002,345.5\nB;5,111;346\n".replace(";", sign)
        frame = read(tmp_path, text, own).frame
        assert frame[["easting", "northing"]].to_numpy().tolist() == [
            [1234.0, 1002345.5],
            [5111.0, 346.0],
        ]


@pytest.mark.parametrize(
    ("row", "decimal", "said"),
    [
        ("12,5;2,345.5", None, "northing '2,345.5' has .* easting '12,5' a decimal co"),
        ("0,411;1,234,567", None, "northing '1,234,567' has .* easting '0,411' a deci"),
        ("1,234;2,345.5", ",", "'2,345.5' has commas between thousands, and the table"),
    ],
)
def test_commas_of_both_kinds_are_refused(tmp_path, row, decimal, said):
    with pytest.raises(TableError, match=rf"P\.txt, row 3: .*{said}"):
        read(tmp_path, f"Nr;E;N\nB;7;8\nA;{row}\n", Said(decimal=decimal))


def test_the_minus_of_typesetters_is_one(tmp_path):
    table = read(tmp_path, "Nr;E;N\nA;\u221213000,25;+5,5\n")
    assert table.frame[["easting", "northing"]].to_numpy().tolist() == [
        [-13000.25, 5.5]
    ]
    assert not [note for note in table.notes if "thousands" in note]


@pytest.mark.parametrize(
    "text",
    [
        "D 1.JPG,P1,562.3,2047.5,1\nD 1.JPG,7/8,-1,2,1\n",  # as Pix4D writes marks
        "P1\tD 1.JPG\t562,3\t2047,5\n7/8\tD 1.JPG\t-1,0\t2,0\n",
    ],
)
def test_a_list_of_marks_without_names_is_told_by_its_images(tmp_path, text):
    (tmp_path / "m.txt").write_text(text)
    table = understand_table(tmp_path / "m.txt", IMAGE_POINTS)
    columns = ["image_id", "point_id", "x", "y"]
    assert table.frame[columns].astype(
        {"x": float, "y": float}
    ).to_numpy().tolist() == [
        ["D 1.JPG", "P1", 562.3, 2047.5],
        ["D 1.JPG", "7/8", -1.0, 2.0],
    ]
    assert "= image_id" in table.notes[0]


@pytest.mark.parametrize(
    "row",
    [
        "D 1.JPG,0.1,240891.44,543450.42,139.03",  # precision and place
        "D 1.JPG,48.207132,16.371044,463.2",  # as Pix4D takes places of images
    ],
)
def test_places_of_images_are_not_taken_for_marks(tmp_path, row):
    """Their precisions or latitudes were names of points, their places pixels."""
    text = f"{row}\n{row.replace('1.JPG', '2.JPG')}\n"
    (tmp_path / "m.txt").write_text(text)
    with pytest.raises(TableError, match="the name of a point or a number") as caught:
        understand_table(tmp_path / "m.txt", IMAGE_POINTS)
    assert "row 1" in str(caught.value)
    # one name that is none is a name as well
    more = ",".join(["D 3.JPG,P1,562.3,2047.5", "1"][: row.count(",") - 2])
    (tmp_path / "m.txt").write_text(f"{text}{more}\n")
    assert len(understand_table(tmp_path / "m.txt", IMAGE_POINTS).frame) == 3


@pytest.mark.parametrize("row", ["a.jpg,b.jpg,1.5,2.5", "a,b,1.5,2.5"])
def test_a_list_in_which_nothing_tells_the_image_is_refused(tmp_path, row):
    (tmp_path / "m.txt").write_text(f"{row}\n{row.replace('a', 'c')}\n")
    read = understand_table(tmp_path / "m.txt", IMAGE_POINTS)
    problems = check_table(read.frame, IMAGE_POINTS, source="m.txt").problems
    assert any("image_id" in problem.found for problem in problems)


def test_a_list_without_names_can_be_answered(tmp_path):
    for said in (Said(), AUSTRIA):
        own = {"easting": "column 2", "northing": "column 3"}
        given = Said(columns=own, crs=said.crs)
        frame = read(tmp_path, "7/8;1,25;2,5;3,75\n", given).frame
        assert frame.to_dict("records") == [
            {"point_id": "7/8", "easting": 1.25, "northing": 2.5, "height": 3.75}
        ]
    with pytest.raises(TableError, match="the columns have no names"):
        read(tmp_path, TEXT, Said())


def test_a_list_of_model_points_needs_names(tmp_path):
    """Two names and two numbers could be anything."""
    with pytest.raises(
        FileError, match=r"the header is .* Write a line with the names"
    ):
        read(tmp_path, "11/12 7/8 1.5 2.5\n", schema=MODEL_POINTS)


# a name, a place and its standard errors, as programs of satellite images list them
SEVEN = "101{0}13000.513{0}322000.450{0}512.086{0}0.01{0}0.01{0}0.02\n"


@pytest.mark.parametrize("sign", [" ", ",", "\t", "   "])
def test_a_list_of_seven_columns_needs_names(tmp_path, sign):
    """Three numbers behind a place may be variances, weights or angles as well."""
    text = SEVEN.format(sign)
    said = "of 7 nothing tells what the last ones are: 0.01, 0.01, 0.02"
    with pytest.raises(TableError, match=said):
        read(tmp_path, text)
    errors = [f"standard_error_{name}" for name in ("easting", "northing", "height")]
    names = ["point_id", "easting", "northing", "height", *errors]
    frame = read(tmp_path, sign.join(names) + "\n" + text).frame
    assert frame[errors].to_numpy().tolist() == [[0.01, 0.01, 0.02]]


def test_a_list_of_seven_columns_can_be_answered(tmp_path):
    own = {"easting": "column 2", "northing": "column 3"}
    own |= {"standard_error_height": "column 7"}
    frame = read(tmp_path, SEVEN.format(" "), Said(columns=own)).frame
    assert frame["point_id"].tolist() == ["101"]
    assert frame["standard_error_height"].tolist() == [0.02]


def test_plain_names_go_before_those_with_a_system(tmp_path):
    frame = read(tmp_path, "Nr;E;N;E_UTM;N_UTM\n7/8;1.5;2.5;3.5;4.5\n").frame
    assert frame[["easting", "northing"]].to_numpy().tolist() == [[1.5, 2.5]]


@pytest.mark.parametrize("below", [[], ["", "[m]", "[m]", "[m]", ""]])
@pytest.mark.parametrize("suffix", [".xlsx", ".ods"])
def test_names_of_a_sheet_may_stand_in_two_rows_above_units(tmp_path, suffix, below):
    upper = ["Punktnummer", "Koordinaten", "Lage", "Höhe", "Art"]
    lower = ["", "Rechtswert", "Hochwert", "", ""]
    rows = [line.split(";") for line in TEXT.splitlines()]
    cells = [lower, *([below] if below else []), *rows]
    path = tmp_path / f"P{suffix}"
    columns = [list(column) for column in zip(*cells, strict=True)]
    sheet = pa.table(columns, names=upper)
    pyogrio.write_arrow(sheet, path, driver=suffix[1:].upper(), geometry_name=None)
    table = understand_table(path, CONTROL_POINTS, AUSTRIA)
    frame = check_table(table.frame, CONTROL_POINTS).frame
    np.testing.assert_array_equal(
        frame[["easting", "northing", "height"]], list(POINTS.values())
    )
    first = 4 if below else 3
    assert frame.index.tolist() == [first, first + 1, first + 2]


@pytest.mark.parametrize("sign", ["[", "_", " ", ".", "-"])
def test_a_long_cell_in_place_of_a_name_takes_no_time(tmp_path, sign):
    started = time.process_time()
    with pytest.raises(EinschaltError):
        require_sound(tmp_path, f"Nr,E,{sign * 20_000}x\n1,2,3\n")
    assert time.process_time() - started < 5.0


@pytest.mark.parametrize(
    "text",
    [
        "10009.37 326802.003 512.3\n10100.1 326900.2 511\n",
        "10009,37;326802,003;512,3\n10100,1;326900,2;511\n",
    ],
)
def test_a_list_without_names_whose_first_number_may_be_a_coordinate(tmp_path, text):
    """The height would be the easting."""
    with pytest.raises(TableError, match="is that a name or a coordinate") as caught:
        read(tmp_path, text)
    assert caught.value.row == 1
    own = replace(AUSTRIA, columns={"point_id": "column 1"})
    assert len(read(tmp_path, "1.10 10009.37 326802.003\n", own).frame) == 1
    # one name with decimals among others is a name
    mixed = "7.1 10009.37 326802.003\nA1 10100.1 326900.2\n"
    assert read(tmp_path, mixed).frame["point_id"].tolist() == ["7.1", "A1"]


def test_heights_of_a_list_without_names(tmp_path):
    first_lacks_it = "1;10009,37;326802,003;\n2;10100,5;326900,1;511,2\n"
    heights = read(tmp_path, first_lacks_it).frame["height"]
    assert heights.isna().tolist() == [True, False]
    second_pair = "1;10009,37;326802,003;10009,4;326802\n"
    with pytest.raises(TableError, match="'column 4' cannot be the height"):
        read(tmp_path, second_pair)


@pytest.mark.parametrize("rows", ["B;10.100;326.900\n", "B;10.100;1\nC;10.200;2\n"])
def test_points_beside_grouped_numbers_are_asked_about(tmp_path, rows):
    """Whoever wrote 10009.37 for 10.009,37 had 10.100 read as ten metres."""
    with pytest.raises(TableError, match=r"'10\.100': is it 10\.100 or 10100\?"):
        read(tmp_path, f"Nr;E;N\nA;10.009,37;326.802,00\n{rows}")
    # another number that only a decimal point can part: the comma is the fault
    with pytest.raises(EinschaltError, match=r"'10\.009,37' has separators"):
        require_sound(tmp_path, "Nr;E;N\nA;10.009,37;1\nB;10.5;2\nC;10.25;3\n")


def test_a_row_of_too_few_values_between_blanks_is_told_so(tmp_path):
    """Which of them is missing nobody can tell."""
    text = "Nr E N H\nA 1.5 2.5 3.5\nB 1.5 2.5\n"
    said = r"3 values, the header 4; expected 4 values separated by blanks\. Part the"
    with pytest.raises(TableError, match=rf"row 3: the row has {said} values by semi"):
        require_sound(tmp_path, text)


def test_units_behind_the_names_of_a_list_that_blanks_part(tmp_path):
    text = "Punktnr  y [m]  x [m]  H (m)\nA  1.5  2.5  3.5\nB  4.5  5.5  6.5\n"
    (tmp_path / "t.txt").write_text(text)
    table = understand_table(tmp_path / "t.txt", CONTROL_POINTS)
    places = table.frame[["easting", "northing", "height"]].to_numpy(float)
    assert places.tolist() == [[1.5, 2.5, 3.5], [4.5, 5.5, 6.5]]
    feet = text.replace("y [m]", "y [ft]")
    (tmp_path / "t.txt").write_text(feet)
    frame = understand_table(tmp_path / "t.txt", CONTROL_POINTS).frame
    assert "easting" not in frame  # feet are not taken for metres


def test_british_words(tmp_path):
    text = "Point Ref,Eastings,Northings\nA,1.5,2.5\n"
    (tmp_path / "t.csv").write_text(text)
    frame = understand_table(tmp_path / "t.csv", CONTROL_POINTS).frame
    assert list(frame) == ["point_id", "easting", "northing"]


@pytest.mark.parametrize(
    "head", ["P,N,E,Z,D", "pt_number,N,E,Z,D", "GCP Label,N,E,Z,D"]
)
def test_lists_as_field_computers_export_them(tmp_path, head):
    (tmp_path / "p.csv").write_text(f"{head}\n12,322000.5,13000.25,512.1,IRON ROD\n")
    table = understand_table(tmp_path / "p.csv", CONTROL_POINTS)
    names = ["point_id", "northing", "easting", "height"]
    values = table.frame.iloc[0][names].astype(str).tolist()
    assert values == ["12", "322000.5", "13000.25", "512.1"]
