"""What holds for affine, helmert, rigid and helmert_3d alike."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from einschalt.foundations import batches
from einschalt.theory.transformation.plane_fit import (
    SAME_GROUND,
    TOO_FEW,
    UNDETERMINED,
    USABLE,
)

seeds = st.integers(0, 2**32 - 1)
angles = st.floats(-np.pi, np.pi)
shifts = st.floats(-1e6, 1e6)
scales = st.floats(0.1, 10.0)
examples = settings(max_examples=25, deadline=None, derandomize=True)
# one unit in the last place of 5·10⁶ m is 1e-9 m
ROUNDING = 1e-8


def fields(fit):
    names = ["parameters", "s_0", "residuals", "leverage", "sum_of_squares"]
    return {name: getattr(fit, name) for name in names}


def turn(angle, size):
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.eye(size)
    matrix[:2, :2] = [[c, -s], [s, c]]
    return matrix


# minimal, over-determined, too few


def test_minimal(solver, make_models):
    fit = solver.fit(*make_models(solver, [solver.least], noise=0.0))
    redundancy = solver.size * solver.least - solver.n_parameters
    assert fit.status[0] == USABLE
    assert fit.redundancy[0] == redundancy
    np.testing.assert_allclose(fit.residuals, 0.0, atol=ROUNDING)
    np.testing.assert_allclose(
        fit.leverage.sum(), solver.n_parameters, rtol=1e-9, atol=0
    )


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_minimal_has_no_standard_error(kind, solver_named, make_models):
    solver = solver_named(kind)
    fit = solver.fit(*make_models(solver, [solver.least]))
    assert fit.redundancy[0] == 0
    assert np.isnan(fit.s_0[0])
    assert np.isnan(fit.m_0[0])
    # what the geometry alone says is known all the same
    assert np.isfinite(solver.cofactors(fit)).all()


def test_overdetermined_recovers_what_was_put_in(solver, make_models):
    models = make_models(solver, [30], noise=0.0)
    fit = solver.fit(*models)
    assert fit.redundancy[0] == solver.size * 30 - solver.n_parameters
    assert fit.s_0[0] < ROUNDING
    found = solver.formula(fit.parameters[0], models.source)
    np.testing.assert_allclose(found, models.target, rtol=0, atol=3 * ROUNDING)


@pytest.mark.parametrize("missing", [1, 2])
def test_too_few(missing, solver, make_models):
    fit = solver.fit(*make_models(solver, [max(solver.least - missing, 0)]))
    assert fit.status[0] == TOO_FEW
    assert fit.redundancy[0] == 0
    for values in (fit.parameters, fit.s_0, fit.m_0, fit.residuals, fit.leverage):
        assert np.isnan(values).all()
    assert np.isnan(solver.cofactors(fit)[0].diagonal()).all()


# degenerate: minimal and over-determined


@pytest.mark.parametrize("extra", [0, 1, 20])
@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.6, 0.8, 0.1)])
@pytest.mark.parametrize("offset", [0.0, 5e6])
@pytest.mark.parametrize("kind", ["affine", "helmert_3d"])
def test_points_on_a_line(kind, offset, direction, extra, solver_named, make_models):
    solver = solver_named(kind)
    models = make_models(solver, [solver.least + extra])
    along = np.linspace(-400.0, 500.0, len(models.weights))
    line = offset + along[:, None] * np.array(direction[: solver.size])
    fit = solver.fit(line, models.target, models.weights, models.start)
    assert fit.status[0] == UNDETERMINED
    assert fit.redundancy[0] == 0
    assert np.isnan(fit.parameters).all()
    assert np.isnan(fit.s_0).all()


@pytest.mark.parametrize("extra", [0, 1, 20])
@pytest.mark.parametrize("place", [0.0, 0.3, 4512345.678])
def test_points_in_one_place(place, extra, solver, make_models):
    models = make_models(solver, [solver.least + extra])
    heap = np.full_like(models.source, place)
    fit = solver.fit(heap, models.target, models.weights, models.start)
    assert fit.status[0] == UNDETERMINED
    assert np.isnan(fit.parameters).all()
    # the last digit of a number does not make two places of one
    heap[1] = np.nextafter(place, np.inf)
    rounded = solver.fit(heap, models.target, models.weights, models.start)
    if place:
        assert rounded.status[0] == UNDETERMINED


@pytest.mark.parametrize("extra", [0, 1, 20])
@pytest.mark.parametrize("place", [0.0, 0.3, 4512345.678])
def test_ground_points_in_one_place(place, extra, solver, make_models):
    models = make_models(solver, [solver.least + extra])
    heap = np.full_like(models.target, place)
    fit = solver.fit(models.source, heap, models.weights, models.start)
    assert fit.status[0] == SAME_GROUND
    assert fit.redundancy[0] == 0
    assert np.isnan(fit.parameters).all()
    assert np.isnan(fit.s_0).all()
    if place:
        heap[::2] = np.nextafter(place, np.inf)
        rounded = solver.fit(models.source, heap, models.weights, models.start)
        assert rounded.status[0] == SAME_GROUND


def test_two_points_on_a_line_are_enough_for_a_similarity(solver_named, make_models):
    for kind in ("helmert", "rigid"):
        solver = solver_named(kind)
        models = make_models(solver, [6], noise=0.0)
        rows = np.array([0, 1, 0, 1, 0, 1])
        line = models.source[rows]
        fit = solver.fit(line, models.target[rows], models.weights, models.start)
        assert fit.status[0] == USABLE
        np.testing.assert_allclose(fit.residuals, 0.0, atol=ROUNDING)


# batches


def test_one_model_is_computed_as_in_a_batch(solver, make_models):
    counts = np.random.default_rng(3).integers(solver.least, 40, 257)
    models = make_models(solver, counts, seed=3)
    together = solver.fit(*models)
    cofactors = solver.cofactors(together)
    for model in [0, 1, 2, 3, 7, 8, 128, 255, 256]:
        alone = solver.fit(*models.single(model))
        for name, values in fields(alone).items():
            part = getattr(together, name)
            is_by_point = len(part) == len(models.weights)
            rows = models.rows(model) if is_by_point else slice(model, model + 1)
            np.testing.assert_array_equal(values, part[rows], err_msg=name)
        np.testing.assert_array_equal(solver.cofactors(alone)[0], cofactors[model])


def test_threads_change_no_bit(solver, make_models, monkeypatch):
    counts = np.random.default_rng(4).integers(solver.least, 60, 300)
    models = make_models(solver, counts, seed=4)
    results = []
    for n_workers in (1, 2, 5):
        monkeypatch.setattr(batches, "n_cores", lambda n=n_workers: n)
        monkeypatch.setattr(batches, "ROWS_WORTH_A_THREAD", 0)
        results.append(fields(solver.fit(*models)))
    for other in results[1:]:
        for name, values in results[0].items():
            np.testing.assert_array_equal(values, other[name], err_msg=name)


def test_order_of_rows_is_irrelevant(solver, make_models):
    models = make_models(solver, [25], seed=5)
    order = np.random.default_rng(5).permutation(25)
    fit = solver.fit(*models)
    turned = solver.fit(
        models.source[order], models.target[order], models.weights[order], models.start
    )
    there = fit.apply(np.zeros(25, dtype=int), models.source)
    again = turned.apply(np.zeros(25, dtype=int), models.source)
    np.testing.assert_allclose(again, there, rtol=0, atol=2e-9)
    np.testing.assert_allclose(turned.residuals, fit.residuals[order], atol=2e-9)
    np.testing.assert_allclose(turned.leverage, fit.leverage[order], rtol=1e-9)


def test_empty_models_between_others(solver, make_models):
    models = make_models(solver, [0, 8, 0, 0, 5, 0], seed=6)
    fit = solver.fit(*models)
    assert fit.status.tolist() == [1, 0, 1, 1, 0, 1]
    for filled in (1, 4):
        alone = solver.fit(*models.single(filled))
        np.testing.assert_array_equal(alone.parameters[0], fit.parameters[filled])
        np.testing.assert_array_equal(alone.s_0[0], fit.s_0[filled])
    points = np.zeros((6, solver.size))
    everywhere = fit.apply(np.arange(6), points)
    assert np.isnan(everywhere).all(axis=1).tolist() == (fit.status != 0).tolist()
    spread = fit.point_cofactors(np.arange(6), points)
    assert np.isfinite(spread).all(axis=(1, 2)).tolist() == (fit.status == 0).tolist()
    back = fit.invert(np.arange(6), points)
    assert np.isnan(back).all(axis=1).tolist() == (fit.status != 0).tolist()
    assert np.isnan(solver.cofactors(fit)[0].diagonal()).all()


def test_no_models_at_all(solver):
    nothing = np.zeros((0, solver.size))
    fit = solver.fit(nothing, nothing, np.zeros(0), np.array([0]))
    assert fit.parameters.shape == (0, solver.n_parameters)
    assert solver.cofactors(fit).shape == (0, solver.n_parameters, solver.n_parameters)


# invariants


@examples
@given(seed=seeds, angle=angles, shift=shifts, scale=scales)
def test_frame_of_the_model_is_irrelevant(
    solver, make_models, seed, angle, shift, scale
):
    models = make_models(solver, [12], seed=seed)
    scale = 1.0 if solver.kind == "rigid" else scale
    other = scale * models.source @ turn(angle, solver.size).T + shift
    fit = solver.fit(*models)
    moved = solver.fit(other, models.target, models.weights, models.start)
    # the shift costs digits: 1e6 m against an extent of 0.1 to 10 km
    np.testing.assert_allclose(moved.residuals, fit.residuals, rtol=0, atol=3e-7)
    np.testing.assert_allclose(moved.leverage, fit.leverage, rtol=1e-6)
    assert moved.redundancy == fit.redundancy


@examples
@given(seed=seeds, angle=angles, shift=shifts, scale=scales)
def test_frame_of_the_ground_turns_the_result(
    solver, make_models, seed, angle, shift, scale
):
    models = make_models(solver, [12], seed=seed)
    scale = 1.0 if solver.kind == "rigid" else scale
    matrix = scale * turn(angle, solver.size)
    fit = solver.fit(*models)
    moved = solver.fit(
        models.source, models.target @ matrix.T + shift, models.weights, models.start
    )
    wanted = fit.residuals @ matrix.T
    np.testing.assert_allclose(moved.residuals, wanted, rtol=0, atol=3e-7)
    np.testing.assert_allclose(moved.s_0, scale * fit.s_0, rtol=1e-5)


@examples
@given(seed=seeds, factor=st.floats(1e-3, 1e3))
def test_unit_of_weight(solver, make_models, seed, factor):
    models = make_models(solver, [9], seed=seed)
    fit = solver.fit(*models)
    heavy = solver.fit(
        models.source, models.target, factor * models.weights, models.start
    )
    np.testing.assert_allclose(heavy.residuals, fit.residuals, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(heavy.leverage, fit.leverage, rtol=1e-9)
    np.testing.assert_allclose(heavy.s_0, np.sqrt(factor) * fit.s_0, rtol=1e-6)


@examples
@given(seed=seeds)
def test_doubled_point_is_a_point_of_double_weight(solver, make_models, seed):
    models = make_models(solver, [7], seed=seed)
    rows = np.array([0, 1, 2, 3, 3, 4, 5, 6])
    doubled = solver.fit(
        models.source[rows],
        models.target[rows],
        models.weights[rows],
        np.array([0, 8]),
    )
    weights = models.weights.copy()
    weights[3] *= 2.0
    heavy = solver.fit(models.source, models.target, weights, models.start)
    there = np.zeros(7, dtype=int)
    np.testing.assert_allclose(
        doubled.apply(there, models.source),
        heavy.apply(there, models.source),
        rtol=0,
        atol=ROUNDING,
    )
    np.testing.assert_allclose(
        solver.cofactors(doubled), solver.cofactors(heavy), rtol=1e-7, atol=1e-14
    )
    np.testing.assert_allclose(doubled.sum_of_squares, heavy.sum_of_squares, rtol=1e-6)
    # the second measurement counts as an observation of its own
    assert doubled.redundancy[0] == heavy.redundancy[0] + solver.size


@examples
@given(seed=seeds)
def test_inverse_leads_back(solver, make_models, seed):
    models = make_models(solver, [8, 11], seed=seed)
    fit = solver.fit(*models)
    model = np.repeat([0, 1], [8, 11])
    ground = fit.apply(model, models.source)
    back = fit.invert(model, ground)
    np.testing.assert_allclose(back, models.source, rtol=0, atol=ROUNDING)


@examples
@given(seed=seeds)
def test_redundancy_numbers_sum_to_the_redundancy(solver, make_models, seed):
    models = make_models(solver, [solver.least, 9, 30], seed=seed)
    fit = solver.fit(*models)
    for model in range(3):
        part = 1.0 - fit.leverage[models.rows(model)]
        np.testing.assert_allclose(part.sum(), fit.redundancy[model], atol=1e-8)
    assert (fit.leverage > 0.0).all()
    assert (fit.leverage < 1.0 + 1e-9).all()


def test_residuals_are_transformed_less_given(solver, make_models):
    models = make_models(solver, [6, 9], seed=7)
    fit = solver.fit(*models)
    transformed = fit.apply(np.repeat([0, 1], [6, 9]), models.source)
    np.testing.assert_allclose(
        fit.residuals, transformed - models.target, rtol=0, atol=2e-9
    )
    squares = models.weights * np.sum(fit.residuals**2, axis=1)
    wanted = np.add.reduceat(squares, models.start[:-1])
    np.testing.assert_allclose(fit.sum_of_squares, wanted, rtol=1e-12)
    redundancy = solver.size * np.array([6, 9]) - solver.n_parameters
    np.testing.assert_allclose(fit.s_0, np.sqrt(wanted / redundancy), rtol=1e-12)
    np.testing.assert_allclose(fit.m_0, np.sqrt(2.0) * fit.s_0, rtol=1e-12)


def test_sum_of_squares_is_least(solver, make_models):
    models = make_models(solver, [15], seed=8)
    fit = solver.fit(*models)
    best = fit.parameters[0]

    def sum_of_squares(parameters):
        off = solver.formula(parameters, models.source) - models.target
        return np.sum(models.weights[:, None] * off**2)

    errors = np.sqrt(solver.cofactors(fit)[0].diagonal())
    for place, error in enumerate(errors):
        for sign in (-1.0, 1.0):
            other = best.copy()
            other[place] += sign * 0.1 * error
            assert sum_of_squares(other) > fit.sum_of_squares[0]


# precision


def jacobian(solver, parameters, points):
    """Change of the coordinates with each parameter, by central differences."""
    columns = []
    for place, value in enumerate(parameters):
        step = 1e-4 * max(abs(value) ** 0.5, 1e-2) if abs(value) > 1e3 else 1e-5
        high, low = parameters.copy(), parameters.copy()
        high[place], low[place] = value + step, value - step
        change = solver.formula(high, points) - solver.formula(low, points)
        columns.append(change / (high[place] - low[place]))
    return np.stack(columns, axis=-1)


def test_precision_of_points_follows_from_that_of_the_parameters(solver, make_models):
    models = make_models(solver, [10], seed=9, noise=0.02)
    # a frame whose origin lies outside the model, and a small ground frame
    source = models.source + 700.0
    target = models.target - models.target.mean(axis=0)
    fit = solver.fit(source, target, models.weights, models.start)
    points = source + np.linspace(-300.0, 300.0, solver.size)
    slopes = jacobian(solver, fit.parameters[0], points)
    wanted = slopes @ solver.cofactors(fit)[0] @ np.swapaxes(slopes, 1, 2)
    found = fit.point_cofactors(np.zeros(10, dtype=int), points)
    np.testing.assert_allclose(found, wanted, rtol=2e-6, atol=2e-6 * wanted.max())


def test_leverage_is_the_precision_of_the_fitted_points(solver, make_models):
    models = make_models(solver, [10, 4], seed=10)
    fit = solver.fit(*models)
    cofactors = fit.point_cofactors(np.repeat([0, 1], [10, 4]), models.source)
    diagonal = np.diagonal(cofactors, axis1=1, axis2=2)
    np.testing.assert_allclose(
        fit.leverage, models.weights[:, None] * diagonal, rtol=1e-10
    )


def test_cofactors_are_those_of_propagation(solver, make_models):
    models = make_models(solver, [9], seed=11, noise=0.0)
    target = models.target - models.target.mean(axis=0)
    fit = solver.fit(models.source, target, models.weights, models.start)
    step = 0.01
    slopes = []
    for place in np.ndindex(target.shape):
        shifted = [target.copy(), target.copy()]
        shifted[0][place] += step
        shifted[1][place] -= step
        high, low = (
            solver.fit(models.source, t, models.weights, models.start).parameters[0]
            for t in shifted
        )
        slopes.append((high - low) / (2.0 * step))
    slopes = np.array(slopes).T
    variances = np.repeat(1.0 / models.weights, solver.size)
    wanted = slopes @ np.diag(variances) @ slopes.T
    found = solver.cofactors(fit)[0]
    size = np.sqrt(wanted.diagonal())
    assert np.abs((found - wanted) / np.outer(size, size)).max() < 1e-6


def test_standard_error_is_right_on_average(solver, make_models):
    counts = np.full(2000, 8)
    fit = solver.fit(*make_models(solver, counts, seed=12, noise=0.0))
    models = make_models(solver, counts, seed=12, noise=0.0)
    rng = np.random.default_rng(12)
    sigma = 0.07 / np.sqrt(models.weights)[:, None]
    noisy = models.target + sigma * rng.normal(size=models.target.shape)
    fit = solver.fit(models.source, noisy, models.weights, models.start)
    redundancy = int(fit.redundancy.sum())
    pooled = np.sqrt(fit.sum_of_squares.sum() / redundancy)
    # relative standard deviation of s_0 is 1 / √(2 r); four of them
    assert abs(pooled / 0.07 - 1.0) < 4.0 / np.sqrt(2.0 * redundancy)


def test_matrix_and_shift_do_the_same(solver, make_models):
    models = make_models(solver, [6, 9], seed=13)
    fit = solver.fit(*models)
    matrix, shift = fit.homogeneous(1)
    points = models.source[models.rows(1)]
    found = points @ matrix.T + shift
    wanted = fit.apply(np.ones(9, dtype=int), points)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUNDING)


# mirror images


@pytest.mark.parametrize("shape", ["scattered", "square"])
@pytest.mark.parametrize("kind", ["helmert", "rigid", "helmert_3d"])
def test_mirror_image_is_recognised(kind, shape, solver_named, make_models):
    solver = solver_named(kind)
    models = make_models(solver, [8], seed=14)
    source = models.source.copy()
    if shape == "square":
        corners = np.array([[-1, -1, 1], [1, -1, -1], [1, 1, 1], [-1, 1, -1]]) * 400.0
        source = np.tile(corners[:, : solver.size], (2, 1))
    mirrored = source.copy()
    mirrored[:, 0] *= -1.0
    scale = 1.0 if kind == "rigid" else 8.0
    fit = solver.fit(scale * mirrored, scale * source, models.weights, models.start)
    assert fit.is_mirrored.tolist() == [True]
    straight = solver.fit(source, scale * source, models.weights, models.start)
    assert straight.is_mirrored.tolist() == [False]


@examples
@given(seed=seeds)
def test_true_image_is_never_taken_for_a_mirror_image(solver, make_models, seed):
    counts = [solver.least, solver.least + 1, 5, 12]
    fit = solver.fit(*make_models(solver, counts, seed=seed))
    assert not fit.is_mirrored.any()


def test_points_on_a_line_are_no_mirror_image(solver_named):
    along = np.linspace(0.0, 900.0, 6)
    line = np.column_stack([0.6 * along, 0.8 * along])
    for kind in ("helmert", "rigid"):
        solver = solver_named(kind)
        fit = solver.fit(line, line + 5e6, np.ones(6), np.array([0, 6]))
        assert fit.is_mirrored.tolist() == [False]


def test_affine_takes_a_mirror_image(solver_named, make_models):
    solver = solver_named("affine")
    models = make_models(solver, [6], seed=15)
    mirrored = models.source * [-1.0, 1.0]
    fit = solver.fit(mirrored, models.target, models.weights, models.start)
    assert fit.is_mirrored.tolist() == [False]
    straight = solver.fit(*models)
    np.testing.assert_allclose(fit.residuals, straight.residuals, rtol=0, atol=1e-8)
