"""The hat matrix in two steps, through the parameters of models."""

import numpy as np
import pytest

from einschalt.theory.adjustment.propagation import through_parameters

MODEL = np.array([0, 1, 0, 1, 1, 0, 2, 2, 0, 1])
FITTED = np.array([0, 5, 8, 1, 3, 9, 6])  # by model; the third has one of two points


@pytest.mark.parametrize(
    ("d", "n_rest", "kind"),
    [(1, 1, complex), (1, 2, float), (2, 1, float), (2, 4, float), (3, 4, float)],
)
def test_the_steps_are_the_hat_matrix(d, n_rest, kind):
    rng = np.random.default_rng(1)
    design = rng.normal(size=(len(MODEL), d, n_rest)).astype(kind)
    if kind is complex:
        design = design + 1j * rng.normal(size=design.shape)
    root = rng.normal(size=(3, n_rest, n_rest))
    cofactors = root @ root.swapaxes(1, 2)
    weights = rng.uniform(0.5, 2.0, len(FITTED))
    weight_sum = np.bincount(MODEL[FITTED], weights)
    of_rows, parameters = through_parameters(
        design, cofactors, weights, weight_sum, MODEL, FITTED
    )
    assert of_rows.n_sources == 3 * (1 + -(-n_rest // d))  # whole points
    expected = np.zeros((len(MODEL), d, len(FITTED), d), dtype=kind)
    for i, m in enumerate(MODEL):
        for k, j in enumerate(FITTED):
            if MODEL[j] == m:
                through = design[i] @ cofactors[m] @ design[j].conj().T
                expected[i, :, k] = weights[k] * (np.eye(d) / weight_sum[m] + through)
    hat = (of_rows @ parameters).matrix.toarray()
    np.testing.assert_allclose(hat, expected.reshape(hat.shape), atol=1e-12)
