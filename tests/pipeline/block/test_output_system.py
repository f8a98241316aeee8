"""Results in another system: coordinates, vectors, covariances, and what it costs."""

import json

import numpy as np
import pandas as pd
import pyogrio
import pyproj
import pytest

import einschalt as es
from einschalt.pipeline.block.output_system import output_system_of

PLANE = ["easting", "northing"]
ERRORS = ["standard_error_easting", "standard_error_northing", "covariance_en"]
UTM = "EPSG:25833"


@pytest.fixture(scope="module")
def in_utm(demo_block):
    return es.densify(demo_block, es.Settings(output_crs=UTM, crs_accuracy_m=2.0))


@pytest.fixture(scope="module")
def in_lambert(demo_block):
    return es.densify(demo_block, es.Settings(output_crs="EPSG:31287"))


def moved(table, block, target):
    way = pyproj.Transformer.from_crs(block.crs, target, always_xy=True)
    return np.column_stack(way.transform(*table[PLANE].to_numpy().T))


def covariances(points):
    east, north, mixed = points[ERRORS].to_numpy().T
    return np.stack([[east**2, mixed], [mixed, north**2]]).transpose(2, 0, 1)


def test_coordinates_are_those_of_proj(good_result, in_lambert, demo_block):
    expected = moved(good_result.points, demo_block, "EPSG:31287")
    np.testing.assert_allclose(in_lambert.points[PLANE], expected, atol=1e-8, rtol=0)
    expected = moved(good_result.coverages, demo_block, "EPSG:31287")
    np.testing.assert_allclose(in_lambert.coverages[PLANE], expected, atol=1e-8, rtol=0)


def test_positions_of_two_steps_come_along(in_lambert, good_result, demo_block):
    points = good_result.points.head(2)
    of_two_steps = points[PLANE].to_numpy() + 0.3
    of_two_steps[1] = np.nan  # unknown to the two steps
    names = ["two_step_easting", "two_step_northing"]
    table = points.assign(**dict(zip(names, of_two_steps.T, strict=True)))
    told = in_lambert.output_system.told(table)
    at = pd.DataFrame(of_two_steps[:1], columns=PLANE)
    expected = moved(at, demo_block, "EPSG:31287")[0]
    np.testing.assert_allclose(told[names].iloc[0], expected, atol=1e-8, rtol=0)
    assert told[names].iloc[1].isna().all()
    assert list(told) == list(table)


def test_covariances_and_vectors_turn_and_scale_with_the_axes(demo_block):
    # errors of one axis alone, so that turning them shows; meridians apart by 1.5 gon
    settings = es.Settings(output_crs=UTM, crs_accuracy_m=2.0)
    system = output_system_of(demo_block, settings)
    place = demo_block.control_points[PLANE].iloc[[0]].to_numpy()
    names = [*PLANE, *ERRORS, "difference_easting", "difference_northing"]
    given = pd.DataFrame([[*place[0], 0.05, 0.0, 0.0, 0.3, 0.0]], columns=names)
    told = system.told(given)
    ends = pd.DataFrame(place + np.array([[0.0, 0.0], [0.3, 0.0]]), columns=PLANE)
    tail, head = moved(ends, demo_block, UTM)
    vector = told[["difference_easting", "difference_northing"]].to_numpy()[0]
    np.testing.assert_allclose(vector, head - tail, atol=1e-8)
    expected = np.outer(head - tail, head - tail) * (0.05 / 0.3) ** 2
    np.testing.assert_allclose(covariances(told)[0], expected, atol=1e-10)
    assert abs(vector[1]) > 0.003


def test_an_azimuth_turns_with_its_axis(in_utm, demo_block):
    system = in_utm.output_system
    place = demo_block.control_points[PLANE].iloc[[0]].to_numpy()
    table = pd.DataFrame(place, columns=PLANE).assign(azimuth_gon=100.0)
    tail, head = moved(
        pd.DataFrame(place + np.array([[0.0, 0.0], [10.0, 0.0]]), columns=PLANE),
        demo_block,
        UTM,
    )
    east, north = head - tail
    expected = np.arctan2(east, north) * 200.0 / np.pi
    assert system.told(table)["azimuth_gon"].iloc[0] == pytest.approx(expected)


def test_the_accuracy_of_the_operation_is_in_every_standard_error(good_result, in_utm):
    before, after = good_result.points, in_utm.points
    expected = np.hypot(before["standard_error_total"], 1.5)
    np.testing.assert_allclose(after["standard_error_total"], expected, rtol=2e-3)
    again = es.densify(in_utm.block, in_utm.settings).points
    pd.testing.assert_frame_equal(again, after)
    sources = in_utm.block_error_sources.set_index("source")["standard_error_total"]
    assert sources["reference_system"] == pytest.approx(1.5)


