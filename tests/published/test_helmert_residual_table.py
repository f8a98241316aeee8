"""A printed table of residuals of a Helmert transformation, eight points.

Only the ground coordinates and the residuals are printed. Points that differ from the
ground by those residuals must come back with them: then they are residuals of a
Helmert transformation. ERRATUM of the source: it prints [vv] of one coordinate divided
by 2n − 4 as the error of that coordinate, although a coordinate has only n residuals;
the error per coordinate is √([vv] / (2n − 4)) = 0.21 m. The first of its figures,
0.165, is cut to 0.16.
"""

import numpy as np
import pytest

# residuals are printed to 0.01 m
HALF_UNIT = 0.005


@pytest.fixture
def case(read_case):
    return read_case("helmert_residual_table_8pt")


@pytest.fixture
def fit(case, transform_case):
    target = np.array(case["data"]["points"])
    source = target + np.array(case["data"]["residuals"])
    return transform_case({"source": source, "target": target}, "helmert")


def test_residuals_come_back(case, fit, residuals_of):
    printed = case["data"]["residuals"]
    np.testing.assert_allclose(residuals_of(fit), printed, rtol=0, atol=HALF_UNIT)


def test_printed_errors(case, fit, residuals_of):
    redundancy = fit.models["redundancy"].iloc[0]
    assert redundancy == 12
    squares = np.sum(residuals_of(fit) ** 2, axis=0) / redundancy
    printed = case["printed"]
    np.testing.assert_allclose(
        np.sqrt(squares), [printed["MY"], printed["MX"]], rtol=0, atol=0.006
    )
    mean = np.sqrt(np.mean(squares))
    np.testing.assert_allclose(mean, printed["mean_m"], rtol=0, atol=HALF_UNIT)


def test_right_error_per_coordinate(fit):
    np.testing.assert_allclose(fit.models["s_0"], 0.21, rtol=0, atol=HALF_UNIT)
