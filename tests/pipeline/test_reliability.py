"""How large a gross error must be to be found, of every measurement."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.stages.stage3_model_transformation import transform_models

KEY = ["flight", "coverage", "model_id", "point_id"]
# two-sided 0.001 and power 0.80: the other tail adds nothing
DELTA = norm.isf(0.0005) + norm.isf(0.2)


@pytest.fixture(scope="module")
def block():
    return simulate_block("demo", seed=1)


@pytest.fixture(scope="module", params=["two_step", "simultaneous"])
def result(request, block):
    return densify(block, Settings(method=request.param))


def test_of_every_measurement_that_has_a_residual(result):
    found = result.reliability
    pd.testing.assert_frame_equal(found[KEY], result.residuals[KEY])
    np.testing.assert_allclose(
        found["redundancy_number"], result.residuals["redundancy_number"]
    )


def test_bias_is_that_of_baarda(block, result):
    found = result.reliability
    for flight, rows in found.groupby("flight"):
        if result.simultaneous is None:
            fits = {"high_flight": result.solution.high.transformation}
            sigma = fits.get(flight, result.solution.low).m_0 / np.sqrt(2.0)
        else:
            given = block.flights[flight]
            sigma = given.m_g_um * 1e-6 * given.scale_number / np.sqrt(2.0)
        r = rows["redundancy_number"]
        is_checked = r > 1e-6
        np.testing.assert_allclose(
            rows["minimal_detectable_bias"][is_checked],
            sigma * DELTA / np.sqrt(r[is_checked]),
            rtol=1e-4,
        )
        np.testing.assert_allclose(
            rows["external_reliability"][is_checked],
            ((1.0 - r) * rows["minimal_detectable_bias"])[is_checked],
        )


def test_unchecked_points_may_have_any_error(block):
    points = block.low_flight.model_points
    model = points["coverage"] + points["model_id"]
    is_left = (model != model.iloc[0]) | (points.groupby(model).cumcount() < 3)
    poor = transform_models(points[is_left], densify(block).approximations)
    first = poor.reliability.iloc[:3]
    assert np.isinf(first["minimal_detectable_bias"]).all()
    assert np.isinf(first["external_reliability"]).all()


def test_an_error_of_that_size_is_found_with_its_power():
    """An error of the size of the bias is found in four of five models."""
    rng, sigma, n = np.random.default_rng(0), 0.05, 4000
    xy = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1], [0, 0]]) * 500.0
    names = [f"{k}" for k in range(5)]
    ground = pd.DataFrame(xy, columns=["easting", "northing"]).assign(point_id=names)
    points = pd.concat(
        [ground.rename(columns={"easting": "x", "northing": "y"})] * n,
        ignore_index=True,
    ).assign(model_id=np.repeat(np.arange(n).astype(str), 5))
    points[["x", "y"]] += rng.normal(0.0, sigma, (5 * n, 2))
    fit = transform_models(points, ground)
    bias = fit.reliability["minimal_detectable_bias"].to_numpy()[0]
    # the error of the first point along x enters its residual with −r
    r = fit.reliability["redundancy_number"].to_numpy()[0]
    v = fit.residuals["residual_easting"].to_numpy()[::5]
    w = (v + r * bias) / (sigma * np.sqrt(r))
    share = np.mean(np.abs(w) > norm.isf(0.0005))
    # σ is known to 0.5 % from 8000 degrees of freedom; 4000 models
    assert share == pytest.approx(0.80, abs=0.03)
