from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from tests.flat_site import FLAT_SITE

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

EN = ["easting", "northing"]
FLIGHTS = ("high_flight", "low_flight")
SCALE = {"high_flight": 15_000, "low_flight": 8_000}
SILENT = BlockNoise(
    control_standard_error=0.0,
    high_m_g_um=0.0,
    low_m_g_um=0.0,
    orientation_error=0.0,
    y_parallax_um=0.0,
)
TABLES = ("control_points", "truth", "gross_errors")


@pytest.fixture(scope="module")
def neukirchen():
    return simulate_block(seed=0)


def with_truth(block, flight):
    return block.flights[flight].model_points.merge(block.truth, on="point_id")


def fit_similarities(points):
    """Residuals [mm] of machine coordinates on the truth, and redundancy, per model."""
    residuals, redundancy = [], 0
    for _, model in points.groupby(["coverage", "model_id"]):
        machine = model["x"].to_numpy() + 1j * model["y"].to_numpy()
        ground = model["easting"].to_numpy() + 1j * model["northing"].to_numpy()
        machine, ground = machine - machine.mean(), ground - ground.mean()
        factor = np.vdot(ground, machine) / np.vdot(ground, ground)
        residuals.append(machine - factor * ground)
        redundancy += 2 * len(model) - 4
    return np.concatenate(residuals), redundancy


def fit_affine(model):
    design = np.column_stack([np.ones(len(model)), model[EN] - model[EN].mean()])
    return np.linalg.lstsq(design, model[["x", "y"]].to_numpy())[0][1:].T


def test_neukirchen_has_the_counts_of_the_documentation(neukirchen):
    assert len(neukirchen.truth) == 1190
    n_models = {
        flight: points.model_points.groupby("coverage")["model_id"].nunique().tolist()
        for flight, points in neukirchen.flights.items()
    }
    assert n_models == {"high_flight": [35, 32], "low_flight": [135, 112]}
    assert (neukirchen.control_points["role"] == "control").all()
    # 129 in the documentation, for other random numbers
    assert len(neukirchen.control_points) == 129


def test_every_model_of_the_high_flight_is_measured_on_its_own_control(neukirchen):
    points = neukirchen.high_flight.model_points
    is_control = points["point_id"].isin(neukirchen.control_points["point_id"])
    count = is_control.groupby([points["coverage"], points["model_id"]]).sum()
    assert set(count) == {5}


@pytest.mark.parametrize("seed", range(5))
def test_every_coverage_of_both_flights_holds_every_point(seed):
    block = simulate_block(seed=seed)
    # in the high flight each model leaves the control of others out
    new = ~block.truth["point_id"].isin(block.control_points["point_id"])
    for flight, expected in (
        ("high_flight", set(block.truth.loc[new, "point_id"])),
        ("low_flight", set(block.truth["point_id"])),
    ):
        for _, points in block.flights[flight].model_points.groupby("coverage"):
            assert expected <= set(points["point_id"])


def test_names_are_text_as_a_survey_would_give_them(neukirchen):
    points = neukirchen.low_flight.model_points
    assert neukirchen.truth["point_id"].iloc[0] == "1001"
    assert set(points["coverage"]) == {"1", "2"}
    assert points["model_id"].str.fullmatch(r"\d+/\d+").all()
    assert neukirchen.name == "Neukirchen (simulated)"
    assert neukirchen.crs == "EPSG:31255"
    assert neukirchen.notes == ()
    assert neukirchen.model_problems == ()


@pytest.mark.parametrize("measurement", ["machine", "parallaxes", "images"])
def test_same_seed_gives_the_same_block(measurement):
    geometry = replace(PRESETS["demo"].geometry, measurement=measurement)
    one, two = (simulate_block("demo", seed=3, geometry=geometry) for _ in range(2))
    other = simulate_block("demo", seed=4, geometry=geometry)
    for table in TABLES:
        pd.testing.assert_frame_equal(getattr(one, table), getattr(two, table))
    for flight in FLIGHTS:
        for table in ("model_points", "y_parallaxes", "base", "image_points", "models"):
            first = getattr(one.flights[flight], table)
            if first is not None:
                second = getattr(two.flights[flight], table)
                pd.testing.assert_frame_equal(first, second)
    assert not np.allclose(one.truth[EN], other.truth[EN])


def test_other_noise_keeps_points_layout_and_machine():
    noise = BlockNoise(high_gross_error_share=0.1, network_strain=0.05)
    quiet, loud = (
        simulate_block("demo", noise=SILENT),
        simulate_block("demo", noise=noise),
    )
    pd.testing.assert_frame_equal(quiet.truth, loud.truth)
    names = ["point_id", "role"]
    pd.testing.assert_frame_equal(
        quiet.control_points[names], loud.control_points[names]
    )
    for flight in FLIGHTS:
        one, two = quiet.flights[flight].model_points, loud.flights[flight].model_points
        names = ["coverage", "model_id", "point_id"]
        pd.testing.assert_frame_equal(one[names], two[names])
        assert np.abs(one[["x", "y"]] - two[["x", "y"]]).to_numpy().max() < 0.1


