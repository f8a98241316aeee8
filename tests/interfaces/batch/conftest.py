"""Folders of blocks, sound and broken, and the bytes of what a batch leaves."""

import os
from importlib import import_module
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[3]


def _cut_in_two(block):
    table = pd.read_csv(block.path / "low_flight.csv", dtype=str)
    table.to_parquet(block.path / "low_flight.parquet")
    block.replace("block.toml", '"low_flight.csv"', '"low_flight.parquet"')
    data = (block.path / "low_flight.parquet").read_bytes()
    block.write("low_flight.parquet", data[: len(data) // 2])


def _in_a_line(block):
    header, *lines = block.read("low_flight.csv").splitlines()
    flat = [f"{line.rpartition(',')[0]},20.0" for line in lines]
    block.write("low_flight.csv", "\n".join([header, *flat, ""]))


# ten ways to break a block: how, in which stage it shows, with which reason and remedy
BREAKAGES = {
    "missing_table": (
        lambda b: (b.path / "low_flight.csv").unlink(),
        "reading",
        "low_flight.csv: the file does not exist",
        "Its folder holds",
    ),
    "no_number": (
        lambda b: b.replace("low_flight.csv", ",10.0000,", ",n/a,"),
        "reading",
        "low_flight.csv, row 2, point 0012, model 11/12: x 'n/a' is not a number",
        "Give a value",
    ),
    "unknown_key": (
        lambda b: b.replace("block.toml", "scale_number", "scale_nmber"),
        "reading",
        "block.toml, row 10: [high_flight] scale_nmber",
        "Write scale_number",
    ),
    "no_toml": (
        lambda b: b.replace("block.toml", "m_g_um = 7.5", "m_g_um = 7,5"),
        "reading",
        "block.toml, row 11: 'm_g_um = 7,5' is no TOML",
        "Write a decimal point",
    ),
    "empty_table": (
        lambda b: b.write("control_points.csv", ""),
        "reading",
        "control_points.csv: the file is empty",
        "Fill it",
    ),
    "unknown_crs": (
        lambda b: b.replace("block.toml", "EPSG:31255", "EPSG:99999"),
        "reading",
        "EPSG:99999",
        "",
    ),
    "truncated_parquet": (
        _cut_in_two,
        "reading",
        "low_flight.parquet: the file is truncated",
        "Copy or export it again",
    ),
    "workbook": (
        lambda b: b.write("low_flight.csv", b"PK\x03\x04 and the rest of it"),
        "reading",
        "low_flight.csv: is a workbook or a zip archive",
        "Save the sheet as CSV UTF-8",
    ),
    "missing_column": (
        lambda b: b.replace("control_points.csv", "easting", "eesting"),
        "reading",
        "control_points.csv, row 1",
        "easting",
    ),
    "points_in_a_line": (_in_a_line, "stage3_model_transformation", "low flight", ""),
}


@pytest.fixture(scope="session")
def breakages():
    return BREAKAGES


@pytest.fixture(scope="session")
def make_blocks(make_block):
    """Write a folder with so many sound blocks, and one for each breakage."""

    def make(folder, n_sound, broken=()):
        for k in range(n_sound):
            # different in size, so that the order of computation is another one
            block = make_block(folder / f"block_{k:02d}")
            shift = f"{10.0 + 0.001 * k:.4f}"
            block.replace("low_flight.csv", ",10.0000,", f",{shift},", count=k)
        for name in broken:
            BREAKAGES[name][0](make_block(folder / name))
        return folder

    return make


@pytest.fixture(scope="session")
def benchmark_module():
    """Import a module of benchmarks/, which lies beside the package."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT)
        yield lambda name: import_module(f"benchmarks.{name}")


@pytest.fixture(scope="session")
def left(benchmark_module):
    """What lies in a folder: every file with its bytes, times apart."""
    return benchmark_module("result_trees").tree


@pytest.fixture
def closed(monkeypatch):
    """Close a folder as rights do; of those of root a system asks nothing."""
    shut, listed = set(), set()

    def refuse(path):
        raise PermissionError(13, "Permission denied", str(path))

    def guard(function, is_refused):
        def guarded(path=".", *arguments, **options):
            if not isinstance(path, int) and is_refused(Path(path)):
                refuse(path)
            return function(path, *arguments, **options)

        return guarded

    def close(folder, *, is_listed=False):
        (listed if is_listed else shut).add(Path(folder))

    def is_below(path):
        return any(one in path.parents for one in shut | listed)

    def may(path, mode, **_):
        return Path(path) not in shut | listed

    monkeypatch.setattr(os, "scandir", guard(os.scandir, lambda path: path in shut))
    for name in ("stat", "open"):
        monkeypatch.setattr(Path, name, guard(getattr(Path, name), is_below))
    monkeypatch.setattr(os, "access", may)
    return close
