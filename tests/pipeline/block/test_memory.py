"""A block that is too large is refused in a sentence, before the work."""

import pandas as pd
import pytest

from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.block import memory
from einschalt.pipeline.densify import densify


class Cloud:
    """Two flights with one model each."""

    def __init__(self, n_points):
        self.table = pd.DataFrame(
            {"coverage": "1", "model_id": "m", "point_id": range(n_points)}
        )
        self.flights = {"high_flight": self, "low_flight": self}

    def model_table(self):
        return self.table


def test_a_million_points_in_a_model_are_refused():
    # 2 · 10¹² pairs
    said = "about 128000 GB of memory, with up to 1000000 points in a model"
    with pytest.raises(GeometryError, match=said):
        memory.require_memory(Cloud(1_000_000))


def test_usual_blocks_need_little(demo_block):
    needed, largest = memory.needed_bytes(demo_block)
    assert needed < 1e7
    assert 5 < largest <= 100
    memory.require_memory(demo_block)


def test_the_limit_of_a_process_counts(demo_block, monkeypatch):
    monkeypatch.setattr(memory, "allowed_bytes", lambda: 1000.0)
    with pytest.raises(GeometryError, match="at most the 1e-06 GB that this"):
        densify(demo_block)
