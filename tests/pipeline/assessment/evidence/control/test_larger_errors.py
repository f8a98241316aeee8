"""Control of spatial models that is worse than it was given, and nothing else told it.

What an adjustment says of such a block, against its known truth.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.judged_alone import judged_alone

from einschalt.pipeline.assessment.evidence.control.larger_errors import (
    larger_control_errors,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

pytestmark = pytest.mark.slow

PLANE, GROUND = ["easting", "northing"], ["easting", "northing", "height"]
SIMULTANEOUS = Settings(method="simultaneous")
GIVEN = 0.03  # standard error of control, TOTAL [m]


def spatial_block(seed):
    geometry = replace(
        PRESETS["demo"].geometry,
        width=3800.0,
        height=3600.0,
        point_spacing=300.0,
        n_check=0,
        transformation="helmert_3d",
    )
    return simulate_block("demo", seed=seed, geometry=geometry)


def with_alike_control(block, error_m, length_m, seed):
    """Errors of control that neighbours have in common, and that nobody stated."""
    control = block.control_points.copy()
    xy = control[PLANE].to_numpy()
    apart = np.linalg.norm(xy[:, None] - xy[None], axis=2)
    root = np.linalg.cholesky(np.exp(-apart / length_m) + 1e-9 * np.eye(len(xy)))
    drawn = root @ np.random.default_rng(seed).standard_normal((len(xy), 3))
    control[GROUND] += error_m / np.sqrt(2.0) * drawn
    return replace(block, control_points=control)


def with_approximations(block, error_m, stated_m, seed):
    """Given approximate coordinates instead of a high flight."""
    rng, given = np.random.default_rng(seed), block.truth[["point_id", *GROUND]].copy()
    given[GROUND] += error_m / np.sqrt(2.0) * rng.standard_normal((len(given), 3))
    return replace(
        block,
        high_flight=None,
        approximate_points=given,
        approximate_m_0_m=stated_m,
    )


def true_error(block, result):
    new = result.points[result.points["role"] == "new"]
    truth = block.truth.set_index("point_id").loc[new["point_id"], PLANE]
    apart = new[PLANE].to_numpy() - truth.to_numpy()
    return float(np.sqrt(np.mean(np.sum(apart**2, axis=1))))


def codes(result):
    return judged_alone(result)


@pytest.mark.parametrize("seed", [0, 3])
def test_larger_errors_are_told_and_counted(seed):
    block = with_alike_control(spatial_block(seed), 0.10, 1300.0, seed)
    result = densify(block, SIMULTANEOUS)
    found = larger_control_errors(result.examination)
    assert found.factor > 1.3
    assert "contradicting_control" in codes(result)
    credible = result.examination.credible
    assert credible.is_lower_bound
    claimed = float(result.examination.figures.mean_within)
    assert credible.value >= found.factor * claimed
    assert credible.value / true_error(block, result) > 0.75


@pytest.mark.parametrize("seed", range(4))
def test_errors_as_given_are_not_told(seed):
    result = densify(spatial_block(seed), SIMULTANEOUS)
    assert larger_control_errors(result.examination) is None
    assert "contradicting_control" not in codes(result)


def test_what_control_shares_by_its_statement_is_no_larger_error():
    block = with_alike_control(spatial_block(0), 0.10, 1300.0, seed=0)
    stated = block.control_points.assign(standard_error_m=np.hypot(0.10, GIVEN))
    block = replace(
        block,
        control_points=stated,
        correlation_lengths_m={"control_points": 1300.0},
    )
    assert larger_control_errors(densify(block, SIMULTANEOUS).examination) is None


def test_far_approximations_make_no_worse_figure():
    """Two steps onto coordinates of 30 cm lie 30 cm away: that was stated."""
    block = with_alike_control(spatial_block(0), 0.10, 1300.0, seed=0)
    block = with_approximations(block, 0.30, stated_m=0.30, seed=5)
    result = densify(block, SIMULTANEOUS)
    # which of both: errors that neighbours share look like a part that lies apart
    assert {"contradicting_control", "broken_network"} & set(codes(result))
    assert 0.75 < result.examination.credible.value / true_error(block, result) < 2.0
