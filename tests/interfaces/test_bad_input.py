"""Every fault that input can have: what is said of it, and where."""

import re
import time
from pathlib import Path

import numpy as np
import pytest

from einschalt.foundations.errors import BlockError, EinschaltError
from einschalt.interfaces.files.block_folder import find_problems, read_block

LOW, CONTROL = "low_flight.csv", "control_points.csv"
GOLDEN = Path(__file__).parents[1] / "golden" / "bad_input.txt"


def replaced(name, old, new):
    return lambda block: block.replace(name, old, new)


def rewritten(name, change):
    """Spoil a whole file; ``change`` takes its text."""
    return lambda block: block.write(name, change(block.read(name)))


def in_parquet(data_of):
    def spoil(block):
        block.replace("block.toml", LOW, "low_flight.parquet")
        block.write("low_flight.parquet", data_of(block.read(LOW)))

    return spoil


def deleted(name):
    return lambda block: (block.path / name).unlink()


def in_metres(text):
    header, *rows = text.splitlines()
    parts = [row.split(",") for row in rows]
    rows = [",".join([*p[:3], *(str(float(v) / 1e3) for v in p[3:])]) for p in parts]
    return "\n".join([header, *rows]) + "\n"


# what is said of each stands in golden/bad_input.txt, under the same name
FAULTS = {
    "missing file": deleted(LOW),
    "misspelt file": replaced("block.toml", LOW, "low_fligth.csv"),
    "folder in place of a file": replaced("block.toml", f'"{LOW}"', '"."'),
    "unknown suffix": replaced("block.toml", LOW, "block.toml"),
    "missing column": replaced(CONTROL, "northing", "Northng"),
    "column twice": replaced(LOW, "coverage,model_id", "model_id,model_id"),
    "text in a number column": replaced(LOW, "82.5000", "n/a"),
    "empty cell": replaced(CONTROL, "322500.00", ""),
    "missing name": replaced(LOW, "1,11/12,0013", "1,11/12,"),
    "NaN": replaced(CONTROL, "322500.00", "NaN"),
    "infinite": replaced(CONTROL, "322500.00", "-inf"),
    "beyond all numbers": replaced(CONTROL, "322500.00", "1e999"),
    "decimal comma in quotes": replaced(LOW, "82.5000", '"82,5"'),
    "decimal comma between commas": replaced(LOW, "82.5000", "82,5000"),
    "comma of two meanings": replaced(LOW, "82.5000", '"82,500"'),
    "thousands parted by points": replaced(CONTROL, "322500.00", '"322.500,00"'),
    "duplicate point of a model": replaced(LOW, "1,11/12,0013", "1,11/12,0012"),
    "axes of one point exchanged": replaced(
        CONTROL, "13000.00,322500.00", "322500.00,13000.00"
    ),
    "millimetres said to be metres": replaced(
        "block.toml", f'"{LOW}"', f'"{LOW}"\nmodel_unit = "m"'
    ),
    "metres in place of millimetres": rewritten(LOW, in_metres),
    "metres in place of micrometres": replaced(
        "block.toml", "m_g_um = 5.0", "m_g_um = 0.000005"
    ),
    "scale in place of its number": replaced("block.toml", "8000", "0.000125"),
    "millimetres in place of metres": replaced("block.toml", "0.03", "30"),
    "millimetres in a column of metres": rewritten(
        CONTROL,
        lambda text: (
            text.replace(".00\n", ".00,20\n", 3)
            .replace(".00,20\n", ".00,0.02\n", 2)
            .replace("northing", "northing,standard_error_m")
            .replace(".00\n", ".00,1\n")
        ),
    ),
    "unknown system": replaced("block.toml", "EPSG:31255", "EPSG:99999"),
    "system in degrees": replaced("block.toml", "EPSG:31255", "EPSG:4312"),
    "empty table": rewritten(CONTROL, lambda text: text.splitlines()[0] + "\n"),
    "empty file": rewritten(CONTROL, lambda _: " \n\n"),
    "point in no model": replaced(CONTROL, "7/10", "7/01"),
    "no model with common points": rewritten(
        LOW, lambda text: text.splitlines()[0] + "\n1,11/12,A,1,2\n1,11/12,B,9,2\n"
    ),
    "unknown role": rewritten(
        CONTROL,
        lambda text: (
            text.replace("\n", ",control\n")
            .replace("g,control", "g,role")
            .replace("322500.00,control", "322500.00,Chek", 1)
        ),
    ),
    "misspelt key": replaced("block.toml", "m_g_um = 5.0", "m_g_mu = 5.0"),
    "misspelt section": replaced("block.toml", "[low_flight]", "[lowflight]"),
    "missing section": rewritten(
        "block.toml", lambda text: text.split("[low_flight]", maxsplit=1)[0]
    ),
    "number in quotes": replaced("block.toml", "m_g_um = 5.0", 'm_g_um = "5.0"'),
    "decimal comma in block.toml": replaced(
        "block.toml", "m_g_um = 5.0", "m_g_um = 5,0"
    ),
    "Windows path": replaced("block.toml", f'"{LOW}"', r'"data\low_flight.csv"'),
    "two encodings": rewritten(
        LOW,
        lambda text: text.replace("PP1", "Mürz", 1).encode() + "Mürz".encode("latin-1"),
    ),
    "umlauts of MS-DOS": rewritten(
        LOW, lambda text: text.replace("PP1", "Mörz").encode("cp850")
    ),
    "truncated UTF-16": rewritten(LOW, lambda text: text.encode("utf-16")[:-1]),
    "short row": replaced(LOW, "0013,72.5000,20.0000", "0013,72.5000"),
    "unclosed quote": replaced(LOW, "1,11/12,0013", '1,11/12,"0013'),
    "unclosed quote and a quote far below": rewritten(
        LOW,
        lambda text: text.replace("1,11/12,0013", '1,11/12,"0013', 1).replace(
            "2,12/13,21", '2,12/13,"21"'
        ),
    ),
    "text after a quote": replaced(LOW, "1,11/12,0013", '1,11/12,"00"13'),
    "title in place of the columns": rewritten(
        LOW, lambda text: "Points of 1971\n" + text.partition("\n")[2]
    ),
    "decimal comma or thousands": rewritten(
        LOW, lambda text: re.sub(r"[.](\d{3})\d", r",\1", text.replace(",", ";"))
    ),
    "binary file": rewritten(LOW, lambda _: b"point\n" + np.arange(20.0).tobytes()),
    "workbook": rewritten(LOW, lambda _: b"PK\x03\x04 and so on"),
    "truncated Parquet": in_parquet(lambda _: b"PAR1" + bytes(100)),
    "text in place of Parquet": in_parquet(str),
}


