"""Shapes of errors that given points may have together, by where they lie.

A step along a line, as where two networks meet, and a quadratic strain. Whether one of
them is hidden in errors is asked by :mod:`.pattern_tests`. See docs/theory/claim.md.
"""

import numpy as np

N_DIRECTIONS = 8
MOST_STEPS_PER_DIRECTION = 24
FEWEST_ON_A_SIDE = 2


def steps_along_lines(offset):
    """Points on the smaller side of lines in many directions, each division once.

    Parameters
    ----------
    offset : (n, 2) array
        Easting, northing from the middle of the points [m].

    Returns
    -------
    (n_steps, n) array
        1 on that side, 0 elsewhere.
    """
    sides = set()
    n = len(offset)
    for angle in np.arange(N_DIRECTIONS) * np.pi / N_DIRECTIONS:
        order = np.argsort(offset @ [np.cos(angle), np.sin(angle)], kind="stable")
        last = n - FEWEST_ON_A_SIDE
        n_steps = min(max(last - FEWEST_ON_A_SIDE + 1, 0), MOST_STEPS_PER_DIRECTION)
        for first in np.linspace(FEWEST_ON_A_SIDE, last, n_steps).astype(int):
            small = order[:first] if 2 * first <= n else order[first:]
            sides.add(tuple(sorted(small.tolist())))
    rows = np.zeros((len(sides), n))
    for row, side in zip(rows, sorted(sides), strict=True):
        row[list(side)] = 1.0
    return rows


def quadratic_strains(offset):
    """The three quadratic forms of the position, of size one (RMS), (3, n).

    Without what shifts all points; ``offset`` as of :func:`steps_along_lines`.
    """
    size = np.sqrt(np.mean(np.sum(offset**2, axis=1)))
    x, y = (offset / size).T if size > 0.0 else np.zeros((2, len(offset)))
    rows = np.stack([x * x, x * y, y * y])
    rows = rows - rows.mean(axis=1, keepdims=True)
    size = np.sqrt(np.mean(rows**2, axis=1, keepdims=True))
    return rows / np.where(size > 0.0, size, 1.0)
