"""Machine coordinates x, y, z: the error of z is that which the residuals show."""

from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from tests.flat_site import FLAT_SITE

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import (
    BlockGeometry,
    BlockNoise,
    simulate_block,
)
from einschalt.pipeline.summary.sections.precision import remarks
from einschalt.stages.stage4_error_propagation import obstacle_to_propagation

GROUND = ["easting", "northing", "height"]
FLIGHTS = ("high_flight", "low_flight")
GEOMETRY = BlockGeometry(
    width=2_500.0,
    height=2_500.0,
    point_spacing=250.0,
    transformation="helmert_3d",
    control_per_model=9,
    crs=FLAT_SITE,  # operators are of straight lines
)
NO_NOISE = BlockNoise(control_standard_error=0.0, high_m_g_um=0.0, low_m_g_um=0.0)


@cache
def machine_block(seed=1, noise=None):
    block = simulate_block("demo", seed=seed, geometry=GEOMETRY, noise=noise)
    return Block(**{f.name: getattr(block, f.name) for f in fields(Block)})


@pytest.fixture(scope="module")
def result():
    return densify(machine_block())


def ratios(result):
    sizes = result.errors.standard_errors
    return [sizes[name][0, 2] / sizes[name][0, 0] for name in FLIGHTS]


@pytest.mark.slow
@pytest.mark.parametrize("is_repeated", [True, False], ids=["models", "residuals"])
def test_the_ratio_is_that_of_the_noise(is_repeated):
    """Of the noise itself: a block with it less the same block without."""
    found, true = [], []
    for seed in range(8):
        noisy, exact = machine_block(seed), machine_block(seed, NO_NOISE)
        if not is_repeated:
            noisy = of_one_coverage(noisy)
            exact = of_one_coverage(exact)
        found.append(ratios(densify(noisy)))
        true.append([])
        for name in FLIGHTS:
            noise = (
                getattr(noisy, name).model_points[list("xyz")]
                - getattr(exact, name).model_points[list("xyz")]
            ).std()
            true[-1].append(
                noise["z"] / np.sqrt((noise["x"] ** 2 + noise["y"] ** 2) / 2)
            )
    found, true = np.array(found), np.mean(true, axis=0)
    scatter = found.std(axis=0, ddof=1) / np.sqrt(len(found))
    assert (np.abs(found.mean(axis=0) - true) < 3.0 * scatter + 0.02).all()
    assert (scatter < (0.1 if is_repeated else 0.35)).all()


def of_one_coverage(block):
    """Each point in one model of the low flight only."""
    flight = block.low_flight
    points = flight.model_points
    is_first = ~points.duplicated("point_id")
    kept = points[is_first & (points["coverage"] == "1")].reset_index(drop=True)
    return replace(block, low_flight=replace(flight, model_points=kept))


def test_errors_are_what_the_operators_make_of_the_noise():
    exact = machine_block(noise=NO_NOISE)
    rng, size = np.random.default_rng(4), 1e-5
    control = exact.control_points.copy()
    noise = {"control": size * rng.normal(size=(len(control), 3))}
    control[GROUND] += noise["control"]
    changes = {"control_points": control}
    # control, plan and heights have other errors here than those that are stated
    settings = Settings(model_deformation="ignored")
    truth = densify(exact, settings).solution
    fits = {"high_flight": truth.high.transformation, "low_flight": truth.low}
    for name, fit in fits.items():
        flight = getattr(exact, name)
        points = flight.model_points.copy()
        moved = 1e-6 * rng.normal(size=(len(points), 3))
        points[list("xyz")] += moved
        linear = fit.fit.linear[fit.observed.models.codes]
        noise[name] = np.einsum("nij,nj->ni", linear, moved)
        changes[name] = replace(flight, model_points=points)
    noisy = densify(replace(exact, **changes), settings)
    error = (noisy.solution.points[GROUND] - truth.points[GROUND]).to_numpy()
    chains = noisy.errors.chains
    found = sum(chain.of_vectors(noise[source]) for source, chain in chains.items())
    np.testing.assert_allclose(found, error, rtol=0, atol=1e-4 * np.abs(error).max())


