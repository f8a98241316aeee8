"""Files of other programs that are made to harm: refused in a sentence, and soon."""

import re
import time

import pytest
from fuzz.foreign_files import DXF, GAMA, MMVII, MORE, PROJECT, READ, SINEX

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.files.odm_lists import read_odm
from einschalt.interfaces.programs.block_tables import found_in

TEXTS = {name: text for name, (text, *_) in READ.items()} | MORE
MARKERS = "<document><chunk><markers/></chunk></document>"
XML = {name: text for name, text in TEXTS.items() if text.lstrip().startswith("<")}
XML["markers.xml"] = MARKERS
LAUGHS = '<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;&x;&x;&x;&x;&x;">]>'
FILE = '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]>'
SOON = 5.0  # seconds of the processor; thousandths are usual


def body(text):
    return text.rpartition("?>")[2]


def refused(file, data):
    file.write_bytes(data if isinstance(data, bytes) else data.encode())
    start = time.process_time()
    with pytest.raises(EinschaltError) as error:
        found_in(file)
    assert time.process_time() - start < SOON
    assert file.name in str(error.value)
    assert len(str(error.value)) < 600
    return str(error.value)


@pytest.mark.parametrize("name", XML)
def test_xml_has_no_entities_and_no_bottom(tmp_path, name):
    file, text = tmp_path / name, body(XML[name])
    for head in (LAUGHS, FILE):
        assert "document type" in refused(file, f"{head}{text}")
    # what is no ASCII is looked at in the same way
    encoded = f'<?xml version="1.0" encoding="UTF-16"?>{LAUGHS}{text}'.encode("utf-16")
    assert tables_of(file, encoded) == {}
    refused(file, text.replace(">", ">" + "<b>" * 50_000, 1))


WRONG = ("nan", "inf", "1e999", "1_0", "٣", "9" * 400, "\0", '"', "0x1F")


@pytest.mark.parametrize("name", TEXTS)
def test_no_number_is_made_of_what_is_none(tmp_path, name):
    """Nothing but a message, or a table in which all numbers are finite."""
    file, text = tmp_path / name, TEXTS[name]
    places = list(re.finditer(r"\d+(\.\d+)?", text))
    for place in places[:: max(1, len(places) // 6)]:
        for wrong in WRONG:
            data = text[: place.start()] + wrong + text[place.end() :]
            for table in tables_of(file, data).values():
                # heights and precisions may be left out
                known = [n for n in table if n[:3] not in ("hei", "sta")]
                numbers = table[known].select_dtypes("number")
                assert (numbers.abs() < 1e300).all(axis=None)


@pytest.mark.parametrize("name", TEXTS)
def test_a_line_without_an_end_and_bytes_are_no_trap(tmp_path, name):
    file, text = tmp_path / name, TEXTS[name]
    for data in (text.encode() + b"x" * 2_000_000, text.encode() + bytes(range(256))):
        start = time.process_time()
        tables_of(file, data)
        assert time.process_time() - start < SOON


def tables_of(file, data):
    """Tables of a file; none where it is refused in a sentence, or is a plain table."""
    file.write_bytes(data if isinstance(data, bytes) else data.encode())
    said = ""
    try:
        found = found_in(file)
    except EinschaltError as error:
        found, said = None, str(error)
    assert len(said) < 2000
    return {} if found is None else found.tables


MANY_TIMES = "  0\nINSERT\n  2\nB\n 70\n30000\n 71\n30000\n"
N_STATIONS = 3000
ESTIMATES = "".join(
    f" {3 * n + k} STA{axis} {n:04d} A 1 26:060:43200 m 2 4.1E+06 1.0E-02\n"
    for n in range(N_STATIONS)
    for k, axis in enumerate("XYZ", 1)
)
HEAD, REST = SINEX[: SINEX.index("     1 STAX")], SINEX[SINEX.index("-SOLUTION/EST") :]


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.gkf", GAMA.replace('dim="2"', 'dim="999999999999"'), "covariances"),
        ("a.gkf", GAMA.replace('band="1"', f'band="{"9" * 99}"'), None),
        ("a.snx", f"{HEAD}{ESTIMATES}{REST}", "expected at most 6000 coordinates"),
        (
            "a.snx",
            SINEX.replace("     3     1  0", "999999999     1  0"),
            "no variance",
        ),
        ("mmvii.xml", MMVII.replace("<Nb>1", "<Nb>999999999"), "holds 1 of"),
        ("project.txt", PROJECT.replace("20 100 100", "2000000000 9 9"), None),
        (
            "a.dxf",
            DXF.replace("  0\nPOINT\n", f"{MANY_TIMES}  0\nPOINT\n"),
            None,
        ),
        ("g.json", "[" * 100_000, "is no whole JSON"),
    ],
)
def test_what_is_announced_is_not_believed(tmp_path, name, text, said):
    """Sizes in a file make no array before as much was found."""
    if name.endswith(".dxf"):
        pytest.importorskip("ezdxf")
    file = tmp_path / name
    if said is not None:
        assert said in refused(file, text)
        return
    file.write_text(text)
    assert len(found_in(file).tables["control_points"]) == 1


def test_ten_thousand_points_without_names_are_numbered_soon(tmp_path):
    """In time that grows as their number does, and not as its square."""
    lines = "".join(f"{k} 2 3 4 5 a.jpg\n" for k in range(10_000))
    (tmp_path / "gcp_list.txt").write_text(f"WGS84\n{lines}")
    start = time.process_time()
    assert len(read_odm(tmp_path / "gcp_list.txt").points) == 10_000
    assert time.process_time() - start < SOON
