"""The error of an operation between reference systems is shared by all points."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.adjust_block import adjust_block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.stages.error_propagation.shared_error import shared_error_of

SHARED = 1.5
TOTAL, BY_AXIS = "standard_error_total", "standard_error_easting"
METHODS = {"two_step": Settings(), "simultaneous": Settings(method="simultaneous")}


@pytest.fixture(scope="module")
def results(demo_block):
    """Each way without a shared error and with one."""
    brought = replace(demo_block, shared_errors_m={"control_points": SHARED})
    return {
        name: [densify(block, settings) for block in (demo_block, brought)]
        for name, settings in METHODS.items()
    }


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_it_stands_in_the_standard_error_of_every_point(results, method):
    plain, shared = (result.points for result in results[method])
    np.testing.assert_allclose(shared[TOTAL], np.hypot(plain[TOTAL], SHARED))
    each = np.hypot(plain[BY_AXIS], SHARED / np.sqrt(2.0))
    np.testing.assert_allclose(shared[BY_AXIS], each)
    np.testing.assert_allclose(shared["covariance_en"], plain["covariance_en"])
    for axis in ("easting", "northing"):
        np.testing.assert_array_equal(shared[axis], plain[axis])


@pytest.mark.parametrize("method", METHODS)
def test_nothing_within_the_block_can_see_it(results, method):
    plain, shared = results[method]
    for part in ("known_check", "known_control"):
        ratios = [getattr(r.examination, part).ratio for r in (plain, shared)]
        assert ratios[0] == pytest.approx(ratios[1], rel=1e-9)
    codes = [
        {finding.code for finding in r.assessment.findings} for r in results[method]
    ]
    assert codes[0] == codes[1]
    within = plain.examination.credible.value
    believed = shared.examination.credible
    assert believed.reason == plain.examination.credible.reason
    assert believed.value == pytest.approx(np.hypot(within, SHARED))


def test_it_is_a_source_of_its_own(results):
    _, shared = results["two_step"]
    table = shared.error_sources
    np.testing.assert_allclose(table["standard_error_reference_system"], SHARED)
    parts = table.filter(like="standard_error_").drop(columns=TOTAL)
    np.testing.assert_allclose((parts**2).sum(axis=1), table[TOTAL] ** 2)
    assert shared.block_error_sources["source"].iloc[0] == "reference_system"
    assert "operation between reference systems" in shared.summary()


def test_differences_of_points_are_without_it(results):
    plain, shared = (result.neighbours for result in results["two_step"])
    np.testing.assert_allclose(shared[TOTAL], plain[TOTAL], rtol=1e-9)


def test_a_shift_of_the_control_is_carried_to_every_point(results, demo_block):
    # the weight of one in every point, seen in a computation
    control = demo_block.control_points
    moved = control.assign(
        easting=control["easting"] + 1.2, northing=control["northing"] - 0.9
    )
    for name, settings in METHODS.items():
        there = densify(
            replace(demo_block, control_points=moved), settings
        ).solution.points
        here = results[name][0].solution.points
        np.testing.assert_allclose(there["easting"] - here["easting"], 1.2, atol=1e-6)
        np.testing.assert_allclose(
            there["northing"] - here["northing"], -0.9, atol=1e-6
        )


@pytest.mark.slow
def test_heights_share_nothing():
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    block = simulate_block("demo", seed=2, geometry=geometry)
    flights = {
        name: replace(flight, transformation="helmert_3d")
        for name, flight in block.flights.items()
    }
    block = replace(block, **flights)
    plain = densify(block).solution.points
    shared = densify(
        replace(block, shared_errors_m={"control_points": SHARED})
    ).solution.points
    assert "standard_error_height" in plain
    column = "standard_error_height"
    np.testing.assert_allclose(shared[column], plain[column])
    np.testing.assert_allclose(shared[TOTAL], np.hypot(plain[TOTAL], SHARED))


def test_it_comes_from_the_points_that_the_block_hangs_on(given_approximations_result):
    errors = {"control_points": 1.0, "approximate_points": 2.0}
    block = given_approximations_result.block
    block = replace(block, shared_errors_m=errors)
    assert block.high_flight is None
    assert shared_error_of(block) == 2.0
    assert shared_error_of(block, "simultaneous") == 1.0


def test_the_adjustment_by_itself_has_it_too(demo_block):
    brought = replace(demo_block, shared_errors_m={"control_points": SHARED})
    plain, shared = adjust_block(demo_block).points, adjust_block(brought).points
    np.testing.assert_allclose(shared[TOTAL], np.hypot(plain[TOTAL], SHARED))
    np.testing.assert_array_equal(shared["easting"], plain["easting"])
