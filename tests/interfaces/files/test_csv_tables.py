"""CSV tables: what goes out comes back, and odd files are read or refused in words."""

import csv
import io
import os
import re
import time
import tracemalloc

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from einschalt.foundations.errors import EinschaltError, FileError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import written_in
from einschalt.foundations.tables import (
    CONTROL_POINTS,
    IMAGE_POINTS,
    MODEL_POINTS,
    check_table,
)
from einschalt.interfaces.files import csv_parts
from einschalt.interfaces.files.csv_tables import (
    _without_marks,
    read_csv,
    understand_csv,
    write_csv,
)
from einschalt.interfaces.files.understood_tables import Said

HEADER = "coverage,model_id,point_id,x,y\n"
# make fuzz reads a million files; EINSCHALT_HUNT looks for new examples
N_EXAMPLES = 300 if os.environ.get("EINSCHALT_HUNT") else 100


def written(tmp_path, text):
    path = tmp_path / "low.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return path


def read(tmp_path, text):
    return read_csv(written(tmp_path, text), MODEL_POINTS)


def test_names_stay_text_and_numbers_become_float(tmp_path):
    frame = read(tmp_path, HEADER + "1,7/8,0012,1,-2.5e1\n")
    assert frame.iloc[0].to_dict() == {
        "coverage": "1",
        "model_id": "7/8",
        "point_id": "0012",
        "x": 1.0,
        "y": -25.0,
    }
    assert frame.index.tolist() == [2]
    assert frame["x"].dtype == float


@pytest.mark.parametrize(
    "name", ["NA", "null", "nan", "1e5", "True", "-", "=A1", "Ö 7"]
)
def test_names_that_others_take_for_something_else(tmp_path, name):
    frame = read(tmp_path, HEADER + f"1,1/2,{name},1,2\n")
    assert frame["point_id"].tolist() == [name]


def test_left_out_heights_are_missing_and_not_refused(tmp_path):
    path = written(tmp_path, "point_id,easting,northing,height\nA,1,2,3\nB,1,2,\n")
    checked = check_table(read_csv(path, CONTROL_POINTS), CONTROL_POINTS)
    assert checked.problems == ()
    np.testing.assert_array_equal(checked.frame["height"], [3.0, np.nan])


@pytest.mark.parametrize(
    ("row", "remedy"),
    [
        ("1/2 P 1 1.5 2.5", "Write names without blanks, or part the columns by tabs"),
        ("1/2 P1 1.5", "Part the values by semicolons"),
    ],
)
def test_rows_of_a_list_that_blanks_part_are_told_so(tmp_path, row, remedy):
    with pytest.raises(EinschaltError) as refused:
        read(tmp_path, f"model_id point_id x y\n1/2 A 1.5 2.5\n{row}\n")
    assert "expected 4 values separated by blanks" in str(refused.value)
    assert remedy in str(refused.value)


def test_header_may_have_blanks(tmp_path):
    frame = read(tmp_path, HEADER.replace(",", " , ") + "1,1/2,A,1,2\n")
    assert list(frame.columns) == ["coverage", "model_id", "point_id", "x", "y"]


def test_header_alone_gives_no_rows(tmp_path):
    frame = read(tmp_path, HEADER)
    assert frame.empty
    assert list(frame.columns) == ["coverage", "model_id", "point_id", "x", "y"]


def test_only_wrong_numbers_make_a_table_of_text(tmp_path):
    frame = read(tmp_path, HEADER + "1,1/2,A,1,2\n1,1/2,B,n/a,4\n")
    assert frame["x"].tolist() == ["1", "n/a"]
    assert frame["y"].tolist() == ["2", "4"]
    assert frame.index.tolist() == [2, 3]


@pytest.mark.parametrize(
    ("header", "said"),
    [
        (",".join(["c"] * 1_000_000), "has more than 1000 columns"),
        ("a" * 2_000_000, "has a name that is longer than any line"),
    ],
)
def test_headers_that_no_table_has(tmp_path, header, said):
    path = tmp_path / "t.csv"
    path.write_text(f"{header}\n1\n", "utf-8")
    with pytest.raises(FileError, match=said):
        read_csv(path, CONTROL_POINTS)


def test_line_breaks_in_quotes_are_counted(tmp_path):
    text = HEADER + '1,1/2,"A\nB",1,2\n1,1/2,C,3,4\n'
    frame = read(tmp_path, text)
    assert frame.index.tolist() == [2, 4]
    assert frame["point_id"].tolist() == ["A\nB", "C"]


