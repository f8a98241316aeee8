"""Every command in German, on sound and on broken input: no English reaches the user.

Each call is made in both languages. A word that both outputs have, and no German
message of the catalogue, was not translated. What computes knows English alone, and
what it says is told in the language of the user: both tell of one computation.
"""

import json
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from tests.interfaces.conftest import BlockFolder
from tests.interfaces.test_bad_input import FAULTS

from einschalt.foundations.kept_texts import words_of
from einschalt.foundations.language import catalogue
from einschalt.interfaces import python_api

pytestmark = pytest.mark.usefixtures("computed_once", "undrawn")

# what users and other programs have named: files, columns, keys, options, systems
DATA = re.compile(
    r"""'[^'\n]*'|"[^"\n]*"|„[^“\n]*“|<[^>\n]*>|\[[^\]\n]*\]"""
    r"""|--[\w-]+(?:[ =][A-Z]\w*)?|\S*[\w.][/_.=\d|]\w\S*|\S*[/_\\]\S*|\w+ = \S+"""
    r"""|\w+:[\w+:]+"""
    r"""|(?:MGI|ETRS89|WGS 84|DHDN)(?: (?:/ [\w -]*?(?=[,;.:(]|$)|to \w+))?"""
)
# first words of lines that other programs look for, keys that are one word, and names
# of blocks, axes, settings, commands and systems
NAMES = set(
    words_of(
        "csv txt tsv parquet pq xlsx ods gpkg shp geojson svg dm μm ft zone opencv "
        "metashape problem model note run keep fail skip plan simulate completion "
        "publish orient simulated Point sound column comma two crs TOWN OLD step many "
        "Northng Austria Lambert Albania Germany LCC Portugal affine easting northing "
        "height weight role control check colour einschalt Nine points Demo Cube TERM "
        "demo init densify serve batch convert transform export explain"
    )
)
# what stands in a file, or is to be typed into it
TYPED = re.compile(
    r"""'[^'\n]*'|„[^“\n]*“|"[^"\n]*"|\w+ = \S+|\[.*?\]|\S+ schreiben|[+]proj.*"""
)
DECIMAL_POINT = re.compile(r"(?<![\w.:/])\d+\.\d+(?![\w.])")


@cache
def german_words():
    known = catalogue("de")._catalog.values()
    return {word for text in known for word in words_of(text)}


def left_in_english(english, german):
    """Words that are in both outputs, and in no German message."""
    english, german = (DATA.sub(" ", text) for text in (english, german))
    same = set(words_of(english)) & set(words_of(german))
    return sorted(same - german_words() - NAMES)


