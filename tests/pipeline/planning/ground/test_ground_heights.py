"""Terrain below a planned flight: large grids, and what is said of them."""

import numpy as np
import pytest
import shapely

from einschalt.foundations.blas_threads import one_blas_thread
from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.ground import ground_heights, height_lattice
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights
from einschalt.pipeline.planning.ground.height_lattice import (
    SHIFT,
    HeightLattice,
    HeightTriangles,
)

ORIGIN = np.array([4e5, 5.3e6])
CELL = 10.0


def grid(n, height_at):
    """Heights on a square grid, row by row as rasters have them."""
    side = np.arange(n) * CELL
    x, y = np.meshgrid(side, side[::-1])
    plane = np.column_stack([x.ravel(), y.ravel()])
    return GroundHeights(plane + ORIGIN, height_at(*plane.T), "dem.tif")


def square(n):
    low, high = ORIGIN - CELL / 2, ORIGIN + (n - 0.5) * CELL
    return FlightArea(shapely.box(*low, *high), "EPSG:32633")


def hills(x, y):
    return 500.0 + 200.0 * np.sin(x / 700.0) * np.cos(y / 900.0)


@pytest.mark.slow
@pytest.mark.parametrize("n", [400, 1000, 1024])
def test_a_large_raster_covers_its_area_and_keeps_its_peaks(n):
    """Every k-th cell of rows as long as a multiple of k would be a stripe."""
    heights = grid(n, hills)
    peak = (n // 2) * n + n // 3
    heights.height[peak] = 2000.0  # one cell
    heights.height[0] = 100.0
    over = heights.over(square(n))
    places = ORIGIN + np.random.default_rng(1).uniform(0, (n - 1) * CELL, (2000, 2))
    over.require_cover(square(n))
    assert over.range == (100.0, 2000.0)
    for reach in (50.0, 300.0, 1500.0):
        (highest,) = over.highest_around(heights.plane[[peak]], reach)
        assert highest == 2000.0
    away = places[np.abs(places - heights.plane[peak]).max(axis=1) > 2000.0]
    away = away[np.abs(away - heights.plane[0]).max(axis=1) > 2000.0]
    mean = over.mean_around(away, 300.0)
    x, y = (away - ORIGIN).T
    # of such waves a mean within a circle keeps 2 J1(k r) / (k r)
    kept = 1.0 - (300.0 * np.hypot(1 / 700.0, 1 / 900.0)) ** 2 / 8.0
    inside = ((away - ORIGIN > 300.0) & (away - ORIGIN < (n - 31) * CELL)).all(axis=1)
    error = (mean - 500.0)[inside] - kept * (hills(x, y) - 500.0)[inside]
    assert np.abs(error).max() < 3.0


def test_heights_that_all_lie_in_one_cell_or_line_are_brought_together():
    line = np.column_stack([np.arange(1000.0), np.zeros(1000)])
    coarse = GroundHeights(line, np.arange(1000.0), "line.csv").in_cells(100.0)
    assert len(coarse.plane) == 10
    np.testing.assert_allclose(coarse.height, coarse.plane[:, 0])
    np.testing.assert_array_equal(coarse.extremes[3], [300.0, 399.0])
    twice = coarse.in_cells(500.0)
    np.testing.assert_array_equal(twice.extremes, [[0.0, 499.0], [500.0, 999.0]])


SIDES = np.array([6000.0, 5000.0])
FIELD = FlightArea(shapely.box(*ORIGIN, *(ORIGIN + SIDES)), "EPSG:32633")


def heights_where(is_there):
    """Heights 100 m apart over a field, where there are some."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(61) * 100, np.arange(51) * 100))
    away = np.abs(np.column_stack([x, y]) - SIDES / 2.0)
    plane = np.column_stack([x, y])[is_there(x, away)] + ORIGIN
    return GroundHeights(plane, np.full(len(plane), 400.0), "dem.xyz")


@pytest.mark.parametrize(
    "is_there",
    [
        lambda _, away: away[:, 0] > 1500,  # all corners have heights near
        lambda _, away: (away > [1500, 1200]).any(axis=1),
        lambda x, _: x < 3000,
    ],
)
def test_an_area_with_a_gap_of_heights_is_refused(is_there):
    heights_where(lambda x, _: x >= 0).require_cover(FIELD)
    with pytest.raises(GeometryError, match="expected heights of the whole area"):
        heights_where(is_there).require_cover(FIELD)


def test_heights_in_degrees_are_told_to_be():
    plane = np.column_stack([np.linspace(13.6, 13.7, 9), np.linspace(48.0, 48.1, 9)])
    heights = GroundHeights(plane, np.full(9, 400.0), "dem.csv")
    area = FlightArea(shapely.box(390_000, 5_300_000, 397_000, 5_306_000))
    with pytest.raises(GeometryError, match="These look like degrees: export the heig"):
        heights.over(area)
    elsewhere = GroundHeights(plane * 1e3, heights.height, "dem.csv")
    with pytest.raises(GeometryError, match="Plan in the system of the heights"):
        elsewhere.over(area)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("n", [300, 3000, 30_000])
def test_scattered_heights_cover_an_area(n, seed):
    """Points thinned at random are refused no more for the widest of their gaps."""
    rng = np.random.default_rng(seed)
    plane = ORIGIN + rng.uniform(-300.0, SIDES + 300.0, (n, 2))
    heights = GroundHeights(plane, np.full(n, 400.0), "points.csv")
    heights.require_cover(FIELD)
    side = np.sqrt(np.prod(SIDES + 600.0) / n)
    assert 0.9 * side < heights.mesh_size < 1.2 * side
    assert heights.spacing < 0.6 * side


def test_one_place_however_often_covers_no_area():
    middle = ORIGIN + SIDES / 2.0
    heights = GroundHeights(np.tile(middle, (5, 1)), np.full(5, 400.0), "points.csv")
    assert heights.mesh_size == 0.0
    with pytest.raises(GeometryError, match="expected heights of the whole area"):
        heights.over(FIELD).require_cover(FIELD)


def test_places_that_stand_twice_are_as_far_apart_as_they_are():
    once = grid(40, hills)
    twice = GroundHeights(
        np.concatenate([once.plane, once.plane]),
        np.concatenate([once.height, once.height]),
        "twice.csv",
    )
    assert twice.spacing == once.spacing == CELL
    middle = np.add(ORIGIN, [[111.0, 222.0]])
    np.testing.assert_allclose(
        twice.straight_below(middle), once.straight_below(middle)
    )


NOTCHED = FlightArea(
    shapely.box(0.0, 0.0, 4000.0, 4000.0) - shapely.box(2000.0, 2000.0, 4000.0, 4000.0)
)


@pytest.mark.parametrize("most_kept", [250_000, 3000])
def test_heights_in_a_notch_of_an_area_do_not_count(most_kept, monkeypatch):
    """But for what lies straight below a camera, and at the border."""
    monkeypatch.setattr(ground_heights, "MOST_KEPT", most_kept)
    x, y = (a.ravel() for a in np.meshgrid(*(np.arange(-1000.0, 5001.0, 50.0),) * 2))
    hill = 1500.0 * np.exp(-(np.hypot(x - 3200.0, y - 3200.0) ** 2) / (2 * 300.0**2))
    heights = GroundHeights(np.column_stack([x, y]), 400.0 + hill, "dem.xyz")
    over = heights.over(NOTCHED)
    peak = np.array([[3200.0, 3200.0]])
    assert over.range[0] == pytest.approx(400.0, abs=0.1)
    assert over.range[1] < 402.0
    assert over.highest_around(peak, 1500.0)[0] < 402.0
    assert over.mean_around(peak, 1500.0)[0] < 402.0
    assert over.straight_below(peak)[0] > 1600.0
    assert not NOTCHED.holds(NOTCHED.to_local(over.beside.plane)).any()
    on_border = np.array([[2000.0, 2375.0], [2625.0, 2000.0]])
    expected = 400.0 + 1500.0 * np.exp(
        -(np.hypot(*(on_border - 3200.0).T) ** 2) / (2 * 300.0**2)
    )
    assert over.straight_below(on_border) == pytest.approx(expected, abs=1.0)


def test_heights_on_a_lattice_are_interpolated_in_its_cells():
    heights = grid(30, lambda x, y: 300.0 + 0.02 * x - 0.05 * y + 1e-4 * x * y)
    rng = np.random.default_rng(5)
    x, y = rng.uniform(0.0, 290.0, (2, 500))
    places = np.column_stack([x, y]) + ORIGIN
    expected = 300.0 + 0.02 * x - 0.05 * y + 1e-4 * x * y
    # of a bilinear surface bilinear interpolation is exact, triangles are not
    np.testing.assert_allclose(heights.straight_below(places), expected, atol=1e-9)
    np.testing.assert_allclose(heights.straight_below(heights.plane), heights.height)
    beside = ORIGIN + np.array([[-40.0, 100.0], [1000.0, 1000.0]])
    nearest = heights.height[[19 * 30, 29]]
    np.testing.assert_array_equal(heights.straight_below(beside), nearest)


def test_gaps_of_a_lattice_are_spanned_by_triangles():
    whole = grid(30, lambda x, _: 300.0 + x)
    is_there = np.hypot(*(whole.plane - ORIGIN - 150.0).T) > 35.0
    gap = GroundHeights(whole.plane[is_there], whole.height[is_there], "dem.tif")
    # in the gap, in a cell, and at a node at the edge of the gap
    places = ORIGIN + np.array([[151.0, 152.0], [52.0, 57.0], [190.0, 150.0]])
    np.testing.assert_allclose(gap.straight_below(places), [451.0, 352.0, 490.0])


def staggered_rows():
    x, y = (a.ravel() for a in np.meshgrid(np.arange(0.0, 3000.0, 100.0), range(60)))
    return np.column_stack([x + 50.0 * (y % 2), 50.0 * y])


def coarse_raster_with_a_fine_part():
    coarse = np.meshgrid(*(np.arange(0.0, 3001.0, 50.0),) * 2)
    fine = np.meshgrid(np.arange(0.0, 1501.0, 25.0), np.arange(0.0, 3001.0, 25.0))
    places = (np.reshape(part, (2, -1)).T for part in (coarse, fine))
    return np.unique(np.concatenate(list(places)), axis=0)


def raster_with_salt():
    places = np.reshape(np.meshgrid(*(np.arange(0.0, 3001.0, 50.0),) * 2), (2, -1)).T
    return places[np.random.default_rng(8).random(len(places)) < 0.7]


@pytest.mark.parametrize(
    "places", [staggered_rows, coarse_raster_with_a_fine_part, raster_with_salt]
)
def test_a_slope_stays_one_where_cells_are_not_whole(places):
    """The nearest height made stairs of it: up to 15 m on a slope of 30 %."""
    plane, slope = places(), np.array([0.3, -0.1])
    heights = GroundHeights(plane, 500.0 + plane @ slope, "slope.xyz")
    ground = np.random.default_rng(9).uniform(200.0, 2700.0, (2000, 2))
    found = heights.straight_below(ground)
    np.testing.assert_allclose(found, 500.0 + ground @ slope, atol=1e-9)


def test_triangles_are_solved_by_one_thread(monkeypatch):
    """LAPACK with threads, on a busy machine, took 42 s of 80 000, and one 0.2 s."""
    asked = []

    def counted():
        asked.append(True)
        return one_blas_thread()

    monkeypatch.setattr(height_lattice, "one_blas_thread", counted)
    triangles = HeightTriangles.of(staggered_rows(), np.zeros(1800), 50.0)
    assert asked == [True]
    # nothing is left to be solved when heights are asked for
    assert triangles.mesh._transform is not None


def test_a_raster_without_a_gap_spans_no_triangles():
    surface = HeightLattice.of(grid(30, hills).plane, grid(30, hills).height)
    assert surface._around_gaps is None
    assert np.isnan(surface.at(np.array([[-1e6, 0.0]]))).all()


def test_turned_rasters_and_scattered_heights_span_triangles():
    rng = np.random.default_rng(6)
    turned = (grid(30, hills).plane - ORIGIN) @ [[0.8, -0.6], [0.6, 0.8]]
    for plane in (turned, rng.uniform(0.0, 300.0, (900, 2))):
        heights = GroundHeights(plane, 300.0 + plane @ [0.3, -0.2], "points.csv")
        inside = plane.mean(axis=0) + rng.uniform(-60.0, 60.0, (200, 2))
        expected = 300.0 + inside @ [0.3, -0.2]
        np.testing.assert_allclose(heights.straight_below(inside), expected)
        assert np.isnan(heights._surface(inside + 1e4)).all()


@pytest.mark.parametrize("rounded", [3, 12])
def test_heights_at_the_border_of_a_turned_raster_are_those_of_its_corners(rounded):
    """Its corners lie in one line there, of the shifted places nearly."""
    side, turn = 12, np.array([[0.8, -0.6], [0.6, 0.8]])
    places = np.round((grid(side, hills).plane - ORIGIN) @ turn, rounded)
    rng = np.random.default_rng(6)
    heights = GroundHeights(places, rng.uniform(300.0, 500.0, len(places)), "points")
    along = np.linspace(places[0], places[side - 1], 500)
    beside = along + rng.uniform(-0.3, 0.3, along.shape)
    for ground in (along, beside):
        found = heights.lowest_at(ground)
        assert 200.0 < found.min() < found.max() < 600.0
    # on a slope, at the border no farther off than it rises over the shift
    slope = np.array([0.3, -0.2])
    tilted = GroundHeights(places, places @ slope, "points")
    off = np.abs(tilted._surface(places - places.min(axis=0)) - places @ slope)
    off = off.reshape(side, side)
    assert off[1:-1, 1:-1].max() < 1e-9
    assert np.isnan(off).sum() < 4 * side
    assert np.nanmax(off) <= 2.0**0.5 * SHIFT * CELL * np.linalg.norm(slope)


def test_triangles_of_a_turned_raster_have_no_four_places_on_a_circle():
    """Which take Qhull many times as long: 38 s for 230 400 heights."""
    places = np.round((grid(30, hills).plane - ORIGIN) @ [[0.8, -0.6], [0.6, 0.8]], 3)
    heights = GroundHeights(places, places @ [0.3, -0.2], "points.csv")
    mesh = heights._surface.__self__.mesh
    corners = mesh.points[mesh.simplices]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    # right angles, as halves of squares have, would be circles of four
    odd = np.sort(sides**2, axis=1) @ [1.0, 1.0, -1.0]
    assert (np.abs(odd) > 1e-9 * sides.max() ** 2).all()
