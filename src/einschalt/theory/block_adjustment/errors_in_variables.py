"""How far errors of measured coordinates move a block as they stand in its design.

The adjustment takes the coordinates in its design matrix as free of errors, and its
residuals are lengths on the ground: a model that is a little smaller has smaller ones.
So all models of a block pull together, and what control does not hold gives way. That
is of second order, and no matter in a block with control around it (0.02 mm in
Neukirchen, RMS); but it grows with the number of models and with the distance from
control, faster than standard errors do, which know nothing of it.

See docs/theory/block_adjustment.md.
"""

from dataclasses import replace

import numpy as np

from einschalt.theory.block_adjustment.block_solution import adjust

SEED = 1971
# times the usual standard error: what was taken out moves no point, and nothing else
LARGEST = 10.0


def displacement_by_design(solution):
    """Displacement that errors of the model coordinates cause in the mean [m].

    Errors ε and −ε of the size of those in the measurements are added to these. What is
    linear in them cancels in the mean of both; what is left is what the errors that the
    measurements have had done already.
    """
    observations = solution.observations
    scale = np.sqrt(np.abs(np.linalg.det(solution.affinities[:, :, 1:])))
    error = observations.standard_error
    error = np.minimum(error, LARGEST * np.median(error)) / scale[observations.model]
    drawn = np.random.default_rng(SEED).normal(size=observations.xy.shape)
    moved = error[:, None] * drawn
    first, second = (
        adjust(
            replace(observations, xy=observations.xy + e), ordering=solution.ordering
        ).points
        for e in (moved, -moved)
    )
    middle = solution.points
    if len(solution.common):  # compared without the deformations that models share
        middle = solution.with_terms(()).points
    return (first + second) / 2.0 - middle
