"""Leverages of planned models against the points themselves."""

import numpy as np
import pytest

from einschalt.theory.planning.leverage import (
    PLANNED_KINDS,
    corner_factor,
    lattice_leverage,
    mid_edge_factor,
)

N_PLACES = 60


def designs(kind, xy):
    """Design matrix of both coordinates, shape (2 n, u), of the linearised fit."""
    x, y = xy.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    if kind == "affine":
        rows = [x, y, one, zero, zero, zero], [zero, zero, zero, x, y, one]
    elif kind == "helmert":
        rows = [x, -y, one, zero], [y, x, zero, one]
    else:
        rows = [-y, one, zero], [x, zero, one]
    return [np.column_stack(row) for row in rows]


def leverages_by_brute_force(kind, xy, places):
    of_points = np.vstack(designs(kind, xy))
    inverse = np.linalg.inv(of_points.T @ of_points)
    of_places = np.stack(designs(kind, np.array(places)))  # rows of x, rows of y
    return np.einsum("anu,uv,anv->n", of_places, inverse, of_places) / 2


def leverage_by_brute_force(kind, xy, place):
    return leverages_by_brute_force(kind, xy, [place])[0]


def shifted_lattices(along, across):
    phase = (np.arange(N_PLACES) + 0.5) / N_PLACES
    for x_0 in phase:
        for y_0 in phase:
            x, y = np.arange(x_0, along, 1.0), np.arange(y_0, across, 1.0)
            grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
            yield grid - [along / 2, across / 2]


@pytest.mark.parametrize("kind", PLANNED_KINDS)
@pytest.mark.parametrize("size", [(4.14, 6.9), (2.76, 4.6), (3.0, 3.5)])
def test_lattice_is_the_mean_over_all_its_places(kind, size):
    corner = np.array(size) / 2
    found = [
        leverages_by_brute_force(kind, xy, [(0.0, 0.0), corner])
        for xy in shifted_lattices(*size)
    ]
    expected = np.mean(found, axis=0)
    leverage = lattice_leverage(kind, *map(np.array, size))
    # the midpoint rule over the places misses a little at the jumps
    assert [leverage.centre, leverage.edge] == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("kind", PLANNED_KINDS)
@pytest.mark.parametrize("extent", [(0.138, 0.23), (0.2, 0.1)])
def test_even_spread_is_the_limit_of_dense_points(kind, extent):
    n = np.array([61, 83])
    axes = [
        side * ((np.arange(k) + 0.5) / k - 0.5)
        for k, side in zip(n, extent, strict=True)
    ]
    xy = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    half = np.array(extent) / 2
    corner = len(xy) * leverage_by_brute_force(kind, xy, half)
    mids = [
        len(xy) * leverage_by_brute_force(kind, xy, place)
        for place in ((half[0], 0.0), (0.0, half[1]))
    ]
    assert corner == pytest.approx(corner_factor(kind), rel=1e-3)
    assert max(mids) == pytest.approx(mid_edge_factor(kind, extent), rel=1e-3)


def test_a_lattice_that_may_not_determine_it_is_infinite():
    sizes = np.array([1.5, 2.5])
    affine = lattice_leverage("affine", sizes, np.array(4.0))
    assert np.isinf(affine.edge[0])
    assert np.isfinite(affine.edge[1])
    # two points do for helmert, and one row of four has them
    helmert = lattice_leverage("helmert", sizes, np.array(4.0))
    assert np.isfinite(helmert.edge).all()


def test_whole_numbers_of_rows_are_no_special_case():
    at, above = (
        lattice_leverage("affine", np.array(4.0 + e), np.array(6.0)).edge
        for e in (0.0, 1e-9)
    )
    assert at == pytest.approx(above, rel=1e-6)
