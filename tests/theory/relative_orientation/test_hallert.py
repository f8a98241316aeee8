"""Hallert's least squares on minimal, redundant and critical figures of points."""

import numpy as np
import pytest
from tests.theory.relative_orientation.flat_model import (
    FLAT_CONTRADICTION,
    flat_contradiction,
    flat_solution_matrix,
)

from einschalt.theory.relative_orientation.hallert import (
    adjust_parallaxes,
    flat_cofactor,
    flat_six_points,
)
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    DEPENDENT_LEFT,
    DEPENDENT_RIGHT,
    INDEPENDENT,
    design_matrix,
    independent_from_dependent,
)

BASE = 92.0
SIGMA = 0.005


def hilly_points(n_points, seed):
    rng = np.random.default_rng(seed)
    return rng.uniform([-5, -95, -190], [97, 95, -110], size=(n_points, 3))


def adjust_one(xyz, parallax, case, base=BASE):
    start = np.array([0, len(xyz)])
    return adjust_parallaxes(xyz, parallax, np.array([base]), start, case=case)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("n_points", [5, 6, 9, 15, 60])
def test_equals_dense_least_squares(case, n_points):
    xyz = hilly_points(n_points, seed=n_points)
    rng = np.random.default_rng(7)
    truth = rng.normal(scale=1e-3, size=5)
    design = design_matrix(xyz, BASE, case)
    parallax = design @ truth + rng.normal(scale=SIGMA, size=n_points)
    found = adjust_one(xyz, parallax, case)

    elements, *_ = np.linalg.lstsq(design, parallax)
    cofactor = np.linalg.inv(design.T @ design)
    residuals = design @ elements - parallax
    leverage = np.einsum("ni,ij,nj->n", design, cofactor, design)
    # a condition of 100 leaves 12 digits to lstsq, its square 10 to the inverse
    np.testing.assert_allclose(found.elements[0], elements, rtol=1e-9, atol=1e-13)
    scale = np.sqrt(np.diag(cofactor))
    np.testing.assert_allclose(
        found.cofactor[0] / np.outer(scale, scale),
        cofactor / np.outer(scale, scale),
        atol=1e-8,
    )
    np.testing.assert_allclose(found.residuals, residuals, atol=1e-11)
    np.testing.assert_allclose(found.redundancy_numbers, 1.0 - leverage, atol=1e-8)
    assert found.redundancy[0] == n_points - 5
    assert found.is_determined[0]
    if n_points > 5:
        sigma_0 = np.sqrt(residuals @ residuals / (n_points - 5))
        np.testing.assert_allclose(found.sigma_0, sigma_0, rtol=1e-9)
        np.testing.assert_allclose(found.redundancy_numbers.sum(), n_points - 5)


def test_five_points_have_no_sigma_0():
    found = adjust_one(hilly_points(5, seed=1), np.arange(5.0) / 100, INDEPENDENT)
    assert np.isnan(found.sigma_0[0])
    np.testing.assert_allclose(found.residuals, 0.0, atol=1e-14)
    np.testing.assert_allclose(found.redundancy_numbers, 0.0, atol=1e-13)


@pytest.fixture
def flight():
    """Thirty hilly models of 0 to 40 points."""
    rng = np.random.default_rng(11)
    count = rng.integers(0, 40, size=30)
    xyz = hilly_points(count.sum(), seed=12)
    parallax = rng.normal(scale=SIGMA, size=count.sum())
    return xyz, parallax, rng.uniform(85, 95, size=30), np.append(0, count.cumsum())


@pytest.mark.parametrize("case", CASES)
def test_one_model_alone_equals_the_same_model_among_many(case, flight):
    xyz, parallax, base, start = flight
    together = adjust_parallaxes(xyz, parallax, base, start, case=case)
    for model in range(len(base)):
        rows = slice(start[model], start[model + 1])
        alone = adjust_one(xyz[rows], parallax[rows], case, base=base[model])
        for name in ("elements", "cofactor", "sigma_0", "condition"):
            np.testing.assert_allclose(
                getattr(alone, name)[0], getattr(together, name)[model], rtol=1e-13
            )
        np.testing.assert_array_equal(alone.residuals, together.residuals[rows])
    assert (together.is_determined == (np.diff(start) >= 5)).all()


