"""Greenfeld, Weighted Coordinate Transformations: three points, plain and weighted.

He states m_0 per coordinate and √2 m_0 for the point: the convention of Kovarik 1971,
in which m_0 of this project is the total and s_0 the coordinate's.
"""

import numpy as np
import pytest


@pytest.fixture
def plain(read_case):
    return read_case("greenfeld_helmert_3pt")


@pytest.fixture
def fit(plain, transform_case):
    return transform_case(plain["data"], "helmert")


def test_parameters(plain, fit):
    printed = plain["printed"]
    found = fit.parameters.loc["7/8"]
    np.testing.assert_allclose(found["a"], printed["a1"], rtol=0, atol=5e-6)
    np.testing.assert_allclose(found["b"], printed["b1"], rtol=0, atol=5e-5)
    np.testing.assert_allclose(found["te"], printed["a0"], rtol=0, atol=0.5)
    np.testing.assert_allclose(found["tn"], printed["b0"], rtol=0, atol=0.5)


def test_transformed_points(plain, fit, transformed):
    found = transformed(fit, plain["data"]["source"])
    np.testing.assert_allclose(
        found, plain["printed"]["transformed"], rtol=0, atol=5e-3
    )


def test_errors_per_coordinate_and_total(plain, fit):
    model = fit.models.iloc[0]
    np.testing.assert_allclose(
        model["s_0"], plain["printed"]["m0_coord"], rtol=0, atol=5e-3
    )
    np.testing.assert_allclose(
        model["m_0"], plain["printed"]["mp_total"], rtol=0, atol=5e-3
    )


def test_weighted_parameters(read_case, transform_case):
    case = read_case("greenfeld_helmert_3pt_weighted")
    fit = transform_case(case["data"], "helmert", weights=case["data"]["weights"])
    printed = case["printed"]
    found = fit.parameters.loc["7/8"]
    np.testing.assert_allclose(found["a"], printed["a1"], rtol=0, atol=5e-9)
    np.testing.assert_allclose(found["b"], printed["b1"], rtol=0, atol=5e-9)
    np.testing.assert_allclose(found["te"], printed["a0"], rtol=0, atol=5e-4)
    np.testing.assert_allclose(found["tn"], printed["b0"], rtol=0, atol=5e-4)
