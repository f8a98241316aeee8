"""Blocks as folders: there and back, reprojected, filled in, found faulty."""

import itertools
import os
import shutil
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyproj
import pytest

from einschalt.foundations.errors import (
    ChangedFileError,
    ConsistencyError,
    EinschaltError,
    FileError,
    ProjectionError,
)
from einschalt.foundations.tables import APPROXIMATE_POINTS
from einschalt.interfaces.files.block_folder import find_problems, read_block
from einschalt.interfaces.files.block_parts import POINT_TABLES
from einschalt.interfaces.files.block_writing import write_block
from einschalt.interfaces.files.csv_tables import read_csv
from einschalt.interfaces.files.input_files import checksum
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

CONTROL = "control_points.csv"
N_OPENED = 4  # how often a file is opened at most until it is read


def assert_same_table(one, other):
    if isinstance(one, pd.DataFrame):
        one, other = one.reset_index(drop=True), other.reset_index(drop=True)
        pd.testing.assert_frame_equal(one, other, check_exact=True)
    else:
        assert one == other


def assert_same_block(one, other):
    """Tables to the last digit; the rows of a file are counted otherwise."""
    for name in POINT_TABLES:
        assert_same_table(getattr(one, name), getattr(other, name))
    for name in ("crs", "name", "settings", "approximate_m_0_m", "may_be_unmeasured"):
        assert getattr(one, name) == getattr(other, name)
    assert one.flights.keys() == other.flights.keys()
    for flight, back in zip(one.flights.values(), other.flights.values(), strict=True):
        for key, value in vars(flight).items():
            assert_same_table(value, getattr(back, key))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("measurement", ["machine", "parallaxes", "images"])
def test_written_block_comes_back(tmp_path, measurement, suffix):
    geometry = replace(PRESETS["demo"].geometry, measurement=measurement)
    block = simulate_block("demo", seed=5, geometry=geometry)
    settings = Settings(coverage_mean="most_central")
    block = replace(block, settings=settings, may_be_unmeasured=True)
    write_block(block, tmp_path / "new" / "demo", suffix=suffix)
    back = read_block(tmp_path / "new" / "demo")
    assert_same_block(block, back)
    assert_same_block(back, read_block(tmp_path / "new" / "demo" / "block.toml"))
    assert back.notes == ()


def test_truth_of_a_simulated_block_is_written(tmp_path, demo_block):
    write_block(demo_block, tmp_path)
    truth = read_csv(tmp_path / "truth.csv", APPROXIMATE_POINTS)
    assert_same_table(demo_block.truth, truth)


def test_block_with_approximate_points_comes_back(
    tmp_path, given_approximations_result
):
    block = given_approximations_result.block
    write_block(block, tmp_path)
    back = read_block(tmp_path)
    assert_same_block(block, back)
    assert back.high_flight is None
    assert back.approximate_m_0_m == 0.09


def test_block_without_system_and_with_one_base(tmp_path, demo_block):
    geometry = replace(PRESETS["demo"].geometry, measurement="parallaxes")
    block = simulate_block("demo", seed=5, geometry=geometry)
    low = replace(block.low_flight, base=92.0)
    block = replace(block, low_flight=low, crs=None)
    write_block(block, tmp_path)
    back = read_block(tmp_path)
    assert back.crs is None
    assert back.low_flight.base == 92.0


def test_equal_blocks_are_equal_files(tmp_path, demo_block):
    for name in ("one", "two"):
        write_block(demo_block, tmp_path / name)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()


def test_kind_of_the_block_can_be_chosen(small_block):
    class OwnBlock(Block):
        pass

    assert type(read_block(small_block.path, kind=OwnBlock)) is OwnBlock


def test_sources_and_checksums_name_the_files(small_block):
    block = read_block(small_block.path)
    assert block.sources == {
        "block": "block.toml",
        "control_points": CONTROL,
        "high_flight.model_points": "high_flight.csv",
        "low_flight.model_points": "low_flight.csv",
    }
    assert block.checksums == {
        name: checksum(small_block.path / name) for name in block.sources.values()
    }


def test_name_of_the_folder_stands_in(small_block):
    small_block.replace("block.toml", 'name = "Nine points"\n', "")
    assert read_block(small_block.path).name == "nine_points"


def test_missing_standard_errors_are_filled_in(small_block):
    block = read_block(small_block.path)
    assert block.control_points["standard_error_m"].tolist() == [0.03] * 8
    small_block.replace("block.toml", "standard_error_m = 0.03\n", "")
    assert "standard_error_m" not in read_block(small_block.path).control_points