def test_rows_of_several_kinds_of_fault_come_in_the_order_of_the_file(tmp_path):
    text = HEADER + '1,1/2,A,x,2\n1,1/2,B,1\n1,1/2,C,1,2,3\n1,1/2,D,1,y\n1,1/2,"E,1,2\n'
    with pytest.raises(EinschaltError) as caught:
        read(tmp_path, text)
    assert [(p.row, p.found) for p in caught.value.problems] == [
        (2, "x 'x' is not a number"),
        (3, "the row has 4 values, the header 5"),
        (4, "the row has 6 values, the header 5"),
        (5, "y 'y' is not a number"),
        (6, "a quote opens here and is not closed on its line"),
    ]


def test_semicolons_in_values_are_to_be_quoted(tmp_path):
    text = HEADER.replace(",", ";") + "1;1/2;A;B;1;2\n"
    with pytest.raises(EinschaltError, match="Put a value that holds semicolons"):
        read(tmp_path, text)


def test_missing_file_names_its_neighbours(tmp_path):
    written(tmp_path, HEADER)
    with pytest.raises(FileError, match=r"^lo\.csv: the file.*Did you mean 'low\.csv'"):
        read_csv(tmp_path / "lo.csv", MODEL_POINTS)


TEXTS = st.text(
    st.sampled_from([*"ab0 ,;'\"\n\r\t=+-@._", "ö", "\u2028", "\ufeff"]), max_size=6
)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False) | st.none()
ROWS = st.lists(st.tuples(TEXTS, TEXTS, NUMBERS), min_size=1, max_size=8)


SIGNS = tuple("=+-@")


INNER = re.compile("(; *)('*[\t\r]*[=+\\-@])")


def harmless(text):
    """What a spreadsheet would compute has an apostrophe before it."""
    text = INNER.sub(r"\1'\2", text)
    if text.startswith("'"):  # would be taken for one of ours
        is_marked = text.lstrip("'").startswith((*SIGNS, "\t", "\r"))
    else:
        is_marked = may_be_computed(text)
    return f"'{text}" if is_marked else text


def may_be_computed(text):
    """Whether it begins as a formula, and is neither a number nor a word of digits."""
    if not text.lstrip("\t\r").startswith(SIGNS) or not set(text) - set(SIGNS):
        return False
    rest = text[1:]
    is_word = text[0] in "+-" and rest[:1].isdigit() and rest.isascii()
    return not (is_plain_number(text) or (is_word and rest.replace("_", "a").isalnum()))


def is_plain_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return text == text.strip()


def frame_of(rows):
    return pd.DataFrame({"point_id": [row[0] for row in rows]})


@pytest.mark.parametrize(
    ("name", "cell"),
    [
        # computed: references, names, functions, sums, other programs
        ("=1+1", "'=1+1"),
        ("=cmd|'/c calc'!A0", "'=cmd|'/c calc'!A0"),
        ("+1+cmd|' /C calc'!A0", "'+1+cmd|' /C calc'!A0"),
        ("-2+3+cmd|' /C calc'!A0", "'-2+3+cmd|' /C calc'!A0"),
        ("@SUM(1)", "'@SUM(1)"),
        ("+A1", "'+A1"),
        ("-Nord", "'-Nord"),
        ("-7/8", "'-7/8"),
        ("+5A!B1", "'+5A!B1"),
        ("-(1)", "'-(1)"),
        ("\t=A1", "'\t=A1"),
        ("＝x", "'＝x"),
        # cells of their own where semicolons part them
        ("x;=1+1", "x;'=1+1"),
        ("x; @A1;-B2", "x; '@A1;'-B2"),
        ("x;'=1", "x;''=1"),
        ("=1;=2", "'=1;'=2"),
        # would be taken for ours
        ("'=x", "''=x"),
        ("'+5A", "''+5A"),
        # kept as they are
        ("-12", "-12"),
        ("+4.5e3", "+4.5e3"),
        ("-5A", "-5A"),
        ("+12b7", "+12b7"),
        ("-", "-"),
        ("--", "--"),
        ("A=1", "A=1"),
        ("7;8", "7;8"),
        ("A+1", "A+1"),
        ("'s Gravenhage", "'s Gravenhage"),
    ],
)
def test_a_formula_is_harmless_in_a_spreadsheet_and_comes_back(tmp_path, name, cell):
    table = pd.DataFrame({"model_id": ["1/2"], "point_id": [name], "x": 1.0, "y": 2.0})
    path = tmp_path / "points.csv"
    write_csv(table, path)
    with path.open(newline="", encoding="utf-8") as file:
        assert list(csv.reader(file))[1][1] == cell
    assert read_csv(path, MODEL_POINTS)["point_id"].tolist() == [name]


