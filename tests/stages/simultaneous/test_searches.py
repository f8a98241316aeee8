"""What adjustments of the same tables share: the same to the bit, and found once."""

import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.photographs_onto_control import one_flight

from einschalt.pipeline.densification.one_adjustment import orient_flights
from einschalt.pipeline.densification.simultaneous import block_tables
from einschalt.stages.simultaneous import adjustment
from einschalt.stages.simultaneous.adjustment import (
    AdjustmentOptions,
    simultaneous_adjustment,
)
from einschalt.stages.simultaneous.searches import Searches

TABLES = ("points", "models", "residuals", "control", "deformations", "failures")
SNOOP = AdjustmentOptions(outliers="snoop")
IN_TURN = (
    SNOOP,
    SNOOP,
    AdjustmentOptions(outliers="huber"),
    AdjustmentOptions(outliers="keep", deformation="tested"),
    AdjustmentOptions(outliers="tukey", variance_components="estimated"),
    AdjustmentOptions(outliers="snoop", variance_components="estimated"),
    AdjustmentOptions(outliers="snoop", significance=1e-6),
    AdjustmentOptions(outliers="snoop", deformation="modelled"),
)
# by variance_components and significance, of those that do not keep gross errors
N_SEARCHES = 3


def spoilt(seed, share, error_mm):
    """Photographs with gross errors in a share of their points."""
    block, rng = one_flight(seed), np.random.default_rng(seed)
    points = block.low_flight.image_points.copy()
    rows = rng.choice(len(points), int(share * len(points)), replace=False)
    xy = points[["x", "y"]].to_numpy().copy()
    xy[rows] += rng.normal(0.0, error_mm, (len(rows), 2))
    points[["x", "y"]] = xy
    return replace(block, low_flight=replace(block.low_flight, image_points=points))


def tables_of(block):
    flights = orient_flights(block, block.settings)
    return block_tables(block, flights, {"low_flight": "helmert_3d"})


@pytest.fixture(scope="module")
def sound():
    """With some gross errors, and no model that is given up."""
    return tables_of(spoilt(7, 0.02, 0.05))


@pytest.fixture(scope="module")
def contradicted():
    """With so many that models are given up."""
    return tables_of(spoilt(5, 0.02, 0.5))


@pytest.fixture
def n_searched(monkeypatch):
    """Searches that are made, a list of one number for each."""
    made, search = [], adjustment.weigh_part

    def counting(tables, part, solution, options):
        made.append(len(part.models))
        return search(tables, part, solution, options)

    monkeypatch.setattr(adjustment, "weigh_part", counting)
    return made


def assert_same(one, other):
    for name in TABLES:
        pd.testing.assert_frame_equal(
            getattr(one, name), getattr(other, name), check_exact=True
        )
    np.testing.assert_array_equal(one.estimates.cofactors, other.estimates.cofactors)
    assert (one.s_0, one.redundancy) == (other.s_0, other.redundancy)
    assert one.loses_no_others == other.loses_no_others


def test_what_is_shared_changes_nothing(sound):
    shared = Searches()
    for options in IN_TURN:
        alone = simultaneous_adjustment(sound, options)
        assert_same(simultaneous_adjustment(sound, options, shared), alone)


def test_gross_errors_are_looked_for_once_by_each_set_of_options(sound, n_searched):
    shared = Searches()
    for options in IN_TURN:
        simultaneous_adjustment(sound, options, shared)
    of_kept = sum(options.outliers == "keep" for options in IN_TURN)
    assert len(n_searched) == N_SEARCHES + of_kept
    n_searched.clear()
    for options in IN_TURN:
        simultaneous_adjustment(sound, options)
    assert len(n_searched) == len(IN_TURN)


def test_an_end_of_a_search_is_remembered_too(contradicted, n_searched):
    """A model is given up in the same way, and the block without it searched once."""
    shared = Searches()
    first = simultaneous_adjustment(contradicted, SNOOP, shared)
    n_models = list(n_searched)
    assert len(first.failures) == len(n_models) - 1 > 0
    assert n_models == sorted(n_models, reverse=True)
    again = simultaneous_adjustment(contradicted, SNOOP, shared)
    assert n_searched == n_models
    assert_same(again, first)
    assert_same(simultaneous_adjustment(contradicted, SNOOP), first)
    # and no frame of it is held, nor anything of it copied
    ends = [end for end in vars(shared)["_weighed"].values() if hasattr(end, "kind")]
    assert len(ends) == len(first.failures)
    assert all(str(end.raised_again()) for end in ends)
    copy = pickle.loads(pickle.dumps(shared))
    assert not vars(copy)["_weighed"]
    assert_same(simultaneous_adjustment(contradicted, SNOOP, copy), first)
