"""Which points show in which models: what each camera sees, by how high it flies.

A model shows as much more of the ground as this lies deeper below its cameras. Points
are looked for among the models that stand near enough to show them, strip by strip.
"""

import numpy as np

from einschalt.foundations.kernels import compiled

ROUNDING = 1e-6  # metres: places and footprints are sums of decimals


@compiled
def points_shown(along, across, altitude, place, ground, planned, sides, base, rises):
    """Pair the models of a raster with the points that they show.

    ``along`` (n_along,) and ``across`` (n_across,), centres of the models in the axes
    of their flight, increasing [m]; ``altitude`` (n_across, n_along) of their cameras,
    the last strip first, -inf where no model is flown [m]; ``place`` (n_points, 2) of
    the points in the same axes, ``ground`` (n_points,) their heights [m]. At the
    ``planned`` height above ground [m] an image shows ``sides`` (2,), of which two of
    a model have all but ``base`` (2,) in common, along and across [m]. Ground that
    lies higher than planned is taken to rise ``rises`` times as much, at least once.

    Gives number of centre and point of each pair, sorted by both.
    """
    n_strips, n_along = altitude.shape
    # the highest of each strip shows most
    highest = np.array([strip.max() for strip in altitude])
    given = (along, across, altitude, place, ground, planned, sides, base, rises)
    n_of = np.zeros(n_strips * n_along, dtype=np.int64)
    none = np.empty(0, dtype=np.int64)
    _pair(given, highest, n_of, none, none)
    end = np.cumsum(n_of)
    centre = np.empty(end[-1], dtype=np.int64)
    point = np.empty(end[-1], dtype=np.int64)
    _pair(given, highest, end - n_of, centre, point)
    return centre, point


@compiled
def _pair(given, highest, row_of, centre, point):
    """Write the pairs of each centre from its row on, or count them, if not one fits.

    ``highest`` altitudes of the strips; ``row_of`` (n_centres,), the next row of each,
    is written to, as are ``centre`` and ``point``.
    """
    along, across, altitude, place, ground, planned, sides, base, rises = given
    n_strips, n_along = altitude.shape
    top = highest.max()
    for p in range(len(place)):
        u, v = place[p]
        reach = _half((top - ground[p]) / planned, sides[1], base[1])
        for row in range(np.searchsorted(across, v - reach), n_strips):
            if across[row] > v + reach:
                break
            strip = n_strips - 1 - row
            widest = _half((highest[strip] - ground[p]) / planned, sides[0], base[0])
            for k in range(np.searchsorted(along, u - widest), n_along):
                if along[k] > u + widest:
                    break
                depth = (altitude[strip, k] - ground[p]) / planned
                if depth < 1.0:
                    depth = 1.0 - rises * (1.0 - depth)
                if not (
                    abs(u - along[k]) <= _half(depth, sides[0], base[0])
                    and abs(v - across[row]) <= _half(depth, sides[1], base[1])
                ):
                    continue
                one = strip * n_along + k
                if len(centre):
                    centre[row_of[one]], point[row_of[one]] = one, p
                row_of[one] += 1


@compiled
def _half(depth, side, base):
    """Half of a model of two images, so many times as deep as planned [m]."""
    return (depth * side - base) / 2.0 + ROUNDING
