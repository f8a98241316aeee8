"""Random models for the races: 5 to 200 points, 25 on average, 5·10⁶ m away."""

from dataclasses import dataclass

import numpy as np

MEAN_LOGARITHM, DEVIATION = np.log(25.0) - 0.18, 0.6


@dataclass(frozen=True)
class Models:
    """Observations sorted by model."""

    xy: np.ndarray
    en: np.ndarray
    weights: np.ndarray
    start: np.ndarray

    @property
    def n_models(self):
        """Number of models."""
        return len(self.start) - 1

    @property
    def counts(self):
        """Points of each model."""
        return np.diff(self.start)

    def one_by_one(self, n_models):
        """Observations of the first models, one model at a time."""
        for k in range(n_models):
            rows = slice(self.start[k], self.start[k + 1])
            yield self.xy[rows], self.en[rows], self.weights[rows]


def generate(n_models, *, seed=0):
    """Generate models with noise of 0.3 m and weights of 0.5 to 2.

    Parameters
    ----------
    n_models : int
    seed : int

    Returns
    -------
    Models
    """
    rng = np.random.default_rng(seed)
    counts = np.rint(rng.lognormal(MEAN_LOGARITHM, DEVIATION, n_models))
    counts = np.clip(counts, 5, 200).astype(np.int64)
    start = np.concatenate([[0], np.cumsum(counts)])
    n_points = int(start[-1])
    xy = rng.uniform(-450.0, 450.0, (n_points, 2))
    angle = np.repeat(rng.uniform(-np.pi, np.pi, n_models), counts)
    c, s = 2.0 * np.cos(angle), 2.0 * np.sin(angle)
    origin = np.array([4.5e6, 5.3e6]) + rng.uniform(-1e4, 1e4, (n_models, 2))
    en = np.column_stack(
        [c * xy[:, 0] - s * xy[:, 1], s * xy[:, 0] + c * xy[:, 1]]
    ) + np.repeat(origin, counts, axis=0)
    en += rng.normal(0.0, 0.3, en.shape)
    return Models(xy, en, rng.uniform(0.5, 2.0, n_points), start)
