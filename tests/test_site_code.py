"""Every command and code block of the site and the README runs.

What the tests of single pages run and compare is left to them: the tutorials
(test_site), the planning guide (test_planning_guide), the README's result and
docs/summary.md (test_readme), docs/figures.md (test_figures of the notebook) and the
theory (test_docs). All others run here, at a desk where the files lie that they name.
"""

import contextlib
import io
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pandas as pd
import pyogrio
import pytest
import tomli_w
from tests.test_site import DOCS, FENCED, NOTEBOOKS, PAGES, ROOT, WALKS
from typer.testing import CliRunner

import einschalt as es
from einschalt.interfaces.cli.main import app
from einschalt.interfaces.cli.work import init as work_of_init

RUN_ELSEWHERE = {
    *("planning", "summary", "figures", "theory/transformation"),
    *NOTEBOOKS,
}
# sizes and addresses of large computers, as they are tried here
SMALLER = {
    "--repeat 2000": "--repeat 2",
    "--repeat 20 ": "--repeat 2 ",
    'Experiment("neukirchen"), 20,': 'Experiment("demo"), 2,',
    "--nworkers 8": "--nworkers 1",
}
ADDRESS, PORT = "10.0.0.5", "8786"  # the scheduler listens there without being told
ANSWERS = "EPSG:31255\n\n\n"  # the suggested sizes of errors


def blocks_of(language, *, walks=True):
    """Page and code of all blocks that no other test runs."""
    pages = {**PAGES, "README": (ROOT / "README.md").read_text("utf-8")}
    elsewhere = RUN_ELSEWHERE | (set() if walks else set(WALKS))
    return [
        pytest.param(name, code, id=f"{name} {k + 1}")
        for name, text in pages.items()
        if name not in elsewhere
        for k, (one, code) in enumerate(FENCED.findall(text))
        if one in language
    ]


@pytest.fixture(scope="module")
def cupboard(tmp_path_factory):
    """Files that are made once."""
    folder = tmp_path_factory.mktemp("cupboard")
    block = es.simulate_block("demo", seed=1)
    block.write(folder / "BLOCK")
    for name in ("north", "south"):
        shutil.copytree(folder / "BLOCK", folder / "BLOCKS" / name)
    es.densify(block).write(folder / "out")
    shutil.copytree(folder / "out", folder / "RESULT")
    for flight in ("high", "low"):
        shutil.copy(folder / "BLOCK" / f"{flight}_flight.csv", folder / f"{flight}.csv")
    control = pd.read_csv(folder / "BLOCK" / "control_points.csv", dtype=str)
    for name in ("points.xlsx", "control.xlsx"):
        control.to_excel(folder / name, index=False, engine="xlsxwriter")
    for file in (DOCS / "tutorials" / "files").iterdir():
        shutil.copy(file, folder)
    meta, table = pyogrio.read_arrow(folder / "area.geojson")
    options = {"crs": meta["crs"], "geometry_type": "Polygon"}
    pyogrio.write_arrow(
        table,
        folder / "area.gpkg",
        geometry_name=meta["geometry_name"] or "wkb_geometry",
        **options,
    )
    return folder


@pytest.fixture
def desk(cupboard, tmp_path, monkeypatch, batches_here):
    """A folder with the files that readers have; with what code makes left out."""
    (tmp_path / "data_examples").symlink_to(ROOT / "data_examples")
    (tmp_path / "Makefile").symlink_to(ROOT / "Makefile")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(work_of_init, "_is_terminal", lambda: True)

    def lay_out(code):
        for one in cupboard.iterdir():
            copy = shutil.copytree if one.is_dir() else shutil.copy
            makes = rf"(init|--output|--to( \S+)*) {re.escape(one.name)}(?!\S)"
            if not re.search(makes, code) or f"--from {one.name}" in code:
                copy(one, tmp_path / one.name)

    return lay_out


@pytest.fixture(scope="module")
def port():
    """Of these tests alone: others run at the same time."""
    with socket.socket() as asked:
        asked.bind(("127.0.0.1", 0))
        return asked.getsockname()[1]


