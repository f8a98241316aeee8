"""Lists of approximate coordinates in which control points have their given ones."""

from dataclasses import replace

import numpy as np
import pytest
from tests.given_approximations import onto_given_approximations

from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.theory.adjustment.least_squares import SQRT2

PLAN = ["easting", "northing"]
OWN, OF_CONTROL = 0.10, 0.02  # TOTAL [m]


def block_with_control(seed, is_stated=True):
    """Half of the points are control, and stand as such in the approximate ones."""
    simulated = simulate_block("demo", seed=seed)
    rng = np.random.default_rng(seed)
    control = simulated.truth[["point_id", *PLAN]].iloc[::2].reset_index(drop=True)
    control[PLAN] += rng.normal(0.0, OF_CONTROL / SQRT2, (len(control), 2))
    control = control.assign(standard_error_m=OF_CONTROL, role="control")
    block = onto_given_approximations(
        simulated, own_error=OWN, seed=seed, is_stated=is_stated
    )
    known = block.approximate_points.set_index("point_id")
    known.loc[control["point_id"], PLAN] = control[PLAN].to_numpy()
    stated = OWN if is_stated else None
    return replace(
        block,
        control_points=control,
        approximate_points=known.reset_index(),
        approximate_m_0_m=stated,
    ), simulated.truth.set_index("point_id")


@pytest.mark.parametrize("is_stated", [True, False])
def test_they_have_the_errors_of_control(is_stated):
    block, _ = block_with_control(1, is_stated)
    sizes = densify(block).examination.error_model.standard_errors["approximate_points"]
    ids = block.approximate_points["point_id"]
    is_control = ids.isin(block.control_points["point_id"]).to_numpy()
    assert sizes[is_control] == pytest.approx(OF_CONTROL / SQRT2)
    # what residuals leave of the others, without those of control
    assert sizes[~is_control] == pytest.approx(
        OWN / SQRT2, rel=1e-12 if is_stated else 0.2
    )


@pytest.mark.slow
def test_a_clean_block_is_told_as_good_as_it_is():
    ratios = []
    for seed in range(1, 6):
        block, truth = block_with_control(seed)
        result = densify(block)
        assert result.claim.is_supported
        new = result.points[result.points["role"] == "new"].set_index("point_id")
        miss = (new[PLAN] - truth.loc[new.index, PLAN]).to_numpy()
        true = np.sqrt(np.mean(np.sum(miss**2, axis=1)))
        ratios.append(result.examination.credible.value / true)
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.1)


def test_what_is_said_of_groups_comes_first():
    block, _ = block_with_control(2)
    known = block.approximate_points
    group = np.where(np.arange(len(known)) % 2, "west", "east")
    block = replace(
        block,
        approximate_points=known.assign(group=group),
        group_errors_m={"approximate_points": 0.05},
    )
    sizes = densify(block).examination.error_model.standard_errors["approximate_points"]
    assert sizes == pytest.approx(OWN / SQRT2)
