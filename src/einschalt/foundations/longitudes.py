"""Arcs of longitudes: west and east [degrees], east less than west over 180°."""

import numpy as np

FULL_CIRCLE = 360.0  # degrees


def eastern_end(west, east):
    """Longitude of the eastern end of an arc, never less than that of the western."""
    return east + FULL_CIRCLE if east < west else east


def arc_of(longitudes):
    """West and east of the shortest arc that holds longitudes from -180° to 180°.

    >>> arc_of(np.array([179.5, -179.0]))
    (179.5, -179.0)
    >>> arc_of(np.array([13.0, 14.0, 12.0]))
    (12.0, 14.0)
    """
    low, high = float(np.min(longitudes)), float(np.max(longitudes))
    if not high - low > FULL_CIRCLE / 2.0:
        return low, high
    ordered = np.unique(longitudes)
    gaps = np.diff(ordered, append=ordered[0] + FULL_CIRCLE)
    last = int(np.argmax(gaps))
    return float(ordered[(last + 1) % len(ordered)]), float(ordered[last])


def lies_within(arc, other, slack=0.0):
    """Whether an arc lies within another one, or within ``slack`` of it [degrees].

    >>> lies_within((170, -175), (160, -170)), lies_within((10, 20), (160, -170))
    (True, False)
    """
    west, east = other[0] - slack, eastern_end(*other) + slack
    if east - west >= FULL_CIRCLE:
        return True
    start = west + (arc[0] - west) % FULL_CIRCLE
    return start + eastern_end(*arc) - arc[0] <= east
