"""Affinity of film and strain of control in simulated blocks."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.judged_alone import judged_alone

from einschalt.foundations.frame_columns import values_of
from einschalt.pipeline.assessment.evidence import systematic_errors
from einschalt.pipeline.assessment.evidence.systematic_errors import (
    ControlScores,
    NetworkStrain,
    SystematicPatterns,
)
from einschalt.pipeline.assessment.findings.systematic_errors import (
    contradicting_control,
    film_affinity,
    strained_network,
    strained_network_of_adjustment,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.pipeline.summary.summary import sections

PLAN = ["easting", "northing"]


def network_strain(result):
    """What is found of the network, whichever of the two it is."""
    examined = result.examination
    return strained_network(examined) or contradicting_control(examined)


def computed(
    preset="demo", *, seed=1, kinds=("affine", "affine"), m_g_um=None, **noise
):
    block = simulate_block(preset, seed=seed, noise=BlockNoise(**noise))
    high = replace(block.high_flight, transformation=kinds[0])
    low = replace(block.low_flight, transformation=kinds[1])
    if m_g_um is not None:
        low = replace(low, m_g_um=m_g_um)
    return densify(replace(block, high_flight=high, low_flight=low))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kinds", "affinity"), [(("affine", "affine"), 2e-4), (("helmert", "helmert"), 0.0)]
)
def test_affinity_has_the_standard_error_that_is_said(kinds, affinity):
    found = []
    for seed in range(8):
        result = computed(seed=seed, kinds=kinds, film_affinity=affinity)
        found.append(result.patterns.affinities)
    every = []
    for place, flight in enumerate(("high_flight", "low_flight")):
        assert {one[place].flight for one in found} == {flight}
        for name, true in (("stretch", affinity), ("shear", 0.0)):
            z = [
                (getattr(one[place], name) - true)
                / getattr(one[place], f"{name}_error")
                for one in found
            ]
            # 8 blocks: means within 3.3 / √8, standard deviations within 3 / √16
            assert abs(np.mean(z)) < 1.17
            assert 0.25 < np.std(z) < 1.75
            every += z
    # both flights and kinds of affinity: within 3.3 / √32 and 3 / √64
    assert abs(np.mean(every)) < 0.58
    assert 0.625 < np.std(every) < 1.375


def test_helmert_is_told_to_become_affine():
    result = computed(kinds=("helmert", "helmert"), film_affinity=3e-4)
    found = film_affinity(result.examination)
    low = result.patterns.affinities[1]
    of_flight = {part["flight"]: part for part in found.facts["flights"]}
    assert of_flight["low_flight"]["stretch"] == low.stretch
    assert found.remedy == "set_affine"
    # δ √(v_x v_y / (v_x + v_y)) of a model of 138 x 230 mm at 1:8000
    v_x, v_y = (0.138 * 8000) ** 2 / 12, (0.230 * 8000) ** 2 / 12
    expected = low.stretch * np.sqrt(v_x * v_y / (v_x + v_y))
    assert low.bias == pytest.approx(expected, rel=0.25)


def test_affine_takes_it_up_and_says_so():
    result = computed(film_affinity=3e-4)
    assert film_affinity(result.examination) is None
    assert "absorbed by affine" in sections(result.assessment)["patterns"].text()
    assert network_strain(result) is None


def test_film_does_not_pass_for_strain():
    result = computed(kinds=("helmert", "helmert"), film_affinity=3e-4)
    assert network_strain(result) is None


def turned(flight, seed):
    """Models that were measured in a machine, each turned in its own way."""
    points = flight.model_points
    names = points["coverage"].astype(str) + points["model_id"].astype(str)
    codes = pd.factorize(names)[0]
    angle = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, codes.max() + 1)
    z = points[["x", "y"]].to_numpy() @ [1.0, 1j] * np.exp(1j * angle)[codes]
    return replace(flight, model_points=points.assign(x=z.real, y=z.imag))


def turned_block(seed, **noise):
    block = simulate_block("demo", seed=seed, noise=BlockNoise(**noise))
    high, low = (
        replace(turned(flight, seed + place), transformation="helmert")
        for place, flight in enumerate((block.high_flight, block.low_flight))
    )
    return replace(block, high_flight=high, low_flight=low)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_film_along_the_strips_of_turned_models_is_no_strain(seed, method):
    block = turned_block(seed, film_affinity=3e-4)
    result = densify(block, Settings(method=method))
    assert network_strain(result) is None
    first = result.assessment.findings[0]
    assert (first.code, first.remedy) == ("film_affinity", "set_affine")
    of_flight = {part["flight"]: part for part in first.facts["flights"]}
    low = of_flight["low_flight"]
    assert low["axes"] == "ground"
    assert abs(abs(low["stretch"]) - 3e-4) < 4.0 * low["stretch_error"]
    assert "however they were turned" in " ".join(result.summary().split())
    # which affine models take up
    flights = {
        name: replace(getattr(block, name), transformation="affine")
        for name in ("high_flight", "low_flight")
    }
    mended = densify(replace(block, **flights), Settings(method=method))
    assert film_affinity(mended.examination) is None
    assert network_strain(mended) is None


@pytest.mark.slow
def test_a_wave_in_control_of_turned_models_is_no_film():
    """What is left beside a stretch of all models tells the two apart."""
    block = turned_block(1, network_strain=0.3)
    result = densify(block)
    assert all(part.axes == "machine" for part in result.patterns.affinities)
    assert network_strain(result) is not None


@pytest.mark.slow
def test_strain_of_neukirchen_is_called_out():
    block = simulate_block("neukirchen", seed=1, noise=BlockNoise(network_strain=0.1))
    result = densify(block)
    strain = result.patterns.strain
    assert strain.is_smooth
    found = network_strain(result)
    assert found.code == "strained_network"
    assert found.names[0] == strain.displacements["point_id"].iloc[0]
    assert found.facts["displacements"][0][0] == found.names[0]
    assert found.remedy == "check_network_or_adjust"
    # what the points have: the claim, and the strain beside it
    new = result.points[result.points["role"] == "new"]
    total = np.sqrt(np.mean(new["standard_error_total"] ** 2))
    assert found.facts["claimed"] == pytest.approx(total)
    reckoned = found.facts["claimed_with_strain"]
    assert reckoned == pytest.approx(np.hypot(total, strain.size))
    true = block.truth.set_index("point_id").loc[new["point_id"], PLAN].to_numpy()
    error = np.sqrt(np.mean(((new[PLAN].to_numpy() - true) ** 2).sum(axis=1)))
    assert np.hypot(total, strain.size) == pytest.approx(error, rel=0.15)
    assert error > 1.4 * total
    # the wave has 10 cm / √2 (total, RMS)
    assert 0.04 < strain.size < 0.08
    assert film_affinity(result.examination) is None
    assert "Control points that are displaced together" in result.summary()


def test_control_that_no_model_holds_is_no_strain(demo_block):
    """A row of sums below the table: a point far beyond the block."""
    control = demo_block.control_points
    total = control.iloc[[0]].assign(point_id="Sum", **control[PLAN].sum())
    given = pd.concat([control, total], ignore_index=True)
    strain = densify(replace(demo_block, control_points=given)).patterns.strain
    alone = densify(demo_block).patterns.strain
    assert strain.n_control == alone.n_control
    assert strain.p_value == alone.p_value
    assert "Sum" not in set(strain.displacements["point_id"])


@pytest.mark.slow
def test_displacements_point_where_the_strain_does():
    strained, clean = (
        simulate_block("neukirchen", seed=1, noise=BlockNoise(network_strain=size))
        for size in (0.1, 0.0)
    )
    true = strained.control_points.set_index("point_id")[PLAN]
    true = true - clean.control_points.set_index("point_id")[PLAN]
    result = densify(strained, Settings(method="simultaneous"))
    found = result.patterns.strain.displacements.set_index("point_id")[PLAN]
    true = true.loc[found.index]
    cosine = (found * true).to_numpy().sum() / np.sqrt(
        (found**2).to_numpy().sum() * (true**2).to_numpy().sum()
    )
    assert cosine > 0.6
    assert not result.simultaneous.control["is_suspect"].any()
    rows = sections(result.assessment)["control_strain"].rows
    assert [row[0] for row in rows] == found.index[: len(rows)].tolist()
    assert strained_network_of_adjustment(result.examination).remedy == "check_network"


@pytest.mark.slow
def test_a_wrong_m_g_does_not_pass_for_a_pattern():
    result = computed("neukirchen", m_g_um=5.0 / 1.5)
    assert film_affinity(result.examination) is None
    assert network_strain(result) is None


@pytest.mark.slow
def test_control_that_is_worse_than_was_said():
    block = simulate_block("neukirchen", noise=BlockNoise(control_standard_error=0.08))
    control = block.control_points.assign(standard_error_m=0.03)
    result = densify(replace(block, control_points=control))
    found = network_strain(result)
    assert found.code == "contradicting_control"
    assert found.remedy == "look_for_wrong_control_or_raise_errors"
    assert "single points" in sections(result.assessment)["patterns"].text()


def test_nothing_is_tested_where_errors_are_not_propagated(given_approximations_result):
    assert given_approximations_result.patterns == SystematicPatterns((), None)
    assert not sections(given_approximations_result.assessment)["patterns"].rows
    assert film_affinity(given_approximations_result.examination) is None
    assert network_strain(given_approximations_result) is None


def test_clean_blocks_are_quiet(good_result):
    assert film_affinity(good_result.examination) is None
    assert network_strain(good_result) is None
    text = sections(good_result.assessment)["patterns"].text()
    assert text.count("none") == 3


def test_strain_of_control_is_tested_without_suspects_too(faulty_result):
    assert isinstance(faulty_result.patterns.strain, NetworkStrain)
    assert network_strain(faulty_result) is None


@pytest.mark.parametrize(
    ("limit", "said"),
    [("MOST_CONTROL", "control points, at most 3"), ("MOST_MODELS", "models, at most")],
)
def test_a_block_too_large_for_the_strain_test_is_told_so(monkeypatch, limit, said):
    monkeypatch.setattr(systematic_errors, limit, 3)
    result = computed()
    assert result.patterns.strain is None
    message = f"Strain was not tested: the block is too large for the test (.*{said}"
    assert re.search(
        message.replace("(", r"\("), result.summary().replace("\n    ", " ")
    )


def test_many_points_for_each_control_point_do_not_pass_for_contradictions():
    """Of drones: what moves everything alike was taken for a check of control."""
    design = FlightDesign(
        scale_number=9100,
        spacing=30,
        m_g_um=1.9,
        high_scale_number=11375,
        high_m_g_um=1.9,
        width=500,
        height=500,
        image_format=(0.024, 0.036),
        principal_distance=0.035,
        forward_overlap=0.8,
        side_overlap=0.6,
    )
    block = simulate_block(seed=500, geometry=design.geometry(), noise=design.noise())
    result = densify(block)
    assert result.patterns.strain.n_control > 40
    assert network_strain(result) is None


def _with_a_wrong_point(simulated, metres=0.5):
    """The block with one control point of the middle moved in easting."""
    control = simulated.control_points.copy()
    place = values_of(control, PLAN)
    is_control = (control["role"] == "control").to_numpy()
    away = np.hypot(*(place - place[is_control].mean(axis=0)).T)
    row = np.argmin(np.where(is_control, away, np.inf))
    control.loc[control.index[row], "easting"] += metres
    return replace(simulated, control_points=control), control["point_id"].iloc[row]


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_one_wrong_point_does_not_pass_for_strain(method):
    """Its neighbours were said to be displaced with it, three times the true error."""
    block, name = _with_a_wrong_point(simulate_block("neukirchen", seed=3))
    result = densify(block, Settings(method=method, outliers="snoop"))
    examined = result.examination
    # an adjustment has set it aside, and so have the two steps beside it
    whole = examined.all_in_two_steps.patterns.strain
    assert whole.is_significant
    assert examined.strain.n_control == whole.n_control - 1
    assert not (examined.strain.is_significant and examined.strain.is_smooth)
    codes = judged_alone(result)
    assert "strained_network" not in codes
    named = {n for found in codes.values() for n in found.names}
    assert name in named


def _with_curved_models(flight, size):
    """The flight whose models are all displaced in x with its square, by this [mm]."""
    points = flight.model_points.copy()
    x = points["x"]
    model = [points["coverage"], points["model_id"]]
    away = x - x.groupby(model).transform("mean")
    points["x"] = x + size * (away / away.abs().groupby(model).transform("max")) ** 2
    return replace(flight, model_points=points)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_models_that_are_curved_alike_do_not_pass_for_strain(method):
    """A strain of metres was told, where the points have 5 cm: control looked curved.

    Ten models in a row, each by 8 µm in the same way, are ten times as far off.
    """
    block = simulate_block("neukirchen", seed=7)
    curved = _with_curved_models(block.high_flight, 0.008)
    result = densify(replace(block, high_flight=curved), Settings(method=method))
    clean = densify(block, Settings(method=method))
    assert network_strain(result) is None
    # what such terms explain is the same whatever their size
    strain, alone = result.patterns.strain, clean.patterns.strain
    assert strain.p_value == pytest.approx(alone.p_value, abs=0.2)
    assert strain.p_value > 0.05
    # told, of that flight alone, unless it was modelled
    codes = judged_alone(result)
    assert ("curved_models" in codes) == (method == "two_step")
    assert not clean.patterns.curvatures
    high, low = result.patterns.curvatures
    assert (high.flight, low.flight) == ("high_flight", "low_flight")
    assert high.is_significant
    assert not low.is_significant
    # 8 µm at the edge, at 1:15000, on the average of (x / edge)² less its mean
    assert 0.02 < high.size < 0.12


@pytest.mark.slow
def test_strain_is_found_beside_a_wrong_point():
    strained = simulate_block(
        "neukirchen", seed=1, noise=BlockNoise(network_strain=0.1)
    )
    block, name = _with_a_wrong_point(strained, 2.0)
    strain = densify(block).examination.strain
    alone = densify(strained).examination.strain
    assert strain.is_significant
    assert strain.is_smooth
    assert strain.size == pytest.approx(alone.size, rel=0.3)
    assert name not in set(strain.displacements["point_id"])


def test_scores_without_a_point_are_those_of_an_adjustment_that_gives_it_no_weight():
    rng = np.random.default_rng(5)
    design = rng.normal(size=(9, 4))
    weight = np.diag(rng.uniform(0.5, 2.0, 9))
    observed = rng.normal(size=(9, 2))

    def scored(weight):
        normal = np.linalg.inv(design.T @ weight @ design)
        information = weight - weight @ design @ normal @ design.T @ weight
        return ControlScores(np.arange(9), information @ observed, information)

    is_free = np.arange(9) == 4
    without = scored(weight).without(is_free)
    given_up = scored(np.where(is_free[:, None], 0.0, weight))
    assert list(without.places) == [0, 1, 2, 3, 5, 6, 7, 8]
    assert without.values == pytest.approx(given_up.values[~is_free])
    kept = given_up.information[np.ix_(~is_free, ~is_free)]
    assert without.information == pytest.approx(kept)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_linear_field_of_which_nothing_is_known_is_no_strain(seed):
    """Film of 28 µm, many points: their errors in the design looked like a check."""
    size = {"width": 1_800.0, "height": 1_500.0, "point_spacing": 70.0}
    geometry = BlockGeometry(high_scale_number=28_000.0, **size)
    noise = BlockNoise(high_m_g_um=28.0, low_m_g_um=28.0)
    block = simulate_block("demo", seed=seed, geometry=geometry, noise=noise)
    control = block.truth[["point_id", "easting", "northing"]].iloc[::6]
    errors = np.random.default_rng(seed).normal(0.0, 0.02, (len(control), 2))
    control = control.assign(
        easting=control["easting"] + errors[:, 0],
        northing=control["northing"] + errors[:, 1],
        standard_error_m=0.02 * np.sqrt(2.0),
        role="control",
    ).reset_index(drop=True)
    examined = densify(replace(block, control_points=control)).examination
    strain = examined.patterns.strain
    assert strain.p_value > 0.01
    assert strain.size < 0.05
    assert contradicting_control(examined) is None