@pytest.fixture(scope="module")
def cluster():
    """Start computers of a cluster as the pages do, each once for all of them."""
    running = set()
    with started_computers() as start:

        def starting(program, words):
            if tuple(words) not in running:
                start(program, words)
                running.add(tuple(words))

        yield starting


@pytest.fixture
def starting(cluster):
    """Start what runs until it is ended: a server with this test, or a cluster."""
    with started_computers() as start:
        yield lambda program, words: (cluster if program == "dask" else start)(
            program, words
        )


def lines_of(code, port):
    text = code.replace("\\\n", " ") + "\n"
    here = {
        f"--host {ADDRESS}": f"--host 127.0.0.1 --port {port}",
        f"{ADDRESS}:{PORT}": f"127.0.0.1:{port}",
    }
    for large, small in {**SMALLER, **here}.items():
        text = text.replace(large, small)
    return [line for line in text.splitlines() if line.partition("#")[0].strip()]


@pytest.mark.parametrize(("page", "code"), blocks_of({"sh", "console"}, walks=False))
def test_commands_run(page, code, desk, port, starting):
    desk(code)
    before = []
    if ADDRESS in code and "dask scheduler" not in code:  # of an earlier block
        before = re.findall(r"^dask .*", PAGES[page], re.MULTILINE)
    for line in lines_of("\n".join([*before, code]), port):
        run(line, starting)


@pytest.mark.parametrize("page", [n for n in WALKS if "```console\n" in PAGES[n]])
def test_console_blocks_of_tutorials_run(page, desk, port, starting):
    """Behind the commands of their page; what these print is compared elsewhere."""
    blocks = [c for one, c in FENCED.findall(PAGES[page]) if one in {"sh", "console"}]
    desk(" ".join(blocks))
    for code in blocks:
        for line in lines_of(code, port):
            run(line, starting)


def test_computers_of_two_tests_listen_at_ports_of_their_own():
    one, two = (
        [
            line
            for line in lines_of(PAGES["batch"], port)
            if line.startswith(("dask", "einschalt"))
        ]
        for port in (50_001, 50_002)
    )
    assert not any(PORT in line or ADDRESS in line for line in one)
    assert [line.replace("50001", "50002") for line in one] == two
    told = {line.split()[1] for line in one if "50001" in line}
    assert told == {"scheduler", "worker", "batch", "simulate"}


def run(line, starting):
    """Run one command as it is written."""
    program, *words = shlex.split(line, comments=True)
    if program == "make":
        makefile = Path("Makefile").read_text("utf-8")
        assert re.search(rf"^{words[0]}:", makefile, re.MULTILINE)  # the tests' own
    elif program == "pip":
        (extra,) = re.findall(r"\[(\w+)\]", words[-1])
        described = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
        assert extra in described["project"]["optional-dependencies"]
    elif program == "dask" or words[0] == "serve":
        starting(program, words)
    else:
        assert program == "einschalt", line
        shown = CliRunner().invoke(app, words, input=ANSWERS)
        assert shown.exit_code == 0, f"{line}\n{shown.output}"
        assert shown.stdout, line


@contextlib.contextmanager
def started_computers():
    """Commands that run until they are ended, each started and seen to work."""
    running = []

    def start(program, words):
        module = {"dask": "dask", "einschalt": "einschalt"}[program]
        if words[0] == "serve":
            words += ["--no-browser"]
        command = [sys.executable, "-m", module, *words]
        log = Path(f"{program}-{words[0]}.log")
        with log.open("w", encoding="utf-8") as file:
            # as one group: a worker has helpers of its own
            running.append(
                subprocess.Popen(
                    command, stdout=file, stderr=file, start_new_session=True
                )
            )
        said = {"scheduler": "Scheduler at", "worker": "Registered to", "serve": "http"}
        wait_for(said[words[0]], log, running[-1])

    try:
        yield start
    finally:
        for process in reversed(running):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
        for process in running:
            process.wait(30)


