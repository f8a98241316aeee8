import numpy as np
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.layout import (
    Raster,
    choose_control,
    flight_rasters,
    lay_flight,
    leave_control_of_others,
    name_points,
    on_control_alone,
    scatter_points,
    shape_terrain,
    turn,
    with_control_of_all,
)
from einschalt.pipeline.simulation.simulate_block import simulate_block


def laid(geometry, flight="high_flight", seed=0):
    position = scatter_points(geometry, np.random.default_rng(seed))
    return position, lay_flight(geometry, flight, position)


def points_held(layout, coverage):
    is_of_coverage = layout.coverage[layout.model] == coverage
    return set(layout.point[is_of_coverage])


def test_points_lie_near_their_lattice_places_row_by_row_from_north_west():
    geometry = BlockGeometry(width=1500.0, height=900.0)
    position = scatter_points(geometry, np.random.default_rng(5))
    east, north = np.meshgrid([-600, -300, 0, 300, 600], [300, 0, -300])
    away = position - np.column_stack([east.ravel(), north.ravel()])
    assert len(position) == 15
    assert np.abs(away).max() <= 90.0
    # uniform over the jitter's range: the largest of 30 exceeds 3/4 of it for certain
    assert np.abs(away).max() > 67.5


def test_no_point_lies_outside_the_lattice():
    geometry = BlockGeometry()
    position = scatter_points(geometry, np.random.default_rng(1))
    assert (np.abs(position) <= geometry.half_extent).all()


def test_names_of_points_are_text_from_1001():
    assert name_points(3).tolist() == ["1001", "1002", "1003"]


def test_terrain_has_its_mean_and_its_standard_deviation():
    geometry = BlockGeometry(relief=30.0)
    far = np.random.default_rng(2).uniform(-1e6, 1e6, (200_000, 2))
    height = shape_terrain(geometry, np.random.default_rng(3)).height(far)
    # over an area of many waves each sine has the mean 0 and the variance 1/2
    assert height.mean() == pytest.approx(520.0, abs=0.5)
    assert height.std() == pytest.approx(30.0, rel=0.02)


def test_raster_pairs_points_and_centres_as_a_plain_comparison_does():
    raster = Raster(
        np.arange(-3, 4) * 100.0, np.arange(-2, 3) * 150.0, 100.0, np.pi / 2
    )
    position = np.random.default_rng(4).uniform(-500.0, 500.0, (300, 2))
    centre, point = raster.holding(position, (130.0, 90.0))
    away = (
        turn(position, -np.pi / 2)[None] - turn(raster.centres(), -np.pi / 2)[:, None]
    )
    expected = np.nonzero((np.abs(away) <= [130.0, 90.0]).all(axis=-1))
    np.testing.assert_array_equal(centre, expected[0])
    np.testing.assert_array_equal(point, expected[1])


def test_models_are_named_by_strip_from_the_left_and_place():
    raster = Raster(np.array([0.0, 100.0]), np.array([-1.0, 1.0]), 100.0, 0.0)
    assert raster.names().tolist() == ["1/1", "1/2", "2/1", "2/2"]
    np.testing.assert_array_equal(
        raster.centres(), [[0, 1], [100, 1], [0, -1], [100, -1]]
    )
    np.testing.assert_array_equal(raster.images().along, [-50, 50, 150])


@pytest.mark.parametrize("side", [2700.0, 3300.0, 4100.0, 5000.0, 6400.0, 7700.0])
@pytest.mark.parametrize("flight", ["high_flight", "low_flight"])
@pytest.mark.parametrize("n_coverages", [1, 2, 3])
def test_every_coverage_covers_every_block(side, flight, n_coverages):
    geometry = BlockGeometry(
        width=side,
        height=9000.0 - side,
        n_coverages=n_coverages,
        least_points_per_model=3,
    )
    position, layout = laid(geometry, flight)
    for coverage in range(n_coverages):
        assert points_held(layout, coverage) == set(range(len(position)))


@pytest.mark.parametrize("width", np.linspace(1500.0, 9000.0, 26))
@pytest.mark.parametrize("n_coverages", [1, 2, 3])
@pytest.mark.parametrize("flight", ["high_flight", "low_flight"])
def test_one_or_two_strips_are_not_shifted_so_far_that_more_are_flown(
    width, n_coverages, flight
):
    geometry = BlockGeometry(width=9000.0, height=width, n_coverages=n_coverages)
    usual = flight_rasters(geometry, flight)
    few = flight_rasters(geometry, flight, few_strips=True)
    scale = (
        geometry.high_scale_number
        if flight == "high_flight"
        else geometry.low_scale_number
    )
    reach = scale * geometry.usable_model[1] / 2.0
    step = scale * geometry.neat_model[1]
    half = geometry.half_extent[1]
    least = max(1, int(np.ceil((2.0 * half - 2.0 * reach) / step - 1e-9)) + 1)
    numbers = [raster.shape[1] for raster in few]
    for raster, shifted in zip(few, usual, strict=True):
        assert np.array_equal(raster.along, shifted.along)
        assert raster.across[0] - reach <= -half + 1e-6
        assert raster.across[-1] + reach >= half - 1e-6
        assert (np.diff(raster.across) <= step + 1e-6).all()
        assert np.abs(raster.across).max() <= half + 1e-6
    if least <= 2 and sum(r.shape[1] for r in usual) > n_coverages * least:
        assert numbers == [least] * n_coverages
        places = np.array([raster.across[0] for raster in few])
        spread = np.diff(places)  # evenly, and never farther than usual
        assert np.allclose(spread, spread[:1])
        assert (spread <= geometry.shift * step + 1e-6).all()
    else:
        assert numbers == [raster.shape[1] for raster in usual]


