"""Approximate coordinates with known truth that come from no high flight.

Coordinates from directly measured orientations (GNSS, IMU) share the errors of the
photographs that they were taken from: neighbours are wrong together, and no residual
of the low flight shows it in full.
"""

from dataclasses import replace

import numpy as np

from einschalt.pipeline.block.block import Block

FORMAT, FORWARD, SIDE = 0.23, 0.60, 0.30  # photograph [m], and its overlaps
SQRT2 = np.sqrt(2.0)


def onto_given_approximations(
    block, *, own_error=0.03, photograph_error=0.0, seed=0, is_stated=True
) -> Block:
    """The low flight of a simulated block onto given approximate coordinates.

    ``own_error`` is the TOTAL error of each point that it shares with no other,
    ``photograph_error`` that of the orientation of each photograph, a shift of all that
    it shows [m]: of photographs of the low flight's scale with 60 and 30 % overlap, a
    point having the mean of the errors of those that show it. ``is_stated`` where the
    block states the error that the coordinates have.
    """
    rng = np.random.default_rng(seed)
    place = block.truth[["easting", "northing"]].to_numpy()
    error = rng.normal(0.0, own_error / SQRT2, place.shape)
    if photograph_error > 0.0:
        error += _errors_of_photographs(block, place, photograph_error, rng)
    approximate = block.truth[["point_id"]].copy()
    approximate[["easting", "northing"]] = place + error
    total = float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
    return Block(
        name=f"{block.name}, given approximations",
        crs=block.crs,
        control_points=block.control_points,
        approximate_points=approximate,
        approximate_m_0_m=total if is_stated else None,
        low_flight=block.low_flight,
    )


def beside_control(block, axes=("easting", "northing"), *, error=0.07, seed=3):
    """The low flight of a simulated block alone, in which control takes no part.

    Onto approximate coordinates with independent errors of ``error`` in each of the
    axes [m], which are stated.
    """
    given = block.truth[["point_id", *axes]].copy()
    shape = (len(given), len(axes))
    given[[*axes]] += np.random.default_rng(seed).normal(0.0, error, shape)
    return replace(
        block,
        high_flight=None,
        approximate_points=given,
        approximate_m_0_m=SQRT2 * error,
    )


def _errors_of_photographs(block, place, photograph_error, rng):
    offset = place - place.mean(axis=0)
    side = FORMAT * block.low_flight.scale_number
    reach = np.abs(offset).max() + side
    lines = (
        np.arange(-reach, reach, side * (1.0 - overlap)) for overlap in (FORWARD, SIDE)
    )
    centres = np.stack(np.meshgrid(*lines), axis=-1).reshape(-1, 2)
    shifts = rng.normal(0.0, photograph_error / SQRT2, centres.shape)
    apart = np.abs(offset[:, None] - centres[None])
    shows = (apart < side / 2.0).all(axis=2).astype(float)
    return (shows @ shifts) / shows.sum(axis=1)[:, None]
