"""Kasper and Waldhäusl: planes, valleys, ruled quadrics.

The figures come from an independent computation; definitions and tolerance stand in
the file.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from einschalt.stages.relative_orientation.dangerous_surface import (
    HEIGHTS,
    FlightPlan,
    forecast_dangerous_surfaces,
)
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)
from einschalt.theory.relative_orientation.base_normal_planes import (
    examine_planes,
)
from einschalt.theory.relative_orientation.dangerous_surfaces import (
    examine_surfaces,
    gaps_to_surface,
    singular_values,
)
from einschalt.theory.relative_orientation.valley_flights import (
    critical_depth,
)

CASES = json.loads(
    (Path(__file__).parent / "cases" / "part2_critical.json").read_text("utf-8")
)
CASE_OF = {"ind": "independent", "dep1": "dependent_left", "dep2": "dependent_right"}
RTOL = CASES["tolerance_rel"]
VALLEYS = CASES["valley"]


def assert_close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=RTOL, atol=1e-12)


@pytest.mark.parametrize("case", CASES["planes"], ids=lambda case: case["name"])
def test_kasper_in_one_plane(case):
    points, expected = np.array(case["points"], dtype=float), case["expected"]
    found = examine_planes(points)
    assert_close(found.circle_end, [expected["Y"], expected["Z"]])
    assert_close(found.circle_end / 2, expected["circle_centre"])
    assert_close(found.circle_radius, expected["circle_radius"])
    assert_close(found.intersection, expected["S"])
    assert_close(found.over_correction_k, expected["k"])
    assert_close(found.over_correction_k, expected["k_from_heights"])
    assert_close(found.over_correction_k, expected["d_0S"] / expected["a_S5"])
    assert_close(found.over_correction_n, expected["n"])
    assert_close(found.determinant, expected["N"])
    assert_close(found.gap, expected["gap_i"])
    assert_close(found.sigma_omega, expected["sigma_omega"])
    assert_close(found.determinant**2 / found.weight, expected["q"])
    squares = np.sum(points**2, axis=1).prod()
    # inverted in the centre, points on a circle through it lie on a line
    inverted = np.column_stack(
        [points / np.sum(points**2, axis=1)[:, None], np.ones(3)]
    )
    assert_close(squares * np.linalg.det(inverted), found.determinant)


@pytest.fixture(scope="module")
def all_valleys():
    xyz = np.concatenate([np.array(case["points"], float) for case in VALLEYS])
    base = np.array([case["b"] for case in VALLEYS])
    return xyz, base, 6 * np.arange(len(VALLEYS) + 1)


def expected_of_valleys(name):
    return np.array([case["expected"][name] for case in VALLEYS])


def test_all_valleys_at_once(all_valleys):
    found = examine_surfaces(*all_valleys)
    # the file says 1e-7 for the closed form of the inflation
    np.testing.assert_allclose(
        found.inflation, expected_of_valleys("inflation"), rtol=1e-7
    )
    assert_close(found.sigma_omega, expected_of_valleys("sigma_omega_LS"))
    for plane in (0, 1):
        planes = found.planes
        assert_close(planes.over_correction_n[:, plane], expected_of_valleys("n"))
        assert_close(planes.over_correction_k[:, plane], expected_of_valleys("k"))
        assert_close(planes.determinant[:, plane], expected_of_valleys("N"))
        assert_close(planes.gap[:, plane], expected_of_valleys("gap_i"))
        assert_close(
            planes.sigma_omega[:, plane], expected_of_valleys("sigma_omega_plane")
        )


@pytest.mark.parametrize("short", CASE_OF)
def test_singular_values_of_valleys(all_valleys, short):
    xyz, base, start = all_valleys
    expected = np.array([c["expected"]["singular_values"][short] for c in VALLEYS])
    depth = np.array([case["h"] for case in VALLEYS])
    assert_close(singular_values(xyz, base, start, depth, CASE_OF[short]), expected)
    found = examine_surfaces(xyz, base, start, case=CASE_OF[short])
    assert_close(found.singular_value, expected[:, -1])


def test_critical_depths_of_valleys():
    wing = np.array([case["tan_beta"] for case in VALLEYS])
    assert_close(critical_depth(wing, 1.0), expected_of_valleys("critical_delta"))


def test_valleys_before_the_flight():
    # the same valleys as terrain heights, flown 1520 m above the middle
    for tan_beta in {case["tan_beta"] for case in VALLEYS}:
        cases = [case for case in VALLEYS if case["tan_beta"] == tan_beta]
        heights = [[500.0] * 2 + [500.0 + 1520.0 * c["delta"]] * 4 for c in cases]
        table = pd.DataFrame(heights, columns=HEIGHTS)
        table["model_id"] = [str(number) for number in range(len(cases))]
        plan = FlightPlan(
            principal_distance=0.1 / tan_beta, flying_height=1520.0, wing=0.1
        )
        models = forecast_dangerous_surfaces(table, plan).models
        for name, column, rtol in (
            ("inflation", "inflation", 1e-7),
            ("n", "over_correction_n", RTOL),
            ("k", "over_correction_k", RTOL),
            ("gap_i", "gap", RTOL),
        ):
            expected = [case["expected"][name] for case in cases]
            np.testing.assert_allclose(models[column], expected, rtol=rtol, atol=1e-12)
        assert_close(models["valley_depth"], [1520.0 * c["delta"] for c in cases])
        assert_close(
            models["critical_depth"],
            [1520.0 * c["expected"]["critical_delta"] for c in cases],
        )


@pytest.mark.parametrize(
    "case", CASES["quadrics"], ids=lambda case: f"{case['name']}-{case['case']}"
)
def test_ruled_quadrics(case):
    xyz, base = np.array(case["points"]), np.array([case["b"]])
    start, kind = np.array([0, len(xyz)]), CASE_OF[case["case"]]
    expected = case["expected"]
    values = singular_values(xyz, base, start, np.array([expected["h_scale"]]), kind)
    np.testing.assert_allclose(
        values[0], expected["singular_values"], rtol=RTOL, atol=1e-15
    )
    found = examine_surfaces(xyz, base, start, case=kind)
    if case["name"].endswith("plus_5"):
        assert found.verdict.names[0] == "weak"
        return
    assert found.verdict.names[0] == "critical"
    surface = found.surface[0]
    np.testing.assert_allclose(surface / surface[0], case["coef"], atol=1e-9)
    np.testing.assert_allclose(gaps_to_surface(xyz, base, surface), 0.0, atol=1e-12)


@pytest.mark.parametrize("case", CASES["layouts"], ids=lambda case: f"a{case['a']}")
def test_flat_layouts(case):
    xyz, base = np.array(case["points"], dtype=float), np.array([case["b"]])
    start = np.array([0, 6])
    for short, kind in CASE_OF.items():
        values = singular_values(xyz, base, start, np.array([case["h"]]), kind)
        assert_close(values[0], case["expected"][short])
    found = examine_surfaces(xyz, base, start)
    assert_close(found.inflation, 1.0)
    assert_close(found.singular_value_ratio, 1.0)


@pytest.mark.parametrize("kind", CASE_OF.values())
def test_verdicts_of_measured_valleys(kind):
    tables = [
        pd.DataFrame(case["points"], columns=["x", "y", "z"]).assign(
            model_id=f"{case['name']}, {case['delta']}", point_id=list("123456")
        )
        for case in VALLEYS
    ]
    parallaxes = pd.concat(tables, ignore_index=True).assign(y_parallax=0.0)
    surfaces = orient_from_parallaxes(parallaxes, 92.0, case=kind).dangerous_surface
    np.testing.assert_allclose(
        surfaces["inflation"], expected_of_valleys("inflation"), rtol=1e-7
    )
    inflation = expected_of_valleys("inflation") * (1.0 + 1e-9)
    limits = [inflation >= 10.0, inflation >= 2.0]
    expected = np.select(limits, ["critical", "weak"], "safe")
    assert surfaces["verdict"].tolist() == expected.tolist()
    assert_close(surfaces["over_correction_n"], expected_of_valleys("n"))
    assert_close(surfaces["n_0"], expected_of_valleys("N"))
