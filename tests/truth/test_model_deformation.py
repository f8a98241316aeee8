"""Deformations that models share: found where they are, and not where they are not.

4 to 5 cm in the middle of the low flight's models and 15 at their edge, as on a real
block. The long form is ``python -m tests.truth.long_form deformation``.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.adjust_block import adjust_block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.pipeline.summary.sections.model_deformation import belief_text

pytestmark = pytest.mark.slow

EDGE_UM = 18.75  # 15 cm at 1:8000
SEEDS = range(3)
SMALL_SEEDS = range(40)
PLANE = ["easting", "northing"]


def rms(points, truth):
    """Root mean square of the total errors of all points [m]."""
    true = truth.set_index("point_id").loc[points["point_id"], PLANE].to_numpy()
    return np.sqrt(np.mean(((points[PLANE].to_numpy() - true) ** 2).sum(axis=1)))


def deformed(preset, seed):
    noise = replace(PRESETS[preset].noise, low_deformation_um=EDGE_UM)
    return simulate_block(preset, seed=seed, noise=noise)


@pytest.fixture(scope="module")
def figures():
    rows = []
    for seed in SEEDS:
        block = deformed("neukirchen", seed)
        modelled = adjust_block(block, deformation="modelled")
        low = modelled.deformations.set_index("flight").loc["low_flight"]
        rows.append(
            {
                "is_detected": low["is_detected"] and low["is_modelled"],
                "edge": low["size_edge"],
                "modelled": rms(modelled.points, block.truth),
                "ignored": rms(adjust_block(block).points, block.truth),
                "two steps": rms(densify(block).solution.points, block.truth),
            }
        )
    return pd.DataFrame(rows)


def test_deformation_is_found_in_every_block(figures):
    assert figures["is_detected"].all()
    # what an affinity takes up of it is gone, and the edge begins at 3/4
    assert figures["edge"].between(0.08, 0.15).all()


def test_modelled_it_is_better_than_two_steps(figures):
    assert (figures["modelled"] < figures["two steps"]).all()
    assert figures["modelled"].mean() < 0.7 * figures["two steps"].mean()
    # left alone it takes most of what the adjustment gains
    assert figures["ignored"].mean() > 1.5 * figures["modelled"].mean()


def test_blocks_without_deformation_seem_to_have_none():
    found = [
        adjust_block(simulate_block("demo", seed=seed), deformation="tested")
        for seed in SMALL_SEEDS
    ]
    is_clean = [not f.deformations["is_detected"].any() for f in found]
    # at 0.001 for each of two flights one block of forty is already rare
    assert np.mean(is_clean) >= 0.95


def bent_each_in_its_own_way(block, size_mm):
    """Every model of the low flight gets a quadratic deformation of its own."""
    table = block.low_flight.model_points
    names = ["coverage", "model_id"]
    xy = table.groupby(names)[["x", "y"]]
    middle = (xy.transform("max") + xy.transform("min")) / 2
    half = (xy.transform("max") - xy.transform("min")) / 2
    x, y = ((table[["x", "y"]] - middle) / half).to_numpy().T
    terms = np.column_stack([x**2 - 1 / 3, x * y, y**2 - 1 / 3])
    number = table.groupby(names).ngroup().to_numpy()
    rng = np.random.default_rng(3)
    own = size_mm * rng.standard_normal((number.max() + 1, 2, 3))
    moved = np.einsum("nij,nj->ni", own[number], terms)
    bent = table.assign(x=table["x"] + moved[:, 0], y=table["y"] + moved[:, 1])
    return replace(block, low_flight=replace(block.low_flight, model_points=bent))


@pytest.fixture(scope="module")
def dense_block():
    """Many points per model and a large m_g: as on the real block."""
    preset = PRESETS["demo"]
    geometry = replace(preset.geometry, point_spacing=100.0, n_check=0)
    noise = replace(preset.noise, low_m_g_um=15.0)
    return simulate_block("demo", seed=1, geometry=geometry, noise=noise)


def test_models_bent_each_in_its_own_way_are_not_recommended_by_s_0(dense_block):
    settings = Settings(method="simultaneous", model_deformation="tested")
    bent = densify(bent_each_in_its_own_way(dense_block, 0.009), settings)
    # s_0 is what one would like to see
    assert bent.simultaneous.s_0 == pytest.approx(1.0, abs=0.1)
    assert bent.simultaneous.deformations["is_alike"].any()
    assert "Use the two steps" in belief_text(bent.assessment.deformation)
    assert "Use the two steps" in bent.summary().replace("\n    ", " ")


def test_a_shared_deformation_that_is_only_tested_is_not_recommended(dense_block):
    noise = replace(dense_block.noise, low_deformation_um=EDGE_UM)
    block = simulate_block("demo", seed=1, geometry=dense_block.geometry, noise=noise)
    tested = densify(block, Settings(method="simultaneous", model_deformation="tested"))
    assert tested.simultaneous.s_0 == pytest.approx(1.0, abs=0.12)
    assert "Use the two steps, or model the deformation" in belief_text(
        tested.examination.deformation
    )
    modelled = densify(block, Settings(method="simultaneous"))
    assert "the deformation is modelled" in belief_text(
        modelled.examination.deformation
    )
    truth = block.truth
    reached = rms(modelled.solution.points, truth)
    assert reached < rms(modelled.two_step.points, truth)
    assert reached < 0.8 * rms(tested.solution.points, truth)
