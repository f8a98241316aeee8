"""How far points were moved, beside the tables of the result."""

import numpy as np
import pytest

from einschalt.pipeline.assessment.facts.moves import (
    distribution_facts,
    iteration_facts,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

NATURAL = "natural_neighbour"


def test_every_pass_has_its_moves(demo_block):
    result = densify(demo_block, Settings(iterations=3))
    facts = iteration_facts(result.examination)
    table = result.iterations
    assert [move[0] for move in facts.moves] == [2, 3]
    for column, place in (("largest_move", 1), ("point_id", 2), ("move_rms", 3)):
        assert [move[place] for move in facts.moves] == table[column].tolist()
    assert (facts.is_converged, facts.most_passes) == (False, 3)
    assert facts.n_held == (result.points["role"] == "control").sum()
    once = densify(demo_block)
    assert facts.total_of_one_pass == pytest.approx(once.figures.mean_total)
    new = result.points[result.points["role"] == "new"]
    rms = np.sqrt(np.mean(new["standard_error_total"] ** 2))
    assert facts.total == pytest.approx(rms)
    usable = result.models[result.models["flight"] == "low_flight"]["is_usable"]
    assert facts.n_models == usable.sum() >= facts.n_models_held > 0


def test_models_that_hold_control_are_counted(demo_block):
    result = densify(demo_block, Settings(iterations=2))
    control = demo_block.control_points
    names = control.loc[control["role"] != "check", "point_id"]
    points = demo_block.low_flight.model_points
    with_control = points[points["point_id"].isin(names)]
    expected = len(with_control[["coverage", "model_id"]].drop_duplicates())
    assert iteration_facts(result.examination).n_models_held == expected


def test_one_pass_has_no_moves(good_result):
    assert iteration_facts(good_result.examination) is None


@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_distributed_residuals_by_role(demo_block, method):
    settings = Settings(residual_distribution=NATURAL, method=method)
    result = densify(demo_block, settings)
    facts = distribution_facts(result.examination)
    assert facts.way == NATURAL
    assert facts.is_propagated == ("standard_error_total" in result.points)
    assert {move[0] for move in facts.moves} == {"new", "control", "check"}
    for role, n_points, rms, most in facts.moves:
        rows = result.points[result.points["role"] == role]
        moved = rows[["distributed_easting", "distributed_northing"]].to_numpy()
        length = np.sqrt((moved**2).sum(axis=1))
        assert n_points == len(rows)
        assert rms == pytest.approx(np.sqrt(np.mean(length**2)))
        assert most == pytest.approx(length.max())


def test_without_distribution_nothing_was_moved(good_result):
    assert distribution_facts(good_result.examination) is None