@pytest.mark.slow
@settings(max_examples=N_EXAMPLES, deadline=None)
@given(rows=ROWS)
def test_what_is_written_is_read_by_python_and_by_us(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("csv") / "t.csv"
    frame = pd.DataFrame(rows, columns=["point_id", "remark", "x"])
    frame["x"] = frame["x"].astype(float)
    write_csv(frame, path)
    with path.open(newline="", encoding="utf-8") as file:
        header, *back = csv.reader(file)
    assert header == ["point_id", "remark", "x"]
    assert [row[:2] for row in back] == [[harmless(v) for v in row[:2]] for row in rows]
    for value in (value for row in back for value in row[:2]):
        assert not may_be_computed(value)
    ours = _without_marks(frame_of(back), MODEL_POINTS)["point_id"].tolist()
    assert ours == [row[0] for row in rows]
    numbers = [float(row[2]) if row[2] else None for row in back]
    assert numbers == [row[2] for row in rows]


def test_marks_of_earlier_versions_are_taken_away(tmp_path):
    """They had an apostrophe before every name with a sign that is no number."""
    frame = read(tmp_path, HEADER + "1,1/2,'+5A,1,2\n1,1/2,'-,3,4\n")
    assert frame["point_id"].tolist() == ["+5A", "-"]


SIGNED_NAMES = st.text(
    st.sampled_from([*"=+-@'A15e./|!(;", "＝", "ö", " "]), min_size=1, max_size=7
)


@pytest.mark.slow
@settings(max_examples=N_EXAMPLES, deadline=None)
@given(names=st.lists(SIGNED_NAMES, min_size=1, max_size=6))
def test_every_name_comes_back_through_a_file(tmp_path_factory, names):
    path = tmp_path_factory.mktemp("csv") / "t.csv"
    table = pd.DataFrame({"model_id": "1/2", "point_id": names, "x": 1.0, "y": 2.0})
    write_csv(table, path)
    assert read_csv(path, MODEL_POINTS)["point_id"].tolist() == names


@settings(max_examples=N_EXAMPLES, deadline=None)
@given(name=st.text(st.sampled_from([*"=+-@'A1./(;#, \t\r\n", '"', "＝", "ö"])))
def test_a_plain_text_is_written_as_among_texts_that_need_signs(tmp_path_factory, name):
    """Columns of plain texts are not looked at twice: the others say what is right."""
    folder = tmp_path_factory.mktemp("csv")
    write_csv(pd.DataFrame({"remark": [name]}), folder / "alone.csv")
    write_csv(pd.DataFrame({"remark": [name, "=;=\",#'"]}), folder / "both.csv")
    alone, both = ((folder / f"{one}.csv").read_bytes() for one in ("alone", "both"))
    assert both.startswith(alone)


NAME = st.text(st.sampled_from([*"ab07/ ", "ö", '"']), min_size=1, max_size=4)
TABLES = st.lists(
    st.tuples(
        NAME.map(lambda name: f'"{name.replace(chr(34), chr(34) * 2)}"') | NAME,
        st.sampled_from(["1", "-2.5", "+3", "1e3", " 4", "", "nan", "x", "1,5"]),
        st.sampled_from(["", "", "", "\n", ",9", '"']),
    ),
    max_size=6,
)


@pytest.mark.slow
@settings(max_examples=N_EXAMPLES, deadline=None)
@given(rows=TABLES)
def test_fast_reading_says_what_reading_row_by_row_says(tmp_path_factory, rows):
    """A blank first line keeps pyarrow away; names are then compared as checked."""
    text = "model_id,point_id,x,y\n"
    text += "".join(f"1/2,{name},{number},1{end}\n" for name, number, end in rows)
    path = tmp_path_factory.mktemp("csv") / "t.csv"
    outcomes = []
    for before in ("", "\n"):
        path.write_text(before + text, encoding="utf-8")
        outcomes.append(outcome(path, n_lines_before=len(before)))
    assert outcomes[0] == outcomes[1]


def outcome(path, n_lines_before):
    try:
        frame = read_csv(path, MODEL_POINTS)
    except EinschaltError as error:
        problems = getattr(error, "problems", [error])
    else:
        checked = check_table(frame, MODEL_POINTS)
        if not checked.problems:
            rows = checked.frame.index - n_lines_before
            return rows.tolist(), checked.frame.to_dict("list")
        problems = checked.problems
    return [(p.row and p.row - n_lines_before, p.point) for p in problems]


def test_fixed_decimals_are_those_of_format(tmp_path):
    random = np.random.default_rng(0)
    values = np.concatenate(
        [random.uniform(-6e6, 6e6, 2000), random.normal(size=2000), [0.0, -0.00001]]
    )
    frame = pd.DataFrame({"easting": values})
    write_csv(frame, tmp_path / "t.csv", decimals={"easting": 4})
    lines = (tmp_path / "t.csv").read_text().splitlines()[1:]
    expected = [f"{value:.4f}".replace("-0.0000", "0.0000") for value in values]
    assert lines == expected


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e300])
def test_numbers_that_have_no_decimals_are_written_whole(tmp_path, value):
    frame = pd.DataFrame({"easting": [1.5, value, np.nan]})
    write_csv(frame, tmp_path / "t.csv", decimals={"easting": 4})
    lines = (tmp_path / "t.csv").read_text().splitlines()[1:]
    assert [float(line) for line in lines[:2]] == [1.5, value]
    assert lines[2] == ""


