"""Patches that are kept of a large block."""

import numpy as np
import pytest

from einschalt.foundations.patches import Patches


@pytest.mark.parametrize("every", [2, 3, 5])
def test_they_hold_their_share_of_points_that_lie_evenly(every):
    xy = np.random.default_rng(0).uniform([0.0, 5e6], [8e4, 5.03e6], (20_000, 2))
    is_in = Patches.over(xy, 200, every).hold(xy)
    assert np.mean(is_in) == pytest.approx(1.0 / every, rel=0.15)
    # over the whole extent, not in one corner
    quarters = (xy > np.median(xy, axis=0)) @ [1, 2]
    share = np.bincount(quarters[is_in], minlength=4) / is_in.sum()
    assert share == pytest.approx(0.25, abs=0.08)


def test_neighbours_stay_together():
    xy = np.random.default_rng(1).uniform(0.0, 1000.0, (4000, 2))
    patches = Patches.over(xy, 100, 2)
    # a tenth of the side of a patch (158 m) further on, most are still within
    is_in = patches.hold(xy)
    assert np.mean(patches.hold(xy[is_in] + [15.8, 0.0])) > 0.85


@pytest.mark.parametrize("axis", [0, 1])
def test_points_on_one_line(axis):
    xy = np.zeros((1000, 2))
    xy[:, axis] = np.arange(1000.0)
    assert np.mean(Patches.over(xy, 50, 2).hold(xy)) == pytest.approx(0.5, abs=0.06)


def test_points_that_lie_far_off_change_nothing():
    """A model with a gross error is taken a thousand kilometres away."""
    xy = np.random.default_rng(2).uniform(0.0, 1000.0, (4000, 2))
    far = np.vstack([xy, [[-1e6, -1e6], [1e6, 1e6]]])
    is_in = Patches.over(far, 100, 2).hold(far)[:-2]
    assert np.mean(is_in) == pytest.approx(0.5, abs=0.01)
    assert np.mean(is_in == Patches.over(xy, 100, 2).hold(xy)) > 0.98


def test_all_points_at_one_place():
    assert (
        np.mean(Patches.over(np.zeros((50, 2)), 10, 2).hold(np.zeros((50, 2)))) == 1.0
    )
