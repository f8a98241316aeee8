"""Weights with which the values of a point enter its mean, and that of a coverage."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.theory.adjustment.correlated_mean import JointCovariance, pairs_of_values

PLAIN, WEIGHTED, RIGOROUS = "plain", "weighted", "rigorous"
WEIGHTINGS = (PLAIN, WEIGHTED, RIGOROUS)


def require_covariances(weighting, covariances):
    """Refuse a rigorous mean of values whose covariances nobody gave."""
    if weighting == RIGOROUS and covariances is None:
        raise SettingsError(
            f'weighting = "{RIGOROUS}" without covariances of the values',
            expected="covariances, a function of pairs of rows",
            remedy=f'Give covariances, or set weighting = "{PLAIN}"',
        )


@dataclass(frozen=True, eq=False)
class ValueWeights:
    """Weights of the values of points."""

    # (n_values,) or (n_values, d, d): in the mean of the point: numbers, or matrices
    # that add up to the unit matrix
    in_mean: np.ndarray
    # of the values, where the weights follow from it
    joint: JointCovariance | None = None

    def in_groups(self, order, start):
        """Weights of values in the mean of each group of them.

        In the order of the values; ``order`` are their places sorted by group, and a
        group is of one point.
        """
        if self.joint is None:
            return self.in_mean
        found = np.empty_like(self.in_mean)
        found[order] = self.joint.shares(order, start)
        return found


def value_weights(weighting, error, rows, start, covariances) -> ValueWeights:
    """Find the weights of the values of each point.

    ``error`` (n_values,) is M of each value [m], sorted by point; ``rows`` are their
    rows in the table whose ``covariances`` are known, a function of pairs (n_pairs, 2)
    that gives (n_pairs, d, d) [m²]; ``start`` is the first value of each point.
    """
    if weighting == PLAIN:
        return ValueWeights(np.ones(len(rows)))
    if weighting == WEIGHTED:
        return ValueWeights(error**-2.0)
    joint = JointCovariance(covariances(rows[pairs_of_values(start)]), start)
    return ValueWeights(joint.shares(np.arange(len(rows)), start), joint)
