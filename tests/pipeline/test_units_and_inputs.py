"""Units reach the computation as they are named, and input that is not used is said."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import BlockError, GeometryError, SettingsError
from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UNIT
from einschalt.pipeline.simulation.simulate_block import PRESETS

LENGTHS = ["x", "y", "z", "y_parallax", "base"]


def demo(**geometry):
    changed = replace(PRESETS["demo"].geometry, **geometry)
    return es.simulate_block("demo", seed=2, geometry=changed)


def in_unit(flight, unit):
    """The same measurements, written in another unit."""
    factor = METRES_PER_UNIT[flight.model_unit] / METRES_PER_UNIT[unit]

    def scaled(table):
        names = [name for name in LENGTHS if name in table]
        return table.assign(**{name: table[name] * factor for name in names})

    tables = {
        name: scaled(getattr(flight, name))
        for name in ("model_points", "y_parallaxes", "base")
        if getattr(flight, name) is not None
    }
    return replace(flight, **tables, model_unit=unit)


def rms_against_truth(result, truth):
    columns = ["easting", "northing"]
    true = truth.set_index("point_id").loc[result.solution.points["point_id"], columns]
    return np.sqrt(
        ((result.solution.points[columns].to_numpy() - true) ** 2).sum(axis=1).mean()
    )


@pytest.fixture(scope="module", params=["machine", "parallaxes"])
def in_mm(request):
    """A block in millimetres, and its result."""
    block = demo(measurement=request.param)
    return block, es.densify(block)


@pytest.mark.parametrize("unit", ["um", "cm", "m"])
def test_the_unit_of_the_models_changes_nothing(in_mm, unit):
    block, expected = in_mm
    other = replace(
        block,
        high_flight=in_unit(block.high_flight, unit),
        low_flight=in_unit(block.low_flight, unit),
    )
    found = es.densify(other)
    names = ["easting", "northing", "standard_error_paper"]
    np.testing.assert_allclose(
        found.solution.points[names], expected.solution.points[names], atol=1e-6
    )
    np.testing.assert_allclose(
        found.orientations["sigma_0"].astype(float),
        expected.orientations["sigma_0"].astype(float),
        rtol=1e-6,
    )


def test_rigid_models_have_the_size_of_the_ground():
    block = demo(transformation="rigid")
    assert block.low_flight.model_unit == "m"
    result = es.densify(block)
    error = rms_against_truth(result, block.truth)
    assert error == pytest.approx(result.figures.mean_total, rel=0.25)
    in_cm = replace(block, low_flight=in_unit(block.low_flight, "cm"))
    found = es.densify(in_cm).solution.points["easting"]
    np.testing.assert_allclose(found, result.solution.points["easting"], atol=1e-6)


def test_rigid_models_of_another_scale_are_refused():
    block = demo(transformation="rigid")
    slip = replace(block.low_flight, model_unit="mm")
    with pytest.raises(
        GeometryError,
        match=r"its scale is not near 1, at which rigid holds it.*ground units",
    ):
        es.densify(replace(block, low_flight=slip))


@pytest.mark.parametrize("kind", ["float32", "Float32"])
def test_numbers_with_too_few_digits_are_told(kind):
    """Coordinates of 32 bits are 3 cm apart; model coordinates of them are good."""
    block = demo()
    control = block.control_points.astype({"northing": kind})
    (note,) = replace(block, control_points=control).notes
    assert note.startswith("control_points: numbers of 32 bits in column northing are")
    assert "as far as 0.031 apart" in note
    models = block.low_flight.model_points.astype({"x": kind})
    low = replace(block.low_flight, model_points=models)
    assert replace(block, low_flight=low).notes == block.notes


def test_weights_in_a_block_are_ignored_and_that_is_said():
    block = demo()
    points = block.low_flight.model_points.assign(weight=1e-4)
    weighted = replace(block, low_flight=replace(block.low_flight, model_points=points))
    assert any("ignored column weight" in note for note in weighted.notes)
    assert es.densify(weighted).figures == es.densify(block).figures


def test_notes_are_not_repeated():
    block = demo()
    points = block.low_flight.model_points.assign(colour="red")
    noted = replace(block, low_flight=replace(block.low_flight, model_points=points))
    assert replace(replace(noted)).notes == noted.notes


def test_simulated_blocks_are_blocks():
    assert isinstance(demo(), es.Block)


def test_parallax_flights_need_heights_in_their_models():
    block = demo(measurement="parallaxes")
    points = block.low_flight.model_points.drop(columns="z")
    with pytest.raises(
        es.EinschaltError, match=r"low_flight.model_points.*'z' is miss"
    ):
        replace(block, low_flight=replace(block.low_flight, model_points=points))


def test_models_without_parallaxes_are_found_by_the_check():
    block = demo(measurement="parallaxes")
    table = block.low_flight.y_parallaxes
    kept = table[table["model_id"] != table["model_id"].iloc[0]]
    changed = replace(block, low_flight=replace(block.low_flight, y_parallaxes=kept))
    said = [str(problem) for problem in changed.model_problems]
    assert said
    assert all("the model has no y-parallaxes" in text for text in said)
    assert len(es.densify(changed).failures) == len(said)


def test_no_model_oriented_names_the_reason():
    block = demo(measurement="parallaxes")
    flight = block.low_flight
    above = flight.y_parallaxes.assign(z=-flight.y_parallaxes["z"])
    upside_down = replace(block, low_flight=replace(flight, y_parallaxes=above))
    with pytest.raises(GeometryError, match="no model could be oriented: a point lies"):
        es.densify(upside_down)


def test_parallaxes_beside_images_are_refused():
    images = demo(measurement="images")
    parallaxes = demo(measurement="parallaxes").low_flight
    both = replace(
        images.low_flight, y_parallaxes=parallaxes.y_parallaxes, base=parallaxes.base
    )
    with pytest.raises(
        (SettingsError, BlockError), match="y_parallaxes and image_points are both"
    ):
        replace(images, low_flight=both)


def test_a_point_without_height_is_left_out_of_spatial_fits():
    block = demo(measurement="images")
    control = block.control_points.copy()
    control.loc[control.index[0], "height"] = np.nan
    result = es.densify(replace(block, control_points=control))
    high = result.residuals[result.residuals["flight"] == "high_flight"]
    assert control["point_id"].iloc[0] not in set(high["point_id"])


def test_roles_are_checked_in_stage_1():
    block = demo()
    control = block.control_points.assign(role="Check")
    with pytest.raises(
        es.EinschaltError, match=r"role 'Check' is unknown.*Write check"
    ):
        es.approximate_coordinates(block.high_flight.model_points, control)


def test_integer_names_are_taken_in_stage_1():
    block = demo()
    points = block.high_flight.model_points
    points = points.assign(point_id=points["point_id"].astype(int))
    found = es.approximate_coordinates(points, block.control_points).points
    expected = es.approximate_coordinates(
        block.high_flight.model_points, block.control_points
    ).points
    pd.testing.assert_frame_equal(found, expected)


def test_millimetres_are_a_thousandth():
    assert METRES_PER_UNIT["mm"] == METRES_PER_MM
