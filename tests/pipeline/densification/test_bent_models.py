"""Two steps of spatial models that are all bent alike."""

from dataclasses import replace

import numpy as np
import pytest
from tests.stages.simultaneous.test_shared_bends import (
    bent,
    distorted,
    simulated,
    with_flights,
)

import einschalt as es
from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.densification.two_steps import solve_in_two_steps

SPACE = ["easting", "northing", "height"]
BENDS = {"machine": lambda f: bent(f, 0.03), "images": lambda f: distorted(f, 0.02)}


def over_claimed(results):
    """True over claimed error of new heights, of many results."""
    true, claimed = 0.0, 0.0
    for result, truth in results:
        points = result.points[result.points["role"] == "new"].set_index("point_id")
        known = truth.set_index("point_id").loc[points.index]
        true += np.sum((points["height"] - known["height"]) ** 2)
        claimed += np.sum(points["standard_error_height"] ** 2)
    return np.sqrt(true / claimed)


@pytest.mark.slow
@pytest.mark.parametrize("measurement", ["machine", "images"])
def test_heights_are_as_good_as_claimed(measurement):
    results, plain = [], []
    for seed in range(6):
        block = with_flights(simulated(seed, measurement), BENDS[measurement])
        result = es.densify(block)
        assert result.two_step is None or result.settings.method == "two_step"
        assert result.solution.shared_bends is not None
        results.append((result, block.truth))
        ignored = es.densify(block, es.Settings(model_deformation="ignored"))
        assert ignored.solution.shared_bends is None
        plain.append((ignored, block.truth))
    assert over_claimed(results) == pytest.approx(1.0, abs=0.2)
    assert over_claimed(plain) > 1.2 * over_claimed(results)


@pytest.mark.slow
def test_what_the_bends_are_not_known_by_is_a_source_of_error():
    """As when the coefficients that correct the models are others by their error."""
    block = with_flights(simulated(3), BENDS["machine"])
    result = es.densify(block)
    solution = result.solution
    bends = solution.shared_bends
    rng = np.random.default_rng(7)
    root = np.linalg.cholesky(bends.covariance)
    squares = 0.0
    n_draws = 60
    for _ in range(n_draws):
        moved = bends.coefficients + root @ rng.standard_normal(len(root))
        other = solution_with(solution, moved)
        squares = squares + (other.points[SPACE] - solution.points[SPACE]) ** 2
    seen = np.sqrt(np.mean(squares["height"] / n_draws))
    part = solution.errors.parts["shared_bend"]
    assert seen == pytest.approx(np.sqrt(np.mean(part[:, 2, 2])), rel=0.2)
    assert "standard_error_shared_bend" in result.error_sources


def solution_with(solution, coefficients):
    """The same flights, straightened by other coefficients."""
    bends = replace(solution.shared_bends, coefficients=coefficients)
    known = replace(solution, shared_bends=bends)
    what = solution.block, solution.settings, solution.flights, lambda *_: None
    return solve_in_two_steps(*what, before=known, searched=solution.searched)


def test_straight_models_are_left_as_they_are():
    result = es.densify(simulated(2))
    assert result.solution.shared_bends is None
    assert "shared_bend" not in result.solution.errors.parts


@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_it_is_told_what_was_corrected(method):
    block = with_flights(simulated(1), BENDS["machine"])
    told = es.densify(block, es.Settings(method=method))
    found = {each.code: each for each in told.assessment.findings}
    assert found["bent_models"].names == ("high_flight", "low_flight")
    assert "are bent alike" in str(told)
    assert "curvature_untold" not in found
    straight = es.densify(simulated(1), es.Settings(method=method))
    assert "bent_models" not in {each.code for each in straight.assessment.findings}


def test_models_that_were_corrected_are_not_published(tmp_path):
    """Their parameters lead from corrected coordinates, which nobody else has."""
    block = replace(with_flights(simulated(1), BENDS["machine"]), crs=None)
    result = es.densify(block)
    result.write(tmp_path / "results")
    for published in (result, tmp_path / "results"):
        with pytest.raises(GeometryError, match="no transformation"):
            es.publish(published, "demo", tmp_path / "published", crs="EPSG:31255")


def test_bends_found_with_gross_errors_are_not_those_without_them():
    """Heights were 3 cm off those of the same block, snooped from the beginning."""
    block = with_flights(simulated(1), BENDS["machine"])
    points = block.low_flight.model_points.copy()
    rows = np.random.default_rng(2).choice(len(points), 6, replace=False)
    points.loc[points.index[rows], "z"] += 0.8  # mm
    block = replace(block, low_flight=replace(block.low_flight, model_points=points))
    kept, snooped = (
        es.densify(block, es.Settings(outliers=outliers)).solution
        for outliers in ("keep", "snoop")
    )
    what = block, snooped.settings, kept.flights, lambda *_: None
    again = solve_in_two_steps(*what, before=kept)
    np.testing.assert_allclose(
        again.shared_bends.coefficients, snooped.shared_bends.coefficients
    )
    assert not np.allclose(
        kept.shared_bends.coefficients, snooped.shared_bends.coefficients, rtol=0.05
    )