def test_larger_noise_is_the_same_noise_enlarged():
    def machine(m_g_um):
        block = simulate_block("demo", noise=replace(SILENT, low_m_g_um=m_g_um))
        return block.low_flight.model_points[["x", "y"]].to_numpy()

    none, some, double = machine(0.0), machine(5.0), machine(10.0)
    np.testing.assert_allclose(double - none, 2.0 * (some - none), atol=1e-12)


def test_noise_of_one_flight_leaves_the_other_as_it_is():
    one = simulate_block("demo", noise=BlockNoise(high_m_g_um=1.0))
    two = simulate_block("demo", noise=BlockNoise(high_m_g_um=20.0))
    pd.testing.assert_frame_equal(
        one.low_flight.model_points, two.low_flight.model_points
    )


def test_more_check_points_keep_those_that_were():
    geometry = PRESETS["demo"].geometry
    few, many = (
        simulate_block("demo", geometry=replace(geometry, n_check=n)).control_points
        for n in (4, 9)
    )
    check = [set(t.loc[t["role"] == "check", "point_id"]) for t in (few, many)]
    assert len(check[0]) == 4
    assert check[0] < check[1]
    is_control = many["role"] == "control"
    pd.testing.assert_frame_equal(
        few[few["role"] == "control"].reset_index(drop=True),
        many[is_control].reset_index(drop=True),
    )


@pytest.mark.parametrize("flight", FLIGHTS)
def test_without_noise_every_model_is_a_similarity_of_the_truth(flight):
    block = simulate_block("demo", noise=SILENT)
    residuals, _ = fit_similarities(with_truth(block, flight))
    assert np.abs(residuals).max() < 1e-9
    control = block.control_points.merge(block.truth, on="point_id")
    assert (control["easting_x"] == control["easting_y"]).all()


@pytest.mark.parametrize("flight", FLIGHTS)
def test_machine_is_set_up_anew_for_every_model(flight):
    block = simulate_block("demo", noise=SILENT)
    matrices = [
        fit_affine(model)
        for _, model in with_truth(block, flight).groupby(["coverage", "model_id"])
    ]
    scale = [1e3 / np.sqrt(np.linalg.det(matrix)) for matrix in matrices]
    np.testing.assert_allclose(scale, SCALE[flight], rtol=1e-9)
    angle = [np.arctan2(matrix[1, 0], matrix[0, 0]) for matrix in matrices]
    assert np.abs(angle).max() < 0.05
    assert len(set(np.round(angle, 6))) == len(angle)


@pytest.mark.parametrize(
    ("flight", "m_g_um"), [("high_flight", 7.5), ("low_flight", 5)]
)
def test_machine_coordinates_have_the_total_error_m_g(neukirchen, flight, m_g_um):
    residuals, redundancy = fit_similarities(with_truth(neukirchen, flight))
    per_coordinate = 1e-3 * m_g_um / np.sqrt(2.0)
    found = (np.abs(residuals) ** 2).sum() / per_coordinate**2
    assert stats.chi2.ppf(1e-3, redundancy) < found < stats.chi2.ppf(0.999, redundancy)


def test_control_has_its_total_standard_error(neukirchen):
    control = neukirchen.control_points.merge(
        neukirchen.truth, on="point_id", suffixes=("", "_true")
    )
    error = (
        control[EN].to_numpy() - control[["easting_true", "northing_true"]].to_numpy()
    )
    found = (error**2).sum() / (0.03**2 / 2.0)
    assert stats.chi2.ppf(1e-3, error.size) < found < stats.chi2.ppf(0.999, error.size)
    assert (control["standard_error_m"] == 0.03).all()


@pytest.mark.parametrize("flight", FLIGHTS)
def test_film_affinity_stretches_every_model_along_its_strip(flight):
    delta = 2e-4
    block = simulate_block("demo", noise=replace(SILENT, film_affinity=delta))
    for _, model in with_truth(block, flight).groupby(["coverage", "model_id"]):
        _, (longer, shorter), axes = np.linalg.svd(fit_affine(model))
        # (1 + delta/2) / (1 - delta/2) is 1 + delta to delta²/2
        assert longer / shorter - 1.0 == pytest.approx(delta, rel=2e-4)
        assert abs(axes[0, 0]) == pytest.approx(1.0, abs=1e-6)  # eastward


def test_strain_bends_the_given_coordinates_smoothly(neukirchen):
    strained = simulate_block(seed=0, noise=BlockNoise(network_strain=0.05))
    shift = strained.control_points[EN] - neukirchen.control_points[EN]
    total = np.hypot(*shift.to_numpy().T)
    assert 0.04 < total.max() <= 0.05
    # a function of the other coordinate alone: a fitted wave leaves nothing
    truth = strained.truth.set_index("point_id").loc[
        strained.control_points["point_id"]
    ]
    for coordinate, other in (EN, EN[::-1]):
        phase = 2.0 * np.pi * truth[other].to_numpy() / 6000.0
        design = np.column_stack([np.cos(phase), np.sin(phase)])
        rest = shift[coordinate].to_numpy()
        rest = rest - design @ np.linalg.lstsq(design, rest)[0]
        assert np.abs(rest).max() < 1e-9


