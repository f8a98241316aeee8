"""Colours of errors: the same in the figures of the report and on the map."""

import numpy as np

# viridis, from the smallest error to the largest, in nine steps; RGB of 255
STEPS = (
    *((253, 231, 37), (170, 220, 50), (92, 200, 99), (39, 173, 129)),
    *((33, 144, 141), (44, 113, 142), (59, 81, 139), (71, 44, 122), (68, 1, 84)),
)


def error_range(error):
    """Range of the colours: all values, or nearly all where a few are far out.

    >>> error_range(np.array([1.0] * 99 + [50.0]))
    (1.0, 2.0)
    """
    low, high = float(error.min()), float(error.max())
    return low, min(high, 2.0 * float(np.quantile(error, 0.95)))
