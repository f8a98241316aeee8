"""Short form of the study of blunders: one of each room of the house."""

from dataclasses import replace

import numpy as np
import pytest
from tests.truth.long_form.blunder_kinds import KINDS, kinds_for
from tests.truth.long_form.blunder_power import is_too_weak
from tests.truth.long_form.blunders import LEAST_COVERED, Outcome, draw, outcome_of

from einschalt.foundations.errors import EinschaltError


@pytest.fixture(scope="module")
def block(demo_block):
    return demo_block


def kind_of(name):
    return next(kind for kind in KINDS if kind.name == name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("several control points", "two_step"),
        ("axis mirrored", "simultaneous"),
        ("names shuffled in a model", "simultaneous"),
        ("one in twenty names", "two_step"),
    ],
)
def test_a_blunder_is_told_and_covered(block, name, method):
    rng = np.random.default_rng(3)
    spoilt = kind_of(name).spoil(block, rng)
    outcome = outcome_of(name, spoilt, block.truth, method)
    assert outcome.is_called_out
    assert outcome.covered >= LEAST_COVERED


@pytest.mark.slow
def test_gross_errors_of_photographs_that_leave_no_two_steps_are_told():
    """One name in twenty is wrong: of one flight no model is held."""
    drawn, kind, rng = draw(1008)
    assert kind.name == "one in twenty names"
    spoilt = kind.spoil(drawn, rng)
    outcome = outcome_of(kind.name, spoilt, drawn.truth, "simultaneous")
    assert outcome.is_called_out
    assert outcome.covered >= LEAST_COVERED


def test_every_kind_changes_the_block(block):
    rng = np.random.default_rng(5)
    for kind in kinds_for(block):
        try:
            spoilt = kind.spoil(block, rng)
        except EinschaltError:  # refused as it is read: it was changed
            continue
        same = (
            spoilt.control_points.equals(block.control_points)
            and spoilt.crs == block.crs
            and all(spoilt.flights.get(n) is f for n, f in block.flights.items())
        )
        assert not same, kind.name


def test_what_moves_points_and_is_believed_is_missed():
    wrong = Outcome("", errors=((0.5, 0.1, 0.1),), is_supported=True)
    assert wrong.is_missed
    assert not replace(wrong, errors=((0.15, 0.1, 0.1),)).is_missed
    told = replace(wrong, is_supported=False)
    assert told.is_missed  # by half of its error, not covered
    assert not replace(told, errors=((0.5, 0.1, 0.3),)).is_missed


@pytest.mark.parametrize(("size", "expected"), [(0.05, True), (5.0, False)])
def test_what_the_best_test_does_not_find_is_too_weak(block, size, expected):
    control = block.control_points
    place = control.index[control["role"] == "control"][3]
    east = control["easting"] + size * (control.index == place)
    spoilt = replace(block, control_points=control.assign(easting=east))
    assert is_too_weak(block, spoilt) is expected
