"""Spatial models over a curved Earth, in a map with a scale of its own."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pyproj
import pytest

import einschalt as es
from einschalt.pipeline.assessment.facts.flights import flight_facts
from einschalt.stages.bent_map import straightened
from einschalt.stages.curved_earth import bend_flights, is_worth_bending
from einschalt.stages.stage2_relative_orientation import relative_orientation

EARTH = 6.38e6
AXES = ["easting", "northing", "height"]
EXACT = {
    **dict.fromkeys(("control_standard_error", "orientation_error"), 0.0),
    **dict.fromkeys(("high_m_g_um", "low_m_g_um", "y_parallax_um"), 0.0),
}


@pytest.fixture(scope="module", params=["machine", "images"])
def exact_block(request):
    """Without any error, 110 km from the meridian of its zone, with 60 m of relief."""
    geometry = es.BlockGeometry(
        width=3e3,
        height=3e3,
        crs="EPSG:25833",
        centre_easting=390_000.0,
        centre_northing=5_240_000.0,
        transformation="helmert_3d",
        measurement=request.param,
        relief=60.0,
    )
    return es.simulate_block("demo", geometry=geometry, noise=es.BlockNoise(**EXACT))


def largest_errors(block, method):
    """Of new points, in plan and in height [m]."""
    # models that are bent alike would be corrected for most of it
    how = {"method": method, "outliers": "keep", "model_deformation": "ignored"}
    settings = es.Settings(**how)
    points = es.densify(block, settings).points
    new = points[points["role"] == "new"].merge(block.truth, on="point_id")
    away = [(new[f"{name}_x"] - new[f"{name}_y"]).abs().max() for name in AXES]
    return np.hypot(*away[:2]), away[2]


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_coordinates_are_right_to_a_tenth_of_a_millimetre(exact_block, method):
    assert max(largest_errors(exact_block, method)) < 1e-4


@pytest.mark.slow
def test_taken_for_cartesian_coordinates_they_would_be_wrong_by_a_decimetre(
    exact_block,
):
    flat = replace(exact_block, crs=None)
    assert largest_errors(flat, "two_step")[1] > 0.05


@pytest.mark.slow
def test_models_that_were_corrected_before_stay_as_they_are(exact_block):
    ignored = es.Settings(earth_curvature="ignored", outliers="keep")
    flat = es.densify(replace(exact_block, crs=None), es.Settings(outliers="keep"))
    found = es.densify(exact_block, ignored)
    np.testing.assert_array_equal(
        found.solution.points[AXES], flat.solution.points[AXES]
    )
    assert not any(flight.is_curved for flight in flight_facts(found.examination))
    treated = es.densify(exact_block).examination
    assert all(flight.is_curved for flight in flight_facts(treated))
    alone = es.adjust_block(replace(exact_block, settings=ignored), kind="helmert_3d")
    expected = es.adjust_block(replace(exact_block, crs=None), kind="helmert_3d")
    np.testing.assert_array_equal(alone.points[AXES], expected.points[AXES])


def test_the_middle_stays_and_the_horizon_falls():
    middle = np.array([390_000.0, 5_240_000.0, 400.0])
    east = np.array([[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [0.0, 0.0, 100.0]])
    found = straightened(middle + east, middle, "EPSG:25833") - middle
    longitude, latitude = pyproj.Transformer.from_crs(
        "EPSG:25833", "EPSG:4258", always_xy=True
    ).transform(*middle[:2])
    scale = pyproj.Proj("EPSG:25833").get_factors(longitude, latitude).meridional_scale
    length = 1000.0 / scale * (1.0 + 400.0 / EARTH)
    expected = [[0, 0, 0], [length, 0, -(length**2) / 2.0 / EARTH], [0, 0, 100]]
    np.testing.assert_allclose(found, expected, atol=2e-3)


def test_models_and_centres_are_bent_and_without_a_system_stay_as_they_are(
    exact_block,
):
    flights = {
        name: relative_orientation(flight)
        for name, flight in exact_block.flights.items()
    }
    flat = bend_flights(replace(exact_block, crs=None), flights)
    assert all(flat[name] is flights[name] for name in flights)
    names = ["coverage", "model_id", "point_id"]
    for name, bent in bend_flights(exact_block, flights).items():
        before = flights[name]
        pd.testing.assert_frame_equal(
            before.model_points[names], bent.model_points[names]
        )
        moved = (bent.model_points[["x", "y", "z"]] - before.model_points).abs()
        # some decimetres of scale at the edges of the model [mm at its scale]
        assert 1e-3 < moved[["x", "y", "z"]].max(axis=None) < 0.2
        # machine coordinates have no centres
        assert len(bent.centres) == len(before.centres)
        if len(bent.centres):
            assert not bent.centres["z"].equals(before.centres["z"])


LILLE = {"crs": "EPSG:2154", "centre_easting": 700e3, "centre_northing": 7_090e3}


@pytest.mark.slow
def test_the_scale_of_the_map_changes_across_plane_models():
    """Without any error, in the north of France, where its map's scale changes most."""
    geometry = es.BlockGeometry(width=3e3, height=3e3, **LILLE)
    noise = es.BlockNoise(**EXACT)
    block = es.simulate_block("demo", geometry=geometry, noise=noise)

    def missed(**more):
        result = es.densify(block, es.Settings(outliers="keep", **more))
        points = result.solution.points
        points = points[points["role"] == "new"].merge(block.truth, on="point_id")
        away = [points[f"{name}_x"] - points[f"{name}_y"] for name in AXES[:2]]
        return np.hypot(*away).max(), result.summary()

    treated, said = missed()
    assert treated < 1e-4
    assert "corrected for the scale of the map, which changes across them" in said
    assert missed(method="simultaneous")[0] < 1e-4
    film = es.adjust_block(block, kind="helmert_film_affinity").points
    film = film[film["role"] == "new"].merge(block.truth, on="point_id")
    np.testing.assert_allclose(film["easting_x"], film["easting_y"], rtol=0, atol=1e-3)
    ignored, said = missed(earth_curvature="ignored")
    assert ignored > 2e-3
    assert "scale of the map" not in said


@pytest.mark.parametrize(
    ("crs", "place", "scale_number", "is_bent"),
    [
        ("EPSG:31255", (15_000.0, 322_000.0), 15_000, False),  # near its meridian
        ("EPSG:31255", (100_000.0, 240_000.0), 15_000, True),
        ("EPSG:31255", (100_000.0, 240_000.0), 8_000, True),
        ("EPSG:31255", (100_000.0, 240_000.0), 6_000, False),
        ("EPSG:31287", (400_000.0, 400_000.0), 8_000, False),
        (None, (100_000.0, 240_000.0), 15_000, False),
    ],
)
def test_small_plane_models_near_the_meridian_are_left_alone(
    crs, place, scale_number, is_bent
):
    """|∇k| r² / 2, of k = 1 + y² / 2R²: y / R² · r² / 2."""
    gradient = place[0] / EARTH**2 if crs == "EPSG:31255" else 0.0
    expected = gradient * (0.134 * scale_number) ** 2 / 2.0 > 1e-3
    assert expected == is_bent
    control = pd.DataFrame([place], columns=AXES[:2])
    flight = SimpleNamespace(scale_number=scale_number)
    block = SimpleNamespace(
        crs=crs,
        control_points=control,
        approximate_points=None,
        flights={"low_flight": flight},
    )
    assert is_worth_bending(block, "low_flight", "affine") is is_bent
