"""Weights with which the values of a point enter its mean, and that of a coverage."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.theory.adjustment.correlated_mean import JointCovariance, pairs_of_values

PLAIN, WEIGHTED, RIGOROUS = "plain", "weighted", "rigorous"
WEIGHTINGS = (PLAIN, WEIGHTED, RIGOROUS)


def require_covariances(weighting, covariances):
    """Refuse a rigorous mean of values whose covariances nobody gave.

    Parameters
    ----------
    weighting : str
    covariances : callable or None

    Raises
    ------
    SettingsError
    """
    if weighting == RIGOROUS and covariances is None:
        raise SettingsError(
            f'weighting = "{RIGOROUS}" without covariances of the values',
            expected="covariances, a function of pairs of rows",
            remedy=f'Give covariances, or set weighting = "{PLAIN}"',
        )


@dataclass(frozen=True, eq=False)
class ValueWeights:
    """Weights of the values of points.

    Attributes
    ----------
    in_mean : ndarray, shape (n_values,) or (n_values, d, d)
        In the mean of the point: numbers, or matrices that add up to the unit matrix.
    joint : JointCovariance or None
        Of the values, where the weights follow from it.
    """

    in_mean: np.ndarray
    joint: JointCovariance | None = None

    def in_groups(self, order, start):
        """Weights of values in the mean of each group of them.

        Parameters
        ----------
        order : ndarray of int, shape (n,)
            Places among the values, sorted by group; a group is of one point.
        start : ndarray of int, shape (n_groups + 1,)

        Returns
        -------
        ndarray, shape (n,) or (n, d, d)
            In the order of the values.
        """
        if self.joint is None:
            return self.in_mean
        found = np.empty_like(self.in_mean)
        found[order] = self.joint.shares(order, start)
        return found


def value_weights(weighting, error, rows, start, covariances):
    """Find the weights of the values of each point.

    Parameters
    ----------
    weighting : {"plain", "weighted", "rigorous"}
    error : ndarray, shape (n_values,)
        M of each value [m], sorted by point.
    rows : ndarray of int, shape (n_values,)
        Row of each in the table whose covariances are known.
    start : ndarray of int, shape (n_points + 1,)
        First value of each point.
    covariances : callable or None
        Of pairs of rows, shape (n_pairs, 2); gives shape (n_pairs, d, d) [m²].

    Returns
    -------
    ValueWeights
    """
    if weighting == PLAIN:
        return ValueWeights(np.ones(len(rows)))
    if weighting == WEIGHTED:
        return ValueWeights(error**-2.0)
    joint = JointCovariance(covariances(rows[pairs_of_values(start)]), start)
    return ValueWeights(joint.shares(np.arange(len(rows)), start), joint)
