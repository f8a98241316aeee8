"""Computed blocks that several tests look at, and texts to compare with."""

import ctypes
import gc
import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import settings

# as the workers of a batch: threads of linear algebra that wait for each other on cores
# that others use as well take ten times as long. Set before numpy is imported
for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

# commands speak the language of the locale; what is compared is English
for _variable in ("LC_ALL", "LC_MESSAGES", "LANG"):
    os.environ.pop(_variable, None)

# figures of matplotlib are drawn without a screen
os.environ.setdefault("MPLBACKEND", "Agg")

# memory that was given back is asked for again by the next block, and each page of it
# costs as much as what is written there: the C library of Linux keeps it instead. Only
# of this process; what a test starts manages its memory as it does for users
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
if hasattr(ctypes.pythonapi, "mallopt"):
    ctypes.pythonapi.mallopt(M_MMAP_THRESHOLD, 2**25)
    ctypes.pythonapi.mallopt(M_TRIM_THRESHOLD, 2**31 - 1)

# a run in the background inherits that interruptions are ignored, and would hand it on
# to the commands that are interrupted here: they would never end
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# the same examples in every run: what fails here fails there. To hunt for new ones:
# EINSCHALT_HUNT=1 make test
settings.register_profile("fixed", derandomize=True, deadline=None)
settings.register_profile("hunt", deadline=None)
settings.load_profile("hunt" if os.environ.get("EINSCHALT_HUNT") else "fixed")


def pytest_collection_finish():
    """Keep what thousands of tests are made of out of every search for garbage."""
    gc.collect()
    gc.freeze()
    # and search when there is something to find: a block of sixty models makes
    # thousands of things that last, and every 700 of them would begin a search
    gc.set_threshold(20_000, 20, 20)


def timed(result):
    """The result as if everything had taken half a second."""
    # numpy is imported by it, which must come after the lines above
    from tests.changed_results import Stopped

    return replace(result, stopwatch=Stopped(0.5))


GOLDEN = Path(__file__).parent / "golden"


def _modified(block, change):
    """The block with other measurements of the low flight."""
    points = change(block.low_flight.model_points.copy())
    return replace(block, low_flight=replace(block.low_flight, model_points=points))


def _with_faults(points):
    """Two models with too few points, one with points in a line, a pair exchanged."""
    models = points["model_id"].to_numpy()
    is_first = points.groupby(["coverage", "model_id"]).cumcount() < 2
    few = (points["coverage"] == "1") & points["model_id"].isin(["1/1", "1/2"])
    points = points[~few | is_first].reset_index(drop=True)
    line = (points["coverage"] == "1") & (points["model_id"] == "2/1")
    points.loc[line, "y"] = 2.0 * points.loc[line, "x"]
    other = (points["coverage"] == "2") & (points["model_id"] == models[-1])
    first, second = points.index[other][:2]
    names = points.loc[[first, second], "point_id"].to_numpy()
    points.loc[[first, second], "point_id"] = names[::-1]
    return points


@pytest.fixture(scope="session")
def demo_block():
    """A simulated block of 100 points, six of them check points."""
    from einschalt.pipeline.simulation.simulate_block import simulate_block

    return simulate_block("demo", seed=1)


@pytest.fixture(scope="session")
def good_result(demo_block):
    """A block without faults."""
    from einschalt.pipeline.densify import densify

    return timed(densify(demo_block))


@pytest.fixture(scope="session")
def faulty_result(demo_block):
    """A block in which models fail, and two points have exchanged names."""
    from einschalt.pipeline.densify import densify

    return timed(densify(_modified(demo_block, _with_faults)))


@pytest.fixture(scope="session")
def given_approximations_result(demo_block, good_result):
    """A block with approximate points instead of a high flight."""
    from einschalt.pipeline.block.block import Block
    from einschalt.pipeline.densify import densify

    block = Block(
        name="Given approximations",
        crs=demo_block.crs,
        control_points=demo_block.control_points,
        approximate_points=good_result.approximations[
            ["point_id", "easting", "northing"]
        ],
        approximate_m_0_m=0.09,
        low_flight=demo_block.low_flight,
    )
    return timed(densify(block))


@pytest.fixture(scope="session")
def unchecked_result():
    """A block without check points."""
    from einschalt.pipeline.densify import densify
    from einschalt.pipeline.simulation.simulate_block import (
        BlockGeometry,
        simulate_block,
    )

    geometry = BlockGeometry(width=3_000.0, height=3_000.0)
    return timed(densify(simulate_block("demo", seed=1, geometry=geometry)))


@pytest.fixture
def batches_here(monkeypatch):
    """Batches run here unless a scheduler is named: processes start for seconds.

    That they run in processes of their own is shown in tests of the batch.
    """
    from tests.interfaces.conftest import InThisProcess

    from einschalt.interfaces import python_api

    chosen = python_api.chosen_engine

    def here(scheduler=None, *args, **kwargs):
        engine = chosen(scheduler, *args, **kwargs)
        return InThisProcess() if scheduler is None else engine

    monkeypatch.setattr(python_api, "chosen_engine", here)


@pytest.fixture(scope="session")
def golden():
    """Compare a text with a file of golden/; EINSCHALT_WRITE_GOLDEN=1 writes it."""

    def compare(text, name):
        file = GOLDEN / name
        if os.environ.get("EINSCHALT_WRITE_GOLDEN"):
            file.write_text(text, encoding="utf-8")
        assert text == file.read_text(encoding="utf-8")

    return compare
