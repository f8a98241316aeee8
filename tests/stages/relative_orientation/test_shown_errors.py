"""Errors of image points, as large as they show where some are much worse."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.stages.relative_orientation.shown_errors import errors_as_shown
from einschalt.stages.stage2_relative_orientation import image_pairs

M_G_UM = 5.0
WORSE = 4.0


def a_flight(seed):
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    return simulate_block("demo", seed=seed, geometry=geometry).low_flight


def with_worse_points(flight, share, seed):
    """A share of the points with errors four times as large."""
    rng, points = np.random.default_rng(seed), flight.image_points
    more = np.sqrt(WORSE**2 - 1.0) * M_G_UM * 1e-3 / np.sqrt(2.0)
    is_worse = rng.random(len(points)) < share
    moved = more * rng.standard_normal((len(points), 2)) * is_worse[:, None]
    xy = points[["x", "y"]].to_numpy() + moved
    return replace(flight, image_points=points.assign(x=xy[:, 0], y=xy[:, 1]))


def shown(flight, outliers="keep"):
    pairs = image_pairs(flight.image_coordinates(), flight.models)
    return errors_as_shown(pairs, flight.principal_distance_mm, M_G_UM, outliers)


@pytest.mark.parametrize("seed", range(4))
def test_alike_points_have_the_errors_that_were_stated(seed):
    assert shown(a_flight(seed)) is None


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.07, 0.15])
def test_a_share_of_worse_points_shows_in_the_root_mean_square(share):
    flights = [with_worse_points(a_flight(seed), share, seed) for seed in range(6)]
    ratios = [shown(flight)[0] for flight in flights]
    expected = np.sqrt(1.0 + share * (WORSE**2 - 1.0))
    assert np.mean(ratios) == pytest.approx(expected, rel=0.08)


@pytest.mark.slow
def test_points_that_are_taken_out_do_not_count():
    """Ten gross errors of a millimetre are no precision of the others."""
    flight = with_worse_points(a_flight(1), 0.1, 1)
    points = flight.image_points.copy()
    points.loc[points.index[::40], "y"] += 1.0
    spoilt = replace(flight, image_points=points)
    assert shown(spoilt, "snoop")[0] < 2.0
    assert shown(spoilt, "huber") == shown(spoilt, "snoop")
