"""``einschalt simulate``."""

import json
import typing

import numpy as np
import pandas as pd
import pytest

from einschalt.interfaces.cli.simulate import Measurement, PresetName, Transformation
from einschalt.pipeline.block.facts import TRANSFORMATIONS
from einschalt.pipeline.simulation.simulate_block import PRESETS

DEMO = ("simulate", "--preset", "demo", "--output")


def test_choices_are_those_of_the_simulation():
    assert typing.get_args(PresetName) == tuple(PRESETS)
    assert typing.get_args(Transformation) == TRANSFORMATIONS
    assert typing.get_args(Measurement) == ("machine", "parallaxes", "images")


def test_a_block_and_its_truth_are_written(invoke, tmp_path):
    shown = invoke(*DEMO, tmp_path)
    assert shown.exit_code == 0
    assert "Demo (simulated): 100 points, seed 0" in shown.stdout
    truth = pd.read_csv(tmp_path / "truth.csv")
    assert list(truth) == ["point_id", "easting", "northing"]
    assert len(truth) == 100
    assert invoke("check", tmp_path).exit_code == 0


def test_the_seed_gives_the_block(invoke, tmp_path):
    folders = [tmp_path / name for name in "abc"]
    for folder, seed in zip(folders, (5, 5, 6), strict=True):
        invoke(*DEMO, folder, "--seed", seed)
    first, again, other = [(f / "low_flight.csv").read_bytes() for f in folders]
    assert first == again
    assert first != other


@pytest.mark.parametrize(
    ("option", "value", "file", "text"),
    [
        ("--high-scale", "20000", "block.toml", "scale_number = 20000"),
        ("--low-scale-number", "10000", "block.toml", "scale_number = 10000"),
        ("--low-m-g-um", "6.5", "block.toml", "m_g_um = 6.5"),
        ("--transformation", "helmert", "block.toml", 'transformation = "helmert"'),
        ("--measurement", "parallaxes", "block.toml", "y_parallaxes"),
    ],
)
def test_options_reach_the_block(option, value, file, text, invoke, tmp_path):
    shown = invoke(*DEMO, tmp_path, option, value)
    assert shown.exit_code == 0
    assert text in (tmp_path / file).read_text(encoding="utf-8")


def test_noise_leaves_the_points_where_they_are(invoke, tmp_path):
    invoke(*DEMO, tmp_path / "a")
    options = ["--gross-errors", "0.05", "--film-affinity", "1e-4"]
    invoke(*DEMO, tmp_path / "b", *options, "--network-strain", "0.05")
    truth, low = (
        [(tmp_path / folder / name).read_bytes() for folder in "ab"]
        for name in ("truth.csv", "low_flight.csv")
    )
    assert truth[0] == truth[1]
    assert low[0] != low[1]


def test_spacing_and_check_points(invoke, tmp_path):
    invoke(*DEMO, tmp_path, "--point-spacing", "200", "--n-check", "9")
    assert len(pd.read_csv(tmp_path / "truth.csv")) == 225
    roles = pd.read_csv(tmp_path / "control_points.csv")["role"]
    assert (roles == "check").sum() == 9


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--gross-errors", "3", ": --gross-errors = 3; expected 0 to 0.5"),
        ("--seed", "-1", "seed = -1"),
        ("--side-overlap", "0", "Raise --side-overlap to 0.0"),
    ],
)
def test_values_out_of_range_are_said(option, value, says, invoke, tmp_path):
    shown = invoke(*DEMO, tmp_path, option, value)
    assert shown.exit_code == 2
    assert says in shown.stderr
    assert "Traceback" not in shown.stderr


@pytest.mark.slow
def test_repetitions_set_truth_against_claim(invoke, tmp_path):
    options = ["--preset", "demo", "--repeat", "2", "--workers", "1", "--seed", "3"]
    said = invoke("simulate", "--output", tmp_path / "out", *options)
    assert said.exit_code == 0
    assert said.stdout.startswith(
        "2 repetitions, new points (total, RMS)\n  true error"
    )
    text = (tmp_path / "out" / "repetitions.csv").read_text(encoding="utf-8")
    assert [line.split(",")[0] for line in text.splitlines()] == ["seed", "3", "4"]


@pytest.mark.usefixtures("in_this_process")
def test_programs_are_told_what_repetitions_come_to(invoke, tmp_path):
    options = ["--preset", "demo", "--repeat", "2", "--workers", "1", "--seed", "3"]
    told = invoke("simulate", "--output", tmp_path / "out", *options, "--json")
    figures = json.loads(told.stdout)["figures"]
    table = pd.read_csv(tmp_path / "out" / "repetitions.csv")
    expected = np.sqrt(np.mean(table["error_total"] ** 2))
    assert figures["error_total"] == pytest.approx(expected, rel=1e-6)
    assert 0.8 < figures["share_in_ellipses"] <= 1.0