def said_of():
    """Read the golden file: a line with the fault's name, then the indented message."""
    lines = GOLDEN.read_text(encoding="utf-8").splitlines()
    return dict(zip(lines[::2], (line.strip() for line in lines[1::2]), strict=True))


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_said_with_its_place_and_remedy(small_block, fault):
    FAULTS[fault](small_block)
    with pytest.raises(EinschaltError) as caught:
        read_block(small_block.path)
    assert str(caught.value) == said_of()[fault]


def test_every_golden_message_has_its_fault():
    assert list(said_of()) == list(FAULTS)


def test_sound_block_has_no_problem(small_block):
    found = find_problems(small_block.path)
    assert (found.problems, found.model_problems, found.notes) == ((), (), ())
    assert found.block.name == "Nine points"


def test_facts_of_an_error_can_be_read(small_block):
    small_block.replace(LOW, "82.5000", "n/a")
    (problem,) = find_problems(small_block.path).problems
    assert (problem.file, problem.row) == (LOW, 5)
    assert (problem.point, problem.model) == ("7/8", "11/12")


TOLERATED = {
    "byte order mark": lambda text: b"\xef\xbb\xbf" + text.encode(),
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "byte order mark and CRLF": lambda text: (
        b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode()
    ),
    "old Macintosh": lambda text: text.replace("\n", "\r"),
    "blank lines at the end": lambda text: text + "\n\n",
    "blank line in the middle": lambda text: text.replace("\n", "\n\n", 4),
    "rows of commas": lambda text: text + ",,,,\n,,,,\n",
    "no end of line": lambda text: text.rstrip("\n"),
    "semicolons": lambda text: text.replace(",", ";"),
    "tabs": lambda text: text.replace(",", "\t"),
    "blanks": lambda text: text.replace(",", "  "),
    "decimal commas": lambda text: text.replace(",", ";").replace(".", ","),
    "UTF-16": lambda text: text.encode("utf-16"),
    "comments": lambda text: "# a\n" + text.replace("\n", "\n#b;\n", 3) + '# "end',
    "header as a comment": lambda text: "# " + text,
    "German, between semicolons": lambda text: (
        text.replace("coverage,model_id,point_id", "Überdeckung,Modell-Nr.,Pkt.-Nr.")
        .replace(",", ";")
        .encode("cp1252")
    ),
    "quotes everywhere": lambda text: (
        '"' + text.strip().replace(",", '","').replace("\n", '"\n"') + '"\n'
    ),
    "blanks after commas": lambda text: text.replace(",", ", "),
    "signs": lambda text: text.replace(",10.0000", ",+10.0000"),
}


@pytest.mark.parametrize("change", TOLERATED)
def test_harmless_peculiarities_are_read_alike(small_block, change):
    plain = read_block(small_block.path).low_flight.model_points
    rewritten(LOW, TOLERATED[change])(small_block)
    found = find_problems(small_block.path)
    assert found.problems == ()
    changed = found.block.low_flight.model_points
    assert changed.reset_index(drop=True).equals(plain.reset_index(drop=True))


