"""Krames' formulas and Gruber's procedure: tables in, orientations out."""

import numpy as np
import pandas as pd
import pytest

from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)
from einschalt.theory.relative_orientation.bachmann import (
    pass_matrices,
    stationary_covariance,
)
from einschalt.theory.relative_orientation.gruber import (
    run_procedure,
    standard_procedure,
)
from einschalt.theory.relative_orientation.hallert import flat_six_points
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    INDEPENDENT,
    design_matrix,
)
from einschalt.theory.relative_orientation.six_points import FROM_1_TO_6

BASE = 92.0
SIGMA = 0.005
NAMES = ["1", "3", "5", "2", "4", "6"]
SIX_POINT_METHODS = ["krames", "gruber"]


def six_points(model_id, seed, relief=12.0):
    """Parallaxes of a hilly model, three points in each of the two planes."""
    rng = np.random.default_rng(seed)
    xyz = flat_six_points(95.0, BASE, 152.0)
    xyz[:, 1:] += rng.uniform(-relief, relief, (6, 2))
    table = pd.DataFrame(xyz, columns=["x", "y", "z"])
    parallax = rng.normal(scale=SIGMA, size=6)
    return table.assign(model_id=model_id, point_id=NAMES, y_parallax=parallax)


@pytest.fixture
def flight():
    """Seven models, of which some suit no method of six points; rows mixed."""
    seven = pd.concat([six_points("7", 7), six_points("7", 17).iloc[[0]]])
    aside, turned = six_points("aside", 6), six_points("turned", 8)
    aside.loc[4, "x"] -= 0.31
    turned["x"] = [0.0, 30.0, 60.0, 70.0, 90.0, 92.0]
    parts = [
        *(six_points(f"m{k}", seed=k) for k in range(3)),
        six_points("5", 5).iloc[:5],
        six_points("4", 4).iloc[:4],
        seven.assign(point_id=[*NAMES, "7"]),
        aside,
        turned,
    ]
    return pd.concat(parts, ignore_index=True).sample(frac=1.0, random_state=1)


@pytest.mark.parametrize("case", CASES)
def test_krames_equals_least_squares(case):
    table = pd.concat([six_points(f"m{k}", seed=k, relief=25.0) for k in range(100)])
    table = table.sample(frac=1.0, random_state=2)
    one = orient_from_parallaxes(table, BASE, case=case, method="krames")
    other = orient_from_parallaxes(table, BASE, case=case)
    assert (one.method, other.method) == ("krames", "least_squares")
    pd.testing.assert_frame_equal(
        one.parameters, other.parameters, rtol=1e-9, atol=1e-13
    )
    pd.testing.assert_series_equal(one.sigma_0, other.sigma_0, rtol=1e-10)
    pd.testing.assert_frame_equal(one.residuals, other.residuals, rtol=1e-9, atol=1e-15)
    pd.testing.assert_frame_equal(one.models, other.models, rtol=1e-10)
    pd.testing.assert_frame_equal(one.contradiction, other.contradiction)
    size = np.abs(other.cofactor("m7").to_numpy()).max()
    pd.testing.assert_frame_equal(
        one.cofactor("m7"), other.cofactor("m7"), rtol=0, atol=1e-11 * size
    )
    points = table[["model_id", "point_id", "x", "y", "z"]]
    pd.testing.assert_frame_equal(
        one.corrected(points), other.corrected(points), rtol=1e-10
    )


def test_krames_says_which_models_it_does_not_fit(flight):
    oriented = orient_from_parallaxes(flight, BASE, method="krames")
    failures = oriented.failures.set_index("model_id").sort_index()
    planes = "not three of its points lie in each of the planes x = 0 and x = base"
    assert failures["reason"].to_dict() == {
        "4": "4 points, but five are needed",
        "5": "5 points, but Krames' construction takes six",
        "7": "7 points, but Krames' construction takes six",
        "aside": planes,
        "turned": planes,
    }
    assert failures["remedy"].to_dict() == {
        "4": "Measure more points in it",
        **dict.fromkeys(["5", "7", "aside", "turned"], 'Use method="least_squares"'),
    }
    assert (failures["stage"] == "stage2_relative_orientation").all()
    is_usable = oriented.models.set_index("model_id")["is_usable"]
    assert sorted(is_usable[is_usable].index) == ["m0", "m1", "m2"]
    assert oriented.contradiction.loc[failures.index].isna().all(axis=None)
    assert oriented.parameters.loc[failures.index].isna().all(axis=None)
    # by least squares they can all be oriented, but the one with four points
    assert orient_from_parallaxes(flight, BASE).failures["model_id"].tolist() == ["4"]


