"""How every image coordinate of a pair moves its orientation.

The orientation of least squares is, to first order, linear in the image coordinates.
With the row j of a point's condition by the parameters, its derivatives d by the four
image coordinates, the weight w = 1 / d.T d and the normal matrix N = sum w j j.T, a
change of the coordinates by e changes the parameters by

    - N^-1 sum w j d.T e .

See docs/theory/relative_orientation/model_precision.md.
"""

import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COMPILED,
    NO_SUMS,
    add_condition,
    coplanarity,
    factorise,
    frame_of,
    parameter_row,
    solve,
)
from einschalt.theory.relative_orientation.coplanarity_solution import pose_at
from einschalt.theory.relative_orientation.model_precision import N_CHANGES


def orientation_influence(orientation, adjusted, factors):
    """Derivatives of every orientation by the image coordinates of its points [1/mm].

    Of the base direction (3) and a small turn of the right camera about the axes of the
    left system (3) by x', y', x", y" of each point: (n_points, 6, 4). The
    ``orientation`` is one of the estimator "rigorous", ``adjusted`` are StereoPairs of
    adjusted coordinates, without points where a pair is not oriented. ``factors``
    (n_points,) of the weights of the conditions are taken as given: 1, or less after a
    robust norm.

    Notes
    -----
    What the curvature of the conditions adds is smaller by the ratio of a residual to
    the principal distance.
    """
    left, right = adjusted.distance.T
    scale = left[adjusted.model]
    found = np.empty((len(adjusted.image), N_CHANGES, 4))
    over_segments(
        _influence,
        np.ascontiguousarray(adjusted.start, dtype=np.int64),
        np.ascontiguousarray(adjusted.image.T / scale),
        -right / left,
        orientation.poses,
        np.ascontiguousarray(factors, dtype=float),
        found,
    )
    return found / scale[:, None, None]


@compiled(**COMPILED)
def _influence(first, last, start, scaled, right_z, poses, factors, found):
    for k in range(first, last):
        zr = right_z[k]
        base, tangents, rotation = frame_of(pose_at(poses[k]), False)
        sums = NO_SUMS
        for i in range(start[k], start[k + 1]):
            point = scaled[0, i], scaled[1, i], scaled[2, i], scaled[3, i]
            _, by_base, by_turn, d = coplanarity(point, zr, base, rotation)
            q = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[3] * d[3]
            row = parameter_row(by_base, by_turn, tangents)
            sums = add_condition(sums, row, 0.0, factors[i] / q)
        normal = factorise(sums, 0.0)
        for i in range(start[k], start[k + 1]):
            point = scaled[0, i], scaled[1, i], scaled[2, i], scaled[3, i]
            _, by_base, by_turn, d = coplanarity(point, zr, base, rotation)
            q = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[3] * d[3]
            x = solve(normal, parameter_row(by_base, by_turn, tangents))
            for j in range(3):
                along = tangents[j] * x[0] + tangents[3 + j] * x[1]
                for axis in range(4):
                    pull = -factors[i] / q * d[axis]
                    found[i, j, axis] = pull * along
                    found[i, 3 + j, axis] = pull * x[2 + j]
