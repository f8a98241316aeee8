"""Bachmann 1947: matrices, covariances and means of repeated Gruber procedures.

The numbers come from an independent computation and its closed forms; the procedure
stands in the file. Points follow each other as 1 to 6.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.theory.relative_orientation.bachmann import (
    compare_errors,
    covariance_of_consecutive_mean,
    covariance_of_independent_mean,
    pass_matrices,
    residual_covariance,
    stationary_covariance,
)
from einschalt.theory.relative_orientation.gruber import (
    over_correction,
    standard_procedure,
)
from einschalt.theory.relative_orientation.hallert import flat_six_points
from einschalt.theory.relative_orientation.parallax_equations import design_matrix
from einschalt.theory.relative_orientation.six_points import FROM_1_TO_6

CASE_OF = {"ind": "independent", "dep1": "dependent_left", "dep2": "dependent_right"}
PATH = Path(__file__).parent / "cases" / "part1_gruber.json"
GRUBER = json.loads(PATH.read_text(encoding="utf-8"))
TOLERANCE = GRUBER["tolerance_rel"]


def tilt_at(case):
    return (
        next(iter(case["omega_points"])) if len(case["omega_points"]) == 1 else "mean"
    )


def case_id(case):
    return f"{case['case']}-{tilt_at(case)}-rel{case['rel']:.2f}-h{case['h']}"


def assert_close(found, expected):
    size = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=TOLERANCE * size)


@pytest.fixture(params=GRUBER["cases"], ids=case_id)
def case(request):
    return request.param


@pytest.fixture
def design(case):
    xyz = flat_six_points(case["a"], case["b"], case["h"])[FROM_1_TO_6]
    return design_matrix(xyz, case["b"], CASE_OF[case["case"]])


@pytest.fixture
def procedure(case, design):
    kind = CASE_OF[case["case"]]
    return standard_procedure(design, kind, tilt_at=tilt_at(case), rel=case["rel"])


def remaining(design, covariance):
    return np.diag(residual_covariance(design, covariance))


def test_over_correction(case, design, procedure):
    expected = case["expected"]
    n = over_correction(design, CASE_OF[case["case"]], tilt_at=tilt_at(case))
    assert n == pytest.approx(expected["n_exact"], rel=TOLERANCE)
    assert n - 1.0 == pytest.approx(expected["k_exact"], rel=TOLERANCE)
    used = procedure.steps[0].over_correction
    assert used == pytest.approx(expected["n_used"], rel=TOLERANCE)


def test_one_pass(case, design, procedure):
    expected = case["expected"]
    one_pass = pass_matrices(procedure, design)
    assert_close(one_pass.T, expected["T"])
    assert_close(one_pass.S, expected["S"])
    # T² = 0 for rel = 1: a double eigenvalue is known to the root of the precision
    np.testing.assert_allclose(
        one_pass.eigenvalue, expected["nonzero_eigenvalue"], atol=1e-6
    )


def test_stationary_covariance(case, design, procedure):
    expected = case["expected"]
    P = stationary_covariance(pass_matrices(procedure, design))
    assert_close(P, expected["P"])
    assert P[0, 0] == pytest.approx(expected["var_omega"], rel=TOLERANCE)
    assert_close(remaining(design, P), expected["R_diag"])


def test_means_of_several_results(case, design, procedure):
    one_pass = pass_matrices(procedure, design)
    for mean in case["expected"]["mean"]:
        independent = covariance_of_independent_mean(one_pass, mean["r"])
        assert_close(remaining(design, independent), mean["R_diag_independent"])
        consecutive = covariance_of_consecutive_mean(one_pass, mean["r"])
        assert_close(remaining(design, consecutive), mean["R_diag_consecutive"])


def test_table_beside_least_squares(case, design, procedure):
    expected = case["expected"]
    table = compare_errors(procedure, design)
    assert_close(table.least_squares**2, expected["LS_R_diag"])
    assert_close(table.stationary**2, expected["R_diag"])
    # after 20 passes (1 - rel)^40 is left of what the start knew better
    assert_close(table.after_passes[-1] ** 2, expected["R_diag"])


# the public method reads the tilt in point 5, and over-corrects it by n
PUBLIC = [c for c in GRUBER["cases"] if tilt_at(c) == "5" and c["rel"] == 1.0]


@pytest.mark.parametrize("case", PUBLIC, ids=case_id)
def test_cofactors_of_the_public_function(case):
    xyz = flat_six_points(case["a"], case["b"], case["h"])
    table = pd.DataFrame(xyz, columns=["x", "y", "z"])
    table = table.assign(model_id="1", point_id=list("135246"))
    table["y_parallax"] = np.random.default_rng(1).normal(scale=1e-3, size=6)
    oriented = es.orient_from_parallaxes(
        table, case["b"], case=CASE_OF[case["case"]], method="gruber"
    )
    assert_close(oriented.cofactor("1").to_numpy(), case["expected"]["P"])
