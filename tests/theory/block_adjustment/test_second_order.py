"""Second derivatives of a sum of squares by scale and turn, by brute differences."""

import numpy as np

from einschalt.foundations.rotations import rotation_by_vector
from einschalt.theory.block_adjustment.model_graph import incidence_of
from einschalt.theory.block_adjustment.second_order import (
    among_unknowns,
    second_derivatives,
)

STEP = 1e-3


def a_case(seed=0, n_models=3, n=12):
    rng = np.random.default_rng(seed)
    model = np.repeat(np.arange(n_models), n)
    incidence = incidence_of(model, np.arange(len(model)), n_models, len(model))
    arm, pulled = rng.standard_normal((2, len(model), 3))
    return incidence, arm, pulled, np.array([1.0, 2.0, 0.5])[:n_models]


def pull(case, model, step):
    """Σ w v · T after a step of scale and turn in units of the extent."""
    incidence, arm, pulled, extent = case
    own = incidence.model == model
    step = np.asarray(step) / extent[model]
    turned = arm[own] @ rotation_by_vector(step[None, 1:])[0].T
    return np.sum(pulled[own] * (1.0 + step[0]) * turned)


def test_are_those_of_turned_and_scaled_models():
    case = a_case()
    found = second_derivatives(*case, is_positive=False)
    unit = STEP * np.eye(4)
    for model in range(3):
        for j, a in enumerate(unit):
            for k, b in enumerate(unit):
                four = [
                    pull(case, model, s * a + t * b) for s in (1, -1) for t in (1, -1)
                ]
                second = (four[0] - four[1] - four[2] + four[3]) / (4.0 * STEP**2)
                assert abs(found[model, j, k] - second) < 1e-4


def test_the_positive_part_never_holds_a_model_less():
    case = a_case(1)
    whole = second_derivatives(*case, is_positive=False)
    positive = second_derivatives(*case, is_positive=True)
    assert np.linalg.eigvalsh(whole).min() < -1.0
    assert np.linalg.eigvalsh(positive).min() > -1e-12
    assert np.linalg.eigvalsh(positive - whole).min() > -1e-12


def test_shifts_and_deformations_have_none():
    second = second_derivatives(*a_case(), is_positive=True)
    among = among_unknowns(second, 9)
    np.testing.assert_array_equal(among[:, 3:7, 3:7], second)
    assert np.count_nonzero(among) == np.count_nonzero(second)
