"""Krames 1951: fundamental points, factors and formula (9), for all three cases.

The numbers come from an independent computation of his formulas; conventions and
tolerances stand in each file. Points follow each other as 1, 3, 5, 2, 4, 6, and the
parallaxes are ``y(moved) - y(fixed)``.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests.theory.relative_orientation.krames_factors import (
    extended_formulas,
    flat_factors,
)

import einschalt as es
from einschalt.theory.relative_orientation.hallert import flat_six_points
from einschalt.theory.relative_orientation.krames import (
    contradiction,
    fundamental_points,
    plane_determinants,
    solve_krames,
    trial_swing,
)

CASE_OF = {"ind": "independent", "dep1": "dependent_left", "dep2": "dependent_right"}


def read(name):
    path = Path(__file__).parent / "cases" / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8"))


FLAT, EQUATION_9, CRITICAL = map(read, ["part1_flat", "part1_eq9", "part2_critical"])


def assert_close(found, expected, tolerance_rel):
    """Compare relative to the largest element, as the files say."""
    size = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance_rel * size)


def case_id(case):
    return f"{case['case']}-{case['kind']}-h{case['h']}"


def points_of(case):
    if "hilly" not in case:
        return flat_six_points(case["a"], case["b"], case["h"])
    planes = ((0.0, case["P0"]), (case["b"], case["Pb"]))
    return np.array([[x, *yz] for x, points in planes for yz in points])


@pytest.mark.parametrize("case", FLAT["cases"], ids=case_id)
def test_each_plane_by_itself(case):
    expected, tolerance = case["expected"], FLAT["tolerance_rel"]
    planes = plane_determinants(points_of(case))
    own = fundamental_points(planes, case["p"])
    np.testing.assert_allclose(own.Y, [expected["Y0"], expected["Yb"]], tolerance)
    np.testing.assert_allclose(own.Z, [expected["Z0"], expected["Zb"]], tolerance)
    tilts = [expected["dw0"], expected["dwb"]]
    np.testing.assert_allclose(own.d_omega, tilts, tolerance)
    assert_close(
        [own.delta_omega - expected["Delta_omega"], 1.0], [0.0, 1.0], tolerance
    )
    w = contradiction(planes, case["p"])
    assert w == pytest.approx(expected["w"], abs=tolerance * np.abs(case["p"]).max())


@pytest.mark.parametrize("case", FLAT["cases"], ids=case_id)
def test_factors(case):
    expected, tolerance = case["expected"], FLAT["tolerance_rel"]
    kind = CASE_OF[case["case"]]
    factors = list(expected["factors_closed"].values())
    closed = flat_factors(case["a"], case["b"], case["h"], kind)
    assert_close(closed, factors, tolerance)
    formulas = extended_formulas(plane_determinants(points_of(case)), case["b"], kind)
    assert_close(formulas.factors, factors, tolerance)
    solution = expected["solution_matrix_closed"]
    assert_close(formulas.solution, solution, tolerance)
    assert_close(formulas.cofactor, expected["Q_closed"], tolerance)


@pytest.mark.parametrize("case", FLAT["cases"], ids=case_id)
def test_elements(case):
    expected, tolerance = case["expected"], FLAT["tolerance_rel"]
    kind, size = CASE_OF[case["case"]], np.abs(case["p"]).max()
    found = solve_krames(points_of(case), case["p"], case["b"], kind)
    assert_close(found.elements, expected["x"], tolerance)
    assert_close(found.cofactor, expected["Q_closed"], tolerance)
    np.testing.assert_allclose(
        found.residuals, expected["v"], rtol=0, atol=tolerance * size
    )
    assert_close(found.redundancy_numbers, expected["redundancy"], tolerance)
    assert found.sigma_0 == pytest.approx(expected["sigma0"], abs=tolerance * size)
    if "true_elements" in expected:
        assert_close(found.elements, expected["true_elements"], tolerance)


@pytest.mark.parametrize("case", FLAT["cases"], ids=case_id)
def test_by_the_public_function(case):
    table = pd.DataFrame(points_of(case), columns=["x", "y", "z"])
    table = table.assign(model_id="1", point_id=list("135246"), y_parallax=case["p"])
    oriented = es.orient_from_parallaxes(
        table, case["b"], case=CASE_OF[case["case"]], method="krames"
    )
    expected, tolerance = case["expected"], FLAT["tolerance_rel"]
    assert_close(oriented.parameters.loc["1"], expected["x"], tolerance)
    assert_close(oriented.cofactor("1"), expected["Q_closed"], tolerance)
    said = oriented.contradiction.loc["1"]
    names = {"Y_0": "Y0", "Z_0": "Z0", "Y_b": "Yb", "Z_b": "Zb"}
    names |= {"d_omega_0": "dw0", "d_omega_b": "dwb"}
    for column, name in names.items():
        assert said[column] == pytest.approx(expected[name], rel=tolerance)
    size = np.abs(case["p"]).max()
    assert said["w"] == pytest.approx(expected["w"], abs=tolerance * size)
    np.testing.assert_allclose(
        said[["N_0", "N_b"]], 2.0 * case["a"] ** 3 * case["h"], rtol=1e-12
    )


@pytest.mark.parametrize("case", EQUATION_9["cases"], ids=["h/a=1.5", "h=152", "hilly"])
def test_trial_formula_9(case):
    expected, tolerance = case["expected"], EQUATION_9["tolerance_rel"]
    xyz = points_of(case)
    found = trial_swing(plane_determinants(xyz), case["p"], case["b"])
    assert found == pytest.approx(expected["dk2_eq9"], rel=tolerance)
    least = solve_krames(xyz, case["p"], case["b"], "dependent_right")
    d_kappa = least.elements[2]
    assert d_kappa == pytest.approx(expected["dk2_least_squares"], rel=tolerance)
    if "Q_ls" in expected:
        assert least.cofactor[2, 2] == pytest.approx(expected["Q_ls"], rel=tolerance)
        ratio = np.sqrt(expected["Q_eq9"] / least.cofactor[2, 2])
        assert ratio == pytest.approx(expected["mean_error_ratio"], rel=tolerance)
        assert ratio == pytest.approx(np.sqrt(3.0), rel=tolerance)


@pytest.mark.parametrize("plane", CRITICAL["planes"], ids=lambda plane: plane["name"])
def test_determinants_of_a_plane(plane):
    xyz = np.column_stack([np.zeros(3), plane["points"]])
    planes = plane_determinants(np.vstack([xyz, xyz]))
    expected, tolerance = plane["expected"], CRITICAL["tolerance_rel"]
    assert_close(planes.N, [expected["N"]] * 2, tolerance)
    assert_close(planes.q, [expected["q"]] * 2, tolerance)
    sigma_omega = np.sqrt(planes.q) / np.abs(planes.N)
    assert sigma_omega == pytest.approx([expected["sigma_omega"]] * 2, rel=tolerance)


def valley_id(case):
    return f"{case['name']}-{case['delta']}"


@pytest.mark.parametrize("case", CRITICAL["valley"], ids=valley_id)
def test_precision_in_valleys_and_on_ridges(case):
    xyz = np.array(case["points"])[[0, 2, 4, 1, 3, 5]]
    expected = case["expected"]
    tolerance = CRITICAL["tolerance_rel"] * max(1.0, expected["inflation"])
    planes = plane_determinants(xyz)
    assert_close(planes.N, [expected["N"]] * 2, tolerance)
    found = solve_krames(xyz, np.zeros(6), case["b"], "independent")
    assert np.sqrt(found.cofactor[0, 0]) == pytest.approx(
        expected["sigma_omega_LS"], rel=tolerance
    )
