"""Shifts whose covariance is known: sums of waves, noise with tails, gross errors."""

import numpy as np

N_WAVES = 300


def simulated_shifts(
    rng, n_points, *, extent, reach, signal, noise, freedom=None, clusters=0, wrong=0.0
):
    """Places, shifts and which of them are wrong, by 3 m (σ) each.

    ``freedom``: of Student's t, whose scale is ``noise``; normal where left out.
    """
    xy = rng.uniform(0.0, extent, (n_points, 2))
    if clusters:
        middles = rng.uniform(0.0, extent, (clusters, 2))
        near = rng.normal(size=(n_points, 2)) * extent / 60.0
        xy = middles[rng.integers(0, clusters, n_points)] + near
    # frequencies with heavy tails: the covariance is exponential, the field has kinks
    waves = rng.normal(size=(N_WAVES, 2)) / reach
    waves /= np.abs(rng.normal(size=(N_WAVES, 1)))
    phases = rng.uniform(0.0, 2.0 * np.pi, (N_WAVES, 2))
    along = xy @ waves.T
    field = [np.cos(along + phases[:, axis]).sum(axis=1) for axis in range(2)]
    field = signal * np.sqrt(2.0 / N_WAVES) * np.column_stack(field)
    if freedom is None:
        errors = rng.normal(size=(n_points, 2))
    else:
        errors = rng.standard_t(freedom, (n_points, 2))
    is_wrong = rng.random(n_points) < wrong
    gross = 3.0 * rng.normal(size=(n_points, 2)) * is_wrong[:, None]
    return xy, field + noise * errors + gross, is_wrong
