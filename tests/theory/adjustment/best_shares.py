"""Shares of values in the mean of all of each point."""

import numpy as np

from einschalt.theory.adjustment.correlated_mean import JointCovariance


def best_shares(covariance):
    """Of points with k values each; covariance (n_points, k, k, d, d)."""
    n_points, k, _, d, _ = covariance.shape
    later, earlier = np.tril_indices(k)
    blocks = covariance[:, later, earlier].reshape(-1, d, d)
    start = k * np.arange(n_points + 1)
    shares = JointCovariance(blocks, start).shares(np.arange(start[-1]), start)
    return shares.reshape(n_points, k, d, d)
