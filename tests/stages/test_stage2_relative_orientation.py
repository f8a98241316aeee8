"""Stage 2: a flight goes in, oriented model points and a table of orientations out."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.block.facts import ORIENTATION_CASES, ORIENTATION_METHODS
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    METHODS,
    orient_from_parallaxes,
)
from einschalt.stages.stage2_relative_orientation import (
    ORIENTATION_COLUMNS,
    image_pairs,
    relative_orientation,
)
from einschalt.theory.relative_orientation.orientation_elements import CASES


@pytest.fixture(scope="module", params=["parallaxes", "images"])
def flight(request):
    geometry = replace(PRESETS["demo"].geometry, measurement=request.param)
    return simulate_block("demo", seed=2, geometry=geometry).low_flight


def oriented_directly(flight, **options):
    if flight.has_images:
        pairs = image_pairs(flight.image_points, flight.models)
        return orient_from_images(pairs, flight.principal_distance_mm, **options)
    return orient_from_parallaxes(flight.y_parallaxes, flight.base, **options)


def in_two_planes(flight):
    """Y-parallaxes in the planes x = 0 and x = base, which Krames' formulas need."""
    names = [name for name in ("coverage", "model_id") if name in flight.base]
    rows = flight.y_parallaxes.merge(flight.base, on=names)
    x, base = rows["x"].to_numpy(), rows["base"].to_numpy()
    is_left = np.abs(x) < np.abs(x - base)
    return rows.drop(columns="base").assign(x=np.where(is_left, 0.0, base))


def test_known_words_are_those_of_the_stages():
    assert set(ORIENTATION_CASES) == set(CASES)
    assert set(ORIENTATION_METHODS) == set(METHODS)


def test_orientations_with_their_verdict(flight):
    found = relative_orientation(flight)
    table = found.orientations
    assert list(table.columns[: len(ORIENTATION_COLUMNS)]) == ORIENTATION_COLUMNS
    direct = oriented_directly(flight)
    assert table["case"].unique().tolist() == [direct.case]
    surfaces = direct.dangerous_surface
    assert table["model_id"].tolist() == surfaces.index.tolist()
    assert table["verdict"].tolist() == surfaces["verdict"].tolist()
    assert set(table["verdict"]) == {"safe"}
    assert (table["reason"] == "").all()
    np.testing.assert_allclose(table["inflation"], surfaces["inflation"])


@pytest.mark.parametrize("case", ORIENTATION_CASES)
def test_case_of_a_flight(flight, case):
    if case == "dependent_right" and not flight.has_images:
        # its parallaxes have the other sign
        turned = flight.y_parallaxes.assign(y_parallax=lambda rows: -rows["y_parallax"])
        flight = replace(flight, y_parallaxes=turned)
    found = relative_orientation(replace(flight, orientation_case=case))
    assert set(found.orientations["case"]) == {case}
    direct = oriented_directly(flight, case=case)
    names = list(direct.parameters.columns)
    np.testing.assert_array_equal(found.orientations[names], direct.parameters)
    # the case is a matter of the system: points fit each other as before
    usual = relative_orientation(flight)
    assert len(found.model_points) == len(usual.model_points)
    np.testing.assert_allclose(
        found.orientations["sigma_0"], usual.orientations["sigma_0"], rtol=1e-6
    )


@pytest.mark.parametrize("method", METHODS)
def test_method_of_a_flight(flight, method):
    if flight.has_images:
        pytest.skip("methods are for y-parallaxes")
    if method == "krames":
        flight = replace(flight, y_parallaxes=in_two_planes(flight))
    found = relative_orientation(replace(flight, orientation_method=method))
    direct = oriented_directly(flight, method=method)
    names = list(direct.parameters.columns)
    np.testing.assert_array_equal(found.orientations[names], direct.parameters)
    assert len(found.failures) == 0


def test_oriented_flights_pass_unchanged():
    flight = simulate_block("demo", seed=2).low_flight
    found = relative_orientation(flight)
    assert found.model_points is flight.model_points
    assert list(found.orientations.columns) == ORIENTATION_COLUMNS
    assert found.summary() == "no relative orientation to compute"


