"""``einschalt plan``."""

import resource
import typing

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.interfaces.cli.plan import CameraName, Edge, Kind
from einschalt.pipeline.camera_presets import CAMERAS
from einschalt.theory.planned_leverage import KINDS
from einschalt.theory.precision_planning import EDGES


def test_choices_are_those_of_planning():
    assert typing.get_args(Kind) == KINDS
    assert typing.get_args(Edge) == EDGES
    assert typing.get_args(CameraName) == tuple(CAMERAS)


def test_without_arguments_it_gives_the_tables_of_1971(invoke, golden):
    shown = invoke("plan")
    assert shown.exit_code == 0
    golden(shown.stdout, "plan_1971.txt")


def test_defaults_take_less_than_a_second(spawn):
    def seconds():
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        assert spawn("plan").returncode == 0
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    # time of the processor: what else the machine does is no fault of the command
    assert min(seconds() for _ in range(3)) < 1.0


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_the_table_is_written(suffix, invoke, tmp_path):
    file = tmp_path / f"plan.{suffix}"
    shown = invoke(
        *("plan", "--scale", "6000:8000:1000", "--scale", "12000", "--m-0", "0.1"),
        *("--spacing", "200,300", "--m-g-um", 5, "--output", file),
    )
    assert shown.exit_code == 0, shown.stderr
    read = pd.read_csv(file) if suffix == "csv" else pd.read_parquet(file)
    table = es.plan_precision([6000, 7000, 8000, 12000], [200, 300], 0.1, 5)
    assert list(read) == list(table)
    np.testing.assert_allclose(read, table, rtol=1e-15)


def test_camera_and_what_replaces_it(invoke, tmp_path):
    file = tmp_path / "plan.csv"
    invoke("plan", "--camera", "dmc_3", "--output", file)
    assert pd.read_csv(file)["flying_height"][0] == pytest.approx(15000 * 0.092)
    options = ("--image-format", "50x100", "--principal-distance", "120")
    invoke("plan", "--camera", "dmc_3", *options, "--edge", "corner", "--output", file)
    row = pd.read_csv(file).iloc[0]
    assert row["flying_height"] == pytest.approx(15000 * 0.12)
    assert row["n_points"] == pytest.approx(0.6 * 0.05 * 0.1 * (15000 / 200) ** 2)


def test_long_tables_are_cut_in_the_text_only(invoke, tmp_path):
    file = tmp_path / "plan.csv"
    shown = invoke(
        *("plan", "--scale", "6000:15000:500", "--spacing", "100:300:10"),
        *("--m-0", "0.1:0.2:0.01", "--output", file),
    )
    assert "and 11 scales and 11 spacings more" in shown.stdout
    assert "and 3 such tables more" in shown.stdout
    assert len(pd.read_csv(file)) == 19 * 21 * 11 * 2


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--scale-number", "-8000", "Give the denominator: 8000 for 1:8000"),
        ("--scale-number", "0", "scale_number = 0"),
        ("--spacing", "3000", "spacing = 3000 m is larger than a model at 1:6000"),
        ("--m-0", "10", "10 cm are 0.10"),
        ("--m-0", "ten", "--m-0 'ten'; expected numbers as 6000,8000"),
        ("--m-0", "0.1:0.2", "first:last:step"),
        ("--m-0", "0.2:0.1:0.01", "with a step above 0, upwards"),
        ("--m-0", "0.1:0.2:1e-9", "100000000 values; expected at most 1000000"),
        ("--m-g-um", "0.00001", "Did you give metres or millimetres?"),
        ("--forward-overlap", "1", "forward_overlap = 1"),
        ("--side-overlap", "30", "Did you give per cent?"),
        ("--image-format", "0.23", "--image-format = 0.23; expected 2 to 1000 mill"),
        ("--image-format", "1x2x", "--image-format ''"),
        ("--principal-distance", "0.152", "Did you give metres?"),
        ("--output", "plan.doc", "suffix '.doc' is unknown"),
    ],
)
def test_nonsense_is_refused_with_the_remedy(option, value, says, invoke):
    shown = invoke("plan", option, value)
    assert shown.exit_code == 2
    assert says in " ".join(shown.stderr.split())
    assert "Traceback" not in shown.stderr
