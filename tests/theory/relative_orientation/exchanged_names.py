"""Pairs in which points have the names of each other in one of the photographs."""

import numpy as np

from einschalt.theory.relative_orientation.condition_tests import StereoPairs


def with_exchanged_names(pairs, n_exchanged, seed):
    """Right images of some points of each pair under the names of each other."""
    rng = np.random.default_rng(seed)
    image, is_wrong = pairs.image.copy(), np.zeros(len(pairs.image), dtype=bool)
    for first, end in zip(pairs.start[:-1], pairs.start[1:], strict=True):
        rows = first + rng.permutation(end - first)[:n_exchanged]
        image[rows, 2:] = image[np.roll(rows, 1), 2:]
        is_wrong[rows] = True
    return StereoPairs(image, pairs.start, pairs.distance), is_wrong
