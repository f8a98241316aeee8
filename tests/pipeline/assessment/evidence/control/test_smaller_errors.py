"""Control whose standard errors are stated much larger than they are: it is told."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.assessment.evidence.control.smaller_errors import (
    size_of_control,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.theory.adjustment.global_tests import ratio_limits

METHODS = ("two_step", "simultaneous")
CODE = "wrong_control_errors"


def stated(block, times):
    """The block with standard errors of control that are stated as many times."""
    control = block.control_points
    errors = {
        name: times * control[name]
        for name in control
        if name in ("standard_error_m", "standard_error_height")
    }
    return replace(block, control_points=control.assign(**errors))


def told(block, method):
    result = densify(block, Settings(method=method))
    found = [each for each in result.assessment.findings if each.code == CODE]
    return result, (found[0] if found else None)


@pytest.mark.parametrize("method", METHODS)
def test_centimetres_for_metres_are_recognised(demo_block, method):
    given = float(np.sqrt(np.mean(demo_block.control_points["standard_error_m"] ** 2)))
    result, found = told(stated(demo_block, 100.0), method)
    facts = found.facts
    assert facts["stated"] == pytest.approx(100.0 * given, rel=0.1)
    # control points are few: their errors are known to a fifth
    assert abs(facts["shown"] - given) < 4.0 * facts["error_of_shown"]
    assert facts["error_of_shown"] < 0.4 * given
    assert facts["unit"] == "centimetres"
    assert found.remedy == "check_unit_of_control_errors"
    said = " ".join(result.summary().split())
    assert "as if they were centimetres. Give standard_error_m in metres" in said


@pytest.mark.parametrize("method", METHODS)
def test_control_as_it_is_stated_is_not_accused(demo_block, method):
    _, found = told(demo_block, method)
    assert found is None


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60, 64))
@pytest.mark.parametrize("kind", ["affine", "helmert_3d"])
def test_what_is_stated_ten_times_has_its_size_told(seed, kind):
    geometry = replace(PRESETS["demo"].geometry, transformation=kind)
    block = simulate_block("demo", seed=seed, geometry=geometry)
    given = float(np.sqrt(np.mean(block.control_points["standard_error_m"] ** 2)))
    for method in METHODS:
        assert told(block, method)[1] is None
        facts = told(stated(block, 10.0), method)[1].facts
        redundancy = (facts["shown"] / facts["error_of_shown"]) ** 2 / 2.0
        least, most = ratio_limits(redundancy, 0.001)
        assert least < facts["shown"] / given < most
        assert facts["stated"] == pytest.approx(10.0 * given)


@pytest.mark.slow
def test_what_is_a_guess_by_three_is_told_by_one_adjustment(demo_block):
    _, found = told(stated(demo_block, 3.0), "simultaneous")
    assert found.remedy == "give_that_standard_error"
    assert found.facts["shown"] < 0.5 * found.facts["stated"]


def test_control_that_shares_errors_tells_nothing(demo_block):
    """Its residuals are smaller than its errors, which are as stated."""
    block = replace(demo_block, correlation_lengths_m={"control_points": 1000.0})
    result = densify(stated(block, 100.0), Settings(method="two_step"))
    assert size_of_control(result.examination) is None