GROUND = "point_id,easting,northing\na,0,0\nb,100,0\nc,0,100\nd,90,90\n"
OLD = "point_id,x,y\na,0,0.01\nb,100,0\nc,0,100\nd,90,90\n"
MODELS = "model_id,point_id,x,y\n1,a,0,0\n1,b,100,0\n1,c,0,100\n2,a,0,0\n2,b,9,9\n"
PAIRS = "model_id,point_id,x_left,y_left,x_right,y_right\n1,a,1,2,3,4\n1,b,2,3,4,5\n"
PARALLAXES = "point_id,x,y,z,y_parallax\na,0,0,-152,0\nb,92,0,-152,0.01\n"
TERRAIN = "model_id,h1,h2,h3,h4,h5,h6\nA,600,600,600,600,600,600\nB,6,6,900,9,9,9\n"
RING = [[5e5, 53e5], [5.03e5, 53e5], [5.03e5, 5.303e6], [5e5, 53e5]]
AREA = {
    "type": "Polygon",
    "coordinates": [RING],
    "crs": {"type": "name", "properties": {"name": "EPSG:32633"}},
}
FILES = {
    "old.csv": OLD,
    "models.csv": MODELS,
    "ground.csv": GROUND,
    "short.csv": GROUND[:44],
    "line.csv": "point_id,easting,northing\na,0,0\nb,1,1\nc,2,2\nd,3,3\n",
    "text.csv": GROUND.replace("100", "n/a"),
    "columns.csv": GROUND.replace("northing", "Northng"),
    "colour.csv": GROUND.replace("northing", "northing,colour"),
    "pairs.csv": PAIRS,
    "parallaxes.csv": PARALLAXES,
    "terrain.csv": TERRAIN,
    "empty.csv": "",
    "broken.xml": "<document><chunk></document>",
    "broken.xlsx": b"PK\x03\x04 and so on",
    "broken.parquet": b"PAR1" + bytes(50),
    "broken.gpkg": b"SQLite format 3\x00" + bytes(99),
    "broken.dxf": "0\nSECTION\n",
    "broken.tif": b"II*\x00" + bytes(30),
    "broken.geojson": '{"type": ',
    "broken.json": '{"cameras": [1, 2',
    "wrong.toml": "[camera]\nfx = 1\nfocal = 2\n",
    "area.geojson": json.dumps(AREA),
    "degrees.geojson": json.dumps({**AREA, "crs": None}),
    "point.geojson": '{"type": "Point", "coordinates": [1, 2]}',
    "heights.xyz": "500000 5300000 x\n1 2 3\n",
    "far.xyz": "1 2 3\n4 5 6\n7 8 9\n10 11 12\n13 15 15\n",
}
# blocks below a folder, each with the fault of test_bad_input that spoils it
BLOCKS = {
    "sound": None,
    "column": "missing column",
    "comma": "decimal comma in block.toml",
    "two": "two encodings",
    "crs": "unknown system",
}


@pytest.fixture(scope="module")
def prepared(tmp_path_factory, block_folder, invoke):
    """A desk with blocks, results, tables, and damaged files."""
    desk = tmp_path_factory.mktemp("desk")
    for name, text in FILES.items():
        data = text if isinstance(text, bytes) else text.encode("utf-8")
        (desk / name).write_bytes(data)
    shutil.copytree(block_folder, desk / "block")
    for name, fault in BLOCKS.items():
        folder = desk / "the_blocks" / name
        folder.mkdir(parents=True)
        block = BlockFolder(folder)
        if fault is not None:
            FAULTS[fault](block)
    (desk / "for_eign").mkdir()
    (desk / "for_eign" / "letter.txt").write_text("mine", "utf-8")
    (desk / "a_file").write_text("mine", "utf-8")
    (desk / "no_thing").mkdir()
    said = invoke("densify", desk / "the_blocks" / "sound", "--output", desk / "result")
    assert said.exit_code == 0, said.output
    transform = ("transform", desk / "old.csv", desk / "ground.csv", "--kind")
    said = invoke(*transform, "helmert", "--output", desk / "fitted")
    assert said.exit_code == 0, said.output
    return desk


@pytest.fixture(scope="module")
def desks(prepared, tmp_path_factory):
    """Gives the desk of a language: as it was prepared, or else a new one.

    Most calls are refused and leave what there was; to lay a desk takes as long.
    """
    laid = {}

    def call(language):
        desk, untouched = laid.get(language, (None, None))
        if desk is None or lying_in(desk) != untouched:
            desk = tmp_path_factory.mktemp(language) / "desk"
            shutil.copytree(prepared, desk)
            laid[language] = desk, lying_in(desk)
        return desk

    return call


def lying_in(folder):
    """Every file and folder, and of which size and when it was written."""
    found = {path: path.stat() for path in folder.rglob("*")}
    return {path: (one.st_size, one.st_mtime_ns) for path, one in found.items()}


@pytest.fixture
def in_both_languages(desks, invoke, monkeypatch):
    """What a call prints in English and in German, each on a desk of its own."""

    def call(words, spoil=None, english_engine=None):
        printed = []
        for language in ("en", "de"):
            desk = desks(language)
            monkeypatch.chdir(desk)
            if spoil is not None:
                spoil(desk)
            with monkeypatch.context() as patch:
                if language == "en" and english_engine is not None:
                    patch.setattr(
                        python_api, "chosen_engine", lambda *_, **__: english_engine
                    )
                shown = invoke(*words.split(), "--language", language)
            assert shown.exception is None or shown.exit_code < 4, shown.exception
            printed.append(shown.output)
        return printed

    return call


