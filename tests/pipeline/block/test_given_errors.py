"""What a block says of errors that its given points share."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.files.block_folder import read_block
from einschalt.interfaces.files.block_writing import write_block
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

CONTROL = "control_points"


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        ({"group_errors_m": {CONTROL: 0.1}}, "no column 'group'"),
        ({"group_errors_m": {"control": 0.1}}, "group_error_m of 'control'"),
        ({"correlation_lengths_m": {CONTROL: -1.0}}, "correlation_length_m = -1"),
        ({"correlation_lengths_m": {CONTROL: np.nan}}, "correlation_length_m = nan"),
        (
            {"correlation_lengths_m": {"approximate_points": 100.0}},
            "there are no approximate_points",
        ),
        ({"group_errors_m": 0.1}, "a dict of metres by table"),
    ],
)
def test_what_cannot_be_is_refused(demo_block, facts, said):
    with pytest.raises(EinschaltError) as caught:
        replace(demo_block, **facts)
    assert said in str(caught.value)


def test_too_many_points_to_correlate(demo_block, monkeypatch):
    monkeypatch.setattr("einschalt.pipeline.block.facts.MOST_CORRELATED", 10)
    with pytest.raises(EinschaltError, match="at most 10 points"):
        replace(demo_block, correlation_lengths_m={CONTROL: 100.0})
    # errors that are said to be independent need no room
    assert replace(demo_block, correlation_lengths_m={CONTROL: 0.0}) is not None


def test_iterations_hold_no_control_of_unknown_shifts(demo_block):
    known = demo_block.truth
    block = Block(
        low_flight=demo_block.low_flight,
        approximate_points=known,
        control_points=demo_block.control_points.assign(group="north"),
        crs=demo_block.crs,
    )
    with pytest.raises(EinschaltError, match="shifts of unknown size") as caught:
        densify(block, Settings(iterations=2))
    assert "group_error_m" in str(caught.value)


def test_a_folder_keeps_them(demo_block, tmp_path):
    control = demo_block.control_points
    group = np.where(np.arange(len(control)) % 2, "north", "").astype(object)
    block = replace(
        demo_block,
        control_points=control.assign(group=group),
        group_errors_m={CONTROL: 0.1},
        correlation_lengths_m={CONTROL: 1500.0},
    )
    write_block(block, tmp_path / "block")
    read = read_block(tmp_path / "block")
    assert read.group_errors_m == {CONTROL: 0.1}
    assert read.correlation_lengths_m == {CONTROL: 1500.0}
    assert read.control_points["group"].fillna("").tolist() == group.tolist()
