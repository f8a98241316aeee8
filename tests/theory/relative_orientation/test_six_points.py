"""Which of six points is which, wherever it stands in the table."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.hallert import flat_six_points
from einschalt.theory.relative_orientation.six_points import (
    FROM_1_TO_6,
    PLANE_TOLERANCE,
    are_in_base_normal_planes,
    are_on_two_sides,
    number_six_points,
)

BASE = 92.0


def hilly_six_points(rng, n_models):
    xyz = np.tile(flat_six_points(95.0, BASE, 152.0), (n_models, 1, 1))
    return xyz + rng.uniform(-30.0, 30.0, xyz.shape)


def test_any_order_of_rows_gives_the_same_six_points():
    rng = np.random.default_rng(1)
    xyz = hilly_six_points(rng, 50)
    mixed = rng.permuted(np.tile(np.arange(6), (50, 1)), axis=1)
    shuffled = np.take_along_axis(xyz, mixed[..., None], axis=1)
    order = number_six_points(shuffled)
    found = np.take_along_axis(shuffled, order[..., None], axis=1)
    np.testing.assert_array_equal(found, xyz)


def test_operators_order_goes_from_1_to_6():
    x, y = flat_six_points(95.0, BASE, 152.0)[FROM_1_TO_6, :2].T
    assert x.tolist() == [0.0, BASE] * 3
    assert y.tolist() == [0.0, 0.0, 95.0, 95.0, -95.0, -95.0]


def test_two_sides():
    xyz = flat_six_points(95.0, BASE, 152.0)
    assert are_on_two_sides(xyz, BASE)
    xyz[0, 0] = 0.49 * BASE
    assert are_on_two_sides(xyz, BASE)
    assert not are_on_two_sides(xyz, 0.9 * BASE)
    assert not are_on_two_sides(xyz, 2.1 * BASE)
    assert not are_on_two_sides(xyz, np.nan)


@pytest.mark.parametrize(("off", "is_in"), [(0.0, True), (0.5, True), (2.0, False)])
@pytest.mark.parametrize("point", [1, 4])
def test_planes_within_their_tolerance(point, off, is_in):
    xyz = np.stack([flat_six_points(95.0, BASE, 152.0)] * 2)
    xyz[1, point, 0] -= off * PLANE_TOLERANCE * BASE
    found = are_in_base_normal_planes(xyz, np.array([BASE, BASE]))
    assert found.tolist() == [True, is_in]
    # a base that is not known holds no plane
    assert not are_in_base_normal_planes(xyz[0], np.nan)
