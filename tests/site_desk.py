"""Files that readers of the site have, and their commands run as they are written."""

import contextlib
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

import numpy as np
import pandas as pd
import pyogrio
from fuzz.foreign_files import CAMERAS, IMAGES, POINTS_3D
from tests.simulated_shifts import simulated_shifts
from tests.test_site import DOCS, PAGES, ROOT
from typer.testing import CliRunner

import einschalt as es
from einschalt.interfaces.cli.main import app

# sizes and addresses of large computers, as they are tried here
SMALLER = {
    "--repeat 2000": "--repeat 2",
    "--repeat 20 ": "--repeat 2 ",
    "--repeat 20\n": "--repeat 2\n",
    'Experiment("neukirchen"), 20,': 'Experiment("demo"), 2,',
    "--nworkers 8": "--nworkers 1",
}
ADDRESS, PORT = "10.0.0.5", "8786"  # the scheduler listens there without being told
ANSWERS = "EPSG:31255\n\n\n"  # the suggested sizes of errors
# targets of the Makefile that .ci/run does not call, and why not
OTHER_TARGETS = {
    "screenshots": "pictures to be looked at",
    "format": "changes the sources; `make lint` says whether it would",
}
FINLAND = ROOT / "data_examples" / "fi_ykj_tm35fin"


def fill(cupboard):
    """Write what the pages name: blocks, results, tables, an area, two frames."""
    block = es.simulate_block("demo", seed=1)
    block.write(cupboard / "BLOCK")
    for name in ("north", "south"):
        shutil.copytree(cupboard / "BLOCK", cupboard / "BLOCKS" / name)
    es.densify(block).write(cupboard / "out")
    shutil.copytree(cupboard / "out", cupboard / "RESULT")
    for flight in ("high", "low"):
        table = cupboard / "BLOCK" / f"{flight}_flight.csv"
        shutil.copy(table, cupboard / f"{flight}.csv")
    for file in (DOCS / "tutorials" / "files").iterdir():
        shutil.copy(file, cupboard)
    _control(cupboard)
    meta, table = pyogrio.read_arrow(cupboard / "area.geojson")
    _write_map(cupboard / "area.gpkg", table, meta, "Polygon")
    for name in ("model_points.csv", "ground_points.csv"):
        shutil.copy(FINLAND / name, cupboard)
    old = pd.read_csv(FINLAND / "model_points.csv")
    _two_frames(cupboard, old, pd.read_csv(FINLAND / "ground_points.csv"))
    (cupboard / "in zone 3").mkdir()
    _two_frames(cupboard / "in zone 3", *_frames_in_zone_3())
    _orientations(cupboard)


def _control(cupboard):
    """Control in a workbook, under two names, and on a map."""
    file = cupboard / "BLOCK" / "control_points.csv"
    control = pd.read_csv(file, dtype=str)
    for name in ("points.xlsx", "control.xlsx", "Punkte.xlsx"):
        control.to_excel(cupboard / name, index=False, engine="xlsxwriter")
    options = {"X_POSSIBLE_NAMES": "easting", "Y_POSSIBLE_NAMES": "northing"}
    meta, table = pyogrio.read_arrow(file, **options)
    meta = {**meta, "crs": "EPSG:31255"}
    _write_map(cupboard / "control.gpkg", table, meta, "Point")


def _write_map(file, table, meta, geometry_type):
    pyogrio.write_arrow(
        table,
        file,
        crs=meta["crs"],
        geometry_type=geometry_type,
        geometry_name=meta["geometry_name"] or "wkb_geometry",
    )


def _two_frames(folder, old, new):
    """Identical points in an old frame and a new one, and more in the old one."""
    plan = old[["point_id", "x", "y"]]
    more = plan.head(20).assign(point_id="M" + plan["point_id"].head(20))
    tables = {"old": plan, "new": new, "more_points": more, "parcels": more}
    for name, table in tables.items():
        table.to_csv(folder / f"{name}.csv", index=False)


def _frames_in_zone_3():
    """Where EPSG:31467 holds; neighbours are shifted alike."""
    sizes = {"extent": 5e4, "reach": 1e4, "signal": 0.2, "noise": 0.02}
    xy, shifts, _ = simulated_shifts(np.random.default_rng(1), 300, **sizes)
    xy += [3.45e6, 5.35e6]
    names = pd.DataFrame({"point_id": [f"Z{k}" for k in range(len(xy))]})
    new = xy + shifts
    return names.assign(x=xy[:, 0], y=xy[:, 1]), names.assign(
        easting=new[:, 0], northing=new[:, 1]
    )


def _orientations(cupboard):
    """A pair of photographs, as parallaxes and as coordinates, and its terrain."""
    rng = np.random.default_rng(1)
    base, depth, distance = 92.0, 152.0, 153.0
    x, side = np.array([(x, s) for s in (0.0, 1.0, -1.0) for x in (0.0, base)]).T
    six = pd.DataFrame({"point_id": list("123456"), "x": x, "y": 100.0 * side})
    parallaxes = rng.normal(scale=0.005, size=6)
    six = six.assign(model_id="7/8", z=-depth, y_parallax=parallaxes)
    six.to_csv(cupboard / "y_parallaxes.csv", index=False)
    xyz = rng.uniform([0, -95, -165], [base, 95, -140], size=(20, 3))
    rays = (xyz, xyz - [base, 0.0, 0.0])
    image = np.hstack([-distance * ray[:, :2] / ray[:, 2:] for ray in rays])
    image += rng.normal(scale=0.005, size=image.shape)
    columns = ["x_left", "y_left", "x_right", "y_right"]
    pairs = pd.DataFrame(image, columns=columns)
    pairs = pairs.assign(model_id="7/8", point_id=np.arange(20).astype(str))
    pairs.to_csv(cupboard / "image_pairs.csv", index=False)
    (heights,) = re.findall(r"```csv\n(.*?)```", PAGES["planning"], re.DOTALL)
    (cupboard / "heights.csv").write_text(heights, "utf-8")


