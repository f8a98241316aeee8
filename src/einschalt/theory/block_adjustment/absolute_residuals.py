"""Measurements that are far off, by the least sum of absolute residuals.

Measured coordinates stand in the design matrix. So least squares shrink a block where
an exchanged name costs more than control does: with errors of control of 1 m and one
pair of names 2 km apart all models come out at a third of their size. Everything
contradicts everything then, and no test tells what is wrong. The sum of absolute
residuals grows with an error itself, and not with its square: a few large ones have no
more pull than small ones. Control counts as much as measurements do, whatever its
errors are, and only tells the scale here.

Iteratively reweighted least squares; source: Huber 1981, ch. 7.
"""

from dataclasses import replace

import numpy as np
from scipy.special import chdtri

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.determinacy import INCREDIBLE

FAR = 6.0  # times the usual residual, which is no chance
# by how much more than a measurement control may have to count: as many large errors
# as there are control points shrink a block by absolute residuals as well
HOLDS = (1.0, 8.0, 64.0)
# share of control that may be wrong: beyond it the block has shrunk
MOST_WRONG = 0.5
MOST_STEPS = 60
# relative change of the sum that is none
SETTLED = 1e-5


def far_measurements(ordinary) -> tuple[np.ndarray, np.ndarray]:
    """Find the measurements that are far off, and the control.

    Parameters
    ----------
    ordinary : BlockSolution
        A block in plan, as least squares adjust it.

    Returns
    -------
    far : ndarray, shape (n_rows,)
        How far off, over the usual error of a measurement; 0 of what is not far, and of
        everything where the ordinary adjustment is credible. Beside a gross error good
        measurements may be among them: they are to be judged without it.
    is_wrong : ndarray of bool, shape (n_points,)
        Given points that are far off.
    """
    observations = ordinary.observations
    if not ordinary.s_0 > INCREDIBLE:
        none = np.zeros(observations.n_points, dtype=bool)
        return np.zeros(len(observations.model)), none
    for hold in HOLDS:
        far, is_wrong = _far_ones(observations, ordinary.ordering, hold)
        if is_wrong[observations.is_control].mean() <= MOST_WRONG:
            break
    return far, is_wrong


def _far_ones(observations, ordering, hold):
    """How far measurements are off that are far, and which control is."""
    of_rows, of_control = _least_absolute(observations, ordering, hold)
    usual = max(1.0, np.median(of_rows) / np.sqrt(chdtri(2, 0.5)))
    # of a point whose given coordinates are farther off these are wrong
    is_far = (of_rows > FAR * usual) & (of_rows >= of_control[observations.point])
    unit = np.median(observations.standard_error)
    own = np.trace(observations.control_covariance, axis1=1, axis2=2) / 2.0
    is_wrong = of_control > FAR * np.hypot(usual, np.sqrt(own) / unit)
    return np.where(is_far, of_rows, 0.0), is_wrong


def _least_absolute(observations, ordering, hold):
    """Lengths of residuals over the usual errors of measurements, as they settle.

    Of measurements (n_rows,) and control (n_points,), 0 where there is none; control
    counts as much as ``hold`` measurements.
    """
    error, is_control = observations.standard_error, observations.is_control
    unit = np.median(error)
    weight_of_rows = np.ones(len(error))
    weight_of_control = np.full(np.count_nonzero(is_control), hold)
    given = replace(observations, shared_control=None, bent=None, orientation=None)
    of_control, before = np.zeros(len(is_control)), np.inf
    for _ in range(MOST_STEPS):
        covariance = np.zeros(observations.control_covariance.shape)
        size = unit**2 / weight_of_control
        covariance[is_control] = size[:, None, None] * np.eye(2)
        used = error / np.sqrt(weight_of_rows)
        used = replace(given, standard_error=used, control_covariance=covariance)
        solution = adjust(used, (), ordering, is_rough=True)
        of_rows = np.hypot(*solution.residuals.T) / error
        left = solution.control_residuals[is_control]
        of_control[is_control] = np.hypot(*left.T) / unit
        now = of_rows.sum() + hold * of_control.sum()
        if abs(before - now) <= SETTLED * now:
            break
        before = now
        # what is within its error has its full weight
        weight_of_rows = 1.0 / np.maximum(of_rows, 1.0)
        weight_of_control = hold / np.maximum(of_control[is_control], 1.0)
    return of_rows, of_control