def wait_for(said, log, process):
    for _ in range(600):
        if said in log.read_text("utf-8"):
            return
        assert process.poll() is None, log.read_text("utf-8")
        time.sleep(0.1)
    raise AssertionError(log.read_text("utf-8"))


@pytest.mark.parametrize(
    ("page", "code"),
    [one for one in blocks_of({"python"}) if one.values[0] != "README"],
)
def test_python_runs(page, code, desk):
    desk(code)
    for large, small in SMALLER.items():
        code = code.replace(large, small)
    with contextlib.redirect_stdout(io.StringIO()):
        exec(compile(code, page, "exec"), {})


def tables_as_the_pages_name_them(code):
    """Write the files that a piece of block.toml names, from those of the block."""
    control = pd.read_csv("control_points.csv", dtype={"point_id": str})
    if "Festpunkte.xlsx" in code:
        names = {"easting": "Y_GK", "northing": "X_GK"}
        table = control.rename(columns=names)
        options = {"index": False, "engine": "xlsxwriter"}
        table.to_excel("Festpunkte.xlsx", sheet_name="Lage", **options)
        low = pd.read_csv("low_flight.csv", dtype={"point_id": str, "coverage": str})
        low = low.rename(columns={"x": "x red", "y": "y red"})
        low.to_csv("auswertung.txt", sep=";", decimal=",", index=False)
    control.to_csv("control.csv", index=False)
    if "approximate.csv" in code:
        truth = es.simulate_block("demo", seed=1).truth
        truth.assign(group="a").to_csv("approximate.csv", index=False)


def merged(whole, part):
    """A table of TOML with the keys of a part in place of its own."""
    for key, value in part.items():
        is_table = isinstance(value, dict) and isinstance(whole.get(key), dict)
        whole[key] = merged(whole[key], value) if is_table else value
    return whole


PIECES = [
    one
    for one in blocks_of({"toml"}, walks=False)
    if "entry-points" not in one.values[1]
]


@pytest.mark.parametrize(("page", "code"), PIECES)
def test_pieces_of_a_block_file_are_read(page, code, cupboard, tmp_path, monkeypatch):
    of_images = page == "theory/interior_orientation"
    source = ROOT / "data_examples/sxb_strasbourg" if of_images else cupboard / "BLOCK"
    shutil.copytree(source, tmp_path / "block")
    monkeypatch.chdir(tmp_path / "block")
    tables_as_the_pages_name_them(code)
    whole = tomllib.loads(Path("block.toml").read_text("utf-8"))
    part = tomllib.loads(code)
    if of_images:
        pixels = pd.read_csv("image_points.csv", dtype={"point_id": str})
        within = 0.4 * pixels[["x", "y"]] / 0.0045 * [1, -1]  # a smaller image
        pixels[["x", "y"]] = within.add([4010.5, 2985.2])
        pixels.to_csv("image_points.csv", index=False)
        del whole["low_flight"]["principal_distance_mm"]
        (camera,) = (
            tomllib.loads(c.values[1])["low_flight"]["camera"]
            for c in PIECES
            if "low_flight.camera" in c.values[1]
        )
        Path("camera.toml").write_text(tomli_w.dumps(camera), "utf-8")
    if "approximate_points" in part:
        del whole["high_flight"]
    Path("block.toml").write_text(tomli_w.dumps(merged(whole, part)), "utf-8")
    block = es.read_block(tmp_path / "block")
    assert len(block.low_flight.image_points if of_images else block.control_points)


def test_no_block_of_the_site_is_left_out():
    """Every language is data, output, or run by a test that this file names."""
    languages = {one for text in PAGES.values() for one, _ in FENCED.findall(text)}
    run_here = {"sh", "console", "python", "toml"}
    data_of_the_planning_guide = {"json", "xyz", "csv"}
    assert languages <= run_here | data_of_the_planning_guide | {"text"}
    for name, text in PAGES.items():
        if data_of_the_planning_guide & {one for one, _ in FENCED.findall(text)}:
            assert name == "planning"
