"""Sizes of errors that the measurements of simulated blocks show."""

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from einschalt.pipeline.assessment.evidence import variance_components
from einschalt.pipeline.assessment.evidence.variance_components import Component
from einschalt.pipeline.assessment.findings.suspects import wrong_measuring_errors
from einschalt.pipeline.block.block import Block, plain_fields
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.pipeline.summary.sections.flights import measured_error_remarks

SEEDS = range(20)
TRUE = {"control": 0.03, "high_flight": 7.5, "low_flight": 5.0}


def with_flights(block, **changes):
    """The block with other facts of its flights: ``low_flight={"m_g_um": 7.5}``."""
    plain = {f.name: getattr(block, f.name) for f in fields(Block)}
    for name, facts in changes.items():
        flight = plain[name]
        plain[name] = type(flight)(**{**plain_fields(flight), **facts})
    return Block(**plain)


@pytest.fixture(scope="module")
def components():
    """Estimates of small blocks in which a third of the given sizes is wrong."""
    found = []
    for seed in SEEDS:
        block = simulate_block("demo", seed=seed)
        wrong = with_flights(block, low_flight={"m_g_um": 7.5})
        found.append(densify(wrong).components)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("source", TRUE)
def test_true_sizes_lie_within_their_standard_errors(components, source):
    found = [getattr(c, source) for c in components]
    z = np.array([(c.estimated - TRUE[source]) / c.standard_error for c in found])
    # 20 blocks: means within 3.3 / √20; standard errors uncertain by 16 %
    assert abs(z.mean()) < 0.75
    assert 0.6 < z.std() < 1.5
    assert np.mean(np.abs(z) < 2) >= 0.8


def test_given_sizes_are_said_beside(components):
    assert components[0].low_flight.given == 7.5
    assert components[0].high_flight.given == 7.5
    assert components[0].control.given == pytest.approx(0.03)


@pytest.mark.parametrize("kinds", [("affine", "helmert"), ("rigid", "affine")])
def test_every_plane_kind_and_mode(kinds):
    block = simulate_block("demo", seed=2)
    facts = [{"transformation": kind} for kind in kinds]
    if "rigid" in kinds:
        # machine coordinates at the scale of the ground
        points = block.high_flight.model_points
        points = points.assign(x=points["x"] * 15.0, y=points["y"] * 15.0)
        facts[0] |= {"model_points": points, "model_unit": "m"}
    block = with_flights(block, high_flight=facts[0], low_flight=facts[1])
    result = densify(block, Settings(coverage_mean="most_central", outliers="snoop"))
    for source in ("high_flight", "low_flight"):
        found = getattr(result.components, source)
        off = abs(found.estimated - TRUE[source])
        assert off < 3.5 * found.standard_error


def test_nothing_is_estimated_where_sizes_are_not_known(given_approximations_result):
    assert given_approximations_result.components is None
    assert measured_error_remarks(given_approximations_result.assessment.flights) == ()
    assert wrong_measuring_errors(given_approximations_result.examination) is None


def test_one_coverage_of_single_models_is_too_small_to_tell():
    block = simulate_block("demo", seed=2)
    points = block.low_flight.model_points
    one = points[points["coverage"] == points["coverage"].iloc[0]]
    first = one.drop_duplicates("point_id")
    block = with_flights(block, low_flight={"model_points": first})
    found = densify(block).components
    # misfits of the low flight are left: they still tell, but hardly
    assert found is None or found.low_flight.standard_error > 0.2


def test_a_wrong_m_g_is_called_out(good_result):
    wrong = with_flights(good_result.block, low_flight={"m_g_um": 7.5})
    result = densify(wrong)
    found = wrong_measuring_errors(result.examination)
    assert found.names == ("low_flight",)
    low = result.components.low_flight
    assert found.facts["flights"][0] == {
        "flight": "low_flight",
        "given_um": 7.5,
        "estimated_um": low.estimated,
        "standard_error_um": low.standard_error,
    }
    assert found.remedy == "give_that_m_g"
    assert wrong_measuring_errors(good_result.examination) is None


def test_summary_says_both_flights(good_result):
    high, low = measured_error_remarks(good_result.assessment.flights)
    assert high.startswith("m_g of the high flight: given 7.5 µm, estimated 7.")
    assert low.startswith("m_g of the low flight: given 5.0 µm, estimated 4.9")
    assert low.endswith(" µm.")


def test_far_too_large_errors_are_gross_ones():
    fine = Component(5.0, 5.0, 0.2)
    wild = Component(5.0, 90.0, 3.0)
    components = SimpleNamespace(high_flight=fine, low_flight=wild)
    found = wrong_measuring_errors(SimpleNamespace(components=components))
    assert found.remedy == "look_for_gross_errors"
    small = replace(wild, estimated=5.3, standard_error=0.01)
    components = SimpleNamespace(high_flight=fine, low_flight=small)
    assert wrong_measuring_errors(SimpleNamespace(components=components)) is None


@pytest.mark.slow
def test_settings_of_each_point_count():
    """Half of the points set four times: their errors are half as large."""
    block = simulate_block("demo", seed=5)
    points = block.low_flight.model_points
    n_settings = np.where(np.arange(len(points)) % 2, 4.0, 1.0)
    low = {"model_points": points.assign(n_settings=n_settings)}
    plain, counted = densify(block), densify(with_flights(block, low_flight=low))
    sigma = counted.errors.standard_errors["low_flight"]
    expected = plain.errors.standard_errors["low_flight"] / np.sqrt(n_settings)
    np.testing.assert_allclose(sigma, expected)
    # M² = (m_g · scale number)² / k + m_t²
    m_g = 5e-6 * 8000
    values = counted.single_values
    expected = np.hypot(m_g / np.sqrt(n_settings), values["m_t"])
    np.testing.assert_allclose(values["standard_error_paper"], expected)
    assert counted.figures.mean_total < plain.figures.mean_total
    # all means of four settings are as one setting of half the error
    all_four = {"model_points": points.assign(n_settings=4.0)}
    halved = densify(with_flights(block, low_flight={"m_g_um": 2.5}))
    four = densify(with_flights(block, low_flight=all_four))
    assert four.figures.mean_total == pytest.approx(halved.figures.mean_total)


@pytest.mark.slow
def test_patches_of_a_large_block_tell_the_same_less_well(monkeypatch):
    """Of a country nobody needs every point to know its m_g."""
    geometry = BlockGeometry(width=21_500.0, height=21_500.0)
    block = simulate_block("neukirchen", seed=3, geometry=geometry)
    whole = densify(block).components
    monkeypatch.setattr(variance_components, "MOST_VALUES", 6_000)
    monkeypatch.setattr(variance_components, "VALUES_OF_PATCH", 600)
    part = densify(block).components
    for source, true in TRUE.items():
        estimate, of_whole = getattr(part, source), getattr(whole, source)
        assert estimate != of_whole
        assert estimate.given == of_whole.given
        assert abs(estimate.estimated - true) < 4.0 * estimate.standard_error
        # a third of the points; the draws know a standard error to a tenth
        ratio = estimate.standard_error / of_whole.standard_error
        assert 1.2 < ratio < 3.0, source