def test_gross_errors_are_listed_and_all_that_differs():
    clean = simulate_block(noise=BlockNoise())
    noise = BlockNoise(low_gross_error_share=0.01, low_gross_error_um=50.0)
    spoilt = simulate_block(noise=noise)
    pd.testing.assert_frame_equal(
        clean.high_flight.model_points, spoilt.high_flight.model_points
    )
    one, two = clean.low_flight.model_points, spoilt.low_flight.model_points
    shift = np.hypot(*(two[["x", "y"]] - one[["x", "y"]]).to_numpy().T)
    is_shifted = shift > 1e-9
    np.testing.assert_allclose(shift[is_shifted], 0.050, rtol=1e-9)
    names = ["coverage", "model_id", "point_id"]
    pd.testing.assert_frame_equal(
        spoilt.gross_errors[names], two.loc[is_shifted, names].reset_index(drop=True)
    )
    assert set(spoilt.gross_errors["flight"]) == {"low_flight"}
    assert (spoilt.gross_errors["image_id"] == "").all()
    assert clean.gross_errors.empty


def test_spatial_models_and_their_ground_have_heights():
    geometry = replace(
        PRESETS["demo"].geometry, transformation="helmert_3d", crs=FLAT_SITE
    )
    block = simulate_block("demo", noise=SILENT, geometry=geometry)
    assert "height" in block.truth
    assert "height" in block.control_points
    for flight in FLIGHTS:
        points = with_truth(block, flight)
        above = points["z"] - 1e3 * points["height"] / SCALE[flight]
        spread = above.groupby([points["coverage"], points["model_id"]]).agg(np.ptp)
        assert spread.max() < 1e-9
    plane = simulate_block("demo", noise=SILENT)
    assert "height" not in plane.truth
    assert "z" not in plane.low_flight.model_points


@pytest.mark.parametrize("name", ["z_high", "z_low"])
def test_heights_are_worse_than_plane_coordinates_by_c_over_b(name):
    flight = name.replace("z_", "") + "_flight"
    geometry = BlockGeometry(transformation="helmert_3d")
    quiet, loud = (
        simulate_block(noise=noise, geometry=geometry).flights[flight].model_points
        for noise in (SILENT, BlockNoise())
    )
    error = (loud["z"] - quiet["z"]).to_numpy()
    m_g = 1e-3 * {"high_flight": 7.5, "low_flight": 5.0}[flight]
    found = (error**2).sum() / (m_g / np.sqrt(2.0) * 153.0 / 92.0) ** 2
    assert stats.chi2.ppf(1e-3, len(error)) < found < stats.chi2.ppf(0.999, len(error))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"preset": "neukirhcen"},
            r"'neukirhcen' is unknown; expected neukirchen or demo\. Write 'neukir",
        ),
        ({"preset": "xyz"}, r"preset 'xyz' is unknown; expected neukirchen or demo\.$"),
        ({"seed": -1}, r"seed = -1; expected a whole number from 0"),
        ({"seed": "today"}, r"seed = 'today'; expected a whole number from 0"),
        (
            {"noise": {"high_m_g_um": 5}},
            r"noise = a dict of length 1; expected a BlockNoise\. Write noise=Block",
        ),
        (
            {"geometry": BlockGeometry(n_check=2000)},
            r"n_check = 2000; expected 0 to 1\d{3}, the number of new points",
        ),
    ],
)
def test_wrong_argument_is_said(arguments, message):
    with pytest.raises(SettingsError, match=message):
        simulate_block(**arguments)


def test_whole_floats_and_numpy_integers_are_seeds():
    expected = simulate_block("demo", seed=2).truth
    for seed in (2.0, np.int64(2)):
        pd.testing.assert_frame_equal(simulate_block("demo", seed=seed).truth, expected)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"n_check": 5, "measurement": "parallaxes"}, "Demo (simulated)"),
        ({"point_spacing": 200.0}, "1:8000 and 1:15000, 200 m (simulated)"),
        ({"low_scale_number": 9e3}, "1:9000 and 1:15000, 300 m (simulated)"),
        ({"principal_distance": 0.2}, "1:8000 and 1:15000, 300 m (simulated)"),
    ],
)
def test_titles_say_what_was_simulated(changes, name):
    geometry = replace(PRESETS["demo"].geometry, **changes)
    assert simulate_block("demo", geometry=geometry).name == name
    assert simulate_block("demo", geometry=geometry, title="Own").name == "Own"


def test_a_block_without_a_system_lies_on_a_flat_earth():
    geometry = replace(PRESETS["demo"].geometry, crs=None)
    block = simulate_block("demo", geometry=geometry)
    assert block.crs is None
    assert block.name == "1:8000 and 1:15000, 300 m (simulated)"
    with_heights = replace(geometry, transformation="helmert_3d")
    assert "height" in simulate_block("demo", geometry=with_heights).truth