def assert_german(printed):
    english, german = printed
    assert not left_in_english(english, german), german
    told = TYPED.sub("", german)
    assert not DECIMAL_POINT.findall(told), german


OUT = "--output the_out"
SOUND = (
    "check block",
    f"densify block {OUT}",
    f"densify block {OUT} --method simultaneous",
    f"densify block {OUT} --method auto --tolerance 0,05",
    f"densify the_blocks/sound {OUT} --residual-distribution natural_neighbour",
    f"densify the_blocks/sound {OUT} --iterations 3 --outliers snoop",
    f"densify the_blocks/sound {OUT} --output-crs EPSG:31287 -v",
    f"densify the_blocks/sound {OUT} --strict",
    f"batch the_blocks {OUT} --workers 1",
    f"batch the_blocks {OUT} --dry-run",
    "init new --template",
    (
        "init new --from block/control_points.csv block/high_flight.csv "
        "block/low_flight.csv --yes"
    ),
    "convert ground.csv out.csv",
    "convert colour.csv out.csv",
    "convert wrong.toml out",
    "export result --to p.dxf p.xlsx p.kml p.xml p.csv p.con p.gkf p.snx",
    "export the_blocks/sound --to p.gkf",
    "publish fitted --as OLD --crs EPSG:31255",
    "plan",
    "plan --scale 6000:8000:1000 --spacing 200 --edge lattice --output plan.csv",
    "plan --target 0.05 --spacing 300",
    "plan --target 5cm --spacing 300 --costs image=12 --by paper --where edge",
    "plan --target 1mm --spacing 300",
    "plan --expect --scale-number 8000 --spacing 300 --width 4000 --height 4000",
    (
        "plan --target 5cm --area area.geojson --scale-number 11000 --spacing 300 "
        "--n-settings 2 --output plan"
    ),
    "plan --scale-number 6000,8000 --terrain terrain.csv",
    f"simulate --preset demo {OUT}",
    f"simulate --preset demo --repeat 2 --workers 1 {OUT}",
    f"simulate --camera dmc_3 --spacing 300 --title 1 {OUT}",
    f"transform old.csv ground.csv {OUT}",
    f"transform models.csv ground.csv {OUT}",
    (
        f"transform old.csv ground.csv --kind helmert --distribute triangles {OUT} "
        "--publish OLD --crs EPSG:3067"
    ),
    f"orient --terrain terrain.csv --principal-distance 152 --scale-number 8000 {OUT}",
    "explain exchanged_names",
)
WRONG = (
    "check no_where",
    "check no_thing",
    "check a_file",
    "check",
    "check --explain Passpnkt",
    "explain Passpnkt",
    f"densify no_where {OUT}",
    "densify block --output block",
    "densify block --output for_eign",
    "densify block --output a_file",
    "densify block --output a_file/out",
    "densify block --output result",
    "densify block",
    f"densify block {OUT} --tolerance wide",
    f"densify block {OUT} --tolerance 50",
    f"densify block {OUT} --significance 2",
    f"densify block {OUT} --iterations 0",
    f"densify block {OUT} --method bundle",
    f"densify block {OUT} --confidence 1,5",
    f"densify block {OUT} --no-report --pdf a4",
    f"densify block {OUT} --output-crs EPSG:99999",
    f"densify block {OUT} --output-crs EPSG:4326",
    f"densify block {OUT} --output-crs EPSG:25833",
    f"densify block {OUT} --output-crs EPSG:25833 --crs-accuracy-m 0,01",
    f"densify block {OUT} --output-crs EPSG:25833 --crs-operation magic",
    f"densify block {OUT} --grids no_where",
    f"densify block {OUT} --iterations 2 --method simultaneous",
    f"densify block {OUT} --crs-epoch soon",
    f"batch no_thing {OUT}",
    f"batch no_where {OUT}",
    "batch the_blocks --output the_blocks/sound",
    f"batch the_blocks {OUT} --workers 0",
    f"batch the_blocks {OUT} --memory 0",
    f"batch the_blocks {OUT} --time-limit -1",
    f"batch the_blocks {OUT} --resume --all",
    f"batch the_blocks {OUT} --scheduler nobody",
    "init block",
    "init block --template",
    "init new",
    "init no_thing",
    "init new --from no_where.csv",
    "init new --from ground.csv",
    "init new --from ground.csv --crs EPSG:99999",
    "init new --from ground.csv --low-scale 8000 --yes",
    "init new --from text.csv --yes",
    "init new --from empty.csv --yes",
    "init new --from broken.xlsx --yes",
    "init new --from broken.parquet broken.gpkg --yes",
    "convert no_where out",
    "convert broken.xml out",
    "convert broken.xlsx out.csv",
    "convert broken.parquet out.csv",
    "convert broken.gpkg out.csv",
    "convert broken.dxf out",
    "convert broken.tif out",
    "convert broken.json out",
    "convert empty.csv out.csv",
    "convert text.csv out.csv",
    "convert columns.csv out.csv",
    "convert ground.csv ground.csv",
    "convert ground.csv out.foo",
    "convert ground.csv out.csv --crs EPSG:0",
    "convert ground.csv out.csv --sheet 1",
    "convert for_eign out",
    "export result",
    "export result --to a.foo",
    "export result --to result/points.csv",
    "export no_thing --to a.dxf",
    "export no_where --to a.dxf",
    "export result --to a_file/a.dxf",
    "export result --to p.kml p.kml",
    "publish result --as 1",
    "publish no_thing --as OLD",
    "publish no_where --as OLD",
    "publish result --as TOWN --crs EPSG:25833",
    "publish result --as TOWN --output for_eign",
    "publish result --as TOWN --proj-db a_file",
    "plan --target 5",
    "plan --target 5foot",
    "plan --target 0.05 --spacing 0",
    "plan --m-0 0,1",
    "plan --camera kodak",
    "plan --image-format 3",
    "plan --forward-overlap 60",
    "plan --costs photo=3",
    "plan --costs image=cheap",
    "plan --scale 9:8:1",
    "plan --expect",
    "plan --width 300",
    "plan --output plan.doc",
    "plan --figure plan.doc",
    "plan --terrain no_where.csv",
    "plan --terrain ground.csv",
    "plan --area area.geojson",
    "plan --target 5cm --area no_where.gpkg",
    "plan --target 5cm --area broken.geojson",
    "plan --target 5cm --area broken.gpkg",
    "plan --target 5cm --area point.geojson",
    "plan --target 5cm --area degrees.geojson",
    "plan --target 5cm --area area.geojson --ground-heights heights.xyz",
    "plan --target 5cm --area area.geojson --ground-heights far.xyz",
    "plan --target 5cm --area area.geojson --ground-heights broken.tif",
    "plan --target 5cm --area area.geojson --crs EPSG:4326",
    f"simulate --preset demo --width -3 {OUT}",
    f"simulate --preset demo --n-check 10000 {OUT}",
    f"simulate --preset demo --forward-overlap 0,99 {OUT}",
    f"simulate --preset demo --camera dmc_3 {OUT}",
    f"simulate --row 2 {OUT}",
    f"simulate --plan no_where {OUT}",
    f"simulate --plan ground.csv {OUT}",
    "simulate --preset demo --output block",
    "simulate --preset demo --output for_eign",
    "simulate",
    f"transform no_where.csv ground.csv {OUT}",
    f"transform old.csv empty.csv {OUT}",
    f"transform old.csv short.csv {OUT}",
    f"transform old.csv line.csv {OUT}",
    f"transform old.csv text.csv {OUT}",
    f"transform old.csv columns.csv {OUT}",
    f"transform ground.csv old.csv {OUT}",
    f"transform old.csv ground.csv {OUT} --kind helmert_3d",
    f"transform old.csv ground.csv {OUT} --apply no_where.csv",
    f"transform old.csv ground.csv {OUT} --crs EPSG:3067",
    f"transform old.csv ground.csv {OUT} --cell 100",
    f"transform old.csv ground.csv {OUT} --distribute collocation --cell 5",
    f"transform old.csv ground.csv {OUT} --distribute triangles --triangles old.csv",
    f"transform old.csv ground.csv {OUT} --publish OLD",
    "transform old.csv ground.csv --output for_eign",
    f"orient {OUT}",
    f"orient parallaxes.csv {OUT}",
    f"orient parallaxes.csv --base 92 {OUT}",
    f"orient parallaxes.csv --base many {OUT}",
    f"orient parallaxes.csv --base -9 {OUT}",
    f"orient pairs.csv --base 92 {OUT}",
    f"orient pairs.csv --principal-distance 153 {OUT}",
    f"orient pairs.csv --principal-distance 0,153 {OUT}",
    f"orient pairs.csv --principal-distance 153 --method gruber {OUT}",
    f"orient pairs.csv --camera wrong.toml {OUT}",
    f"orient --terrain terrain.csv --principal-distance 152 {OUT}",
    f"orient --terrain ground.csv --principal-distance 152 --altitude 2000 {OUT}",
    f"orient --terrain terrain.csv --principal-distance 152 --altitude 300 {OUT}",
    f"orient --terrain terrain.csv --principal-distance 1520 --altitude 3000 {OUT}",
    "completion tcsh",
    "densfy block",
    "densify block --outptu out",
    "plan --spacing",
    "explain",
)


