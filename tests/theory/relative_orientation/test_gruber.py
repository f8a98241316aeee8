"""Gruber's procedure, step by step: what it clears, and where it comes to rest."""

import numpy as np
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.theory.relative_orientation.bachmann import pass_matrices
from einschalt.theory.relative_orientation.gruber import (
    Procedure,
    Step,
    elimination,
    over_correction,
    run_procedure,
    standard_procedure,
)
from einschalt.theory.relative_orientation.hallert import flat_six_points
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    DEPENDENT_LEFT,
    DEPENDENT_RIGHT,
    ELEMENTS,
    INDEPENDENT,
    design_matrix,
)
from einschalt.theory.relative_orientation.six_points import FROM_1_TO_6

BASE = 92.0
WIDE, SUPER_WIDE = (95.0, BASE, 152.0), (100.0, BASE, 88.0)
TILT_AT = ["5", "6", "mean"]


def flat_design(case, layout=WIDE):
    return design_matrix(flat_six_points(*layout)[FROM_1_TO_6], layout[1], case)


def hilly_designs(case, n_models, seed=1, relief=20.0):
    rng = np.random.default_rng(seed)
    xyz = np.tile(flat_six_points(*WIDE)[FROM_1_TO_6], (n_models, 1, 1))
    xyz[..., 1] += rng.uniform(-5.0, 5.0, (n_models, 6))
    xyz[..., 2] += rng.uniform(-relief, relief, (n_models, 6))
    return design_matrix(xyz, BASE, case), rng


def some_elements(case, rng=None):
    rng = rng or np.random.default_rng(2)
    scale = np.ones(5) if case == INDEPENDENT else np.array([1, 1, 1, 150.0, 150.0])
    return 1e-3 * rng.normal(size=5) * scale


@pytest.mark.parametrize("case", CASES)
def test_each_step_of_the_elimination_clears_its_point(case):
    design = flat_design(case)
    residual = np.random.default_rng(3).normal(size=6)
    cleared = []
    for step in elimination(case):
        one = Procedure(case, (step,))
        residual = run_procedure(one, design, residual, 1).residual_parallaxes[1]
        cleared += [point - 1 for point in step.observed]
        np.testing.assert_allclose(residual[cleared], 0.0, atol=1e-14)
    assert sorted(cleared) == [0, 1, 2, 3]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("tilt_at", TILT_AT)
@pytest.mark.parametrize("layout", [WIDE, SUPER_WIDE, (1.0, 0.92, 1.52)])
def test_flat_model_without_errors_is_clear_after_one_pass(case, tilt_at, layout):
    design = flat_design(case, layout)
    truth = some_elements(case)
    procedure = standard_procedure(design, case, tilt_at=tilt_at)
    record = run_procedure(procedure, design, design @ truth, 2)
    assert np.abs(record.residual_parallaxes[0, 4:]).max() > 1e-4
    np.testing.assert_allclose(record.residual_parallaxes[1:], 0.0, atol=1e-13)
    np.testing.assert_allclose(record.elements[1], truth, atol=1e-13)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("tilt_at", TILT_AT)
@pytest.mark.parametrize("layout", [WIDE, SUPER_WIDE, (95.0, BASE, 95.0)])
def test_over_correction_of_flat_terrain(case, tilt_at, layout):
    a, _, h = layout
    n = over_correction(flat_design(case, layout), case, tilt_at=tilt_at)
    assert n == pytest.approx((1.0 + h**2 / a**2) / 2.0, rel=1e-13)
    # the extra over-correction k turns negative where the height is below a
    assert np.sign(np.round(n - 1.0, 12)) == np.sign(h - a)


