"""Whether any test could tell what is wrong with control.

The best test there is knows the blunder but for its size. It looks at control points
that are predicted without themselves, as the program does; a blunder that not even it
finds with the power 0.80 at the level 0.001 is one that the data do not show.
"""

import numpy as np

from einschalt.pipeline.assessment.evidence.control.signatures import (
    HEIGHT,
    PLAN,
    Signatures,
    covariance_of,
)
from einschalt.pipeline.densify import densify
from einschalt.theory.adjustment.reliability import noncentrality


def is_too_weak(clean, spoilt):
    """Whether coordinates of control are wrong by less than the best test finds.

    Parameters
    ----------
    clean, spoilt : Block
        The same but for the coordinates of control; otherwise it is not asked.
    """
    before, after = clean.control_points, spoilt.control_points
    if not before["point_id"].equals(after["point_id"]):
        return False
    axes = [name for name in ("easting", "northing", "height") if name in before]
    change = (after[axes] - before[axes]).to_numpy(dtype=float)
    if not change.any():
        return False
    examined = densify(clean).examination
    left_out = examined.left_out_control
    shown = Signatures(examined, left_out)
    numbers = shown.axes.packed(change).reshape(-1, 1)
    made = shown.axes.unpacked(left_out.of_control.apply(numbers)[:, 0])
    sizes = examined.error_model.standard_errors
    squares = []
    for kept in (PLAN, HEIGHT)[: made.shape[1] - 1]:
        covariance = covariance_of(left_out.chains, sizes, kept)
        signature = made[:, list(kept)].T.ravel()
        squares.append(signature @ np.linalg.solve(covariance, signature))
    return bool(max(squares) < noncentrality() ** 2)