def test_settings_count_for_heights_too():
    block = machine_block()
    flight = block.low_flight
    points = flight.model_points.assign(n_settings=1)
    points.loc[::2, "n_settings"] = 4
    changed = replace(flight, model_points=points)
    sizes = densify(replace(block, low_flight=changed)).errors.standard_errors
    of_low = sizes["low_flight"]
    np.testing.assert_allclose(of_low[1::2][:3] / of_low[::2][:3], 2.0)


def test_heights_of_control_have_errors_of_their_own(result):
    control = result.block.control_points.assign(standard_error_height=0.5)
    found = densify(replace(result.block, control_points=control))
    np.testing.assert_allclose(found.errors.standard_errors["control"][:, 2], 0.5)
    assert (
        found.solution.points["standard_error_height"]
        > result.solution.points["standard_error_height"]
    ).all()
    # the plan hardly hangs on heights
    np.testing.assert_allclose(
        found.solution.points["standard_error_total"],
        result.solution.points["standard_error_total"],
        rtol=0.15,
    )


def test_heights_that_nothing_checks(result):
    """Each point in one model of three control points: no height is measured twice."""
    block = result.block
    flight, names = block.high_flight, block.control_points["point_id"]
    points = flight.model_points[~flight.model_points.duplicated("point_id")]
    model = [points["coverage"], points["model_id"]]
    is_control = points["point_id"].isin(names)
    is_few = is_control.groupby(model).cumsum() <= 3
    points = points[~is_control | is_few].reset_index(drop=True)
    changed = replace(flight, model_points=points)
    found = densify(replace(block, high_flight=changed, may_be_unmeasured=True))
    usable = found.solution.high.transformation.models["is_usable"].to_numpy()
    fit = found.solution.high.transformation.fit
    assert (fit.n_points[usable] == 3).all()
    assert found.errors is None
    assert "standard_error_total" not in found.solution.points
    with pytest.raises(SettingsError, match=r"nothing checks .* its heights"):
        found.covariance_between([tuple(found.solution.points["point_id"].iloc[:2])])
    left = replace(block, high_flight=changed, may_be_unmeasured=True)
    with pytest.raises(
        SettingsError, match=r'"rigorous", but nothing checks the block'
    ):
        densify(left, Settings(weighting="rigorous"))


def test_one_flight_in_space_and_one_in_plan():
    block = machine_block()
    low = replace(block.low_flight, transformation="affine")
    mixed = replace(block, low_flight=low)
    text = "one flight is transformed in space, and the other one in plan"
    assert obstacle_to_propagation(mixed) == text
    with pytest.raises(SettingsError, match=f"{text}.*Transform both flights in space"):
        densify(mixed, Settings(weighting="rigorous"))
    found = densify(mixed)
    with pytest.raises(SettingsError, match=text):
        found.covariance_between([("1001", "1002")])


def test_distributed_residuals_leave_heights_alone(result):
    settings = Settings(residual_distribution="natural_neighbour")
    found = densify(result.block, settings)
    np.testing.assert_allclose(
        found.errors.covariance[:, 2, 2], result.errors.covariance[:, 2, 2]
    )
    is_control = (found.solution.points["role"] == "control").to_numpy()
    given = 0.03 / np.sqrt(2.0)
    np.testing.assert_allclose(
        found.solution.points.loc[is_control, "standard_error_easting"], given
    )


def test_heights_are_told(result):
    said = " ".join(remarks(result.assessment.precision))
    assert "Heights of the new points" in said
    assert result.claim.is_supported
    assert result.left_out_control.normalized_square == pytest.approx(1.0, abs=0.4)
    assert result.components is None
    assert result.patterns.affinities == ()
