"""Files that are dropped: whole, within limits, and made a block."""

import ast
import asyncio
import errno
import io
import json
import os
import re
import shutil
from pathlib import Path

import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import written_in
from einschalt.foundations.told_errors import told
from einschalt.interfaces.local_page import drop_pages, dropped_files
from einschalt.interfaces.local_page.refusals import TooLargeError
from einschalt.interfaces.new_block import proposal
from einschalt.interfaces.new_block.questions import Question

CHUNK = bytes(2**20)
GIGABYTES = 2 * 2**30
# minutes, seconds and their decimals of angles
PARTS = [
    range(first, last, (last - first) // 12)[:12]
    for first, last in ((1, 59), (3, 58), (11, 9000))
]


def dropped(visitor, files):
    """Drop files as the script of the page does; the page that is led to."""
    number = json.loads(visitor.post("/drop").text)["drop"]
    for name, text in files.items():
        data = text.encode()
        answer = visitor.put(
            f"/drop/{number}/{name}", [data], content_length=str(len(data))
        )
        assert answer.status == 200, answer.text
    return visitor.get(f"/drop/{number}").headers["location"]


def files_of(block):
    return {path.name: path.read_text("utf-8") for path in block.path.iterdir()}


def test_a_dropped_block_is_checked(visit, root, small_block):
    visitor = visit(root)
    files = {f"mine/{name}": text for name, text in files_of(small_block).items()}
    page = visitor.get(dropped(visitor, files))
    assert page.status == 200
    assert "Nothing is wrong with its input" in page.text
    assert 'name="output" value="Nine_points_results"' in page.text
    assert list(root.iterdir()) == []


@pytest.mark.parametrize("address", ["/block?drop=7", "/block?drop=x", "/new?drop=²"])
def test_files_that_were_not_dropped_are_not_there(visit, root, address):
    assert visit(root).get(address).status == 404


def test_of_dropped_tables_a_block_is_made(visit, root, small_block):
    visitor = visit(root)
    files = files_of(small_block)
    del files["block.toml"]
    address = dropped(visitor, files)
    page = visitor.get(address)
    assert "8 points" in page.text
    assert 'name="low_flight.m_g_um" value="5"' in page.text
    answers = {"drop": "1", "name": "Mine", "block.crs": "EPSG:31255"}
    answers |= {"control_points.standard_error_m": "0,03"}
    made = visitor.post("/new", answers)
    assert made.status == 303
    checked = visitor.get(made.headers["location"]).text
    assert "<h1>Mine</h1>" in checked
    assert "Nothing is wrong with its input" in checked
    text = (visitor.session.folder / "dropped-1" / "block.toml").read_text("utf-8")
    assert "standard_error_m = 0.03" in text


def test_of_dropped_photographs_and_control_a_block_is_made(visit, root):
    """Their pairs are chosen as init does."""
    visitor = visit(root)
    names = ("control_points.csv", "image_points.csv")
    source = Path(__file__).parents[3] / "data_examples" / "sxb_strasbourg"
    files = {name: (source / name).read_text("utf-8") for name in names}
    page = visitor.get(dropped(visitor, files))
    assert 'name="low_flight.principal_distance_mm"' in page.text
    answers = {"drop": "1", "low_flight.principal_distance_mm": "123,9392"}
    made = visitor.post("/new", answers)
    assert made.status == 303
    checked = visitor.get(made.headers["location"]).text
    assert "Nothing is wrong with its input" in checked
    folder = visitor.session.folder / "dropped-1"
    assert len((folder / "low_flight_models.csv").read_text().splitlines()) == 10
    # a table that is none of ours is not written over
    (folder / "block.toml").unlink()
    (folder / "low_flight_models.csv").write_text("remarks\nmine\n")
    refused = visitor.post("/new", answers)
    assert refused.status == 400
    assert "holds low_flight_models.csv already" in refused.text
    assert (folder / "low_flight_models.csv").read_text() == "remarks\nmine\n"
    assert not (folder / "block.toml").exists()


def asked_again(visitor, address, **said):
    """The page of dropped tables, with fields of its form filled in."""
    return visitor.get(address + "".join(f"&{k}={v}" for k, v in said.items()))


def test_the_column_of_names_is_named_on_the_page(visit, root, small_block):
    visitor = visit(root)
    files = files_of(small_block)
    del files["block.toml"]
    name = next(name for name in files if "control" in name)
    files[name] = files[name].replace("point_id", "LFP3-Nummer", 1)
    address = dropped(visitor, files)
    page = visitor.get(address)
    assert "Name that column below, as the names of the points" in page.text
    assert 'name="point_id"' in page.text
    page = asked_again(visitor, address, point_id="LFP3-Nummer")
    assert "not yet a block" not in page.text
    # and the block is made of tables that are read so
    assert '<input type="hidden" name="point_id" value="LFP3-Nummer">' in page.text
    answers = {"drop": "1", "block.crs": "EPSG:31255", "point_id": "LFP3-Nummer"}
    made = visitor.post("/new", answers)
    assert made.status == 303
    assert (
        "Nothing is wrong with its input" in visitor.get(made.headers["location"]).text
    )


def test_where_a_table_is_left_out_the_fields_are_open(visit, root, small_block):
    visitor = visit(root)
    files = files_of(small_block)
    del files["block.toml"]
    assert "<details>" in visitor.get(dropped(visitor, files)).text
    name = next(name for name in files if "control" in name)
    files["more.csv"] = files[name].replace("point_id", "LFP3-Nummer", 1)
    page = visitor.get(dropped(visitor, files)).text
    assert "Name that column below" in page
    assert "<details open>" in page


def test_how_angles_are_written_is_chosen_on_the_page(visit, root, small_block):
    visitor = visit(root)
    files = files_of(small_block)
    del files["block.toml"]
    name = next(name for name in files if "control" in name)
    # seconds that look like decimals: 47° and 15°, packed
    packed = [f"{m:02d}{s:02d}{t:04d}" for m, s, t in zip(*PARTS, strict=True)]
    rows = [f"P{k};47.{one};15.{one}" for k, one in enumerate(packed)]
    files[name] = "\n".join(["Punkt;Breite;Länge", *rows, ""])
    address = dropped(visitor, files)
    system = "Name the system of longitudes and latitudes below"
    assert system in visitor.get(address).text
    address += "&crs=EPSG:31255&points_crs=EPSG:4258"
    assert system not in visitor.get(address).text
    text = "Choose below how longitudes and latitudes are written"
    assert text in visitor.get(address).text
    for way in ("degrees", "D.MMSS"):
        page = asked_again(visitor, address, angles=way)
        assert text not in page.text
        assert re.search(rf"<option selected>({way}|Grad)", page.text)


SCALE = Question("low_flight", "scale_number", "", "scale number of the low flight")
PITCH = Question("low_flight", "pixel_size_um", "", "size of a pixel")
CONTROL = Question("control_points", "standard_error_m", "", "error of control points")


@pytest.mark.parametrize(
    ("question", "text", "value"),
    [
        (SCALE, "10.000", 10_000.0),
        (SCALE, "10,000", 10_000.0),
        (SCALE, "120 000", 120_000.0),
        (SCALE, " 7999,5 ", 7999.5),
        (PITCH, "13.26", 13.26),  # which was refused: "at most 10 metres"
        (CONTROL, "0,030", 0.03),
        (CONTROL, "1.250", 1.25),
    ],
)
def test_an_answer_is_understood_as_it_is_meant(question, text, value):
    assert drop_pages._value(question, text) == value


@pytest.mark.parametrize(
    ("question", "text"),
    [(SCALE, "8"), (SCALE, "8.000.000"), (SCALE, "inf"), (SCALE, "1_000")]
    + [(CONTROL, text) for text in ("inf", "nan", "0", "-1", "30", "3 cm", "")],
)
def test_an_answer_that_a_block_would_refuse_is_refused(question, text):
    required = Question(question.section, question.key, "", question.text)
    with pytest.raises(SettingsError, match="is no answer to") as caught:
        drop_pages._value(required, text)
    with written_in("de"):
        said = told(caught.value)
    assert "Nenner" in said if question is SCALE else "höchstens 10 Meter" in said


def test_an_upload_of_2_gb_is_refused_before_it_is_read(visit, root):
    visitor = visit(root)
    visitor.post("/drop")
    answer = visitor.put("/drop/1/x.csv", [CHUNK], content_length=str(GIGABYTES))
    assert answer.status == 413
    assert visitor.n_sent == 0
    assert list((visitor.session.folder / "dropped-1").iterdir()) == []


@pytest.mark.parametrize("announced", [None, "10"])
def test_an_upload_that_does_not_end_is_broken_off(visit, root, announced):
    visitor = visit(root, most_upload_mb=5.0)
    visitor.post("/drop")
    endless = (CHUNK for _ in range(GIGABYTES // len(CHUNK)))
    answer = visitor.put("/drop/1/x.csv", endless, content_length=announced)
    assert answer.status == 413
    assert visitor.n_sent <= 6 * len(CHUNK)
    assert list((visitor.session.folder / "dropped-1").iterdir()) == []
    assert visitor.session.drops.n_bytes == 0


class FullDisk(io.BytesIO):
    def write(self, _data):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_full_disk_is_said_and_leaves_nothing(visit, root, monkeypatch):
    visitor = visit(root)
    visitor.post("/drop")

    def new_file(path):
        path.touch()
        return FullDisk()

    monkeypatch.setattr(dropped_files, "_new_file", new_file)
    answer = visitor.put("/drop/1/x.csv", [b"123"])
    assert answer.status == 507
    assert "x.csv: cannot be stored: no space left on device" in answer.text
    assert list((visitor.session.folder / "dropped-1").iterdir()) == []
    assert visitor.session.drops.n_bytes == 0


def test_temporary_files_that_were_cleared_are_said(visit, root):
    visitor = visit(root)
    shutil.rmtree(visitor.session.folder)
    answer = visitor.post("/drop")
    assert answer.status == 507
    assert "cannot be stored" in answer.text


def test_what_breaks_off_does_not_uncount_what_comes_beside_it(tmp_path):
    drops = dropped_files.Drops(tmp_path, 100)
    drop = drops.new()

    async def chunks(n, size):
        for _ in range(n):
            await asyncio.sleep(0)
            yield bytes(size)

    async def both():
        too_large = drops.take(drop, "large", None, chunks(30, 10))
        small = drops.take(drop, "small", None, chunks(3, 10))
        return await asyncio.gather(too_large, small, return_exceptions=True)

    failed, _ = asyncio.run(both())
    assert isinstance(failed, TooLargeError)
    assert drops.n_bytes == 30
    assert [path.name for path in (tmp_path / "dropped-1").iterdir()] == ["small"]


@pytest.mark.parametrize(
    "name", ["../x.csv", "a/../../x.csv", "/etc/x.csv", ".ssh/x", "a\\..\\x", "%00"]
)
def test_names_of_dropped_files_lead_nowhere(visit, root, name):
    visitor = visit(root)
    visitor.post("/drop")
    before = sorted(visitor.session.folder.rglob("*"))
    answer = visitor.put(f"/drop/1/{name}".replace("%00", "\0"), [b"x"])
    assert answer.status == 403
    assert sorted(visitor.session.folder.rglob("*")) == before


def test_no_file_takes_the_place_of_another(visit, root):
    visitor = visit(root)
    visitor.post("/drop")
    visitor.put("/drop/1/x.csv", [b"first"])
    answer = visitor.put("/drop/1/x.csv", [b"second"])
    assert answer.status == 400
    file = visitor.session.folder / "dropped-1" / "x.csv"
    assert file.read_bytes() == b"first"


def test_a_form_of_2_gb_is_not_read(visit, root):
    visitor = visit(root)
    answer = visitor.post("/start", content_length=str(GIGABYTES))
    assert answer.status == 413
    assert visitor.n_sent == 0


def test_what_was_dropped_goes_with_the_session(visit, root, small_block):
    visitor = visit(root)
    dropped(visitor, files_of(small_block))
    folder = visitor.session.folder
    assert folder.stat().st_mode & 0o077 == 0
    visitor.session.close()
    assert not folder.exists()


def test_no_remedy_of_the_page_is_an_option_of_a_command():
    """Whoever drops files can name nothing after --from."""
    told_of_options = []
    for path in Path(proposal.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.keyword) and node.arg == "remedy":
                text = ast.unparse(node.value)
                told_of_options += [text] if "--from" in text else []
    assert len(told_of_options) == 7
    for text in told_of_options:
        error = SettingsError("x", remedy=ast.literal_eval(text))
        assert "--" not in told(drop_pages._as_dropped(error))


def test_all_files_that_cannot_be_read_are_told(visit, root):
    """Only the first was, and the next one after it had been mended."""
    visitor = visit(root)
    files = {"empty.csv": "", "rows.csv": "a,b\n1\n", "nul.csv": "a\0b\n"}
    page = visitor.get(dropped(visitor, files)).text
    for name in files:
        assert name in page
    visitor = visit(root)
    page = visitor.get(dropped(visitor, {f"{k}.csv": "" for k in range(14)})).text
    told_of = re.findall(r"\d+\.csv is empty|\d+\.csv: [a-z]", page)
    assert len(told_of) == drop_pages.MOST_MESSAGES, page
    assert "and 4 more problems" in page


def test_two_tables_of_control_are_told_as_on_a_page(visit, root):
    text = "point_id,easting,northing\nA,13000.25,322000.5\nB,13100.25,322000.5\n"
    visitor = visit(root)
    shown = visitor.get(dropped(visitor, {"a.csv": text, "b.csv": text})).text
    assert "Drop the files again, with one of them alone" in shown
    assert "--from" not in shown


def test_degrees_of_no_system_are_told_as_on_a_page(visit, root):
    text = "point_id,longitude,latitude\nA,13.5,47.25\nB,13.75,47.5\n"
    visitor = visit(root)
    shown = visitor.get(dropped(visitor, {"a.csv": text})).text
    assert "Name the system of longitudes and latitudes below" in shown
    assert "--points-crs" not in shown
