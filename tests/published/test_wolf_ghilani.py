"""Wolf and Ghilani: two-dimensional conformal transformation, four new points.

Their b has the sign of ours: E = a x − b y + T_E. Tolerances are half a unit of the
last printed digit.
"""

import numpy as np
import pytest


@pytest.fixture
def case(read_case):
    return read_case("wolf_ghilani_2d_conformal")


@pytest.fixture
def fit(case, transform_case):
    return transform_case(case["data"], "helmert")


def test_parameters(case, fit):
    printed = case["printed"]
    found = fit.parameters.loc["7/8"]
    np.testing.assert_allclose(found["a"], printed["a"], rtol=0, atol=5e-6)
    np.testing.assert_allclose(found["b"], printed["b"], rtol=0, atol=5e-6)
    np.testing.assert_allclose(found["te"], printed["tx"], rtol=0, atol=5e-4)
    np.testing.assert_allclose(found["tn"], printed["ty"], rtol=0, atol=5e-4)


def test_new_points(case, fit, transformed):
    found = transformed(fit, case["data"]["new_source"])
    np.testing.assert_allclose(found, case["printed"]["new"], rtol=0, atol=5e-4)