def test_row_is_the_line_of_the_file_below_blank_lines(small_block):
    small_block.replace(LOW, "1,11/12,0013", "\n\n1,11/12,0013")
    small_block.replace(LOW, "82.5000", "n/a")
    (problem,) = find_problems(small_block.path).problems
    assert problem.row == 7
    assert small_block.read(LOW).splitlines()[6] == "1,11/12,7/8,10.0000,n/a"


def test_unknown_column_is_ignored_and_said(small_block):
    small_block.write(LOW, small_block.read(LOW).replace("\n", ",remark\n"))
    found = find_problems(small_block.path)
    assert found.problems == ()
    assert found.notes == ("low_flight.csv: ignored column remark",)


def test_model_without_common_points_does_not_stop_the_block(small_block):
    rows = "2,13/14,X1,1.0,1.0\n2,13/14,X2,1.0,9.0\n"
    small_block.write(LOW, small_block.read(LOW) + rows)
    found = find_problems(small_block.path)
    assert found.problems == ()
    (problem,) = found.model_problems
    assert str(problem) == (
        "low_flight.csv, row 26, model 13/14: none of its points has coordinates from "
        "the high flight; expected common points. Correct the names of its points, or "
        "delete the model."
    )


def test_faults_of_all_files_come_together(small_block):
    small_block.replace("block.toml", "m_g_um = 5.0", 'm_g_um = "5.0"')
    small_block.replace("block.toml", "15000", "0.00006")
    small_block.replace(CONTROL, "322500.00", "n/a")
    small_block.replace(LOW, "82.5000", "n/a")
    small_block.replace(LOW, "1,11/12,0013,72.5000", "1,11/12,0013")
    (small_block.path / "high_flight.csv").unlink()
    with pytest.raises(BlockError) as caught:
        read_block(small_block.path)
    assert [(problem.file, problem.row) for problem in caught.value.problems] == [
        ("block.toml", 16),
        ("high_flight.csv", None),
        (LOW, 3),
        (LOW, 5),
        ("block.toml", 10),
        (CONTROL, 5),
    ]
    assert str(caught.value).startswith("6 problems:\n")
    assert str(caught.value).endswith("  and 1 more")


def test_all_axes_exchanged_is_said_of_five_points(small_block):
    small_block.replace(CONTROL, "easting,northing", "northing,easting")
    with pytest.raises(BlockError, match="8 problems:\n") as caught:
        read_block(small_block.path)
    lines = str(caught.value).splitlines()
    assert len(lines) == 1 + 5 + 1
    assert "row 2, point 0012: easting 322000.000, northing 13000.000" in lines[1]
    assert lines[-1] == "  and 3 more"


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        ("x", "x 'x' is not a number"),
        ('"1,5"', "x '1,5' has a decimal comma"),
        ("nan", "x 'nan' is missing"),
    ],
)
def test_ten_thousand_wrong_rows_are_said_once_and_in_time(small_block, bad, said):
    rows = "".join(
        f"1,11/12,N{k},{bad if k < 10_000 else 1.0},1\n" for k in range(20_000)
    )
    small_block.write(LOW, small_block.read(LOW) + rows)
    started = time.process_time()
    (problem,) = find_problems(small_block.path).problems
    seconds = time.process_time() - started
    assert str(problem).startswith(
        f"low_flight.csv, row 26, point N0, model 11/12: {said}; x is wrong in 9999 "
        "more rows (27, 28, 29, 30, 31, …); expected millimetres"
    )
    assert problem.stands_for == 10_000
    assert seconds < 5.0  # usually 0.2 s


def test_ten_thousand_ragged_rows_are_said_once(small_block):
    rows = "".join(f"1,11/12,N{k},1\n" for k in range(10_000))
    small_block.write(LOW, small_block.read(LOW) + rows)
    (problem,) = find_problems(small_block.path).problems
    assert problem.found == (
        "the row has 4 values, the header 5; the number of values is not that of the "
        "header in 9999 more rows (27, 28, 29, 30, 31, …)"
    )


def test_ten_thousand_repeated_rows_are_found_in_time(small_block):
    rows = "".join(f"1,11/12,N{k % 2},{k},1\n" for k in range(10_002))
    small_block.write(LOW, small_block.read(LOW) + rows)
    started = time.process_time()
    (first,) = find_problems(small_block.path).problems
    assert time.process_time() - started < 5.0  # usually 0.2 s
    assert (first.row, first.point) == (28, "N0")
    assert first.found.startswith(
        "the row repeats row 26; earlier rows are repeated in "
    )


def test_path_that_leads_nowhere(tmp_path):
    with pytest.raises(EinschaltError, match="there is no such folder or file"):
        read_block(tmp_path / "nowhere")


def test_folder_without_block_toml(tmp_path):
    with pytest.raises(
        EinschaltError, match=r"the folder holds no block\.toml; expected"
    ):
        read_block(tmp_path)
