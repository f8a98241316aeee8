"""Facts of flights, beside numbers from the tables of the block and the result."""

import numpy as np
import pytest

from einschalt.pipeline.assessment.facts.flights import (
    approximation_facts,
    flight_facts,
)

RESULTS = ["good", "faulty", "unchecked"]


def of(result):
    return {facts.name: facts for facts in flight_facts(result.examination)}


@pytest.mark.parametrize("name", RESULTS)
def test_models_are_those_of_the_tables(name, request):
    result = request.getfixturevalue(f"{name}_result")
    facts = of(result)
    assert list(facts) == ["high_flight", "low_flight"]
    for flight, one in facts.items():
        rows = result.models[result.models["flight"] == flight]
        given = result.block.flights[flight].model_points
        assert one.n_models == len(given.groupby(["coverage", "model_id"]))
        assert one.n_usable == rows["is_usable"].sum()
        assert one.orientation is None


def test_failed_models_are_not_usable(faulty_result):
    low = of(faulty_result)["low_flight"]
    assert (low.n_models, low.n_usable) == (23, 20)


def test_m_g_on_the_ground_and_m_0_of_all_models(good_result):
    facts = of(good_result)
    assert facts["high_flight"].m_g_ground == pytest.approx(7.5e-6 * 15_000)
    assert facts["low_flight"].m_g_ground == pytest.approx(5e-6 * 8_000)
    residuals = good_result.residuals
    for name, one in facts.items():
        part = residuals[residuals["flight"] == name]
        squares = (part[["residual_easting", "residual_northing"]] ** 2).sum().sum()
        models = good_result.models[good_result.models["flight"] == name]
        redundancy = models["redundancy"].sum()
        # total: of both coordinates
        assert one.m_0 == pytest.approx(np.sqrt(2.0 * squares / redundancy))


def test_m_g_that_the_data_show_is_the_estimated_component(
    good_result, given_approximations_result
):
    for name, one in of(good_result).items():
        assert one.shown_m_g is getattr(good_result.components, name)
        assert abs(one.shown_m_g.estimated - one.m_g_um) < 3 * (
            one.shown_m_g.standard_error
        )
    assert of(given_approximations_result)["low_flight"].shown_m_g is None


def test_orientations_by_parallaxes(parallaxes_result):
    orientations = parallaxes_result.orientations
    for name, one in of(parallaxes_result).items():
        rows = orientations[orientations["flight"] == name]
        found = one.orientation
        assert found.n_models == len(rows)
        assert not found.is_from_images
        assert found.image_points is None
        weight = rows["redundancy"].to_numpy(dtype=float)
        square = np.sum(weight * rows["sigma_0"].astype(float) ** 2) / weight.sum()
        assert found.sigma_0 == pytest.approx(1e-3 * np.sqrt(square))
        bent = rows["m_g_orientation_um"].to_numpy(dtype=float)
        assert found.m_g_orientation_um == pytest.approx(np.sqrt(np.mean(bent**2)))


def test_approximations_of_a_high_flight(good_result, simultaneous_result):
    facts = approximation_facts(good_result.examination)
    assert facts.n_points == len(good_result.approximations)
    assert not facts.is_given
    assert 0.0 < facts.total < 0.3
    beside = approximation_facts(simultaneous_result.examination)
    assert beside.n_points == facts.n_points


def test_approximations_that_were_given(given_approximations_result):
    facts = approximation_facts(given_approximations_result.examination)
    given = given_approximations_result.block.approximate_points
    assert (facts.n_points, facts.is_given, facts.total) == (len(given), True, 0.09)
