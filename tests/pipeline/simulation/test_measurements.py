from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import linalg, stats
from tests.flat_site import FLAT_SITE

from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)
from einschalt.stages.stage2_relative_orientation import image_pairs
from einschalt.stages.stage3_model_transformation import transform_models
from einschalt.theory.relative_orientation.parallax_equations import design_matrix

FLIGHTS = ("high_flight", "low_flight")
MODEL = ["coverage", "model_id"]
SILENT = BlockNoise(
    control_standard_error=0.0, high_m_g_um=0.0, low_m_g_um=0.0, y_parallax_um=0.0
)


def demo(measurement, noise=SILENT, **geometry):
    geometry = {"measurement": measurement, "crs": FLAT_SITE, **geometry}
    changed = replace(PRESETS["demo"].geometry, **geometry)
    return simulate_block("demo", seed=1, geometry=changed, noise=noise)


def largest_error(model_points, truth, kind):
    """Largest distance from the truth after the best transformation of each model."""
    fitted = transform_models(model_points, truth, kind)
    names = [name for name in fitted.residuals if name.startswith("residual_")]
    return np.abs(fitted.residuals[names]).to_numpy().max()


# -- parallaxes ----------------------------------------------------------------------


def test_every_model_has_parallaxes_at_six_standard_points_and_a_base():
    flight = demo("parallaxes").low_flight
    models = flight.model_points[MODEL].drop_duplicates().reset_index(drop=True)
    pd.testing.assert_frame_equal(flight.base[MODEL], models)
    # the strips of the first coverage are divided into equal, shorter bases
    base = flight.base.groupby("coverage")["base"].agg(["min", "max"])
    assert base.loc["1"].tolist() == pytest.approx([84.375, 84.375])
    assert base.loc["2"].tolist() == pytest.approx([92.0, 92.0])
    assert len(flight.y_parallaxes) == 6 * len(models)
    of_second = flight.y_parallaxes[flight.y_parallaxes["coverage"] == "2"]
    six = of_second.groupby("point_id")[["x", "y"]].mean()
    expected = [[0, 0], [92, 0], [0, 92], [92, 92], [0, -92], [92, -92]]
    assert six.index.tolist() == ["1", "2", "3", "4", "5", "6"]
    # 0.001 rad displaces a place 180 mm away by 0.2 mm, five elements by little more
    np.testing.assert_allclose(six, expected, atol=0.6)
    assert (flight.model_points["z"] < 0.0).all()


@pytest.mark.parametrize("flight", FLIGHTS)
def test_orientation_error_bends_models_and_its_correction_mends_them(flight):
    errors = {}
    for size in (1e-4, 1e-3):
        block = demo("parallaxes", replace(SILENT, orientation_error=size))
        measured = block.flights[flight]
        oriented = orient_from_parallaxes(measured.y_parallaxes, measured.base)
        corrected = oriented.corrected(measured.model_points)
        errors[size] = (
            largest_error(measured.model_points, block.truth, "affine"),
            largest_error(corrected, block.truth, "affine"),
        )
    bent, mended = np.transpose([errors[size] for size in (1e-4, 1e-3)])
    # as measured the models are bent in proportion to the error; the parallax
    # equations are linear, so that what they leave grows with its square
    assert bent[1] / bent[0] == pytest.approx(10.0, rel=0.05)
    assert bent[1] > 0.3
    assert mended[1] / mended[0] == pytest.approx(100.0, rel=0.2)
    assert mended[1] < 0.005


def test_without_orientation_error_models_are_true_and_free_of_parallax():
    block = demo("parallaxes", replace(SILENT, orientation_error=0.0))
    for flight in block.flights.values():
        assert largest_error(flight.model_points, block.truth, "helmert") < 1e-8
        assert np.abs(flight.y_parallaxes["y_parallax"]).max() < 1e-12


