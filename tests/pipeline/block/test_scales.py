"""Sizes that do not fit each other are a wrong unit, and are said before computing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import einschalt as es
from einschalt.foundations.errors import (
    BlockError,
    ConsistencyError,
    SettingsError,
    TableError,
)
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import written_in
from einschalt.pipeline.simulation.simulate_block import PRESETS


@pytest.fixture(scope="module")
def block():
    # without a system, so that the area of use does not speak first
    return replace(es.simulate_block("demo", seed=5), crs=None)


@pytest.fixture(scope="module")
def parallax_block():
    geometry = replace(PRESETS["demo"].geometry, measurement="parallaxes")
    return es.simulate_block("demo", seed=5, geometry=geometry)


def with_control(block, factor):
    control = block.control_points.copy()
    control[["easting", "northing"]] *= factor
    return replace(block, control_points=control)


@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_control_in_another_unit(block, factor):
    with pytest.raises(
        es.EinschaltError,
        match=r"the points of a model extend over .* m on the ground.*in metres",
    ):
        with_control(block, factor)


def test_scale_number_ten_times_too_small(block):
    flight = replace(block.high_flight, scale_number=1500)
    with pytest.raises(
        ConsistencyError, match=r"in an image 1:1500; expected 4 to 800 mm"
    ):
        replace(block, high_flight=flight)


def test_images_of_small_sensors():
    """9 mm wide, as small aircraft carry them: models extend over 3 mm there."""
    block = es.read_block(Path(__file__).parents[3] / "data_examples/sxb_strasbourg")
    flight, factor = block.low_flight, 12.0
    wrong = replace(flight, scale_number=factor * flight.scale_number)
    with pytest.raises(
        ConsistencyError, match=r"is 3\.\d+ mm .*; expected 4 to 800 mm"
    ):
        replace(block, low_flight=wrong)
    images = flight.image_points
    images = images.assign(x=images["x"] / factor, y=images["y"] / factor)
    distance = flight.principal_distance_mm / factor
    small = replace(wrong, image_points=images, principal_distance_mm=distance)
    assert replace(block, low_flight=small).low_flight.n_models == flight.n_models


def test_a_coordinate_beyond_all_systems(block):
    control = block.control_points.copy()
    control.loc[control.index[2], "easting"] = 1e30
    with pytest.raises(
        ConsistencyError, match=r"row 2, point \d+: easting 1e\+30.*Correct the value"
    ):
        replace(block, control_points=control)


def test_one_wrong_point_does_not_stop_a_block(block):
    control = block.control_points.copy()
    control.loc[control.index[2], "easting"] += 50_000.0
    assert len(es.densify(replace(block, control_points=control)).solution.points)


def test_base_in_metres_beside_millimetres(parallax_block):
    flight = parallax_block.low_flight
    base = flight.base.assign(base=flight.base["base"] / 1e3)
    with pytest.raises(ConsistencyError, match=r"base 0\.\d+, where .* in model_unit"):
        replace(parallax_block, low_flight=replace(flight, base=base))


def test_parallaxes_in_micrometres_beside_millimetres(parallax_block):
    flight = parallax_block.low_flight
    table = flight.y_parallaxes
    table = table.assign(y_parallax=table["y_parallax"] * 1e3)
    with pytest.raises(ConsistencyError, match=r"y_parallax .* in model_unit"):
        replace(parallax_block, low_flight=replace(flight, y_parallaxes=table))


def test_parallaxes_without_base_in_stage_2(parallax_block):
    flight = replace(parallax_block.low_flight, base=None)
    with pytest.raises(SettingsError, match="base"):
        es.relative_orientation(flight)


def test_systems_are_kept_as_text():
    block = es.simulate_block("demo", seed=5)
    assert replace(block, crs=31255).crs == "EPSG:31255"
    assert replace(block, crs=np.int64(31255)).crs == "EPSG:31255"


def test_what_is_no_block_is_refused():
    with pytest.raises(SettingsError, match="was given a str; expected a Block"):
        es.densify("data_examples/neukirchen")
    block = es.simulate_block("demo", seed=5)
    with pytest.raises(SettingsError, match="settings is a dict; expected Settings"):
        es.densify(block, {"coverage_mean": "all"})


def test_weights_by_row_and_by_point():
    block = es.simulate_block("demo", seed=5)
    points = block.low_flight.model_points.reset_index(drop=True)
    ground = block.truth
    weights = 1.0 + points["x"].abs() / 50.0
    by_row = es.transform_models(points, ground, weights=weights)
    array = es.transform_models(points, ground, weights=weights.to_numpy())
    assert by_row.parameters.equals(array.parameters)
    ids = {name: str(place) for place, name in enumerate(ground["point_id"])}
    numbered = points.assign(point_id=points["point_id"].map(ids))
    renamed = ground.assign(point_id=ground["point_id"].map(ids))
    with pytest.raises(TableError, match=r"names points as well.*Give an array"):
        es.transform_models(numbered, renamed, weights=weights)


@pytest.mark.parametrize(
    "column",
    ["standard_error_easting", "standard_error_northing", "standard_error_height"],
)
def test_standard_errors_of_each_axis_in_millimetres(block, column):
    names = ["standard_error_easting", "standard_error_northing"]
    errors = dict.fromkeys([*names, column], 0.021) | {column: 21.0}
    control = block.control_points.assign(**errors)
    with pytest.raises((TableError, BlockError), match=f"{column} 21.*millimetres"):
        replace(block, control_points=control)
    replace(block, control_points=control.assign(**{column: 0.021}))


@pytest.mark.parametrize(
    ("value", "remedy"),
    [
        (400.0, "Did you give square millimetres"),
        (-400.0, "Did you give square millimetres"),
        (0.6, "Did you give a correlation"),
        (5e9, "Delete the column"),
    ],
)
def test_covariances_beyond_the_product_of_standard_errors(block, value, remedy):
    errors = dict.fromkeys(["standard_error_easting", "standard_error_northing"], 0.021)
    control = block.control_points.assign(**errors, covariance_en=0.0003)
    replace(block, control_points=control)
    control.loc[control.index[2], "covariance_en"] = value
    with pytest.raises(TableError, match=rf"row 2.* 0\.021 and 0\.021 m.*{remedy}"):
        replace(block, control_points=control)


def coarse(block):
    return [note for note in block.notes if "digits below" in note]


def rounded(frame, digits, names=("easting", "northing")):
    return frame.assign(**{name: frame[name].round(digits) for name in names})


def test_control_without_decimals_is_noted(demo_block):
    """Rounding to a metre makes 0.41 m of a point that is stated to centimetres."""
    control = demo_block.control_points
    (note,) = coarse(replace(demo_block, control_points=rounded(control, 0)))
    assert "no digits below 1 m: rounding makes 0.41 m (total)" in note
    assert "give more digits, or standard errors of 0.41 m" in note
    assert coarse(replace(demo_block, control_points=rounded(control, 3))) == []
    # a grid of places, as of a plan
    assert coarse(replace(demo_block, control_points=rounded(control, -2))) == []
    for step in (5.0, 25.0):
        grid = (control[["easting", "northing"]] / step).round() * step
        on_grid = control.assign(easting=grid["easting"], northing=grid["northing"])
        assert coarse(replace(demo_block, control_points=on_grid)) == []
    # what is advised is enough
    followed = rounded(control, 0).assign(standard_error_m=0.41)
    assert coarse(replace(demo_block, control_points=followed)) == []
    cautious = rounded(control, 0).assign(standard_error_m=2.0)
    assert coarse(replace(demo_block, control_points=cautious)) == []
    assert coarse(demo_block) == []


@pytest.mark.parametrize("axis", ["easting", "northing"])
def test_one_axis_without_decimals_is_noted(demo_block, axis):
    """Of an axis alone rounding leaves 1/√12 of a metre."""
    control = rounded(demo_block.control_points, 0, (axis,))
    (note,) = coarse(replace(demo_block, control_points=control))
    assert f"{axis} has no digits below 1 m: rounding makes 0.29 m (total)" in note
    with written_in("de"):
        told = retold(note)
    assert f": {axis} hat keine Stellen unter 1 m: das Runden macht 0,29 m" in told
    # the axis of a plan, along which points were laid out
    laid_out = rounded(demo_block.control_points, -2, (axis,))
    assert coarse(replace(demo_block, control_points=laid_out)) == []


def test_heights_without_decimals_are_noted_where_models_are_spatial(demo_block):
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
    spatial = es.simulate_block("demo", seed=1, geometry=geometry)
    control = rounded(spatial.control_points, 0, ("height",))
    (note,) = coarse(replace(spatial, control_points=control))
    assert "heights have no digits below 1 m: rounding makes 0.29 m, beside" in note
    assert "give more digits, or standard_error_height of 0.29 m" in note
    followed = control.assign(standard_error_height=0.29)
    assert coarse(replace(spatial, control_points=followed)) == []
    own = rounded(control, 1, ("height",)).assign(standard_error_height=0.02)
    assert (
        "beside a standard error of 0.02 m"
        in coarse(replace(spatial, control_points=own))[0]
    )
    assert coarse(replace(spatial, control_points=rounded(control, 3))) == [note]
    assert coarse(spatial) == []
    # nobody needs them in plane models
    plane = demo_block.control_points.assign(height=range(23))
    assert coarse(replace(demo_block, control_points=plane)) == []


def test_approximate_points_without_decimals_are_noted(demo_block):
    points = rounded(demo_block.truth[["point_id", "easting", "northing"]], 0)
    given = {"high_flight": None, "approximate_points": points}
    (note,) = coarse(replace(demo_block, **given, approximate_m_0_m=0.1))
    assert "beside a standard error of 0.1 m" in note
    assert coarse(replace(demo_block, **given, approximate_m_0_m=2.0)) == []
    assert coarse(replace(demo_block, **given)) == []


def test_film_coordinates_of_tenths_of_millimetres_are_noted(demo_block):
    low = demo_block.low_flight
    points = rounded(low.model_points, 1, ("x", "y"))
    (note,) = coarse(replace(demo_block, low_flight=replace(low, model_points=points)))
    assert "no digits below 100 µm: rounding makes 41 µm (total)" in note
    points = rounded(low.model_points, 3, ("x", "y"))
    assert (
        coarse(replace(demo_block, low_flight=replace(low, model_points=points))) == []
    )


def test_control_with_errors_of_its_axes_has_their_total(block):
    """As programs of adjustment state them; what is stated as total stays."""
    given = block.control_points.drop(columns="standard_error_m", errors="ignore")
    axes = {"standard_error_easting": 0.03, "standard_error_northing": 0.04}
    by_axis = replace(block, control_points=given.assign(**axes)).control_points
    np.testing.assert_allclose(by_axis["standard_error_m"], 0.05, rtol=1e-12)
    both = given.assign(**axes, standard_error_m=0.06)
    stated = replace(block, control_points=both).control_points["standard_error_m"]
    assert (stated == 0.06).all()
