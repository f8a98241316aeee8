"""Points are paired with the models that show them, as a table of all pairs says."""

import numpy as np
import pytest

from einschalt.theory.planning.points_shown import points_shown

PLANNED = 1000.0
SIDES, BASE = np.array([900.0, 600.0]), np.array([300.0, 0.0])


def _flight(seed, *, steep):
    """Centres, altitudes, places and heights of a flight; a fifth is not flown."""
    rng = np.random.default_rng(seed)
    along, across = np.arange(9) * 290.0 - 1100.0, np.arange(5) * 410.0 - 800.0
    altitude = PLANNED + rng.uniform(-100.0, 300.0, (5, 9))
    altitude[rng.random((5, 9)) < 0.2] = -np.inf
    place = rng.uniform(-1800.0, 1800.0, (4000, 2))
    return along, across, altitude, place, steep * place[:, 0] - 50.0


def _table(along, across, altitude, place, ground, rises):
    """All pairs tried; strips count from the last of ``across``."""
    v, u = np.meshgrid(across[::-1], along, indexing="ij")
    away = abs(place - np.column_stack([u.ravel(), v.ravel()])[:, None])
    depth = (altitude.ravel()[:, None] - ground) / PLANNED
    depth = np.where(depth < 1.0, 1.0 - rises * (1.0 - depth), depth)
    half = (depth[..., None] * SIDES - BASE) / 2.0
    return np.nonzero((away <= half).all(axis=2))


@pytest.mark.parametrize("rises", [1.0, 1.1])
@pytest.mark.parametrize("steep", [0.0, 0.3])
def test_pairs_are_those_of_the_table(steep, rises):
    flight = _flight(7, steep=steep)
    found = points_shown(*flight, PLANNED, SIDES, BASE, rises)
    expected = _table(*flight, rises)
    assert len(expected[0]) > 3000
    np.testing.assert_array_equal(found[0], expected[0])
    np.testing.assert_array_equal(found[1], expected[1])


def test_points_on_the_rim_are_shown():
    """Places and footprints are sums of decimals: the last digit decides nothing."""
    place = np.array([[0.3 + 299.7, 0.0], [300.001, 0.0], [0.0, -300.0]])
    one = np.zeros(1), np.zeros(1), np.full((1, 1), PLANNED)
    _, point = points_shown(*one, place, np.zeros(3), PLANNED, SIDES, BASE, 1.0)
    np.testing.assert_array_equal(point, [0, 2])


def test_without_a_model_nothing_is_shown():
    along, across, altitude, place, ground = _flight(3, steep=0.1)
    none = np.full_like(altitude, -np.inf)
    given = along, across, none, place, ground
    centre, point = points_shown(*given, PLANNED, SIDES, BASE, 1.1)
    assert len(centre) == len(point) == 0