@pytest.mark.parametrize("case", CASES)
def test_order_of_points_does_not_matter(case):
    xyz = hilly_points(15, seed=3)
    parallax = np.random.default_rng(4).normal(scale=SIGMA, size=15)
    mixed = np.random.default_rng(5).permutation(15)
    one, other = (
        adjust_one(xyz, parallax, case),
        adjust_one(xyz[mixed], parallax[mixed], case),
    )
    np.testing.assert_allclose(one.elements, other.elements, rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(one.residuals[mixed], other.residuals, atol=1e-13)


@pytest.mark.parametrize("case", CASES)
def test_unit_of_length_does_not_matter(case):
    xyz = hilly_points(9, seed=6)
    parallax = np.random.default_rng(6).normal(scale=SIGMA, size=9)
    in_mm = adjust_one(xyz, parallax, case)
    in_m = adjust_one(xyz * 1e-3, parallax * 1e-3, case, base=BASE * 1e-3)
    n_angles = 5 if case == INDEPENDENT else 3
    np.testing.assert_allclose(
        in_m.elements[0, :n_angles], in_mm.elements[0, :n_angles], rtol=1e-9
    )
    np.testing.assert_allclose(
        in_m.elements[0, n_angles:], 1e-3 * in_mm.elements[0, n_angles:], rtol=1e-9
    )
    np.testing.assert_allclose(in_m.condition, in_mm.condition, rtol=1e-9)


@pytest.mark.parametrize(
    ("case", "sign"), [(DEPENDENT_LEFT, 1.0), (DEPENDENT_RIGHT, -1.0)]
)
def test_independent_and_dependent_orient_the_same_model(case, sign):
    xyz = hilly_points(12, seed=8)
    parallax = np.random.default_rng(8).normal(scale=SIGMA, size=12)
    independent = adjust_one(xyz, parallax, INDEPENDENT)
    dependent = adjust_one(xyz, sign * parallax, case)
    turn = np.linalg.inv(independent_from_dependent(BASE, case))
    np.testing.assert_allclose(
        dependent.elements[0], turn @ independent.elements[0], rtol=1e-9, atol=1e-13
    )
    np.testing.assert_allclose(
        dependent.cofactor[0],
        turn @ independent.cofactor[0] @ turn.T,
        atol=1e-9 * np.abs(dependent.cofactor).max(),
    )
    np.testing.assert_allclose(dependent.sigma_0, independent.sigma_0, rtol=1e-10)


def test_elements_spread_as_their_cofactors_say():
    xyz, n_models = hilly_points(12, seed=9), 4000
    parallax = np.random.default_rng(9).normal(scale=SIGMA, size=12 * n_models)
    found = adjust_parallaxes(
        np.tile(xyz, (n_models, 1)),
        parallax,
        np.full(n_models, BASE),
        np.arange(0, 12 * n_models + 1, 12),
        case=INDEPENDENT,
    )
    spread = np.sqrt(np.mean(found.elements**2, axis=0))
    expected = SIGMA * np.sqrt(np.diag(found.cofactor[0]))
    # a standard deviation from 4000 values has 1.1 %; four times that is allowed
    np.testing.assert_allclose(spread, expected, rtol=4 / np.sqrt(2 * n_models))
    pooled = np.sqrt(np.mean(found.sigma_0**2))
    np.testing.assert_allclose(pooled, SIGMA, rtol=4 / np.sqrt(2 * 7 * n_models))


def points_on_a_line():
    share = np.linspace(0.0, 1.0, 9)[:, None]
    return np.array([10.0, -80.0, -150.0]) + share * np.array([70.0, 150.0, 20.0])


def points_on_a_cylinder_through_the_base():
    rng = np.random.default_rng(10)
    angle = rng.uniform(-0.8, 0.8, size=20)
    circle = 80.0 * np.array([np.sin(angle), -1.0 - np.cos(angle)])
    return np.column_stack([rng.uniform(0.0, BASE, size=20), *circle])


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(
    "xyz",
    [
        points_on_a_line(),
        points_on_a_cylinder_through_the_base(),
        np.tile([40.0, 30.0, -150.0], (8, 1)),
        np.column_stack([np.linspace(0, BASE, 7), np.zeros(7), np.full(7, -152.0)]),
        points_on_a_cylinder_through_the_base().round(3),
        flat_six_points(95.0, BASE, 152.0)[:4],
    ],
    ids=["line", "cylinder", "one_place", "y_0", "cylinder_to_1_um", "four_points"],
)
def test_points_that_determine_nothing_do_not_stop_the_others(case, xyz):
    good = hilly_points(9, seed=13)
    parallax = np.random.default_rng(13).normal(scale=SIGMA, size=9 + len(xyz))
    found = adjust_parallaxes(
        np.vstack([xyz, good]),
        parallax,
        np.full(2, BASE),
        np.array([0, len(xyz), len(xyz) + 9]),
        case=case,
    )
    assert found.is_determined.tolist() == [False, True]
    for name in ("elements", "cofactor", "sigma_0"):
        assert np.isnan(getattr(found, name)[0]).all()
        assert np.isfinite(getattr(found, name)[1]).all()
    assert np.isnan(found.residuals[: len(xyz)]).all()
    assert np.isfinite(found.residuals[len(xyz) :]).all()


def test_one_critical_plane_alone_is_harmless():
    # the circle through the base and points 1, 3, 5 does not pass through 2, 4, 6
    h, a = 152.0, 60.0
    depth = 0.5 * (h + np.sqrt(h**2 - 4.0 * a**2))
    xyz = flat_six_points(a, BASE, h)
    xyz[1:3, 2] = -depth
    design = design_matrix(xyz, BASE, INDEPENDENT)
    truth = np.array([1e-3, -2e-3, 1.5e-3, 5e-4, -1e-3])
    plane = design[:3] @ np.linalg.qr(design[:3].T)[0]
    assert np.linalg.cond(plane) > 1e12
    found = adjust_one(xyz, design @ truth, INDEPENDENT)
    np.testing.assert_allclose(found.elements[0], truth, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(
    ("half_width", "base", "height"), [(95.0, 92.0, 152.0), (110.0, 92.0, 88.0)]
)
def test_flat_closed_forms_equal_the_adjustment(case, half_width, base, height):
    xyz = flat_six_points(half_width, base, height)
    parallax = np.random.default_rng(14).normal(scale=SIGMA, size=6)
    found = adjust_one(xyz, parallax, case, base=base)
    contradiction = flat_contradiction(parallax)
    np.testing.assert_allclose(
        found.residuals, -contradiction / 12 * FLAT_CONTRADICTION, atol=1e-13
    )
    np.testing.assert_allclose(found.sigma_0, abs(contradiction) / np.sqrt(12))
    cofactor = flat_cofactor(half_width, base, height, case)
    scale = np.sqrt(np.diag(cofactor))
    np.testing.assert_allclose(
        found.cofactor[0] / np.outer(scale, scale),
        cofactor / np.outer(scale, scale),
        atol=1e-12,
    )
    np.testing.assert_allclose(
        found.elements[0],
        flat_solution_matrix(half_width, base, height, case) @ parallax,
        atol=1e-12,
    )