def test_every_kind_of_column_is_written(tmp_path):
    frame = pd.DataFrame(
        {
            "text": ["a,b", None, 'c"d'],
            "mixed": [1, "x", 2.5],
            "is_usable": [True, False, True],
            "count": [1, 2, 3],
            "kind": pd.Categorical(["new", "control", "new"]),
            "empty": [None, None, None],
        }
    )
    write_csv(frame, tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_bytes() == (
        b"text,mixed,is_usable,count,kind,empty\n"
        b'"a,b",1,true,1,new,\n'
        b",x,false,2,control,\n"
        b'"c""d",2.5,true,3,new,\n'
    )


def test_table_without_rows_is_a_header(tmp_path):
    write_csv(pd.DataFrame(columns=["flight", "a,b"]), tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_bytes() == b'flight,"a,b"\n'


@pytest.fixture(scope="module")
def million_rows():
    """Two coverages of a flight with a million measured points, as text."""
    n = 1_000_000
    random = np.random.default_rng(8)
    frame = pd.DataFrame(
        {
            "coverage": np.repeat(["1", "2"], n // 2),
            "model_id": [f"{k // 7}/{k // 7 + 1}" for k in range(n)],
            "point_id": [f"P{k % 200_000:06d}" for k in range(n)],
            "x": random.uniform(-115, 115, n).round(3),
            "y": random.uniform(-115, 115, n).round(3),
        }
    )
    buffer = io.StringIO()
    frame.to_csv(buffer, index=False)
    return buffer.getvalue()


def seconds_of(function, *arguments):
    started = time.process_time()
    value = function(*arguments)
    return time.process_time() - started, value


@pytest.mark.slow
def test_a_million_rows_are_read_and_checked_in_seconds(tmp_path, million_rows):
    path = written(tmp_path, million_rows)
    reading, frame = seconds_of(read_csv, path, MODEL_POINTS)
    checking, checked = seconds_of(check_table, frame, MODEL_POINTS)
    assert checked.problems == ()
    assert len(checked.frame) == 1_000_000
    # usually 0.4 s each; row by row it takes more than 6 s
    assert reading < 4.0
    assert checking < 4.0
    writing, _ = seconds_of(write_csv, checked.frame, tmp_path / "out.csv")
    assert writing < 4.0
    assert (tmp_path / "out.csv").stat().st_size > 30e6


@pytest.mark.parametrize("n_cores", [1, 2, 3, 7])
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_parts_of_a_table_read_at_once_are_the_whole(
    tmp_path, monkeypatch, n_cores, ends
):
    monkeypatch.setattr(csv_parts, "BYTES_WORTH_A_THREAD", 8)
    monkeypatch.setattr(csv_parts, "n_cores", lambda: n_cores)
    for n_rows in (*range(1, 12), 100):
        rows = [f"1,m{k % 3},P{k}{'x' * (k % 5)},{k},{k / 4}" for k in range(n_rows)]
        text = HEADER + "".join(f"{row}\n" for row in rows)
        frame = read(tmp_path, text.replace("\n", ends))
        assert frame["point_id"].tolist() == [row.split(",")[2] for row in rows]
        assert frame["y"].tolist() == [k / 4 for k in range(n_rows)]
        assert frame.index.tolist() == list(range(2, n_rows + 2))
    with pytest.raises(EinschaltError, match="row 52: the row has 4 values"):
        read(tmp_path, text.replace("P50,", ""))
    frame = read(tmp_path, text.replace("P51x,", "P51x,x"))
    problems = check_table(frame, MODEL_POINTS).problems
    assert [(problem.row, problem.point) for problem in problems] == [(53, "P51x")]
    frame = read(tmp_path, text.replace("P50,", '"P,\n50",'))
    assert frame["point_id"].tolist()[50] == "P,\n50"
    assert len(frame) == 100


def test_bytes_are_counted_without_memory_for_all_of_them():
    """A comparison of all at once would be as large as the file."""
    data = (b"1;2\n" * 2**18) * 16
    tracemalloc.start()
    try:
        n_lines = csv_parts.count_byte(data, b"\n")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert n_lines == 2**22
    assert peak < len(data) / 8
    # a block ends within, at and after the last byte
    for n_more in (-1, 0, 1):
        part = data[: 2 * csv_parts.BLOCK_BYTES + n_more]
        assert csv_parts.count_byte(part, b"\n") == part.count(b"\n")
    assert csv_parts.count_byte(b"", b"\n") == 0


DBAT_FIXED = """\
# Id, Name, X, Y, Z, sigmaX, sigmaY, sigmaZ
317, B2.16,   999604.580, 112344.443, 139.453
375, B3.05,   999619.041, 112370.818, 138.97
"""
DBAT_WEIGHTED = """\
# Control points of the block,
# weighted version.
# Id, Name, X, Y, Z, sigmaX, sigmaY, sigmaZ
317, B2.16, 999604.580, 112344.443, 139.453, 0.02, 0.02, 0.04
375, B3.05, 999619.041, 112370.818, 138.97, 0.02, 0.02, 0.04
"""
DBAT_CLOSE = """\
# Id, name, X, Y, Z, sigmaX, sigmaY, sigmaZ
317,  , 999604.580, 112344.443, 139.453
375,  , 999619.041, 112370.818, 138.97
"""


@pytest.mark.parametrize("text", [DBAT_FIXED, DBAT_WEIGHTED, DBAT_CLOSE])
def test_control_of_dbat_is_read_by_the_names_in_its_comment(tmp_path, text):
    (tmp_path / "c.txt").write_text(text)
    said = Said(crs="EPSG:27561")
    frame = understand_csv(tmp_path / "c.txt", CONTROL_POINTS, said).frame
    columns = ["point_id", "easting", "northing", "height"]
    assert frame[columns].to_numpy().tolist() == [
        ["317", 999604.58, 112344.443, 139.453],
        ["375", 999619.041, 112370.818, 138.97],
    ]


@pytest.mark.parametrize(
    "names",
    [
        "Format: image id, point id, x, y, sxy",
        "Format: Image id, OP id, x, y, sxy",
        "Format: image id, point id, x, y, sxy, more, than, there, are",
    ],
)
def test_marks_of_dbat_are_read_by_the_names_in_their_comment(tmp_path, names):
    text = f"# Mark points of the demo\n# {names}\n"
    rows = " 1,    2, 1429.1871, 1456.4278, 0.1\n 1,    3, 1217.8557, 1456.1798, 0.1\n"
    (tmp_path / "m.txt").write_text(text + rows)
    read = understand_csv(tmp_path / "m.txt", IMAGE_POINTS).frame
    frame = check_table(read, IMAGE_POINTS).frame  # takes blanks off names
    assert frame[["image_id", "point_id", "x", "y"]].to_numpy().tolist() == [
        ["1", "2", 1429.1871, 1456.4278],
        ["1", "3", 1217.8557, 1456.1798],
    ]


@pytest.mark.parametrize("comment", ["Id,X,Y,Z", "Id,Name,Note,Date,Time,X,Y"])
def test_comments_that_name_other_columns_are_no_header(tmp_path, comment):
    """Four names of six columns, or what is needed behind the last column."""
    (tmp_path / "c.txt").write_text(f"# {comment}\n1001,CP1,0,1,0,1e-3\n")
    said = Said(crs="EPSG:27561")
    frame = understand_csv(tmp_path / "c.txt", CONTROL_POINTS, said).frame
    assert "easting" not in frame


def test_the_title_of_another_table_is_told(tmp_path):
    text = (
        "model_id,point_id,x,y\n1,A,2,3\nTiefflug,,\nmodel_id,point_id,x,y\n1,A,2,3\n"
    )
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(EinschaltError, match="row 3: the row has 3 values") as told:
        understand_csv(tmp_path / "t.csv", MODEL_POINTS)
    remedy = (
        "Part the values as the header does, and leave none out; delete the row if it "
        "is a remark; if it is the title of another table, put what follows into a "
        "file of its own"
    )
    assert told.value.problems[0].remedy == remedy
    with written_in("de"):
        said = retold(remedy)
    assert said.startswith("Die Werte wie in der Kopfzeile trennen, und keinen wegl")
    assert said.endswith("Tabelle ist, was folgt, in eine eigene Datei stellen")