def test_one_error_of_all_beside_errors_of_the_axes_is_not_used(small_block):
    """It counted in two steps, and those of the axes in one adjustment."""
    header, *rows = small_block.read(CONTROL).splitlines()
    errors = "standard_error_easting,standard_error_northing"
    rows = [f"{row},0.02,0.02" for row in rows]
    small_block.write(CONTROL, "\n".join([f"{header},{errors}", *rows]) + "\n")
    block = read_block(small_block.path)
    np.testing.assert_allclose(block.control_points["standard_error_m"], 0.0283, 1e-2)
    (note,) = (note for note in block.notes if "of its own" in note)
    assert note.endswith("standard_error_m = 0.03 of block.toml is not used")


def test_column_of_standard_errors_is_kept(small_block):
    text = small_block.read(CONTROL).replace("\n", ",0.02\n")
    small_block.write(
        CONTROL, text.replace("northing,0.02", "northing,standard_error_m")
    )
    block = read_block(small_block.path)
    assert block.control_points["standard_error_m"].tolist() == [0.02] * 8


def in_other_system(block, crs):
    """Give the control points in another system than that of the block."""
    frame = pd.read_csv(block.path / CONTROL, dtype={"point_id": str})
    transformer = pyproj.Transformer.from_crs("EPSG:31255", crs, always_xy=True)
    plane = transformer.transform(frame["easting"], frame["northing"])
    frame["easting"], frame["northing"] = plane
    frame.to_csv(block.path / CONTROL, index=False)
    block.replace("block.toml", f'"{CONTROL}"', f'"{CONTROL}"\ncrs = "{crs}"')


def test_control_of_another_system_is_reprojected_and_said(small_block):
    plain = read_block(small_block.path).control_points
    in_other_system(small_block, "EPSG:31258")
    raw = pd.read_csv(small_block.path / CONTROL)
    assert raw["easting"].min() > 400_000  # M31 adds 450 km
    block = read_block(small_block.path)
    for axis in ("easting", "northing"):
        np.testing.assert_allclose(block.control_points[axis], plain[axis], atol=1e-6)
    assert block.control_points.index.tolist() == plain.index.tolist()
    (note,) = block.notes
    assert note == (
        "control_points.csv: 8 points transformed from MGI / Austria GK M31 "
        "(EPSG:31258) to MGI / Austria GK Central (EPSG:31255) by change of map "
        "projection (0 m)"
    )


def test_same_system_under_another_name_is_left_alone(small_block):
    small_block.replace(
        "block.toml", f'"{CONTROL}"', f'"{CONTROL}"\ncrs = "epsg:31255"'
    )
    assert read_block(small_block.path).notes == ()


def test_axes_are_compared_in_the_system_of_the_file(small_block):
    in_other_system(small_block, "EPSG:31258")
    small_block.replace(CONTROL, "easting,northing", "northing,easting")
    problems = find_problems(small_block.path).problems
    assert {type(problem) for problem in problems} == {ConsistencyError}
    assert "outside the area of MGI / Austria GK M31 (EPSG:31258)" in problems[0].found
    assert (problems[0].row, problems[0].point) == (2, "0012")


def test_unknown_system_of_the_control_points(small_block):
    small_block.replace("block.toml", f'"{CONTROL}"', f'"{CONTROL}"\ncrs = "EPSG:foo"')
    with pytest.raises(ProjectionError, match=r"row 7: \[control_points\] crs = 'EPSG"):
        read_block(small_block.path)


def test_system_of_the_block_is_needed_to_reproject(small_block):
    small_block.replace("block.toml", 'crs = "EPSG:31255"\n', "")
    small_block.replace(
        "block.toml", f'"{CONTROL}"', f'"{CONTROL}"\ncrs = "EPSG:31258"'
    )
    with pytest.raises(EinschaltError, match=r"\[block\] crs is missing.*Add crs = …"):
        read_block(small_block.path)


def test_tables_may_lie_elsewhere(small_block, tmp_path):
    common = tmp_path / "common"
    common.mkdir()
    (small_block.path / CONTROL).rename(common / CONTROL)
    small_block.replace("block.toml", f'"{CONTROL}"', f'"../common/{CONTROL}"')
    assert read_block(small_block.path).source("control_points") == (
        f"../common/{CONTROL}"
    )
    absolute = (common / CONTROL).as_posix()
    small_block.replace("block.toml", f'"../common/{CONTROL}"', f'"{absolute}"')
    assert len(read_block(small_block.path).control_points) == 8