def test_gruber_says_which_models_it_does_not_fit(flight):
    oriented = orient_from_parallaxes(flight, BASE, method="gruber")
    failures = oriented.failures.set_index("model_id").sort_index()
    assert failures["reason"].to_dict() == {
        "4": "4 points, but five are needed",
        "5": "5 points, but Gruber's procedure takes six",
        "7": "7 points, but Gruber's procedure takes six",
        "turned": "not three of its points lie on the side of each projection centre",
    }
    is_usable = oriented.models.set_index("model_id")["is_usable"]
    assert sorted(is_usable[is_usable].index) == ["aside", "m0", "m1", "m2"]
    assert oriented.contradiction.loc["aside"].isna().all()


def test_gruber_says_where_the_procedure_diverges():
    # points 1 and 3 of the left plane nearly on one ray
    table = six_points("1/2", seed=3)
    table.loc[[0, 1, 2], "y"] = [60.0, 66.0, -95.0]
    table.loc[[0, 1, 2], "z"] = [-150.0, -120.0, -150.0]
    good = six_points("2/3", seed=4)
    oriented = orient_from_parallaxes(pd.concat([table, good]), BASE, method="gruber")
    assert oriented.failures["model_id"].tolist() == ["1/2"]
    reason = "its points make Gruber's procedure diverge: a pass multiplies errors by "
    assert oriented.failures["reason"].str.startswith(reason).all()
    assert oriented.failures["remedy"].tolist() == ['Use method="least_squares"']
    for values in (oriented.sigma_0, oriented.parameters.sum(axis=1, skipna=False)):
        assert values.isna().tolist() == [True, False]
    assert set(oriented.residuals["model_id"]) == {"2/3"}
    assert orient_from_parallaxes(table, BASE).failures.empty


@pytest.mark.parametrize("method", SIX_POINT_METHODS)
def test_singular_model_is_said_as_by_least_squares(method):
    a, h = 60.0, 152.0
    table = six_points("1/2", seed=5, relief=0.0).assign(z=-h)
    is_wing = table["y"] != 0.0
    table.loc[is_wing, "y"] = np.sign(table["y"]) * a
    table.loc[is_wing, "z"] = -0.5 * (h + np.sqrt(h**2 - 4.0 * a**2))
    oriented = orient_from_parallaxes(table, BASE, method=method)
    least = orient_from_parallaxes(table, BASE)
    pd.testing.assert_frame_equal(oriented.failures, least.failures)
    assert "dangerous surface" in oriented.failures["reason"].iloc[0]
    assert not oriented.is_usable
    assert "0 of 1 model oriented" in oriented.summary()


@pytest.mark.parametrize("case", CASES)
def test_gruber_leaves_the_contradiction_in_point_6(case):
    table = six_points("7/8", seed=6, relief=10.0)
    oriented = orient_from_parallaxes(table, BASE, case=case, method="gruber")
    residuals = oriented.residuals.set_index("point_id")
    np.testing.assert_allclose(residuals.loc[list("12345"), "residual"], 0, atol=1e-14)
    redundancy = residuals["redundancy_number"]
    np.testing.assert_allclose(redundancy, [0, 0, 0, 0, 0, 1], atol=1e-13)
    least = orient_from_parallaxes(table, BASE, case=case)
    assert oriented.sigma_0["7/8"] == pytest.approx(least.sigma_0["7/8"], rel=1e-12)
    # to the operator's six parallaxes this is where the procedure comes to rest
    rows = table.iloc[FROM_1_TO_6]
    design = design_matrix(rows[["x", "y", "z"]].to_numpy(), BASE, case)
    procedure = standard_procedure(design, case)
    record = run_procedure(procedure, design, rows["y_parallax"].to_numpy(), 60)
    found = oriented.parameters.loc["7/8"]
    np.testing.assert_allclose(found, record.elements[-1], rtol=1e-9, atol=1e-13)
    expected = stationary_covariance(pass_matrices(procedure, design))
    np.testing.assert_allclose(oriented.cofactor("7/8"), expected, rtol=1e-12)
    covariance = oriented.cofactor("7/8") * oriented.sigma_0["7/8"] ** 2
    pd.testing.assert_frame_equal(oriented.covariance("7/8"), covariance)