def test_a_change_of_projection_costs_nothing(good_result, in_lambert):
    before, after = good_result.points, in_lambert.points
    ratio = after["standard_error_total"] / before["standard_error_total"]
    np.testing.assert_allclose(ratio, 1.0, atol=1e-3)


def test_ellipses_of_another_level_are_told_there_too(in_utm):
    small, usual = in_utm.confidence_ellipses(0.5), in_utm.ellipses
    np.testing.assert_array_equal(small[PLANE], usual[PLANE])
    assert (small["semi_major"] < usual["semi_major"]).all()


def test_an_operation_by_which_control_came_is_none_of_the_way_out(demo_block):
    settings = es.Settings(crs_operation="EPSG:1619", output_crs="EPSG:31258")
    assert output_system_of(demo_block, settings).operation.accuracy_m == 0.0
    settings = es.Settings(crs_operation="EPSG:1619", output_crs=UTM)
    assert output_system_of(demo_block, settings).operation.name == "MGI to ETRS89 (1)"


def test_an_operation_that_is_not_good_enough_ends_before_the_work(demo_block):
    with pytest.raises(es.EinschaltError) as error:
        es.densify(demo_block, es.Settings(output_crs=UTM))
    said = str(error.value)
    assert "MGI / Austria GK Central (EPSG:31255) to ETRS89 / UTM zone 33N" in said
    assert "at_bev_AT_GIS_GRID_2021_09_28.tif" in said
    assert "crs_accuracy_m = 1.5" in said


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("EPSG:31254", "outside the area of MGI / Austria GK West (EPSG:31254)"),
        ("EPSG:4258", "has axes in degree"),
        ("EPSG:5703", "has the axes up; expected a plane system in metres"),
        ("EPSG:99", "output_crs: crs = 'EPSG:99' is unknown"),
        ("EPSG:3857", "output_crs: WGS 84 / Pseudo-Mercator (EPSG:3857) shows lengths"),
    ],
)
def test_systems_that_do_not_fit_are_refused(name, said, demo_block):
    settings = es.Settings(output_crs=name, crs_accuracy_m=2.0)
    with pytest.raises(es.EinschaltError) as error:
        output_system_of(demo_block, settings)
    assert said in str(error.value)


def test_heights_without_a_system_are_not_guessed(demo_block):
    from dataclasses import replace

    control = demo_block.control_points.assign(height=500.0)
    block = replace(demo_block, control_points=control)
    settings = es.Settings(output_crs="EPSG:31287")
    assert "heights stay as they are" in output_system_of(block, settings).note
    with pytest.raises(es.EinschaltError, match="has a system of heights"):
        output_system_of(block, es.Settings(output_crs="EPSG:31287+5778"))


def test_the_block_s_own_system_changes_nothing(demo_block):
    settings = es.Settings(output_crs=demo_block.crs)
    assert output_system_of(demo_block, settings) is None


def test_files_say_the_system_of_the_results(in_utm, tmp_path):
    in_utm.write(tmp_path)
    for layer in ("points", "residual_vectors", "models", "ellipses"):
        info = pyogrio.read_info(tmp_path / "block.gpkg", layer=layer)
        assert info["crs"] == UTM
    west, south, east, north = pyogrio.read_info(
        tmp_path / "block.gpkg", layer="models"
    )["total_bounds"]
    points = in_utm.points
    assert points["easting"].between(west - 100.0, east + 100.0).all()
    assert points["northing"].between(south - 100.0, north + 100.0).all()
    facts = json.loads((tmp_path / "provenance.json").read_text(encoding="utf-8"))
    assert facts["output"]["crs"] == UTM
    assert facts["output"]["accuracy_m"] == 1.5
    places = {"X_POSSIBLE_NAMES": "easting", "Y_POSSIBLE_NAMES": "northing"}
    assert pyogrio.read_info(tmp_path / "points.csv", **places)["crs"] is not None
    assert "results transformed from" in (tmp_path / "summary.txt").read_text("utf-8")


def test_the_plane_scales_no_standard_error_of_heights(in_utm, demo_block):
    place = demo_block.control_points[PLANE].iloc[[0]].reset_index(drop=True)
    names = ("height", "height_checked", "height_of_tomorrow", "total_checked")
    errors = {f"standard_error_{name}": 1.0 for name in names}
    told = in_utm.output_system.told(place.assign(**errors))[list(errors)].iloc[0]
    assert (told[:3] == 1.0).all()
    assert abs(told.iloc[3] - 1.0) > 1e-5