def test_points_may_be_unmeasured(small_block):
    text = small_block.read(CONTROL)
    # which looks like PP1, a measured point without coordinates
    small_block.write(CONTROL, text + "pp-1,13000.00,322100.00\n")
    with pytest.raises(ConsistencyError, match="row 10, point pp-1: no model of the"):
        read_block(small_block.path)
    small_block.replace(
        "block.toml", f'"{CONTROL}"', f'"{CONTROL}"\nmay_be_unmeasured = true'
    )
    assert read_block(small_block.path).may_be_unmeasured


def test_empty_file_name_is_a_fault_of_block_toml(small_block):
    small_block.replace("block.toml", f'"{CONTROL}"', '""')
    with pytest.raises(
        FileError, match=r"block.toml, row 6: \[control_points\] file is"
    ):
        read_block(small_block.path)


def test_missing_table_brings_no_further_complaint(small_block):
    """A missing file is not said to be a missing section as well."""
    for name in (CONTROL, "high_flight.csv", "low_flight.csv"):
        (small_block.path / name).unlink()
    problems = find_problems(small_block.path).problems
    assert [problem.file for problem in problems] == [
        CONTROL,
        "high_flight.csv",
        "low_flight.csv",
    ]


def test_findings_keep_the_notes_of_a_block_with_faults(small_block):
    small_block.write("low_flight.csv", small_block.read("low_flight.csv") + "1,1\n")
    text = small_block.read(CONTROL).replace("\n", ",\n").replace("g,\n", "g,remark\n")
    small_block.write(CONTROL, text)
    found = find_problems(small_block.path)
    assert found.block is None
    assert len(found.problems) == 1
    assert found.notes == ("control_points.csv: ignored column remark",)


def test_folder_that_cannot_be_made(tmp_path, demo_block):
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="cannot be written"):
        write_block(demo_block, tmp_path / "file")


CHANGES = {
    "a row more": lambda path: path.write_bytes(path.read_bytes() + b"\n"),
    "half of it": lambda path: path.write_bytes(path.read_bytes()[:100]),
    "gone": lambda path: path.unlink(),
    "another file": lambda path: (path.unlink(), path.write_text("another")),
}


@pytest.fixture
def meanwhile(monkeypatch):
    """Let another program have a file as soon as its bytes are in our hands."""

    def change(name, how, *, honest=Path.read_bytes):
        seen = []

        def read_and_change(path):
            data = honest(path)
            if path.name == name and not seen:
                seen.append(path)
                how(path)
            return data

        monkeypatch.setattr(Path, "read_bytes", read_and_change)
        return seen

    return change


