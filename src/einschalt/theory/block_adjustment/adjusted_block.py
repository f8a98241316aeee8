"""What plane and spatial blocks have in common once they are adjusted."""

from functools import cached_property

import numpy as np


class AdjustedBlock:
    """Properties that follow from residuals and cofactors, whatever the models are.

    A solution has ``observations``, ``residuals`` (n_rows, d), ``redundancy``,
    ``sum_of_squares``, ``solver``, ``ordering``, and the cofactors of its points
    (n_points, d, d) and of what was adjusted (n_rows, d, d).
    """

    @property
    def s_0(self):
        """Standard error of unit weight, 1 where the errors are as large as given."""
        if self.redundancy <= 0:
            return np.nan
        return float(np.sqrt(self.sum_of_squares / self.redundancy))

    @property
    def is_held(self):
        """Unknowns that nothing determines, shape (n_models, n_solved)."""
        return in_old_order(self.solver.factor.is_held, self.ordering.order)

    def null_motion(self, model, unknown):
        """How all models move with an unknown that nothing determines.

        Parameters
        ----------
        model, unknown : int
            One of ``is_held``.

        Returns
        -------
        ndarray, shape (n_models,)
            Size of the motion of each model, at its edge [m].
        """
        place = int(np.flatnonzero(self.ordering.order == model)[0])
        motion = np.abs(self.solver.factor.null_vector(place, unknown)).max(axis=1)
        return in_old_order(motion, self.ordering.order)

    @cached_property
    def leverage(self):
        """Share of each observation in its own adjusted value, (n_rows, d)."""
        diagonal = np.diagonal(self.adjusted_cofactors, axis1=1, axis2=2)
        error = self.observations.standard_error
        return diagonal / error.reshape(len(error), -1) ** 2

    @cached_property
    def control_leverage(self):
        """The same of the control, (n_points, d); NaN where there is none."""
        product = self.observations.control_weight @ self.point_cofactors
        diagonal = np.diagonal(product, axis1=1, axis2=2).copy()
        diagonal[~self.observations.is_control | self.observations.is_fixed] = np.nan
        return diagonal


def in_old_order(values, old_number):
    """Put rows back into their old order.

    Parameters
    ----------
    values : ndarray, shape (n, …)
    old_number : ndarray of int, shape (n,)
        Old place of each row.

    Returns
    -------
    ndarray, shape (n, …)
    """
    result = np.empty_like(values)
    result[old_number] = values
    return result