def _of_colmap(folder):
    folder.mkdir(parents=True)
    colmap = {"cameras": CAMERAS, "images": IMAGES, "points3D": POINTS_3D}
    for name, text in colmap.items():
        (folder / f"{name}.txt").write_text(text, "utf-8")


def _fit(output, *more):
    old, new = FINLAND / "model_points.csv", FINLAND / "ground_points.csv"
    call("transform", old, new, "--kind", "helmert", "--output", output, *more)


def _published(output):
    _fit(output, "--publish", "OLD", "--crs", "EPSG:3067")
    return output / "OLD"


# folders within others, made when a command first names them
INNER = {
    "sparse/0": lambda _, f: _of_colmap(f),
    "out/neukirchen": lambda cupboard, f: shutil.copytree(cupboard / "RESULT", f),
    "out/plan": lambda _, f: call(
        *("plan", "--camera", "ultracam_eagle", "--expect", "--scale-number", "25000"),
        *("--spacing", "300", "--width", "5000", "--height", "5000", "--output", f),
    ),
    "out/old_to_new": lambda _, f: _fit(f),
    "out/OLD": lambda _, f: shutil.move(_published(f.parent / "fit"), f),
}


def lay_out(cupboard, desk, code):
    """Copy what is in the cupboard to the desk, without what the code makes."""

    def is_made(name):
        makes = (
            rf"(init|--output|--to( \S+)*) {re.escape(name)}(?!\S)"
            rf'|publish\(.*"{re.escape(name)}"'
        )
        return re.search(makes, code) and f"--from {name}" not in code

    for one in cupboard.iterdir():
        if one.name not in {"inner", "in zone 3"} and not is_made(one.name):
            copy = shutil.copytree if one.is_dir() else shutil.copy
            copy(one, desk / one.name)
    if "| grep low_flight.csv" in code:  # who looks for problems has some
        table = desk / "BLOCK" / "low_flight.csv"
        table.write_text(table.read_text("utf-8").replace(".", ".x", 1), "utf-8")
    if "EPSG:31467" in code:
        shutil.copytree(cupboard / "in zone 3", desk, dirs_exist_ok=True)
    for name, make in INNER.items():
        if re.search(rf"(?<![\w/]){name}(?![\w-])", code) and not is_made(name):
            kept = cupboard / "inner" / name
            if not kept.exists():
                make(cupboard, kept)
            shutil.copytree(kept, desk / name)


def call(*words, **options):
    """Run a command of the program, which succeeds."""
    shown = CliRunner().invoke(app, [str(word) for word in words], **options)
    assert shown.exit_code == 0, f"{words}\n{shown.output}"
    return shown.stdout


def free_port():
    """A port of these tests alone: others run at the same time."""
    with socket.socket() as asked:
        asked.bind(("127.0.0.1", 0))
        return asked.getsockname()[1]


def lines_of(code, port):
    """Commands of a block, small enough for this computer, and on it alone."""
    text = code.replace("\\\n", " ") + "\n"
    here = {
        f"--host {ADDRESS}": f"--host 127.0.0.1 --port {port}",
        f"{ADDRESS}:{PORT}": f"127.0.0.1:{port}",
        "--port 8417": f"--port {port}",
    }
    for large, small in {**SMALLER, **here}.items():
        text = text.replace(large, small)
    return [line for line in text.splitlines() if line.partition("#")[0].strip()]


def run(line, starting):
    """Run one command as it is written."""
    line, file = redirected(line)
    line, _, filtering = (part.strip() for part in line.partition(" | "))
    program, *words = shlex.split(line, comments=True)
    if program == "make":
        assert words[0] in of_ci() | set(OTHER_TARGETS), line
    elif program == "pip":
        assert_installed_in_ci(words)
    elif program == "dask" or words[0] == "serve":
        starting(program, words)
    else:
        assert program == "einschalt", line
        shown = CliRunner().invoke(app, words, input=ANSWERS)
        # of a pipe the last program says how it went
        assert shown.exit_code == 0 or filtering, f"{line}\n{shown.output}"
        assert shown.stdout or "--quiet" in words, line
        if file:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(shown.stdout, "utf-8")
        if filtering.startswith("grep "):
            assert filtering.split()[1] in shown.stdout


def redirected(line):
    """A command without ``> file``, and the file, whose ~ is the desk."""
    command, _, file = re.sub(r" >>? ", "\0", line).partition("\0")
    return command, Path(file.replace("~", ".")) if file else None


def of_ci():
    """Targets of the Makefile that the one check calls."""
    called = (ROOT / ".ci" / "run").read_text("utf-8")
    return set(re.findall(r"^make (\S+)", called, re.MULTILINE))


def assert_installed_in_ci(words):
    """The extra is one of those that ``make test`` installs, in the same form."""
    assert words[0] == "install"
    (extra,) = re.findall(r"^\.\[(\w+)\]$", words[1]) or [None]
    described = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    installed = described["project"]["optional-dependencies"]["test"]
    assert words[1] == "." or f"einschalt[{extra}]" in installed, words


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
