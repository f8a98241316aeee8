"""Film and the way round that it shows the ground: what residuals cannot tell."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.changed_results import changed

import einschalt as es
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.pipeline.assessment.evidence.ground.frame import (
    LARGEST_DIAGONAL_M,
    LARGEST_STRETCH,
    Doubt,
    _film_of,
    are_mirrored,
    are_upside_down,
)
from einschalt.pipeline.assessment.evidence.ground.stretch import (
    affinities_onto_control,
    stretch_of,
)
from einschalt.pipeline.simulation.simulate_block import PRESETS


def without_system(result):
    return changed(result, block=replace(result.block, crs=None))


def test_a_good_block_is_not_doubted(good_result):
    frame = good_result.examination.frame
    assert frame.doubt is Doubt.NONE
    assert without_system(good_result).examination.frame.doubt is Doubt.NONE
    for film in frame.films:
        # 60 % overlap of 23 cm film, and the points that lie beyond it
        assert 0.1 < film.on_film < 0.3


def test_the_diameter_does_not_depend_on_the_direction_of_the_strips(good_result):
    frame = good_result.examination.frame
    points = good_result.solution.points.copy()
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    points[["easting", "northing"]] = points[["easting", "northing"]] @ turn.T
    turned = changed(good_result, points=points).examination.frame
    for before, after in zip(frame.films, turned.films, strict=True):
        assert after.diameter == pytest.approx(before.diameter, rel=0.04)


@pytest.mark.parametrize("has_system", [True, False])
def test_mirrored_models_are_doubted_where_no_system_tells(good_result, has_system):
    models = good_result.models.copy()
    models[["a1", "b1"]] *= -1.0
    mirrored = changed(good_result, models=models)
    mirrored = mirrored if has_system else without_system(mirrored)
    assert are_mirrored(models)["is_mirrored"].all()
    assert mirrored.examination.frame.is_mirrored
    doubt = mirrored.examination.frame.doubt
    assert doubt is (Doubt.NONE if has_system else Doubt.MIRRORED)
    assert mirrored.examination.credible.is_lower_bound != has_system


def test_models_larger_than_film(good_result):
    low = good_result.block.low_flight
    small = replace(low, scale_number=low.scale_number / 2.5)
    block = replace(good_result.block, low_flight=small)
    frame = changed(good_result, block=block).examination.frame
    assert frame.doubt is Doubt.LARGER_THAN_FILM
    (film,) = frame.impossible_films
    assert film.flight == "low_flight"
    assert film.on_film > LARGEST_DIAGONAL_M


def test_a_few_models_upside_down_are_no_doubt_of_the_frame(good_result):
    models = good_result.models.assign(omega=0.1, phi=0.0, is_usable=True)
    models.loc[models.index[:3], "omega"] = np.pi
    assert are_upside_down(models)["is_upside_down"].sum() == 3
    few = changed(good_result, models=models).examination.frame
    assert few.doubt is Doubt.NONE
    over = changed(good_result, models=models.assign(omega=np.pi)).examination.frame
    assert over.doubt is Doubt.UPSIDE_DOWN


def test_an_axis_that_is_stretched_more_than_film(good_result):
    assert good_result.examination.frame.stretch < 0.001
    models = good_result.models.copy()
    models[["a2", "b2"]] *= 1.01
    frame = changed(good_result, models=models).examination.frame
    assert frame.doubt is Doubt.STRETCHED
    # beside the affinity that measuring errors make of single models
    assert frame.stretch == pytest.approx(0.01, rel=0.1)


def test_spatial_models_of_tilted_photographs_are_not_stretched():
    """As oriented by themselves; with a plane fit of x and y by a third."""
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
    block = es.simulate_block("demo", seed=2, geometry=geometry)
    turn = rotation_from_angles(0.7, 0.0, 0.3)
    points = block.high_flight.model_points
    tilted = points.copy()
    tilted[["x", "y", "z"]] = points[["x", "y", "z"]].to_numpy() @ turn.T
    high = replace(block.high_flight, model_points=tilted)
    result = es.densify(replace(block, high_flight=high))
    frame = result.examination.frame
    assert stretch_of(affinities_onto_control(tilted, block.control_points)).size > 0.2
    assert frame.stretch < LARGEST_STRETCH
    assert not frame.is_stretched
    codes = [finding.code for finding in result.assessment.findings]
    assert "stretched_models" not in codes


def test_affinities_of_weak_models_are_no_stretch():
    rng = np.random.default_rng(5)
    weak = np.eye(2) + rng.normal(0.0, 0.02, (12, 2, 2))
    names = ["a1", "a2", "b1", "b2"]
    models = pd.DataFrame(weak.reshape(-1, 4), columns=names).assign(n_points=5)
    ratio = np.linalg.cond(weak)
    assert np.median(ratio) - 1.0 > 4.0 * LARGEST_STRETCH
    assert stretch_of(models).p_value > 0.01
    models["b2"] *= 1.2  # feet of another length do not hide in the noise
    found = stretch_of(models)
    assert found.size == pytest.approx(0.2, rel=0.2)
    assert found.p_value < 0.001


def doubted(frame, **fields):
    known = {"coordinates": (15_000.0, 322_000.0, 520.0), "has_system": False}
    return replace(frame, **known | fields)


def test_a_doubt_of_the_frame_counts_by_what_coordinates_would_be_off(good_result):
    frame = good_result.examination.frame
    assert frame.could_be_off.plan == 0.0
    mirrored = doubted(frame, n_mirrored=frame.n_affine)
    assert mirrored.could_be_off.plan == 644_000.0
    common = replace(frame.common, size=999.0, p_value=0.0, east_by_north=1000.0)
    # northing in thousands: 322 of 322 000
    in_thousands = (15_000.0, 322.0, 520.0)
    stretched = doubted(frame, common=common, coordinates=in_thousands)
    assert stretched.could_be_off.plan == pytest.approx(999.0 * 322.0)


def with_scales(frame, *ratios):
    films = zip(frame.films, ratios, strict=True)
    return doubted(frame, films=tuple(replace(f, scale_ratio=r) for f, r in films))


def test_photographs_of_all_flights_tell_the_unit_of_control(good_result):
    frame = with_scales(good_result.examination.frame, 0.31, 0.30)
    assert frame.doubt is Doubt.OUT_OF_SCALE
    # given as 0.305 of what it is
    off = frame.could_be_off
    assert off.plan == pytest.approx(2.28 * 322_350.0, rel=0.01)
    assert off.height == pytest.approx(2.28 * 520.0, rel=0.01)


def test_photographs_of_one_flight_tell_its_scale_number(good_result):
    frame = with_scales(good_result.examination.frame, 1.02, 10.0)
    assert frame.doubt is Doubt.NONE
    (film,) = frame.films_out_of_scale
    assert film.flight == "low_flight"
    assert with_scales(frame, 1.02, 0.95).films_out_of_scale == ()


def test_scale_of_photographs_is_that_of_their_flights(image_block):
    places = image_block.truth.set_index("point_id")[["easting", "northing"]]
    for name, flight in image_block.flights.items():
        film = _film_of(name, flight, places)
        assert film.scale_ratio == pytest.approx(1.0, abs=0.1)
