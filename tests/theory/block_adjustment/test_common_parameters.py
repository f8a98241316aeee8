"""Terms that models share, and what they do on the ground."""

import numpy as np
import pytest

from einschalt.theory.block_adjustment.common_parameters import (
    CUBIC,
    QUADRATIC,
    displacement,
    polynomials_on_ground,
    positions_in_model,
)

COMPLEX = np.array([1.0, 1j])
N = 12


@pytest.mark.parametrize("is_mirrored", [False, True])
def test_every_deformation_of_the_flight_is_a_sum_of_them(is_mirrored):
    """Models that are turned, of several scales, mirrored or not."""
    rng = np.random.default_rng(4)
    model = np.repeat(np.arange(3), N)
    xy = rng.uniform(-0.1, 0.1, (3 * N, 2)) + 5.0 * model[:, None]
    position, _ = positions_in_model(xy, model)
    terms = [displacement(family, position) for family in (QUADRATIC, CUBIC)]
    bent = np.concatenate(terms, axis=2) @ rng.normal(0.0, 1e-5, 14)
    turn = np.array([8e3, 8.1e3j, -7.9e3 + 2e3j])[model]

    def ground(model_xy):
        z = model_xy @ COMPLEX
        return turn * (z.conj() if is_mirrored else z)

    at = np.column_stack([ground(xy).real, ground(xy).imag])
    columns = polynomials_on_ground(xy, model, at, 0.07)
    assert columns.shape == (3 * N, 7)
    wanted = ground(xy + bent) - ground(xy)
    found = np.linalg.lstsq(columns, wanted, rcond=None)[0]
    np.testing.assert_allclose(
        columns @ found, wanted, atol=1e-9 * np.abs(wanted).max()
    )
    at_edge = np.abs(columns).max() / np.abs(position).max() ** 3
    assert at_edge == pytest.approx(0.07, rel=0.2)