@pytest.mark.parametrize("side", [2700.0, 3300.0, 4100.0, 5000.0, 6400.0, 7700.0])
@pytest.mark.parametrize("is_cross", [False, True])
def test_control_of_every_model_is_spread_over_it(side, is_cross):
    geometry = BlockGeometry(
        width=side, height=9000.0 - side, high_cross_flight=is_cross
    )
    position, layout = laid(geometry)
    control = choose_control(geometry, layout, position)
    # the centre of a model lies on the block, so that its control extends over half
    # of the neat model at least, less the distance of the nearest points
    extent = np.ptp(position[control], axis=1)
    along, across = layout.scale_number * np.array(geometry.neat_model) / 2.0
    is_turned = (layout.direction > 0)[:, None]
    half = np.where(is_turned, [across, along], [along, across])
    nearest = geometry.point_spacing * (0.5 + geometry.jitter)
    assert (extent >= np.minimum(half, np.ptp(position, axis=0)) - 2 * nearest).all()
    singular = np.linalg.svd(
        position[control] - position[control].mean(axis=1, keepdims=True),
        compute_uv=False,
    )
    # four corners at the ends of half a base: their root sum of squares is half a base
    assert singular.min() > along - nearest


def test_control_is_the_nearest_points_and_each_once():
    geometry = BlockGeometry()
    position, layout = laid(geometry)
    control = choose_control(geometry, layout, position)
    assert control.shape == (67, 5)
    assert all(len(set(points)) == 5 for points in control)
    middle = np.flatnonzero((np.abs(layout.centre) < 3000.0).all(axis=1))
    half = geometry.control_reach * 15_000 * np.array([0.046, 0.0805])
    for model in middle:
        for place, chosen in zip(
            [(-1, 1), (1, 1), (0, 0), (-1, -1), (1, -1)], control[model], strict=True
        ):
            wanted = layout.centre[model] + half * np.array(place)
            assert np.hypot(*(position - wanted).T).argmin() == chosen


@pytest.mark.parametrize("shares_control", [True, False])
def test_control_of_the_neighbours_is_measured_or_not(shares_control):
    geometry = BlockGeometry(width=3000.0, height=3000.0, shares_control=shares_control)
    block = simulate_block("demo", seed=1, geometry=geometry)
    points = block.high_flight.model_points
    is_control = points["point_id"].isin(block.control_points["point_id"])
    count = is_control.groupby([points["coverage"], points["model_id"]]).sum()
    assert (count > 5).all() if shares_control else (count == 5).all()
    # the rest is measured either way
    position, layout = laid(geometry, seed=0)
    kept = leave_control_of_others(layout, choose_control(geometry, layout, position))
    new = np.setdiff1d(layout.point, choose_control(geometry, layout, position))
    assert np.isin(kept.point, new).sum() == np.isin(layout.point, new).sum()


def test_nine_control_points_are_three_by_three():
    geometry = BlockGeometry(control_per_model=9)
    position, layout = laid(geometry)
    control = choose_control(geometry, layout, position)
    assert control.shape == (67, 9)
    assert all(len(set(points)) == 9 for points in control)


def test_second_coverage_of_a_cross_flight_is_turned():
    geometry = BlockGeometry(low_cross_flight=True)
    position, layout = laid(geometry, "low_flight")
    inner = (np.abs(layout.centre) < 3000.0).all(axis=1)
    for coverage, (wide, high) in enumerate([(1024.0, 1760.0), (1760.0, 1024.0)]):
        for model in np.flatnonzero(inner & (layout.coverage == coverage)):
            extent = np.ptp(position[layout.point[layout.model == model]], axis=0)
            assert (extent <= [wide, high]).all()
            # the outermost points are at most one lattice cell inside the edge
            assert (extent >= np.array([wide, high]) - 2 * 300 * 1.6).all()


def test_flight_whose_models_hold_too_few_points_is_refused():
    geometry = BlockGeometry(point_spacing=1000.0, low_scale_number=3000)
    with pytest.raises(
        SettingsError,
        match=r"no model of the low flight holds 6 points.*Lower point_sp",
    ):
        laid(geometry, "low_flight")


def test_control_of_few_points_stands_at_nodes_of_all_and_in_every_model():
    geometry = BlockGeometry(width=5000.0, height=4400.0, point_spacing=100.0)
    few = scatter_points(geometry, np.random.default_rng(0), 320.0)
    layout = lay_flight(geometry, "high_flight", few)
    position, n_control = with_control_of_all(geometry, layout, few)
    nodes = (position[:n_control] + geometry.half_extent) / 100.0
    np.testing.assert_allclose(nodes, np.round(nodes), atol=1e-9)
    assert np.abs(position[:n_control]).max(axis=0) == pytest.approx(
        geometry.half_extent
    )
    # about as many others make room
    assert len(few) <= len(position) < len(few) + n_control / 2
    layout = lay_flight(geometry, "high_flight", position)
    alone = on_control_alone(layout, n_control, geometry.control_per_model)
    assert alone.point.max() < n_control
    control = choose_control(geometry, alone, position)
    assert (np.sort(control, axis=1)[:, 1:] > np.sort(control, axis=1)[:, :-1]).all()
    # a model that would be left too few keeps its points, and so do all
    assert on_control_alone(layout, 3, geometry.control_per_model) is layout