def test_elements_have_their_size():
    geometry = PRESETS["neukirchen"].geometry
    block = simulate_block(
        geometry=replace(geometry, measurement="parallaxes"),
        noise=replace(SILENT, orientation_error=5e-4),
    )
    flight = block.low_flight
    oriented = orient_from_parallaxes(flight.y_parallaxes, flight.base)
    elements = oriented.parameters.to_numpy()
    assert elements.shape == (247, 5)
    found = (elements**2).sum() / 5e-4**2
    # chi square of all elements, widened by the linearisation (5e-4 of each)
    low, high = stats.chi2.ppf([1e-3, 0.999], elements.size)
    assert 0.999 * low < found < 1.001 * high


def test_measured_parallaxes_have_their_standard_error():
    geometry = replace(PRESETS["neukirchen"].geometry, measurement="parallaxes")
    quiet, loud = (
        simulate_block(geometry=geometry, noise=replace(SILENT, y_parallax_um=size))
        for size in (0.0, 8.0)
    )
    column = "y_parallax"
    error = loud.low_flight.y_parallaxes[column] - quiet.low_flight.y_parallaxes[column]
    found = (error**2).sum() / 0.008**2
    assert stats.chi2.ppf(1e-3, len(error)) < found < stats.chi2.ppf(0.999, len(error))
    pd.testing.assert_frame_equal(
        quiet.low_flight.model_points, loud.low_flight.model_points
    )


def test_parallaxes_are_those_that_the_theory_predicts():
    size = 1e-5
    flight = demo("parallaxes", replace(SILENT, orientation_error=size)).low_flight
    oriented = orient_from_parallaxes(flight.y_parallaxes, flight.base)
    table = flight.y_parallaxes
    rows = np.repeat(oriented.parameters.to_numpy(), 6, axis=0)
    base = np.repeat(flight.base["base"].to_numpy(), 6)
    design = design_matrix(table[["x", "y", "z"]].to_numpy(), base, "independent")
    predicted = np.sum(design * rows, axis=1)
    # second order: 1e-10 rad² of about 150 mm, and a few such terms
    np.testing.assert_allclose(table["y_parallax"], predicted, atol=1e-7)


# -- images --------------------------------------------------------------------------


def fit_camera(xy, ground):
    """Fit a camera by direct linear transformation: calibration matrix and centre."""
    centre = ground.mean(axis=0)
    homogeneous = np.column_stack([(ground - centre) / 1e3, np.ones(len(ground))])
    zero = np.zeros_like(homogeneous)
    rows = [
        np.column_stack([homogeneous, zero, -xy[:, :1] / 100 * homogeneous]),
        np.column_stack([zero, homogeneous, -xy[:, 1:] / 100 * homogeneous]),
    ]
    projection = np.linalg.svd(np.concatenate(rows))[2][-1].reshape(3, 4)
    calibration, _ = linalg.rq(projection[:, :3])
    calibration = calibration * np.sign(np.diag(calibration))
    at_infinity = np.linalg.solve(projection[:, :3], projection[:, 3])
    return calibration / calibration[2, 2], centre - 1e3 * at_infinity


@pytest.mark.parametrize(
    ("flight", "height"), [("high_flight", 2815), ("low_flight", 1744)]
)
def test_every_image_is_taken_by_the_camera_at_its_height(flight, height):
    block = demo(
        "images", relief=60.0, point_spacing=150.0, low_cross_flight=True, n_check=0
    )
    points = block.flights[flight].image_points.merge(block.truth, on="point_id")
    for _, image in points.groupby("image_id"):
        calibration, centre = fit_camera(
            image[["x", "y"]].to_numpy(),
            image[["easting", "northing", "height"]].to_numpy(),
        )
        # lengths in units of 100 mm: principal distance 153 mm, no shear, no offset
        expected = np.diag([1.53, 1.53, 1.0])
        np.testing.assert_allclose(calibration, expected, atol=1e-8)
        assert centre[2] == pytest.approx(height, abs=1e-4)


@pytest.mark.parametrize("flight", FLIGHTS)
def test_images_of_free_rays_give_the_truth_back(flight):
    block = demo("images")
    measured = block.flights[flight]
    pairs = image_pairs(measured.image_points, measured.models)
    oriented = orient_from_images(pairs, measured.principal_distance_mm)
    assert oriented.sigma_0.max() < 1e-9
    assert largest_error(oriented.model_points, block.truth, "helmert_3d") < 1e-6


