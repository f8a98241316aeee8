"""Models that are deformed each in its own way: what is claimed is what is true.

Deformations of second and third degree in the position on the photograph, 15 cm at the
edge of the low flight's models.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.truth.disturbed_blocks import bent

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

pytestmark = pytest.mark.slow

SEEDS = range(5)
EDGE_M = 0.15
PLANE = ["easting", "northing"]
WAYS = {
    "two steps": Settings(),
    "simultaneous": Settings(method="simultaneous"),
    "ignored": Settings(method="simultaneous", model_deformation="ignored"),
}


def compared(points, truth):
    """Mean squares of new points, claimed and true; share of ellipses that hold."""
    new = points[points["role"] == "new"]
    true = truth.set_index("point_id").loc[new["point_id"]]
    d = new[PLANE].to_numpy() - true[PLANE].to_numpy()
    covariance = np.empty((len(new), 2, 2))
    covariance[:, 0, 0] = new["standard_error_easting"] ** 2
    covariance[:, 1, 1] = new["standard_error_northing"] ** 2
    covariance[:, 0, 1] = covariance[:, 1, 0] = new["covariance_en"]
    square = np.einsum("ni,nij,nj->n", d, np.linalg.inv(covariance), d)
    claimed = np.trace(covariance, axis1=1, axis2=2).mean()
    return claimed, (d**2).sum(axis=1).mean(), np.mean(square < 5.991)


@pytest.fixture(scope="module")
def figures():
    rows = []
    for seed in SEEDS:
        geometry = replace(PRESETS["demo"].geometry, n_check=0)
        block = simulate_block("demo", seed=seed, geometry=geometry)
        block = bent(block, EDGE_M, seed)
        for way, settings in WAYS.items():
            result = densify(block, settings)
            row = compared(result.solution.points, block.truth)
            rows.append((way, *row, result.claim is None or result.claim.is_supported))
    columns = ["way", "claimed", "true", "ellipses", "is_supported"]
    return pd.DataFrame(rows, columns=columns).groupby("way").mean()


@pytest.mark.parametrize("way", ["two steps", "simultaneous"])
def test_claims_are_true(figures, way):
    one = figures.loc[way]
    # points of a block share errors: five blocks tell the ratio to some eight per cent
    assert np.sqrt(one["claimed"] / one["true"]) == pytest.approx(1.0, abs=0.2)
    assert one["ellipses"] > 0.85
    assert one["is_supported"] == 1.0


def test_ignored_they_make_claims_too_small_and_points_worse(figures):
    ignored, modelled = figures.loc["ignored"], figures.loc["simultaneous"]
    assert np.sqrt(ignored["claimed"] / ignored["true"]) < 0.75
    assert np.sqrt(modelled["true"] / ignored["true"]) < 0.8
    assert modelled["true"] < 0.6 * figures.loc["two steps", "true"]


def test_a_result_says_what_its_models_are_deformed_by():
    block = bent(simulate_block("demo", seed=1), EDGE_M, 1)
    together = densify(block, Settings(method="simultaneous"))
    found = together.simultaneous.deformations.set_index("flight")
    assert found.loc["low_flight", "own_size_edge"] == pytest.approx(0.09, abs=0.03)
    assert found["own_is_modelled"].tolist() == [False, True]
    assert "models the deformation of each model" in together.summary()
    two_steps = densify(block)
    assert "standard_error_own_deformation" in two_steps.error_sources
    assert "deformation of each model" in two_steps.summary()
    ignored = densify(block, Settings(model_deformation="ignored"))
    assert "standard_error_own_deformation" not in ignored.error_sources