@pytest.mark.parametrize("layout", [WIDE, SUPER_WIDE])
def test_tilt_drives_the_wing_to_minus_k_times_its_parallax(layout):
    case = INDEPENDENT
    design = flat_design(case, layout)
    procedure = standard_procedure(design, case)
    cleared = run_procedure(procedure, design, design @ some_elements(case), 0)
    before = cleared.residual_parallaxes[0]
    turn = Procedure(case, procedure.steps[:1])
    after = run_procedure(turn, design, before, 1).residual_parallaxes[1]
    k = procedure.steps[0].over_correction - 1.0
    assert after[4] == pytest.approx(-k * before[4], rel=1e-12)


def test_over_correction_of_hilly_terrain_is_that_of_the_plane():
    # n = r5² (y1 z3 - z1 y3)/N with the points of the left plane only, where point 1
    # is at the nadir and the planes are those of the projection centres
    xyz = flat_six_points(*WIDE)[FROM_1_TO_6]
    xyz[[2, 4], 1:] = [[92.0, -131.0], [-101.0, -160.0]]
    xyz[[3, 5], 1:] = [[88.0, -170.0], [-99.0, -148.0]]
    for case in CASES:
        design = design_matrix(xyz, BASE, case)
        for at, wing, other in (("5", 4, (0, 2)), ("6", 5, (1, 3))):
            (y, z), r2 = xyz[[*other, wing], 1:].T, (xyz[wing, 1:] ** 2).sum()
            N = np.linalg.det(np.stack([y, z, y**2 + z**2], axis=1))
            expected = r2 * (y[0] * z[1] - z[0] * y[1]) / N
            n = over_correction(design, case, tilt_at=at)
            assert n == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("tilt_at", TILT_AT)
def test_hilly_models_come_to_rest_at_the_limit(case, tilt_at):
    design, rng = hilly_designs(case, n_models=40)
    parallax = rng.normal(scale=0.01, size=(40, 6))
    procedure = standard_procedure(design, case, tilt_at=tilt_at)
    one_pass = pass_matrices(procedure, design)
    assert not one_pass.diverges.any()
    record = run_procedure(procedure, design, parallax, 400)
    limit = one_pass.limit(parallax)
    np.testing.assert_allclose(record.elements[-1], limit, rtol=1e-9, atol=1e-12)
    # at rest every step reads zero
    residual = record.residual_parallaxes[-1]
    tilt = residual[:, [4, 5]] @ {"5": [1, 0], "6": [0, 1], "mean": [0.5, 0.5]}[tilt_at]
    np.testing.assert_allclose(residual[:, :4], 0.0, atol=1e-11)
    np.testing.assert_allclose(tilt, 0.0, atol=1e-11)
    # the record keeps the balance: residual = measured - A · elements, in every pass
    balance = parallax - np.einsum("mpi,kmi->kmp", design, record.elements)
    np.testing.assert_allclose(record.residual_parallaxes, balance, atol=1e-11)


@pytest.mark.parametrize("case", CASES)
def test_one_model_alone_equals_the_same_model_among_many(case):
    design, rng = hilly_designs(case, n_models=7, seed=4)
    parallax = rng.normal(scale=0.01, size=(7, 6))
    together = run_procedure(
        standard_procedure(design, case), design, parallax, n_passes=3
    )
    for model in range(7):
        alone = run_procedure(
            standard_procedure(design[model], case), design[model], parallax[model], 3
        )
        np.testing.assert_array_equal(alone.elements, together.elements[:, model])


@pytest.mark.parametrize(("rel", "factor"), [(2 / 3, 1 / 3), (1.5, 0.5), (2.0, 1.0)])
def test_wrong_over_correction_leaves_a_part_of_the_error(rel, factor):
    case = DEPENDENT_RIGHT
    design = flat_design(case)
    procedure = standard_procedure(design, case, rel=rel)
    record = run_procedure(procedure, design, design @ some_elements(case), 6)
    left = np.abs(record.residual_parallaxes[:, 4])
    np.testing.assert_allclose(left[1:] / left[:-1], factor, rtol=1e-9)
    assert pass_matrices(procedure, design).diverges == (rel >= 2.0)