def test_models_from_untilted_images_of_flat_ground_are_plane_similarities():
    block = demo("images", relief=0.0, camera_tilt=0.0, transformation="helmert")
    flight = block.low_flight
    pairs = image_pairs(flight.image_points, flight.models)
    # x_left - x_right is the base, y is the same: the model is the left image
    x_parallax = (pairs["x_left"] - pairs["x_right"]).groupby(pairs["coverage"])
    assert x_parallax.agg(np.ptp).max() < 1e-9
    assert x_parallax.mean().tolist() == pytest.approx([84.375, 92.0])
    assert np.abs(pairs["y_left"] - pairs["y_right"]).max() < 1e-9
    left = pairs.rename(columns={"x_left": "x", "y_left": "y"})
    left = left[[*MODEL, "point_id", "x", "y"]]
    assert largest_error(left, block.truth, "helmert") < 1e-8
    # and the same points make the model as in the machine: with the shorter bases of
    # the first coverage the images have more in common than the least overlap
    machine = demo("machine").low_flight.model_points
    in_images, in_machine = (
        {
            coverage: set(zip(rows["model_id"], rows["point_id"], strict=True))
            for coverage, rows in table.groupby("coverage")
        }
        for table in (left, machine)
    )
    assert in_images["1"] > in_machine["1"]
    assert in_images["2"] == in_machine["2"]


def test_image_points_lie_inside_the_usable_rim():
    for flight in demo("images", camera_tilt=0.03).flights.values():
        assert np.abs(flight.image_points[["x", "y"]]).to_numpy().max() <= 110.0
        # and reach it: the images are full of points
        assert np.abs(flight.image_points[["x", "y"]]).to_numpy().max() > 100.0


def test_consecutive_photographs_of_a_strip_make_a_model():
    models = demo("images").low_flight.models.set_index(MODEL)
    assert models.loc[("1", "2/3")].tolist() == ["1/2/3", "1/2/4"]
    assert models.loc[("2", "1/4")].tolist() == ["2/1/4", "2/1/5"]


def test_cross_flight_turns_the_photographs_too():
    block = demo("images", low_cross_flight=True, camera_tilt=0.0, relief=0.0)
    flight = block.low_flight
    pairs = image_pairs(flight.image_points, flight.models).merge(
        block.truth, on="point_id"
    )
    for coverage, along in (("1", "easting"), ("2", "northing")):
        for _, model in pairs[pairs["coverage"] == coverage].groupby("model_id"):
            slope = np.polyfit(model[along], model["x_left"], 1)[0]
            assert slope == pytest.approx(1e3 / 8000.0)


def test_image_coordinates_have_the_total_error_m_g():
    quiet, loud = (demo("images", noise) for noise in (SILENT, BlockNoise()))
    for flight, m_g_um in (("high_flight", 7.5), ("low_flight", 5.0)):
        one, two = (b.flights[flight].image_points for b in (quiet, loud))
        error = (two[["x", "y"]] - one[["x", "y"]]).to_numpy()
        found = (error**2).sum() / ((1e-3 * m_g_um) ** 2 / 2.0)
        low, high = stats.chi2.ppf([1e-3, 0.999], error.size)
        assert low < found < high


def test_gross_errors_in_images_name_the_image():
    noise = replace(SILENT, low_gross_error_share=0.05)
    clean, spoilt = demo("images"), demo("images", noise)
    rows = ["image_id", "point_id"]
    one, two = clean.low_flight.image_points, spoilt.low_flight.image_points
    shift = np.hypot(*(two[["x", "y"]] - one[["x", "y"]]).to_numpy().T)
    pd.testing.assert_frame_equal(
        spoilt.gross_errors[rows], two.loc[shift > 1e-9, rows].reset_index(drop=True)
    )
    assert (spoilt.gross_errors["model_id"] == "").all()
