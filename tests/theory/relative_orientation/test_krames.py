"""Krames' formulas: least squares for any terrain, and no division by a determinant."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.theory.relative_orientation.flat_model import flat_contradiction
from tests.theory.relative_orientation.krames_factors import (
    extended_formulas,
    flat_factors,
)

from einschalt.theory.relative_orientation.hallert import (
    LARGEST_CONDITION,
    adjust_parallaxes,
    flat_cofactor,
    flat_six_points,
)
from einschalt.theory.relative_orientation.krames import (
    contradiction,
    fundamental_points,
    plane_determinants,
    solve_krames,
    trial_swing,
)
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    DEPENDENT_RIGHT,
    INDEPENDENT,
    design_matrix,
)

LAYOUTS = [(95.0, 92.0, 152.0), (100.0, 92.0, 88.0), (1.0, 1.0, 1.5)]
N_TERRAINS = 1000


def hilly_models(seed, n_models=N_TERRAINS):
    """Six points of each model in the two planes, with a relief of 60 %."""
    rng = np.random.default_rng(seed)
    base = rng.uniform(60.0, 110.0, n_models)
    y = np.array([0.0, 90.0, -90.0] * 2) + rng.uniform(-25, 25, (n_models, 6))
    z = rng.uniform(-190.0, -100.0, (n_models, 6))
    x = base[:, None] * np.repeat([0.0, 1.0], 3)
    return np.stack([x, y, z], axis=-1), base, rng


def by_hallert(xyz, parallax, base, case):
    start = np.arange(0, 6 * len(base) + 1, 6)
    return adjust_parallaxes(
        xyz.reshape(-1, 3), parallax.ravel(), base, start, case=case
    )


def of_size(found, expected):
    """Largest difference of each model relative to its largest value."""
    axes = tuple(range(1, expected.ndim))
    return np.abs(found - expected).max(axis=axes) / np.abs(expected).max(axis=axes)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
@settings(max_examples=10, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(1e-4, 1.0))
def test_equals_least_squares_on_1000_terrains(case, seed, size):
    xyz, base, rng = hilly_models(seed)
    parallax = size * rng.normal(size=(len(base), 6))
    found = solve_krames(xyz, parallax, base, case)
    expected = by_hallert(xyz, parallax, base, case)
    good = expected.is_determined
    assert good.mean() > 0.99
    assert ((found.condition <= LARGEST_CONDITION) == good).all()
    # relative to its own standard error no element loses more than the condition
    error = np.sqrt(np.einsum("mii->mi", expected.cofactor[good]))
    tolerance = 1e-10
    assert of_size(found.elements[good], expected.elements[good]).max() < tolerance
    difference = np.abs(found.elements - expected.elements)[good]
    assert (difference / (size * error)).max() < tolerance
    scale = error[:, :, None] * error[:, None, :]
    difference = np.abs(found.cofactor - expected.cofactor)[good]
    assert (difference / scale).max() < tolerance
    for name in ("residuals", "redundancy_numbers"):
        difference = getattr(found, name)[good].ravel()
        difference = difference - getattr(expected, name).reshape(-1, 6)[good].ravel()
        assert np.abs(difference).max() < tolerance
    np.testing.assert_allclose(
        found.sigma_0[good], expected.sigma_0[good], rtol=0, atol=tolerance * size
    )
    np.testing.assert_allclose(found.condition[good], expected.condition[good], 1e-9)


@pytest.mark.parametrize("case", CASES)
def test_extended_formulas_give_the_same(case):
    xyz, base, rng = hilly_models(seed=2)
    parallax = rng.normal(scale=0.01, size=(len(base), 6))
    planes = plane_determinants(xyz)
    # the formulas as printed divide by N, so only planes that know of a tilt
    own_error = np.sqrt(planes.q / planes.N**2) * 150.0
    good = own_error.max(axis=1) < 50.0
    assert good.mean() > 0.9
    formulas = extended_formulas(planes, base, case)
    found = np.einsum("mij,mj->mi", formulas.solution, parallax)
    expected = solve_krames(xyz, parallax, base, case)
    assert of_size(found[good], expected.elements[good]).max() < 1e-10
    assert of_size(formulas.cofactor[good], expected.cofactor[good]).max() < 1e-10
    # own value + factor · Δω, as they are written
    delta = fundamental_points(planes, parallax).delta_omega
    as_written = np.einsum("mij,mj->mi", formulas.s, parallax)
    as_written = as_written + formulas.factors * delta[:, None]
    assert of_size(as_written[good], expected.elements[good]).max() < 1e-10


def test_own_values_are_those_of_the_fundamental_points():
    xyz, base, rng = hilly_models(seed=3)
    parallax = rng.normal(scale=0.01, size=(len(base), 6))
    planes = plane_determinants(xyz)
    own = fundamental_points(planes, parallax)
    formulas = extended_formulas(planes, base, INDEPENDENT)
    found = np.einsum("mij,mj->mi", formulas.s, parallax)
    turned = own.d_omega / base[:, None]
    expected = [
        own.d_omega.mean(axis=1),
        *(own.Y * turned).T[::-1],
        *(own.Z * turned).T[::-1],
    ]
    np.testing.assert_allclose(found, np.stack(expected, axis=1), rtol=1e-7)


def test_fundamental_point_lies_on_the_circle_of_zero_parallax():
    xyz, base, rng = hilly_models(seed=4)
    parallax = rng.normal(scale=0.01, size=(len(base), 6))
    planes = plane_determinants(xyz)
    own = fundamental_points(planes, parallax)
    Y, Z, d_omega = (each[..., None] for each in (own.Y, own.Z, own.d_omega))
    p = parallax.reshape(-1, 2, 3)
    # (1) as printed
    left = planes.y * Y + planes.z * Z + p * planes.z / d_omega
    np.testing.assert_allclose(left, planes.y**2 + planes.z**2, rtol=1e-7)
    # and as a distance below the perpendicular from G on the ray
    below = Z - planes.z + planes.y / planes.z * (Y - planes.y)
    np.testing.assert_allclose(p, -below * d_omega, atol=1e-9)


def test_dw_is_the_weighted_mean_of_both_planes():
    xyz, base, rng = hilly_models(seed=5)
    parallax = rng.normal(scale=0.01, size=(len(base), 6))
    planes = plane_determinants(xyz)
    weight = planes.N**2 / planes.q
    own = fundamental_points(planes, parallax).d_omega
    expected = (weight * own).sum(axis=1) / weight.sum(axis=1)
    found = solve_krames(xyz, parallax, base, INDEPENDENT)
    np.testing.assert_allclose(found.elements[:, 0], expected, rtol=1e-9, atol=1e-12)
    factor = extended_formulas(planes, base, INDEPENDENT).factors[:, 0]
    closed = (weight[:, 0] - weight[:, 1]) / (2.0 * weight.sum(axis=1))
    np.testing.assert_allclose(factor, closed, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_factors_of_flat_terrain(case, layout):
    xyz = flat_six_points(*layout)
    formulas = extended_formulas(plane_determinants(xyz), layout[1], case)
    closed = flat_factors(*layout, case)
    scale = np.abs(closed).max()
    np.testing.assert_allclose(formulas.factors / scale, closed / scale, atol=1e-14)
    cofactor = flat_cofactor(*layout, case)
    np.testing.assert_allclose(
        formulas.cofactor, cofactor, rtol=0, atol=1e-13 * np.abs(cofactor).max()
    )


@pytest.mark.parametrize("layout", LAYOUTS)
def test_contradiction_of_flat_terrain(layout):
    a, b, h = layout
    parallax = np.random.default_rng(6).normal(size=(20, 6))
    planes = plane_determinants(flat_six_points(a, b, h))
    w = contradiction(planes, parallax)
    np.testing.assert_allclose(w, flat_contradiction(parallax), atol=1e-13)
    delta = fundamental_points(planes, parallax).delta_omega
    np.testing.assert_allclose(delta, w * h / (2.0 * a**2), rtol=1e-9, atol=1e-15)


def test_elements_without_errors_come_out_exact():
    xyz, base, rng = hilly_models(seed=7, n_models=50)
    for case in CASES:
        truth = rng.normal(scale=1e-3, size=(50, 5))
        bases = np.broadcast_to(base[:, None], (50, 6))
        parallax = np.einsum("mpi,mi->mp", design_matrix(xyz, bases, case), truth)
        found = solve_krames(xyz, parallax, base, case)
        np.testing.assert_allclose(found.elements, truth, atol=1e-13)
        np.testing.assert_allclose(found.contradiction, 0.0, atol=1e-14)


@pytest.mark.parametrize("case", CASES)
def test_elements_stay_finite_where_the_fundamental_points_do_not(case):
    # without a tilt p z is a combination of y and z: M = 0 in both planes
    xyz, base = flat_six_points(95.0, 92.0, 152.0), 92.0
    truth = np.array([0.0, 1e-3, -2e-3, 5e-4, -1e-3])
    parallax = design_matrix(xyz, base, case) @ truth
    own = fundamental_points(plane_determinants(xyz), parallax)
    assert (own.M == 0.0).all()
    assert not np.isfinite(own.Y).any() or not np.isfinite(own.Z).any()
    assert not (np.isfinite(own.Y) & np.isfinite(own.Z)).any()
    found = solve_krames(xyz, parallax, base, case)
    np.testing.assert_allclose(found.elements, truth, atol=1e-15)


def test_no_parallax_at_all():
    xyz = flat_six_points(95.0, 92.0, 152.0)
    own = fundamental_points(plane_determinants(xyz), np.zeros(6))
    assert np.isnan(own.Y).all()
    assert (own.d_omega == 0.0).all()
    found = solve_krames(xyz, np.zeros(6), 92.0, INDEPENDENT)
    assert (found.elements == 0.0).all()
    assert found.sigma_0 == 0.0


def on_the_critical_circle(sides, off=0.0):
    """Wings of some planes on the circle through the centre and the middle point."""
    a, h = 60.0, 152.0
    xyz = flat_six_points(a, 92.0, h)
    depth = 0.5 * (h + np.sqrt(h**2 - 4.0 * a**2))
    for side in sides:
        xyz[3 * side + 1 : 3 * side + 3, 2] = -depth * (1.0 + off)
    return xyz


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-12, 1e-8, 1e-4])
def test_one_critical_plane_does_no_harm(case, side, off):
    xyz, base = on_the_critical_circle([side], off), np.array([92.0])
    planes = plane_determinants(xyz)
    if off == 0.0:
        assert planes.N[side] == 0.0
        assert not np.isfinite(extended_formulas(planes, 92.0, case).factors).all()
    parallax = np.random.default_rng(8).normal(scale=0.01, size=(1, 6))
    found = solve_krames(xyz[None], parallax, base, case)
    expected = by_hallert(xyz[None], parallax, base, case)
    assert of_size(found.elements, expected.elements) < 1e-10
    assert of_size(found.cofactor, expected.cofactor) < 1e-10
    np.testing.assert_allclose(found.sigma_0, expected.sigma_0, rtol=1e-10)
    # only the other plane knows of the tilt
    own = fundamental_points(planes, parallax[0]).d_omega[1 - side]
    if off <= 1e-8:
        np.testing.assert_allclose(found.elements[0, 0], own, rtol=1e-6)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(
    "xyz",
    [
        on_the_critical_circle([0, 1]),
        on_the_critical_circle([0, 1], off=1e-9),
        flat_six_points(95.0, 92.0, 152.0) * [[1.0, 0.0, 1.0]],
        np.add(flat_six_points(0.0, 92.0, 152.0), [[0.0, 5.0, 0.0]]),
    ],
    ids=["two_circles", "nearly", "y_0", "three_points_in_one"],
)
def test_two_critical_planes_are_said_and_do_not_stop_the_others(case, xyz):
    good = flat_six_points(95.0, 92.0, 152.0)
    parallax = np.random.default_rng(9).normal(scale=0.01, size=(2, 6))
    found = solve_krames(np.stack([xyz, good]), parallax, np.full(2, 92.0), case)
    assert found.condition[0] > LARGEST_CONDITION
    alone = solve_krames(good, parallax[1], 92.0, case)
    for name in ("elements", "cofactor", "sigma_0", "residuals", "redundancy_numbers"):
        assert np.isnan(getattr(found, name)[0]).all()
        np.testing.assert_allclose(getattr(found, name)[1], getattr(alone, name), 1e-13)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_trial_formula_9_is_a_difference_of_two_parallaxes_in_flat_terrain(layout):
    parallax = np.random.default_rng(10).normal(scale=0.01, size=(200, 6))
    xyz, base = flat_six_points(*layout), layout[1]
    found = trial_swing(plane_determinants(xyz), parallax, base)
    expected = (parallax[:, 0] - parallax[:, 3]) / base
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_trial_formula_9_has_a_standard_error_of_sqrt_3():
    a, b, h = LAYOUTS[0]
    n_trials = 200_000
    parallax = np.random.default_rng(11).normal(size=(n_trials, 6))
    found = trial_swing(plane_determinants(flat_six_points(a, b, h)), parallax, b)
    least = flat_cofactor(a, b, h, DEPENDENT_RIGHT)[2, 2]
    np.testing.assert_allclose(
        np.std(found) / np.sqrt(least), np.sqrt(3.0), rtol=4.0 / np.sqrt(2.0 * n_trials)
    )
    assert np.isnan(
        trial_swing(plane_determinants(flat_six_points(a, b, h)), np.zeros(6), b)
    )


def test_misprint_after_equation_4():
    # with the numerators as printed (U, of Y, in place of V, of Z) nothing agrees
    xyz, base, _ = hilly_models(seed=12, n_models=1)
    truth = np.array([1e-3, -2e-3, 1.5e-3, 4.0, -3.0]) * 1e-1
    bases = np.full((1, 6), base[0])
    parallax = design_matrix(xyz, bases, DEPENDENT_RIGHT)[0] @ truth
    planes = plane_determinants(xyz[0])
    by_plane = parallax.reshape(2, 3)
    U, V = ((row * by_plane).sum(axis=1) for row in (planes.u, planes.v))
    corrected = (V[1] / planes.N[1] - V[0] / planes.N[0]) / base[0]
    printed = (U[1] / planes.N[1] - U[0] / planes.N[0]) / base[0]
    assert corrected == pytest.approx(truth[2], rel=1e-9)
    assert abs(printed - truth[2]) > 0.1 * abs(truth[2])
