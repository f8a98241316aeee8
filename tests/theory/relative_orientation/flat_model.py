"""Hallert's solution of the flat model with six points, in closed form."""

import numpy as np

from einschalt.theory.relative_orientation.hallert import flat_cofactor, flat_six_points
from einschalt.theory.relative_orientation.parallax_equations import design_matrix

FLAT_CONTRADICTION = np.array([2.0, -1.0, -1.0, -2.0, 1.0, 1.0])


def flat_solution_matrix(half_width, base, height, case):
    """Matrix S (5, 6) of the flat model: elements = S @ (p1, p3, p5, p2, p4, p6)."""
    design = design_matrix(flat_six_points(half_width, base, height), base, case)
    return flat_cofactor(half_width, base, height, case) @ design.T


def flat_contradiction(y_parallax):
    """Contradiction w = 2 p1 - p3 - p5 - 2 p2 + p4 + p6 of six flat points.

    ``y_parallax`` (..., 6) follows the order 1, 3, 5, 2, 4, 6. It vanishes when the
    parallaxes are free of error, whatever the orientation. The residuals are ``-(w/12)
    (2, -1, -1, -2, 1, 1)`` and sigma_0 is ``|w| / √12``.
    """
    return np.asarray(y_parallax, dtype=float) @ FLAT_CONTRADICTION
