"""A part of a small network that lies apart: named first, and no strain of it."""

from dataclasses import replace

import numpy as np
import pytest
from tests.judged_alone import judged_alone

from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.systematic_errors import (
    ControlScores,
    strain_beside,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import simulate_block

PLAN = ["easting", "northing"]
SHIFT = 0.6


def with_a_corner_apart(seed):
    """Control and check points in the south-west off; and the names of this control."""
    block = simulate_block("demo", seed=seed)
    control = block.control_points.copy()
    is_control = (control["role"] == "control").to_numpy()
    median = control.loc[is_control, PLAN].median()
    rows = (control[PLAN] < median).all(axis=1).to_numpy()
    control.loc[rows, "easting"] += SHIFT
    names = set(control.loc[rows & is_control, "point_id"])
    return replace(block, control_points=control), names


def with_a_smooth_strain(seed):
    """Control and check points displaced with their neighbours, 20 cm (total)."""
    block = simulate_block("demo", seed=seed)
    control = block.control_points
    xy = control[PLAN].to_numpy()
    apart = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1))
    reach = 0.25 * np.ptp(xy, axis=0).max()
    alike = np.exp(-0.5 * (apart / reach) ** 2) + 1e-9 * np.eye(len(xy))
    drawn = np.random.default_rng(seed).standard_normal(xy.shape)
    moved = xy + 0.2 / np.sqrt(2.0) * np.linalg.cholesky(alike) @ drawn
    control = control.assign(easting=moved[:, 0], northing=moved[:, 1])
    return replace(block, control_points=control)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_a_corner_of_a_small_network_is_named_first(method):
    block, names = with_a_corner_apart(seed=2)
    result = densify(block, Settings(method=method))
    told = result.assessment
    assert told.causes[0] == "broken_network"
    first = next(found for found in told.findings if not found.explained_by)
    assert first.code == "broken_network"
    assert set(first.names) == names
    assert first.facts["easting"] == pytest.approx(SHIFT, abs=0.1)
    assert first.remedy == "correct_control"
    assert {found.code for found in told.findings} > {"broken_network"}
    head, *_ = result.summary().splitlines()
    assert "; check the control points in the south-west first" in head


def test_a_corner_is_no_strain():
    """The strain test alone finds one: beside the step nothing of it is left."""
    block, names = with_a_corner_apart(seed=3)
    result = densify(block, Settings())
    examined = result.examination
    assert examined.strain.is_significant
    left = strain_beside(examined.strain, names, block.control_points)
    assert left.p_value > 0.05
    codes = judged_alone(result)
    assert "strained_network" not in codes


@pytest.mark.slow
def test_a_step_by_itself_is_told_in_the_first_line():
    """Though no other finding follows from it."""
    block, _ = with_a_corner_apart(seed=3)
    control, true = block.control_points.copy(), simulate_block("demo", seed=3)
    control[PLAN] = (control[PLAN] + true.control_points[PLAN]) / 2.0  # half of it
    result = densify(replace(block, control_points=control), Settings())
    assert [found.code for found in result.assessment.findings] == ["broken_network"]
    assert "; check the control points in the south-west first" in result.summary()


@pytest.mark.parametrize("seed", range(20, 26))
def test_a_smooth_strain_is_no_step(seed):
    result = densify(with_a_smooth_strain(seed), Settings())
    step = result.examination.network_step
    assert step is None
    codes = judged_alone(result)
    assert "broken_network" not in codes or (
        result.examination.control_patterns.plan.kind is Kind.BEND
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_a_step_that_is_part_of_a_strain_does_not_enlarge_the_figure(method):
    """The side of a wave looks like a step, which would move points much further."""
    geometry = BlockGeometry(width=5000.0, height=5000.0)
    noise = BlockNoise(network_strain=0.3, network_strain_wavelength=2500.0)
    ratios = []
    for seed in range(40, 43):
        block = simulate_block("demo", seed=seed, geometry=geometry, noise=noise)
        result = densify(block, Settings(method=method))
        examined = result.examination
        assert examined.smooth_strain is not None
        assert examined.displaced.plan < examined.control_patterns.moved_plan
        ratios.append(result.examination.credible.value / true_error(result, block))
    # what moves the control moves the points less: a figure that is safe
    assert 1.0 < np.median(ratios) < 2.0


def true_error(result, block):
    """RMS of the new points, total [m]."""
    both = result.points.merge(block.truth, on="point_id", suffixes=("", "_true"))
    new = both[both["role"] == "new"]
    off = [new[axis] - new[f"{axis}_true"] for axis in PLAN]
    return float(np.sqrt(np.mean(np.hypot(*off) ** 2)))


def test_scores_beside_a_pattern_know_nothing_of_it():
    rng = np.random.default_rng(5)
    root = rng.standard_normal((6, 4))
    information = root @ root.T
    pattern = np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    displaced = np.outer(pattern, [3.0, -2.0])
    scores = ControlScores(np.arange(6), information @ displaced, information)
    beside = scores.beside(pattern)
    assert np.abs(beside.values).max() < 1e-9
    assert np.abs(beside.information @ pattern).max() < 1e-9
    # of a pattern that nothing is known of there is nothing to take out
    assert scores.beside(np.zeros(6)) is scores
