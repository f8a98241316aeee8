"""A block that is too large is refused in a sentence, before the work."""

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.block import memory
from einschalt.pipeline.densify import densify

GB = 1e9


class Tables:
    """Two flights: which point lies in which model, control none."""

    control_points = approximate_points = None

    def __init__(self, high, low):
        self.flights = {"high_flight": Flight(*high), "low_flight": Flight(*low)}


class Flight:
    def __init__(self, models, points):
        names = {"coverage": "1", "model_id": models, "point_id": points}
        self.table = pd.DataFrame(names).astype(str)

    def model_table(self):
        return self.table


def cloud(n_points):
    return ["m"] * n_points, np.arange(n_points)


@pytest.fixture(autouse=True)
def computer(monkeypatch):
    monkeypatch.setattr(memory, "allowed_bytes", lambda: 24.0 * GB)


def test_a_cloud_in_one_model_of_both_flights_is_refused():
    said = r"about 58 GB of memory, with up to 30000 points in a model.*a tenth"
    with pytest.raises(GeometryError, match=said):
        memory.require_memory(Tables(cloud(30_000), cloud(30_000)))


def test_a_cloud_that_no_other_flight_holds_needs_memory_by_its_points():
    """Measured: 1.4 GB for 10⁵ points, 3 GB for three times as many."""
    block = Tables(cloud(50), cloud(100_000))
    assert 0.5 * GB < sum(memory.needed_bytes(block).values()) < 1.4 * GB
    memory.require_memory(block)


def test_one_name_in_ten_thousand_models_is_refused():
    models, points = np.arange(10_000), np.zeros(10_000, dtype=int)
    with pytest.raises(GeometryError, match=r"a point in 10000 models.*different name"):
        memory.require_memory(Tables((models, points), (models, points)))


def test_points_that_the_same_models_share_make_no_more_pairs_of_models():
    """Measured: 0.44 GB for six points in a thousand models; 1.8 were said."""
    models, points = np.repeat(np.arange(1000), 6), np.tile(np.arange(6), 1000)
    block = Tables(cloud(50), (models, points))
    assert 0.3 * GB < sum(memory.needed_bytes(block).values()) < 0.6 * GB


def test_a_hundred_thousand_models_of_three_points_are_not():
    """They were computed with 1.8 GB."""
    models = np.repeat(np.arange(100_000), 3)
    points = np.arange(300_000) % 50_000
    block = Tables(cloud(2_000), (models, points))
    assert sum(memory.needed_bytes(block).values()) < 3.0 * GB


def test_usual_blocks_need_little(demo_block):
    assert sum(memory.needed_bytes(demo_block).values()) < 3e7
    memory.require_memory(demo_block)


@pytest.mark.parametrize(("share", "is_to_spare"), [(0.7, True), (0.9, False)])
def test_a_block_that_needs_most_of_it_leaves_nothing(
    demo_block, monkeypatch, share, is_to_spare
):
    needed = memory.BYTES_OF_PROGRAM + sum(memory.needed_bytes(demo_block).values())
    monkeypatch.setattr(memory, "allowed_bytes", lambda: needed / share)
    assert memory.has_memory_to_spare(demo_block) == is_to_spare
    memory.require_memory(demo_block)  # it is computed all the same


def test_the_limit_of_a_process_counts(demo_block, monkeypatch):
    monkeypatch.setattr(memory, "allowed_bytes", lambda: 1000.0)
    with pytest.raises(GeometryError, match="at most the 1e-06 GB that this"):
        densify(demo_block)


def test_what_libraries_reserve_counts(demo_block, monkeypatch):
    monkeypatch.setattr(memory, "is_there_room_for", lambda n_bytes: n_bytes < 1e8)
    with pytest.raises(GeometryError, match=r"libraries reserve\. Raise"):
        memory.require_memory(demo_block)