def test_readings_have_errors_of_their_own():
    case = DEPENDENT_LEFT
    design = flat_design(case)
    procedure = standard_procedure(design, case, tilt_at="mean")
    rng = np.random.default_rng(5)
    record = run_procedure(
        procedure, design, np.zeros((20_000, 6)), 1, sigma=3, rng=rng
    )
    residual = record.residual_parallaxes[-1]
    # the last reading was in point 4; a mean of two has its error over √2
    assert residual[:, 3].std() == pytest.approx(3.0, rel=0.02)
    assert residual[:, 4:].mean(axis=1).std() > 3.0
    again = run_procedure(
        procedure,
        design,
        np.zeros((20_000, 6)),
        1,
        sigma=3,
        rng=np.random.default_rng(5),
    )
    np.testing.assert_array_equal(record.elements, again.elements)


def test_procedure_of_ones_own():
    # Gauss-Seidel on nine points, each element by the mean of three of them
    rng = np.random.default_rng(6)
    xyz = rng.uniform([-5, -95, -170], [97, 95, -130], (9, 3))
    xyz[:3, 0], xyz[3:6, 0], xyz[6:, 0] = 0.0, BASE / 2, BASE
    design = design_matrix(xyz, BASE, DEPENDENT_RIGHT)
    steps = [
        Step(element, dict.fromkeys(np.argsort(column)[-3:] + 1, 1 / 3), 0.5)
        for element, column in zip(
            ELEMENTS[DEPENDENT_RIGHT], np.abs(design).T, strict=True
        )
    ]
    procedure = Procedure(DEPENDENT_RIGHT, steps)
    truth = some_elements(DEPENDENT_RIGHT)
    record = run_procedure(procedure, design, design @ truth, 3)
    matrices = pass_matrices(procedure, design)
    needed = truth - record.elements
    np.testing.assert_allclose(needed[1:], needed[:-1] @ matrices.T.T, atol=1e-13)


def test_undetermined_points_give_nan_and_do_not_stop_the_others():
    design = np.stack([flat_design(INDEPENDENT)] * 3)
    design[1] = design_matrix(np.tile([0.0, 5.0, -150.0], (6, 1)), BASE, INDEPENDENT)
    design[2] = np.nan
    n = over_correction(design, INDEPENDENT)
    assert np.isfinite(n).tolist() == [True, False, False]
    procedure = standard_procedure(design, INDEPENDENT)
    one_pass = pass_matrices(procedure, design)
    assert one_pass.diverges.tolist() == [False, True, True]
    limit = one_pass.limit(np.ones((3, 6)))
    assert np.isfinite(limit).all(axis=1).tolist() == [True, False, False]


def test_mistakes_are_said():
    design = flat_design(INDEPENDENT)
    with pytest.raises(SettingsError, match="observes no point; expected a point numb"):
        Step("d_omega", {5: 0.0})
    with pytest.raises(SettingsError, match="case = 'dep' is unknown; expected indep"):
        Procedure("dep", (Step("d_omega", {5: 1.0}),))
    with pytest.raises(SettingsError, match="a procedure without steps"):
        Procedure(INDEPENDENT, ())
    with pytest.raises(
        SettingsError, match="independent has no element 'd_by'; expected d_omega or"
    ):
        Procedure(INDEPENDENT, (Step("d_by", {5: 1.0}),))
    with pytest.raises(
        SettingsError, match="tilt_at = '7' is unknown; expected 5 or 6"
    ):
        standard_procedure(design, INDEPENDENT, tilt_at="7")
    seventh = Procedure(INDEPENDENT, (Step("d_omega", {7: 1.0}),))
    for work in (run_procedure, lambda *given: pass_matrices(*given[:2])):
        with pytest.raises(
            SettingsError, match="a step observes point 7; expected 1 to 6"
        ):
            work(seventh, design, np.zeros(6), 1)
    with pytest.raises(
        SettingsError, match=r"sigma without rng; expected rng=np\.random"
    ):
        run_procedure(seventh, design, np.zeros(6), 1, sigma=1.0)