@pytest.mark.parametrize("name", ["low_flight.csv", "control_points.csv", "block.toml"])
@pytest.mark.parametrize("how", CHANGES.values(), ids=CHANGES)
def test_file_that_changes_while_it_is_read(small_block, meanwhile, name, how):
    seen = meanwhile(name, how)
    said = rf"{name}: the file changed while it was read.*Run it again when the other"
    with pytest.raises(ChangedFileError, match=said):
        read_block(small_block.path)
    assert seen


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_half_a_table_is_a_change_and_no_fault(small_block, monkeypatch, suffix):
    """What reads like a truncated table was one only while it was being copied."""
    name = f"low_flight.{suffix}"
    small_block.replace("block.toml", "low_flight.csv", name)
    path = small_block.path / name
    if suffix == "parquet":
        pd.read_csv(path.with_suffix(".csv"), dtype={"model_id": str}).to_parquet(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    honest = Path.read_bytes

    def read_while_it_is_copied(file):
        data = honest(file)
        if file == path:
            path.write_bytes(whole)
        return data

    monkeypatch.setattr(Path, "read_bytes", read_while_it_is_copied)
    with pytest.raises(ChangedFileError, match="the file changed while it was read"):
        read_block(small_block.path)
    monkeypatch.undo()
    assert len(read_block(small_block.path).low_flight.model_points) == 24


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_the_checksum_is_that_of_the_bytes_that_were_understood(
    small_block, monkeypatch, suffix
):
    """Also where the file is another one for a moment, and then as it was before.

    Two checksums, before and after the reading, cannot see that. Every order in which
    two versions of the file can be met is tried.
    """
    name = f"low_flight.{suffix}"
    path = small_block.path / name
    table = pd.read_csv(small_block.path / "low_flight.csv", dtype=str)
    table = table.astype({"x": float, "y": float})
    small_block.replace("block.toml", "low_flight.csv", name)
    first_x = {}
    for number in (0.0, 1.0):
        moved = table.assign(x=table["x"] + number)
        file = path.with_name(f"{number:g}.{suffix}")
        moved.to_csv(file, index=False) if suffix == "csv" else moved.to_parquet(file)
        first_x[checksum(file)] = moved["x"].iloc[0]
    honest = Path.open
    n_read = 0
    for order in itertools.product("01", repeat=N_OPENED):
        turns = iter(order)

        def open_one_or_the_other(file, *args, turns=turns, **options):
            if file == path:
                turn = next(turns, "0")
                shutil.copyfile(path.with_name(f"{turn}{path.suffix}"), path)
            return honest(file, *args, **options)

        shutil.copyfile(path.with_name(f"0{path.suffix}"), path)
        monkeypatch.setattr(Path, "open", open_one_or_the_other)
        with suppress(ChangedFileError):
            block = read_block(small_block.path)
            signed = first_x[block.checksums[name]]
            assert block.low_flight.model_points["x"].iloc[0] == signed, order
            n_read += 1
    assert n_read > 0


@pytest.mark.parametrize("taken", ["block.toml", "low_flight.csv", "truth.csv"])
def test_a_block_that_stands_there_is_not_overwritten_unasked(
    taken, tmp_path, demo_block
):
    (tmp_path / taken).write_text("mine", encoding="utf-8")
    said = rf"holds {taken} already; expected a new folder for the block\. Name another"
    with pytest.raises(FileError, match=said):
        write_block(demo_block, tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == [taken]
    write_block(demo_block, tmp_path, overwrite=True)
    assert read_block(tmp_path).name == demo_block.name


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/stdin", "pipe.csv"])
def test_devices_and_pipes_are_no_tables(device, small_block):
    os.mkfifo(small_block.path / "pipe.csv")
    small_block.replace("block.toml", "low_flight.csv", device)
    with pytest.raises(
        FileError, match=r"is a device or a pipe; expected a file|no such"
    ):
        read_block(small_block.path)


@pytest.mark.parametrize("unit", ["cm", "m", "um"])
def test_a_wrong_number_is_said_in_the_unit_of_the_flight(unit, small_block):
    words = {"cm": "centimetres", "m": "metres", "um": "micrometres"}
    low = small_block.read("low_flight.csv")
    small_block.write("low_flight.csv", low.replace(",10.0000,", ",n/a,", 1))
    small_block.replace(
        "block.toml", "m_g_um = 5.0", f'm_g_um = 5.0\nmodel_unit = "{unit}"'
    )
    with pytest.raises(
        EinschaltError, match=f"'n/a' is not a number; expected {words[unit]}"
    ):
        read_block(small_block.path)


@pytest.mark.parametrize("tolerance", ["vermv_2010", 0.035, 1.0])
def test_the_tolerance_comes_back(demo_block, tmp_path, tolerance):
    settings = Settings(tolerance=tolerance)
    write_block(replace(demo_block, settings=settings), tmp_path / "block")
    assert read_block(tmp_path / "block").settings == settings


@pytest.mark.parametrize(
    ("name", "value"),
    [("grids", "mine"), ("crs_operation", "EPSG:1619"), ("crs_epoch", 2020.0)],
)
def test_a_way_that_no_points_take_is_told(tmp_path, name, value):
    write_block(simulate_block("demo"), tmp_path)
    (tmp_path / "mine").mkdir()
    (note,) = read_block(tmp_path, {name: value}).notes
    assert note.startswith(f"{name} = {value} is not used: no points come from another")
    assert read_block(tmp_path, {"crs_accuracy_m": 1.0}).notes == ()
    to_other = {"output_crs": "EPSG:31256", name: value}
    assert read_block(tmp_path, to_other).notes == ()


@pytest.mark.parametrize("name", ["nowhere", "block.toml"])
@pytest.mark.parametrize("more", [{}, {"output_crs": "EPSG:31256"}])
def test_grids_that_are_not_there_are_refused_also_where_none_is_needed(
    tmp_path, name, more
):
    write_block(simulate_block("demo"), tmp_path)
    (problem,) = find_problems(tmp_path, {"grids": name, **more}).problems
    assert problem.found == f"[settings] grids = {name!r} is no folder"
    assert problem.remedy == "Correct the path"
