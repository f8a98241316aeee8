"""Control of a region that is off by one shift, and what data snooping makes of it."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block

pytestmark = pytest.mark.slow

PLAN = ["easting", "northing"]
SNOOPED = {"method": "simultaneous", "outliers": "snoop"}


def solved(block):
    return densify(block, block.settings.updated(SNOOPED))


def rms_of_new(result, truth):
    new = result.points[result.points["role"] == "new"]
    true = truth.set_index("point_id")[PLAN].reindex(new["point_id"]).to_numpy()
    return float(np.sqrt(np.mean(np.sum((new[PLAN].to_numpy() - true) ** 2, axis=1))))


def with_shifted_region(block, shift, *, keeps_check):
    """Control within a third of the block's width of its first point, off by a shift.

    The high flight is left out: approximate coordinates that agree with the control.
    """
    control, rng = block.control_points.copy(), np.random.default_rng(0)
    approximate = block.truth[["point_id", *PLAN]].copy()
    centre = approximate[PLAN].mean()
    centre["northing"] += 0.3 * np.ptp(approximate["northing"])
    approximate[PLAN] += 0.06 * rng.standard_normal((len(approximate), 2))
    reach = 0.35 * np.ptp(approximate["easting"])
    for table in (control, approximate):
        away = table[PLAN].to_numpy() - centre.to_numpy()
        table.loc[np.hypot(*away.T) < reach, PLAN] += shift
    if not keeps_check:
        control = control[control["role"] != "check"]
    return replace(
        block,
        control_points=control,
        high_flight=None,
        approximate_points=approximate,
        approximate_m_0_m=0.09,
    )


@pytest.mark.parametrize("seed", [15, 16])
def test_control_set_aside_in_one_direction_supports_no_claim(seed):
    """Good control was set aside: 4 cm stood there, supported, where 1 m was true."""
    block = simulate_block("demo", seed=seed)
    shifted = with_shifted_region(block, [1.5, 1.5], keeps_check=False)
    result = solved(shifted)
    judged = result.assessment
    found = next(f for f in judged.findings if f.code == "control_set_aside")
    assert found.facts["n_points"] > 1
    assert found.facts["are_alike"]
    assert found.gravity is Gravity.GRAVE
    assert found.remedy == "check_all_control"
    assert judged.claim_is_supported is False
    assert judged.credible.is_lower_bound
    stated = result.examination.figures.mean_total
    true = rms_of_new(result, block.truth)
    assert true > 3.0 * stated  # so that it matters
    assert judged.credible.value > 3.0 * stated


def test_single_wrong_control_leaves_the_claim_supported():
    block = simulate_block("demo", seed=15)
    control = block.control_points.copy()
    rows = control.index[control["role"] != "check"][[0, 7]]
    control.loc[rows, PLAN] += np.array([[2.0, 0.0], [0.3, -1.0]])
    control = control[control["role"] != "check"]
    judged = solved(replace(block, control_points=control)).assessment
    found = next(f for f in judged.findings if f.code == "control_set_aside")
    assert found.facts["n_points"] == len(rows)
    assert not found.facts["are_alike"]
    assert found.gravity is Gravity.WARNING
    assert judged.claim_is_supported


def test_check_points_that_agree_tell_which_control_is_wrong():
    block = simulate_block("demo", seed=15)
    control = block.control_points.copy()
    rows = control.index[control["role"] != "check"][[0, 7]]
    control.loc[rows, PLAN] += [2.0, 0.5]  # the same error of both
    checked = solved(replace(block, control_points=control)).assessment
    found = next(f for f in checked.findings if f.code == "control_set_aside")
    assert set(found.names) == set(control.loc[rows, "point_id"])
    assert not found.facts["are_alike"]
    assert checked.claim_is_supported
    unchecked = control[control["role"] != "check"]
    judged = solved(replace(block, control_points=unchecked)).assessment
    assert judged.claim_is_supported is False
