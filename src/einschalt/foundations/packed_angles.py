"""Angles packed as D.MMSS: 47.123456 is 47°12'34.56", as pocket calculators have it.

Instruments and field books of Leica, Trimble and others write them so. Nothing but the
numbers tells them from decimal degrees: minutes and seconds are below 60.
"""

import numpy as np

PER_DEGREE, PER_MINUTE, BASE = 10_000.0, 100.0, 60.0
DECIMALS = 8  # of a packed second: far below a micrometre on the ground


def unpacked(values):
    """Degrees of packed angles, NaN where minutes or seconds are 60 or more.

    Parameters
    ----------
    values : ndarray
        Angles as D.MMSS.

    Returns
    -------
    ndarray
        Angles [degrees].

    >>> unpacked(np.array([47.123456, -0.3, 12.6, 12.0075])).round(9).tolist()
    [47.2096, -0.5, nan, nan]
    """
    degrees, minutes, seconds = _parts(values)
    angle = degrees + minutes / BASE + seconds / BASE**2
    is_one = (minutes < BASE) & (seconds < BASE)
    return np.where(is_one, np.copysign(angle, values), np.nan)


def _parts(values):
    """Degrees, minutes and seconds without signs.

    47.12 has no 11' 99.999…" for the sake of its last binary digit.
    """
    packed = np.round(np.abs(values) * PER_DEGREE, DECIMALS)
    degrees, rest = np.divmod(packed, PER_DEGREE)
    minutes, seconds = np.divmod(rest, PER_MINUTE)
    return degrees, minutes, seconds


def chance_of_packed(values):
    """Probability with which decimal degrees look like packed ones; 0 if they do not.

    That of independent points which lie anywhere between the outer ones, each of which
    has its minutes and seconds below 60 by chance. 1 of points within one such minute,
    which tell nothing.

    >>> angles = np.array([47.10, 47.1258, 47.2212, 47.3031, 47.4459, 47.5501])
    >>> round(chance_of_packed(angles), 3), chance_of_packed(angles + 0.0077)
    (0.13, 0.0)
    """
    values = values[np.isfinite(values)]
    if len(values) < 2 or np.isnan(unpacked(values)).any():
        return float(len(values) < 2)
    low, high = values.min(), values.max()
    if not high > low:
        return 1.0
    share = (_possible_below(high) - _possible_below(low)) / (high - low)
    return float(share ** max(len(values) - 2, 0))


def _possible_below(value):
    """Length below a number of all in which packed angles can lie; odd in its sign."""
    degrees, minutes, seconds = _parts(np.array(value))
    whole = degrees * BASE * BASE + np.minimum(minutes, BASE) * BASE
    part = np.where(minutes < BASE, np.minimum(seconds, BASE), 0.0)
    return float(np.copysign((whole + part) / PER_DEGREE, value))
