"""Control of another datum, by command: refused, allowed or through a grid, by name."""

import os
import re
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer

import pandas as pd
import pyproj
import pytest
from tests.moved_block import moved_block
from tests.ntv2_grids import write_ntv2

from einschalt.interfaces.files import result_folder

pytestmark = pytest.mark.slow

AUSTRIA = "at_bev_AT_GIS_GRID_2021_09_28.tif"
# systems of control and block, place, grid, accuracy without it and with it [m]
PAIRS = {
    "Salzburg": ("EPSG:31255", "EPSG:25833", (13.5, 47.3), AUSTRIA, 1.5, 0.14),
    "Frankfurt": (
        *("EPSG:31467", "EPSG:25832", (9.0, 50.0)),
        *("de_hvbg_hessen_HeTA2010.tif", 1.0, 0.1),
    ),
    "Lucerne": (
        *("EPSG:21781", "EPSG:25832", (8.0, 47.0)),
        *("ch_swisstopo_CHENyx06_ETRS.tif", 1.5, 0.25),
    ),
    "Graz": ("EPSG:25833", "EPSG:31256", (15.5, 47.2), AUSTRIA, 1.0, 0.14),
}
SHARED = "standard_error_reference_system"


@pytest.fixture
def run(invoke, small_block, tmp_path, monkeypatch):
    """Run both commands on the small block: exit codes and what is said."""
    monkeypatch.setattr(result_folder, "render", lambda _: "no report")

    def both(*options):
        output = ("--output", tmp_path / "out", "--overwrite")
        checked = invoke("check", small_block.path, *options)
        densified = invoke("densify", small_block.path, *output, *options)
        return [(one.exit_code, one.output) for one in (checked, densified)]

    return both


def results(tmp_path, table="points"):
    return pd.read_csv(tmp_path / "out" / f"{table}.csv")


def label(code):
    return f"{pyproj.CRS(code).name} ({code})"


@pytest.mark.parametrize("pair", PAIRS)
def test_metres_are_refused_allowed_or_made_better_by_a_grid(
    pair, run, small_block, tmp_path
):
    own, crs, place, grid, coarse, fine = PAIRS[pair]
    moved_block(small_block, crs, place, own)
    for code, said in run():
        assert code == 2
        assert f"{label(own)} to {label(crs)}: no operation is good enough" in said
        assert f": {fine:g} m, needs {grid}, which is missing" in said
        assert re.search(rf": {coarse:g} m(;|\. )", said)
        assert f"Get {grid} from https://cdn.proj.org/{grid}" in said
    assert not (tmp_path / "out").exists()

    (code, said), (done, _) = run("--crs-accuracy-m", 2)
    assert (code, done) == (0, 0)
    assert f"from {label(own)} to {label(crs)} by " in said
    assert f"({coarse:g} m); better would be " in said
    points = results(tmp_path)
    # 1.5 m, and the few centimetres of everything else
    assert points["standard_error_total"].between(coarse, coarse + 0.05).all()
    sources = results(tmp_path, "error_sources")
    assert sources[SHARED].tolist() == pytest.approx([coarse] * len(points))

    write_ntv2(tmp_path / grid, -1.5, -3.5)
    better = ("--crs-accuracy-m", fine, "--grids", tmp_path)
    (code, said), (done, _) = run(*better)
    assert (code, done) == (0, 0)
    assert f"({fine:g} m) with {grid}" in said
    assert results(tmp_path)["standard_error_total"].between(fine, fine + 0.05).all()
    provenance = (tmp_path / "out" / "provenance.json").read_text("utf-8")
    assert f'"{grid}"' in provenance


def test_grids_of_the_command_are_looked_for_from_where_the_user_stands(
    invoke, small_block, tmp_path, monkeypatch
):
    own, crs, place, *_ = PAIRS["Salzburg"]
    moved_block(small_block, crs, place, own)
    nowhere = invoke("check", small_block.path, "--grids", tmp_path / "nowhere")
    assert nowhere.exit_code == 2
    assert "is no folder" in nowhere.stdout
    (tmp_path / "mine").mkdir()
    monkeypatch.chdir(tmp_path)
    assert "is missing" in invoke("check", small_block.path, "--grids", "mine").stdout


class Server(HTTPServer):
    """Counts who asks, and has nothing to give."""

    asked = 0


class Nothing(BaseHTTPRequestHandler):
    def do_GET(self):
        self.server.asked += 1
        self.send_error(404)

    def log_message(self, *_):
        """Say nothing."""


ASKS = """
import sys
import pyproj
from typer.testing import CliRunner
from einschalt.interfaces.cli.main import app
folder, own, crs = sys.argv[1:]
assert pyproj.network.is_network_enabled()
strict = ["densify", folder, "--output", folder + "/out"]
for command, code in (
    (strict, 2), (["check", folder], 2), (["check", folder, "--crs-accuracy-m", "2"], 0)
):
    assert CliRunner().invoke(app, command).exit_code == code
print("done", flush=True)
sys.stdin.readline()
pyproj.Transformer.from_crs(own, crs, always_xy=True).transform(13e3, 240e3)
"""


@pytest.fixture
def server():
    """A network of one computer."""
    with Server(("127.0.0.1", 0), Nothing) as one:
        threading.Thread(target=one.serve_forever, daemon=True).start()
        yield one
        one.shutdown()


def test_nobody_asks_the_network_even_where_proj_is_told_to(small_block, server):
    own, crs, place, *_ = PAIRS["Salzburg"]
    moved_block(small_block, crs, place, own)
    told = {"PROJ_NETWORK": "ON"}
    told["PROJ_NETWORK_ENDPOINT"] = f"http://127.0.0.1:{server.server_port}"
    # pyproj reads the environment once, when it is imported
    asked = subprocess.Popen(
        [sys.executable, "-c", ASKS, small_block.path, own, crs],
        env={**os.environ, **told},
        stdout=subprocess.PIPE,
        stdin=subprocess.PIPE,
        text=True,
    )
    assert asked.stdout.readline() == "done\n"
    assert server.asked == 0
    # the same two systems, with nobody who forbids it: the server would have been asked
    asked.communicate("now\n")
    assert asked.returncode == 0
    assert server.asked > 0
