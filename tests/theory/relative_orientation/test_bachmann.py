"""Bachmann's covariances: closed forms, simulated operators, and no convergence."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.bachmann import (
    compare_errors,
    covariance_after_passes,
    covariance_of_consecutive_mean,
    covariance_of_independent_mean,
    pass_matrices,
    residual_covariance,
    stationary_covariance,
)
from einschalt.theory.relative_orientation.gruber import (
    Procedure,
    run_procedure,
    standard_procedure,
)
from einschalt.theory.relative_orientation.hallert import flat_cofactor, flat_six_points
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    DEPENDENT_LEFT,
    DEPENDENT_RIGHT,
    INDEPENDENT,
    design_matrix,
)
from einschalt.theory.relative_orientation.six_points import FROM_1_TO_6

BASE = 92.0
WIDE, SUPER_WIDE = (95.0, BASE, 152.0), (100.0, BASE, 88.0)
WINGS = {"5": 11.0, "6": 11.0, "mean": 8.0}
N_OPERATORS = 100_000


def flat_design(case, layout=WIDE):
    return design_matrix(flat_six_points(*layout)[FROM_1_TO_6], layout[1], case)


def hilly_design(case, seed=1):
    rng = np.random.default_rng(seed)
    xyz = flat_six_points(*WIDE)[FROM_1_TO_6]
    xyz[:, 1:] += rng.uniform(-15.0, 15.0, (6, 2))
    return design_matrix(xyz, BASE, case)


def remaining(design, covariance):
    return np.diagonal(residual_covariance(design, covariance), axis1=-2, axis2=-1)


def relative_difference(found, expected):
    """Difference of two covariances in units of the standard errors."""
    error = np.sqrt(np.diagonal(expected, axis1=-2, axis2=-1))
    error = np.where(error > 0.0, error, 1.0)
    return np.abs(found - expected) / (error[..., :, None] * error[..., None, :])


@pytest.mark.parametrize("layout", [WIDE, SUPER_WIDE])
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("tilt_at", WINGS)
def test_parallaxes_of_11_or_8_remain_however_often_it_is_repeated(
    case, tilt_at, layout
):
    design = flat_design(case, layout)
    procedure = standard_procedure(design, case, tilt_at=tilt_at)
    one_pass = pass_matrices(procedure, design)
    left = remaining(design, stationary_covariance(one_pass))
    np.testing.assert_allclose(left, [1, 1, 1, 1, *2 * [WINGS[tilt_at]]], rtol=1e-12)
    # T² = 0: without errors nothing is left after the second pass
    np.testing.assert_allclose(one_pass.T @ one_pass.T, 0.0, atol=1e-9)
    assert one_pass.spectral_radius < 1e-6
    assert not one_pass.diverges


@pytest.mark.parametrize("rel", [0.2, 2 / 3, 1.0, 1.5, 1.9])
@pytest.mark.parametrize("case", CASES)
def test_flat_closed_forms(case, rel):
    a, b, h = WIDE
    design = flat_design(case)
    procedure = standard_procedure(design, case, rel=rel)
    one_pass = pass_matrices(procedure, design)
    # a double zero of T's polynomial is found to the root of the machine's precision
    assert one_pass.eigenvalue.real == pytest.approx(1.0 - rel, rel=1e-9, abs=1e-6)
    P = stationary_covariance(one_pass)
    V = 6.0 * (h / (2.0 * a**2)) ** 2 * rel / (2.0 - rel)
    tip, swing = 2.0 * h**2 / a**2 + a**2 * V, 1.0 + h**2 * V
    if case == INDEPENDENT:
        expected = [V, tip / b**2, tip / b**2, swing / b**2, swing / b**2]
    else:
        expected = [V, 4.0 * h**2 / (a * b) ** 2, 2.0 / b**2, swing, tip]
    np.testing.assert_allclose(np.diag(P), expected, rtol=1e-10)
    wing = 5.0 + 6.0 * rel / (2.0 - rel)
    left = remaining(design, P)
    np.testing.assert_allclose(left, [1, 1, 1, 1, wing, wing], rtol=1e-10)


def test_cautious_over_correction_equals_least_squares_in_the_tilt():
    design = flat_design(INDEPENDENT)
    tilts = [
        stationary_covariance(
            pass_matrices(standard_procedure(design, INDEPENDENT, rel=rel), design)
        )[0, 0]
        for rel in (2 / 3, 1.5)
    ]
    least = flat_cofactor(*WIDE, INDEPENDENT)[0, 0]
    np.testing.assert_allclose(tilts, [least, 6.0 * least], rtol=1e-12)


def test_mean_errors_beside_least_squares():
    # dependent pair, one wing: √2, 2 and √3 times those of least squares
    design = flat_design(DEPENDENT_RIGHT)
    procedure = standard_procedure(design, DEPENDENT_RIGHT)
    P = stationary_covariance(pass_matrices(procedure, design))
    Q = flat_cofactor(*WIDE, DEPENDENT_RIGHT)
    ratio = np.sqrt(np.diag(P) / np.diag(Q))[:3]
    np.testing.assert_allclose(ratio, np.sqrt([2.0, 4.0, 3.0]), rtol=1e-12)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("rel", [0.5, 1.7])
def test_stationary_covariance_solves_its_equation(case, rel):
    design = hilly_design(case)
    one_pass = pass_matrices(standard_procedure(design, case, rel=rel), design)
    P = stationary_covariance(one_pass)
    fresh = one_pass.S @ one_pass.S.T
    by_vec = np.linalg.solve(
        np.eye(25) - np.kron(one_pass.T, one_pass.T), fresh.ravel()
    )
    assert relative_difference(by_vec.reshape(5, 5), P).max() < 1e-9
    assert relative_difference(one_pass.T @ P @ one_pass.T.T + fresh, P).max() < 1e-12
    assert relative_difference(P, P.T).max() < 1e-14


@pytest.mark.parametrize("case", CASES)
def test_many_passes_approach_the_stationary_covariance(case):
    design = hilly_design(case)
    procedure = standard_procedure(design, case, rel=0.6)
    after = covariance_after_passes(procedure, design, 80)
    stationary = stationary_covariance(pass_matrices(procedure, design))
    distance = relative_difference(after, np.broadcast_to(stationary, after.shape))
    assert distance[-1].max() < 1e-8
    assert distance[0].max() > distance[3].max() > distance[10].max()


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(
    ("tilt_at", "rel", "design_of"),
    [("5", 1.0, flat_design), ("mean", 1.0, hilly_design), ("6", 0.7, hilly_design)],
)
def test_simulated_operators_have_this_covariance(case, tilt_at, rel, design_of):
    design = design_of(case)
    procedure = standard_procedure(design, case, tilt_at=tilt_at, rel=rel)
    record = run_procedure(
        procedure,
        design,
        np.zeros((N_OPERATORS, 6)),
        n_passes=4,
        sigma=1.0,
        rng=np.random.default_rng(7),
    )
    expected = covariance_after_passes(procedure, design, 4)
    for passes in (0, 1, 4):
        found = record.elements[passes]
        found = found.T @ found / N_OPERATORS
        # 3 % asked for; a variance of 10⁵ values has 0.45 %
        assert relative_difference(found, expected[passes]).max() < 0.02
        left = np.mean(record.residual_parallaxes[passes] ** 2, axis=0)
        np.testing.assert_allclose(left, remaining(design, expected[passes]), rtol=0.02)


@pytest.mark.parametrize(("tilt_at", "rel"), [("5", 1.0), ("mean", 0.7)])
def test_simulated_means_have_this_covariance(tilt_at, rel):
    case, r, n_runs = DEPENDENT_LEFT, 5, 40_000
    design = flat_design(case)
    procedure = standard_procedure(design, case, tilt_at=tilt_at, rel=rel)
    rng = np.random.default_rng(8)
    record = run_procedure(
        procedure, design, np.zeros((n_runs, 6)), 30, sigma=1, rng=rng
    )
    one_pass = pass_matrices(procedure, design)
    consecutive = record.elements[-r:].mean(axis=0)
    found = consecutive.T @ consecutive / n_runs
    expected = covariance_of_consecutive_mean(one_pass, r)
    assert relative_difference(found, expected).max() < 0.03
    independent = record.elements[-1].reshape(-1, r, 5).mean(axis=1)
    found = independent.T @ independent / len(independent)
    expected = covariance_of_independent_mean(one_pass, r)
    # from a fifth of the values
    assert relative_difference(found, expected).max() < 4.0 * np.sqrt(2.0 * r / n_runs)


def test_means_of_repeated_orientations():
    # variances in points 5 and 6 of the mean of r, in closed form
    closed = {
        "5": lambda r: ([11 / r, 11 / r], [(r + 10) / r**2, 11 / r]),
        "mean": lambda r: ([8 / r, 8 / r], 2 * [(3 * r + 5) / r**2]),
    }
    design = flat_design(INDEPENDENT)
    for tilt_at, formulas in closed.items():
        procedure = standard_procedure(design, INDEPENDENT, tilt_at=tilt_at)
        one_pass = pass_matrices(procedure, design)
        for r in range(1, 13):
            independent = covariance_of_independent_mean(one_pass, r)
            consecutive = covariance_of_consecutive_mean(one_pass, r)
            for covariance, wings in zip(
                (independent, consecutive), formulas(r), strict=True
            ):
                expected = [*4 * [1 / r], *wings]
                np.testing.assert_allclose(
                    remaining(design, covariance), expected, rtol=1e-10
                )


def test_three_rather_five_repetitions():
    # Bachmann's "at least three, rather five or six": both wings, consecutive passes
    design = flat_design(INDEPENDENT)
    one_pass = pass_matrices(
        standard_procedure(design, INDEPENDENT, tilt_at="mean"), design
    )
    left = np.array(
        [
            remaining(design, covariance_of_consecutive_mean(one_pass, r))
            for r in range(1, 8)
        ]
    )
    within_rms = left.mean(axis=1) <= 1.0 + 1e-12
    within_all = left.max(axis=1) <= 1.0 + 1e-12
    assert 1 + np.argmax(within_rms) == 3
    assert 1 + np.argmax(within_all) == 5


@pytest.mark.parametrize(("tilt_at", "wing"), [("5", 11.0), ("mean", 8.0)])
def test_table_of_no_convergence(tilt_at, wing):
    design = flat_design(INDEPENDENT)
    procedure = standard_procedure(design, INDEPENDENT, tilt_at=tilt_at)
    table = compare_errors(procedure, design)
    assert table.passes == (1, 2, 5, 20)
    rows = np.sqrt(np.tile([1, 1, 1, 1, wing, wing], (4, 1)))
    np.testing.assert_allclose(table.after_passes, rows, rtol=1e-9)
    np.testing.assert_allclose(table.stationary, rows[0], rtol=1e-9)
    least = np.sqrt([2 / 3, 2 / 3, *4 * [11 / 12]])
    np.testing.assert_allclose(table.least_squares, least, rtol=1e-12)
    # in the wings more than σ remains, and more than least squares leave, for ever
    assert (table.after_passes[:, 4:] > 2.8).all()
    exaggerated = standard_procedure(design, INDEPENDENT, tilt_at=tilt_at, rel=1.5)
    assert (
        compare_errors(exaggerated, design).after_passes[-1, 4:] > np.sqrt(wing)
    ).all()


@pytest.mark.parametrize("rel", [2.0, 2.5, -0.1])
def test_divergence_is_said_and_does_not_stop_the_others(rel):
    design = np.stack([flat_design(INDEPENDENT)] * 2)
    procedure = standard_procedure(design, INDEPENDENT, rel=np.array([1.0, rel]))
    one_pass = pass_matrices(procedure, design)
    assert one_pass.diverges.tolist() == [False, True]
    np.testing.assert_allclose(one_pass.spectral_radius[1], abs(1.0 - rel), rtol=1e-9)
    for covariance in (
        stationary_covariance(one_pass),
        covariance_of_consecutive_mean(one_pass, 3),
        covariance_of_independent_mean(one_pass, 3),
    ):
        assert np.isfinite(covariance[0]).all()
        assert np.isnan(covariance[1]).all()
    limit = one_pass.limit(np.ones((2, 6)))
    assert np.isfinite(limit).all(axis=1).tolist() == [True, False]


def test_a_step_that_reads_nothing_of_its_element():
    # the right bundle's swing cannot be seen at the right centre
    design = flat_design(INDEPENDENT)
    steps = standard_procedure(design, INDEPENDENT).steps
    design = design.copy()
    design[0, 4] = 0.0
    one_pass = pass_matrices(Procedure(INDEPENDENT, steps), design)
    assert one_pass.diverges
    assert np.isnan(stationary_covariance(one_pass)).all()


def test_without_a_start_the_first_pass_begins_with_certainty():
    design = flat_design(INDEPENDENT)
    standard = standard_procedure(design, INDEPENDENT)
    bare = Procedure(INDEPENDENT, standard.steps)
    after = covariance_after_passes(bare, design, 1)
    assert (after[0] == 0.0).all()
    one_pass = pass_matrices(bare, design)
    np.testing.assert_allclose(after[1], one_pass.S @ one_pass.S.T, rtol=1e-12)
    assert one_pass.points == (5, 1, 2, 3, 4)