@pytest.mark.parametrize("words", SOUND)
def test_what_is_done_is_told_in_german_alone(words, in_both_languages, engine_here):
    # what is told of the answers of workers: of their processes in German
    assert_german(in_both_languages(words, english_engine=engine_here))


@pytest.mark.parametrize("words", WRONG)
def test_what_is_refused_is_told_in_german_alone(words, in_both_languages):
    assert_german(in_both_languages(words))


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_input_are_told_in_german_alone(fault, in_both_languages):
    def spoil(desk):
        FAULTS[fault](BlockFolder(desk / "the_blocks" / "sound"))

    assert_german(in_both_languages("check the_blocks/sound", spoil))


@pytest.mark.slow
@pytest.mark.usefixtures("in_this_process")
def test_batches_that_go_on_are_told_in_german_alone(in_both_languages, invoke):
    def computed(desk):
        invoke("batch", desk / "the_blocks", "--output", desk / "the_out")

    for mode in ("--dry-run", ""):
        assert_german(in_both_languages(f"batch the_blocks {OUT} {mode}", computed))


@pytest.fixture(scope="module")
def a_plan(tmp_path_factory, invoke):
    """A plan with its expected precision, as a folder."""
    folder = tmp_path_factory.mktemp("planned") / "a_plan"
    size = ("--width", 4000, "--height", 4000, "--output", folder)
    said = invoke("plan", "--expect", "--scale", 8000, "--spacing", 300, *size)
    assert said.exit_code == 0, said.output
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("more", ["", "--repeat 2 --workers 1", "--row 0"])
@pytest.mark.usefixtures("in_this_process")
def test_plans_that_are_tried_are_told_in_german_alone(more, in_both_languages, a_plan):
    def planned(desk):
        shutil.copytree(a_plan, desk / "a_plan")

    words = f"simulate --plan a_plan --title 1 {OUT} {more}"
    assert_german(in_both_languages(words, planned))


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
@pytest.mark.parametrize("words", ["--help", "explain all"])
def test_a_full_disk_is_told_in_german(words):
    with Path("/dev/full").open("w") as full:
        call = [sys.executable, "-m", "einschalt", *words.split(), "--language", "de"]
        shown = subprocess.run(
            call, stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert shown.returncode == 2
    assert shown.stderr.endswith("auf dem Datenträger ist kein Platz mehr\n")
    assert "output" not in shown.stderr
