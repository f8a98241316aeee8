"""Numbers of points in a drawing: most of them do not cover each other."""

import numpy as np
import pytest

from einschalt.interfaces.programs.drawing import _text_height

LETTER = 0.9  # width of one, of its height, as fonts of CAD programs have it
# of points at random some lie closer than any number is long
MOST_COVERED = 0.55


def share_covered(xy, length, height):
    """Share of the numbers that another one covers in part."""
    width = LETTER * height * length
    gap = np.abs(xy[:, None] - xy[None])
    is_covered = (gap[..., 0] < width) & (gap[..., 1] < height)
    np.fill_diagonal(is_covered, val=False)
    return is_covered.any(axis=1).mean()


def layouts():
    rng = np.random.default_rng(7)
    along = rng.uniform(0.0, 5000.0, 300)
    centres = rng.uniform(0.0, 5000.0, (5, 2))
    axis = 50.0 * np.arange(17.0)
    return {
        "area": rng.uniform(0.0, 1000.0, (300, 2)),
        "road": np.column_stack([along, along]) + rng.normal(0.0, 15.0, (300, 2)),
        "villages": np.concatenate([c + rng.normal(0, 40, (60, 2)) for c in centres]),
        "grid": np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2),
    }


@pytest.mark.parametrize("length", [4, 12, 25])
@pytest.mark.parametrize("name", layouts())
def test_numbers_of_any_length_stand_apart(name, length):
    xy = layouts()[name]
    height = _text_height(xy, ["x" * length] * len(xy))
    most = 0.0 if name == "grid" else MOST_COVERED
    assert share_covered(xy, length, height) <= most
    # nor are they lost: of the same drawing, four letters are no dots
    assert height >= _text_height(xy, ["1234"]) * 4 / (1.5 * length)


def test_short_numbers_of_even_points_have_the_height_of_before():
    xy = layouts()["area"]
    even = np.sqrt(np.prod(np.ptp(xy, axis=0)) / len(xy))
    assert _text_height(xy, ["1001"] * 300) == pytest.approx(0.15 * even)


@pytest.mark.parametrize("name", layouts())
@pytest.mark.parametrize("apart", [0.0, 0.01])
def test_points_given_twice_have_numbers_as_if_given_once(name, apart):
    """A tenth of their height was left, where all were given twice."""
    xy = layouts()[name]
    twice = np.concatenate([xy, xy + apart])
    alone = _text_height(xy, ["1001"])
    assert _text_height(twice, ["1001"]) == pytest.approx(alone, rel=0.03)


def test_a_single_point_has_a_number():
    assert _text_height(layouts()["area"][:1], ["1001"]) > 0.0
    assert _text_height(np.zeros((2, 2)), ["1001"]) > 0.0
