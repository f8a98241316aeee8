"""Krames 1951 and Hallert 1944: orientation of six points by least squares.

The cases come from an independent computation (in part with many digits, in part in
closed form); conventions and tolerance stand in each file. Their parallaxes are
already ``y(moved) - y(fixed)``, in the order 1, 3, 5, 2, 4, 6, and are given to the
public function as they are, for all three cases.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests.theory.relative_orientation.flat_model import (
    flat_contradiction,
    flat_solution_matrix,
)

from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)
from einschalt.theory.relative_orientation.hallert import (
    LARGEST_CONDITION,
    adjust_parallaxes,
    flat_cofactor,
    flat_six_points,
)
from einschalt.theory.relative_orientation.parallax_equations import (
    design_matrix,
    element_scale,
    independent_from_dependent,
)

CASE_OF = {
    "ind": "independent",
    "dep1": "dependent_left",
    "dep2": "dependent_right",
}
NAMES = ["1", "3", "5", "2", "4", "6"]


def read(name):
    path = Path(__file__).parent / "cases" / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8"))


FLAT = read("part1_flat")
CONVERSION = read("part1_conversion")
EQUATION_9 = read("part1_eq9")
GRUBER = read("part1_gruber")
CRITICAL = read("part2_critical")


def assert_close(found, expected, tolerance_rel):
    """Compare relative to the largest element, as the files say."""
    size = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance_rel * size)


def six_parallaxes(xyz, parallax, model_id="1"):
    table = pd.DataFrame(xyz, columns=["x", "y", "z"])
    return table.assign(model_id=model_id, point_id=NAMES, y_parallax=parallax)


def case_id(case):
    return f"{case['case']}-{case.get('kind', '')}-h{case['h']}"


@pytest.mark.parametrize("case", FLAT["cases"], ids=case_id)
def test_flat_six_points(case):
    a, b, h, expected = case["a"], case["b"], case["h"], case["expected"]
    parallaxes = six_parallaxes(flat_six_points(a, b, h), case["p"])
    oriented = orient_from_parallaxes(parallaxes, b, case=CASE_OF[case["case"]])
    tolerance = FLAT["tolerance_rel"]
    size = np.abs(case["p"]).max()
    assert_close(oriented.parameters.loc["1"], expected["x"], tolerance)
    assert_close(oriented.cofactor("1"), expected["Q_closed"], tolerance)
    residuals = oriented.residuals
    assert residuals["point_id"].tolist() == NAMES
    np.testing.assert_allclose(
        residuals["residual"], expected["v"], rtol=0, atol=tolerance * size
    )
    assert_close(residuals["redundancy_number"], expected["redundancy"], tolerance)
    np.testing.assert_allclose(
        oriented.sigma_0["1"], expected["sigma0"], rtol=0, atol=tolerance * size
    )


@pytest.mark.parametrize("case", FLAT["cases"], ids=case_id)
def test_flat_closed_forms(case):
    a, b, h, expected = case["a"], case["b"], case["h"], case["expected"]
    kind, tolerance = CASE_OF[case["case"]], FLAT["tolerance_rel"]
    assert_close(flat_cofactor(a, b, h, kind), expected["Q_closed"], tolerance)
    solution = flat_solution_matrix(a, b, h, kind)
    assert_close(solution, expected["solution_matrix_closed"], tolerance)
    contradiction = flat_contradiction(case["p"])
    np.testing.assert_allclose(contradiction, expected["w"], atol=1e-15)


def test_all_flat_models_at_once():
    # the same as one by one, in one table per kind of pair
    for short, kind in CASE_OF.items():
        cases = [case for case in FLAT["cases"] if case["case"] == short]
        tables = [
            six_parallaxes(flat_six_points(c["a"], c["b"], c["h"]), c["p"], str(k))
            for k, c in enumerate(cases)
        ]
        base = pd.Series({str(k): c["b"] for k, c in enumerate(cases)})
        oriented = orient_from_parallaxes(pd.concat(tables), base, case=kind)
        for k, c in enumerate(cases):
            found = oriented.parameters.loc[str(k)]
            assert_close(found, c["expected"]["x"], FLAT["tolerance_rel"])


@pytest.mark.parametrize("case", CONVERSION["cases"], ids=lambda case: f"b{case['b']}")
@pytest.mark.parametrize("short", ["dep1", "dep2"])
def test_conversion_of_elements(case, short):
    b, kind, tolerance = case["b"], CASE_OF[short], CONVERSION["tolerance_rel"]
    turn = independent_from_dependent(b, kind)
    assert_close(turn @ case[short], case["ind"], tolerance)
    assert_close(np.linalg.solve(turn, case["ind"]), case[short], tolerance)


def equation_9_points(case):
    if "hilly" not in case:
        return flat_six_points(case["a"], case["b"], case["h"])
    planes = ((0.0, case["P0"]), (case["b"], case["Pb"]))
    return np.array([[x, *yz] for x, points in planes for yz in points])


@pytest.mark.parametrize("case", EQUATION_9["cases"], ids=["h/a=1.5", "h=152", "hilly"])
def test_least_squares_beside_equation_9(case):
    parallaxes = six_parallaxes(equation_9_points(case), case["p"])
    oriented = orient_from_parallaxes(parallaxes, case["b"], case="dependent_right")
    expected, tolerance = case["expected"], EQUATION_9["tolerance_rel"]
    d_kappa = oriented.parameters.loc["1", "d_kappa"]
    assert_close(d_kappa, expected["dk2_least_squares"], tolerance)
    if "Q_ls" in expected:
        cofactor = oriented.cofactor("1").loc["d_kappa", "d_kappa"]
        assert_close(cofactor, expected["Q_ls"], tolerance)


@pytest.mark.parametrize("case", GRUBER["cases"], ids=case_id)
def test_least_squares_beside_gruber(case):
    a, b, h, kind = case["a"], case["b"], case["h"], CASE_OF[case["case"]]
    expected, tolerance = case["expected"], GRUBER["tolerance_rel"]
    xyz = flat_six_points(a, b, h)
    found = adjust_parallaxes(
        xyz, np.zeros(6), np.array([b]), np.array([0, 6]), case=kind
    )
    assert_close(found.cofactor[0], expected["LS_P"], tolerance)
    # here the points follow each other as 1 to 6
    design = design_matrix(xyz, b, kind)[np.argsort(NAMES)]
    adjusted = np.einsum("ni,ij,nj->n", design, found.cofactor[0], design)
    assert_close(adjusted, expected["LS_R_diag"], tolerance)


def valley_id(case):
    return f"{case['name']}-{case['delta']}"


@pytest.mark.parametrize("case", CRITICAL["valley"], ids=valley_id)
def test_precision_in_valleys_and_on_ridges(case):
    xyz, expected = np.array(case["points"]), case["expected"]
    found = adjust_parallaxes(
        xyz, np.zeros(6), np.array([case["b"]]), np.array([0, 6]), case="independent"
    )
    # the published sigma itself was computed close to singularity, and says so
    tolerance = CRITICAL["tolerance_rel"] * max(1.0, expected["inflation"])
    sigma_omega = np.sqrt(found.cofactor[0, 0, 0])
    assert_close(sigma_omega, expected["sigma_omega_LS"], tolerance)


@pytest.mark.parametrize(
    "case", CRITICAL["quadrics"], ids=lambda case: f"{case['name']}-{case['case']}"
)
def test_orthogonal_ruled_quadrics(case):
    xyz, kind, expected = (
        np.array(case["points"]),
        CASE_OF[case["case"]],
        case["expected"],
    )
    height = np.array([-xyz[:, 2].mean()])
    assert_close(height[0], expected["h_scale"], 1e-12)
    design = design_matrix(xyz, case["b"], kind) / element_scale(height, kind)
    values = np.linalg.svd(design / np.sqrt(len(xyz)), compute_uv=False)
    assert_close(values, expected["singular_values"], CRITICAL["tolerance_rel"])
    found = adjust_parallaxes(
        xyz,
        np.zeros(len(xyz)),
        np.array([case["b"]]),
        np.array([0, len(xyz)]),
        case=kind,
    )
    is_critical = "null_vector" in expected
    assert found.is_determined[0] == (not is_critical)
    if is_critical:
        assert found.condition[0] > 1e6 * LARGEST_CONDITION
    else:
        condition = np.linalg.norm(design) * np.linalg.norm(np.linalg.pinv(design))
        assert_close(found.condition, condition, 1e-9)
