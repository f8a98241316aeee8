"""Displacements of image points by what a calibration has left of a lens.

Radial distortion of the third and fifth power, and decentring (Brown 1971): with the
position x, y from the principal point and r² = x² + y², both in the largest radius,

    radial      (x, y) r²,  (x, y) r⁴
    decentring  (r² + 2x², 2xy),  (2xy, r² + 2y²), a third of each.

The first power is a principal distance, of which the transformation of a spatial model
leaves a scale of heights.
"""

import numpy as np

LENS_TERMS = ("lens:r3", "lens:r5", "lens:p1", "lens:p2")


def lens_displacements(xy):
    """Displacement of each image point by each of the terms with the coefficient 1.

    Parameters
    ----------
    xy : ndarray, shape (n, 2)
        Image coordinates from the principal point.

    Returns
    -------
    ndarray, shape (n, 2, 4)
        Of 1 at the largest radius.
    """
    radius = float(np.sqrt((xy**2).sum(axis=1).max(initial=0.0))) or 1.0
    x, y = xy.T / radius
    square = x * x + y * y
    along = [x * square, x * square**2, (square + 2.0 * x * x) / 3.0, 2.0 * x * y / 3.0]
    across = [
        y * square,
        y * square**2,
        2.0 * x * y / 3.0,
        (square + 2.0 * y * y) / 3.0,
    ]
    return np.stack([np.column_stack(along), np.column_stack(across)], axis=1)