def test_flat_gruber_leaves_w_in_point_6_and_eleven_times_the_variance():
    table = six_points("7/8", seed=7, relief=0.0)
    oriented = orient_from_parallaxes(table, BASE, method="gruber")
    w = oriented.contradiction.loc["7/8", "w"]
    residual = oriented.residuals.set_index("point_id")["residual"]
    # w = 2 p1 - p3 - p5 - 2 p2 + p4 + p6 is p6 where the others are cleared
    assert residual["6"] == pytest.approx(-w)
    assert oriented.sigma_0["7/8"] == pytest.approx(abs(w) / np.sqrt(12.0))
    xyz = table[["x", "y", "z"]].to_numpy()
    design = design_matrix(xyz, BASE, INDEPENDENT)
    left = np.diag(design @ oriented.cofactor("7/8").to_numpy() @ design.T)
    np.testing.assert_allclose(left, [1, 1, 11, 1, 1, 11], rtol=1e-10)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("method", SIX_POINT_METHODS)
def test_parallaxes_without_errors_give_the_truth(case, method):
    table = six_points("7/8", seed=8)
    truth = np.array([1e-3, -2e-3, 1.5e-3, 5e-4, -1e-3])
    xyz = table[["x", "y", "z"]].to_numpy()
    table["y_parallax"] = design_matrix(xyz, BASE, case) @ truth
    oriented = orient_from_parallaxes(table, BASE, case=case, method=method)
    np.testing.assert_allclose(oriented.parameters.loc["7/8"], truth, atol=1e-12)


@pytest.mark.parametrize("method", SIX_POINT_METHODS)
def test_order_and_names_of_points_do_not_matter(method):
    table = pd.concat([six_points(f"m{k}", seed=k) for k in range(5)])
    mixed = table.sample(frac=1.0, random_state=3)
    mixed["point_id"] = [f"p{k}" for k in range(len(mixed))]
    one = orient_from_parallaxes(table, BASE, method=method)
    other = orient_from_parallaxes(mixed, BASE, method=method)
    pd.testing.assert_frame_equal(
        one.parameters, other.parameters.loc[one.parameters.index], rtol=1e-12
    )
    assert other.residuals["point_id"].tolist() == mixed["point_id"].tolist()


@pytest.mark.parametrize("method", ["least_squares", *SIX_POINT_METHODS])
def test_contradiction_of_six_points_in_the_two_planes(method, flight):
    oriented = orient_from_parallaxes(flight, BASE, method=method)
    said = oriented.contradiction
    assert said.index.name == "model_id"
    assert said.index.tolist() == oriented.parameters.index.tolist()
    assert said.columns.tolist() == [
        *("w", "d_omega_0", "d_omega_b", "delta_omega"),
        *("Y_0", "Z_0", "Y_b", "Z_b", "M_0", "M_b", "N_0", "N_b"),
    ]
    has_planes = said.notna().all(axis=1)
    assert sorted(has_planes[has_planes].index) == ["m0", "m1", "m2"]
    known = said.loc[["m0", "m1", "m2"]]
    sigma_0 = known["w"].abs() / np.sqrt(12.0)
    pd.testing.assert_series_equal(
        sigma_0, oriented.sigma_0[sigma_0.index], check_names=False, rtol=1e-10
    )
    np.testing.assert_allclose(
        known["delta_omega"], known["d_omega_0"] - known["d_omega_b"], rtol=1e-12
    )


def test_contradiction_where_no_tilt_shows():
    table = six_points("7/8", seed=9)
    xyz = table[["x", "y", "z"]].to_numpy()
    truth = np.array([0.0, 1e-3, -2e-3, 5e-4, 1e-3])
    table["y_parallax"] = design_matrix(xyz, BASE, INDEPENDENT) @ truth
    oriented = orient_from_parallaxes(table, BASE, method="krames")
    said = oriented.contradiction.loc["7/8"]
    zero = ["w", "d_omega_0", "d_omega_b", "delta_omega", "M_0", "M_b"]
    assert (said[zero] == 0.0).all()
    assert not np.isfinite(said[["Y_0", "Z_0", "Y_b", "Z_b"]]).any()
    np.testing.assert_allclose(oriented.parameters.loc["7/8"], truth, atol=1e-15)


def test_summary_names_the_method():
    table = six_points("7/8", seed=1)
    said = {
        "krames": "independent pair; Krames' formulas\n",
        "gruber": "; Gruber's procedure, tilt over-corrected in point 5\n",
    }
    for method, text in said.items():
        assert text in orient_from_parallaxes(table, BASE, method=method).summary()
