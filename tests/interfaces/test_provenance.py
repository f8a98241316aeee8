"""Where a result comes from, and nothing of the computer it was made on."""

import getpass
import json
import platform
import re
from dataclasses import replace
from importlib import metadata

import numpy as np
import pandas as pd
import pyproj
import pytest
import scipy
from tests.changed_results import changed

from einschalt.interfaces.files.block_folder import read_block
from einschalt.interfaces.provenance import provenance
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.theory.interior_orientation import Camera


@pytest.fixture
def small_result(small_block):
    return densify(read_block(small_block.path))


def test_versions_are_those_that_ran(good_result):
    origin = provenance(good_result)
    assert origin["version"] == metadata.version("einschalt")
    expected = {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "pandas": pd.__version__,
        "pyproj": pyproj.__version__,
        "PROJ": pyproj.proj_version_str,
    }
    assert origin["versions"].items() >= expected.items()


def test_facts_of_block_and_flights(small_result):
    origin = provenance(small_result)
    assert origin["block"]["name"] == "Nine points"
    assert origin["block"]["crs"] == "EPSG:31255"
    assert origin["flights"]["low_flight"] == {
        "scale_number": 8000,
        "m_g_um": 5.0,
        "transformation": "affine",
        "model_unit": "mm",
    }
    assert origin["settings"] == Settings().model_dump(mode="json")


def test_inputs_bear_their_checksums(small_result):
    checksums = small_result.block.checksums
    assert provenance(small_result)["inputs"] == [
        {"table": table, "file": file, "sha256": checksums[file]}
        for table, file in small_result.block.sources.items()
    ]
    assert all(re.fullmatch(r"[0-9a-f]{64}", digest) for digest in checksums.values())


def test_block_of_a_script_has_no_inputs(good_result):
    assert provenance(good_result)["inputs"] == []


@pytest.mark.slow
def test_a_camera_is_told_by_its_constants(good_result):
    """A block with a camera could be computed, but its results not be written."""
    camera = Camera.from_metashape(
        6150.0, (6000, 4000), distortion={"k1": -0.04}, pixel_size_um=3.9
    )
    block = good_result.block
    flight = replace(block.low_flight, camera=camera)
    other = changed(good_result, block=replace(block, low_flight=flight))
    told = json.loads(json.dumps(provenance(other)))["flights"]["low_flight"]["camera"]
    assert told["convention"] == "metashape"
    assert (told["f"], told["k1"], told["width"]) == (6150.0, -0.04, 6000)


def test_time_is_utc(good_result):
    created = provenance(good_result)["created"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}\+00:00", created)


@pytest.mark.slow
def test_numbers_of_numpy_become_json(good_result):
    block = good_result.block
    flight = replace(
        block.low_flight, m_g_um=np.float64(5.0), scale_number=np.int64(8000)
    )
    block = replace(block, low_flight=flight)
    json.dumps(provenance(changed(good_result, block=block)), allow_nan=False)


@pytest.mark.slow
def test_nothing_tells_of_the_computer(small_block, tmp_path):
    """Files named by absolute paths are told by their name alone, in notes as well."""
    absolute = tmp_path / "elsewhere" / "control_points.csv"
    absolute.parent.mkdir()
    text = small_block.read("control_points.csv")
    absolute.write_text(text.replace("\n", ",\n").replace("g,\n", "g,remark\n"))
    small_block.replace(
        "block.toml", '"control_points.csv"', f'"{absolute.as_posix()}"'
    )
    small_block.replace(
        "block.toml", '"low_flight.csv"', '"../nine_points/low_flight.csv"'
    )
    result = densify(read_block(small_block.path))
    origin = provenance(result)
    said = json.dumps(origin)
    files = {entry["table"]: entry["file"] for entry in origin["inputs"]}
    assert files["control_points"] == "control_points.csv"
    assert files["low_flight.model_points"] == "../nine_points/low_flight.csv"
    assert origin["block"]["notes"] == ["control_points.csv: ignored column remark"]
    assert str(tmp_path) not in said
    assert platform.node() not in said
    assert f"/{getpass.getuser()}" not in said


def test_windows_paths_are_shortened(good_result):
    path = r"C:\Users\someone\control_points.csv"
    block = replace(good_result.block, sources={"control_points": path})
    (entry,) = provenance(changed(good_result, block=block))["inputs"]
    assert entry == {
        "table": "control_points",
        "file": "control_points.csv",
        "sha256": None,
    }


def test_figures_are_those_of_the_result(good_result):
    origin = provenance(good_result)
    assert origin["seconds"] == 0.5
    assert origin["figures"]["n_points"] == len(good_result.points)
    new = good_result.points[good_result.points["role"] == "new"]
    for kind in ("total", "paper", "internal"):
        squares = new[f"standard_error_{kind}"] ** 2
        figure = origin["figures"][f"mean_{kind}"]
        assert figure == pytest.approx(np.sqrt(squares.mean()), rel=1e-12)


def test_figures_that_are_not_known_are_null(given_approximations_result):
    figures = provenance(given_approximations_result)["figures"]
    assert figures["m_0_high"] is None
