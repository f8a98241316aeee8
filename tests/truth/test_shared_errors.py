"""Given points that share errors: claims are true, and silence about them is not.

Strips of approximate coordinates displaced by 20 cm each, a control network whose
parts are displaced by 10 cm, and control whose errors are alike over 2 km.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.truth.disturbed_blocks import (
    onto_grouped_approximations,
    with_correlated_control,
    with_grouped_control,
)
from tests.truth.test_own_deformation import compared

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

pytestmark = pytest.mark.slow

SEEDS, N_STRIPS = range(8), 8
# between blocks claimed over true scatters by 0.22, and the share in the ellipses by
# 0.076 (20 blocks of each kind, tests.truth.long_form real_life): 3.5 standard errors
RATIO = 3.5 * 0.22 / np.sqrt(len(SEEDS))
LEAST_INSIDE = 0.95 - 3.5 * 0.076 / np.sqrt(len(SEEDS))
SIDE = {"width": 4000.0, "height": 4000.0, "n_check": 0}
WAYS = ("two steps", "simultaneous")
CASES = {
    "strips": lambda b, seed, told: onto_grouped_approximations(
        b, 0.1, 0.2, (1e9, 800.0), seed, is_stated=told
    ),
    "parts": lambda b, seed, told: with_grouped_control(b, 0.1, seed, is_stated=told),
    "distance": lambda b, seed, told: with_correlated_control(
        b, 0.05, 2000.0, seed, is_stated=told
    ),
}


def _block(kind, seed, told=True, **geometry):
    shape = replace(PRESETS["demo"].geometry, **SIDE, **geometry)
    noise = PRESETS["demo"].noise
    if kind == "distance":
        noise = BlockNoise(control_standard_error=0.0)
    plain = simulate_block("demo", seed=700 + seed, geometry=shape, noise=noise)
    return CASES[kind](plain, seed, told)


@pytest.fixture(scope="module")
def figures():
    """Claimed over true and share in 95 % ellipses, by kind and way."""
    found = {"strips": {"two steps": []}}
    for seed in range(N_STRIPS):
        block = _block("strips", seed)
        row = compared(densify(block).solution.points, block.truth)
        found["strips"]["two steps"].append(row)
    for kind in ("parts", "distance"):
        found[kind] = {way: [] for way in WAYS}
        for seed in SEEDS:
            block = _block(kind, seed)
            result = densify(block, Settings(method="simultaneous"))
            ways = {"two steps": result.two_step, "simultaneous": result.solution}
            for way, solved in ways.items():
                found[kind][way].append(compared(solved.points, block.truth))
    return found


@pytest.mark.parametrize(
    ("kind", "way"),
    [
        ("strips", "two steps"),
        *((kind, way) for kind in ("parts", "distance") for way in WAYS),
    ],
)
def test_claims_are_true(figures, kind, way):
    claimed, true, inside = np.mean(figures[kind][way], axis=0)
    assert np.sqrt(claimed / true) == pytest.approx(1.0, abs=RATIO)
    assert inside > LEAST_INSIDE


def test_silence_claims_too_little():
    block = _block("parts", 1)
    silent = replace(
        block,
        control_points=block.control_points.drop(columns="group"),
        group_errors_m={},
    )
    told, untold = (densify(b) for b in (block, silent))
    assert told.figures.mean_total > 1.3 * untold.figures.mean_total


def test_sizes_that_nobody_gives_show_in_the_residuals():
    found = [
        np.sqrt(2.0)
        * densify(_block("strips", seed, told=False)).errors.standard_errors[
            "approximate_groups"
        ][0]
        for seed in range(N_STRIPS)
    ]
    # seven shifts in each axis of each block: known to some seven per cent in all
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(0.2, rel=0.25)


def test_they_stand_among_the_sources():
    result = densify(_block("parts", 2))
    assert "standard_error_control_groups" in result.error_sources
    assert "shifts of groups of control points" in result.summary()
