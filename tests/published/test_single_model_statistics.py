"""Test statistics of one model, from an independent computation (cases/single_*)."""

import numpy as np
import pytest

from einschalt.theory.adjustment.reliability import (
    external_t,
    redundancy_numbers,
    standardized_residuals,
)

# given with all digits of double precision; inputs of 5·10⁶ m leave 1e-9 m
TOLERANCE = 1e-6


@pytest.mark.parametrize("kind", ["affine", "helmert", "rigid"])
def test_w_tau_and_t(read_case, transform_case, kind):
    case = read_case(f"single_{kind}")
    expected = case["expected"]
    fit = transform_case(case, kind).fit
    r = redundancy_numbers(fit.leverage)
    w = standardized_residuals(fit.residuals, r, 1.0)
    np.testing.assert_allclose(w, expected["w"], atol=TOLERANCE)
    tau = standardized_residuals(fit.residuals, r, fit.s_0[0])
    np.testing.assert_allclose(tau, expected["t_int"], atol=TOLERANCE)
    if "t_ext" in expected:
        t = external_t(tau, fit.redundancy[0])
        np.testing.assert_allclose(t, expected["t_ext"], atol=10 * TOLERANCE)


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_w_of_the_table_is_both_coordinates_together(read_case, transform_case, kind):
    case = read_case(f"single_{kind}")
    table = transform_case(case, kind).residuals
    tau = np.array(case["expected"]["t_int"])
    np.testing.assert_allclose(table["w"], np.hypot(*tau.T), atol=TOLERANCE)