def distances_over_base(flight, case):
    """From both projection centres to the points of a model, its base being 1."""
    found = relative_orientation(replace(flight, orientation_case=case))
    first = found.orientations[["coverage", "model_id"]].head(1)
    points, centres = (
        table.merge(first) for table in (found.model_points, found.centres)
    )
    centres = centres.set_index("image_id")[list("xyz")].to_numpy(dtype=float)
    way = points[list("xyz")].to_numpy()[:, None] - centres
    base = np.linalg.norm(centres[1] - centres[0])
    return centres, np.linalg.norm(way, axis=2) / base


@pytest.mark.parametrize("case", CASES)
def test_projection_centres_belong_to_the_model_in_every_case(flight, case):
    if not flight.has_images:
        assert relative_orientation(
            replace(flight, orientation_case=case)
        ).centres.empty
        return
    centres, found = distances_over_base(flight, case)
    _, expected = distances_over_base(flight, "dependent_right")
    # the case turns the system and changes its scale: ratios stay
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    # the base of two photographs that overlap by 60 % of 23 cm, at image scale
    assert np.linalg.norm(centres[1] - centres[0]) == pytest.approx(92.0, rel=0.1)


def test_models_without_coverage_are_of_the_first(flight):
    names = ("model_points", "y_parallaxes", "models", "base")
    tables = {n: t for n in names if hasattr(t := getattr(flight, n), "columns")}
    first = {
        name: table[table["coverage"] == "1"].drop(columns="coverage")
        for name, table in tables.items()
        if "coverage" in table
    }
    found = relative_orientation(replace(flight, **first))
    assert set(found.orientations["coverage"]) == {"1"}
    assert set(found.model_points["coverage"]) == {"1"}
    assert len(found.failures) == 0


def test_every_model_of_exchanged_photographs_is_a_failure():
    """Photographs of two strips: nothing is left of their pairs, which are told."""
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    flight = simulate_block("demo", seed=2, geometry=geometry).low_flight
    names = flight.image_points["image_id"].unique()
    one, other = names[1], names[-2]
    exchanged = {one: other, other: one}
    points = flight.image_points.assign(
        image_id=flight.image_points["image_id"].replace(exchanged)
    )
    result = relative_orientation(replace(flight, image_points=points))
    key = ["coverage", "model_id"]
    done = {tuple(row) for row in result.orientations[key].to_numpy()}
    failed = {tuple(row) for row in result.failures[key].to_numpy()}
    given = {tuple(row) for row in flight.models[key].to_numpy()}
    assert done | failed == given
    reasons = set(result.failures["reason"])
    assert "its photographs have no point in common" in reasons
    assert result.failures["remedy"].str.contains("they may be exchanged").any()


def test_a_flight_without_any_pair_is_refused():
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    flight = simulate_block("demo", seed=2, geometry=geometry).low_flight
    points = flight.image_points
    points = points.assign(point_id=points["image_id"] + points["point_id"])
    with pytest.raises(GeometryError, match="have no point in common"):
        relative_orientation(replace(flight, image_points=points))


def test_models_that_are_left_out_take_their_errors_with_them(flight):
    oriented = relative_orientation(flight)
    keys = ["coverage", "model_id"]
    lost = oriented.model_points[keys].drop_duplicates().iloc[[0, 2]]
    rest = oriented.without_models(lost)
    is_lost = oriented.model_points.set_index(keys).index.isin(
        lost.set_index(keys).index
    )
    assert is_lost.any()
    kept = oriented.model_points[~is_lost].reset_index(drop=True)
    assert rest.model_points.equals(kept)
    if flight.has_images:
        for name in ("model", "by_image", "gain", "by_point"):
            whole = getattr(oriented.errors.influence, name)
            part = getattr(rest.errors.influence, name)
            np.testing.assert_array_equal(part, whole[~is_lost])
        np.testing.assert_array_equal(
            rest.errors.sources, oriented.errors.sources[~is_lost]
        )
    else:
        for name in ("model", "factors"):
            whole, part = getattr(oriented.errors, name), getattr(rest.errors, name)
            np.testing.assert_array_equal(part, whole[~is_lost])


def test_models_without_errors_of_orientation_may_be_left_out():
    flight = simulate_block("demo", seed=2).low_flight
    oriented = relative_orientation(flight)
    first = oriented.model_points[["coverage", "model_id"]].head(1)
    rest = oriented.without_models(first)
    assert rest.errors is None
    assert 0 < len(rest.model_points) < len(oriented.model_points)
