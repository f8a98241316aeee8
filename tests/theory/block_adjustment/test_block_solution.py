"""The block adjustment against dense Gauss-Markov and against statsmodels."""

from dataclasses import replace

import numpy as np
import pytest
import statsmodels.api as sm
from scipy import stats

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.block_tests import (
    judge_control,
    judge_observations,
)
from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    CUBIC,
    QUADRATIC,
    CommonTerms,
)

NANOMETRE = 1e-9
RELATIVE = 1e-9
# everything that can meet in a block: way of the solver, control, weights, layout
CASES = {
    "affine": {},
    "helmert": {"kind": "helmert"},
    "both kinds": {"kind": "mixed"},
    "affine, own weights": {"weights": True},
    "helmert, own weights": {"kind": "helmert", "weights": True},
    "affine, two flights": {"n_flights": 2},
    "affine, unequal control": {"control": "unequal"},
    "affine, correlated control": {"control": "correlated", "weights": True},
    "helmert, correlated control": {"kind": "helmert", "control": "correlated"},
    "affine, control held": {"control": "held"},
    "helmert, control held": {"kind": "helmert", "control": "held"},
    "some control held": {"some_held": True, "control": "correlated"},
    "one model": {"layout": "one model", "every": 2},
    "two models": {"layout": "two models", "kind": "helmert"},
    "strip": {"layout": "strip"},
    "ring": {"layout": "ring", "kind": "helmert"},
    "ring of affine models": {"layout": "ring"},
    "control in one corner": {"chosen": np.arange(6)},
    "control in one corner, helmert": {"chosen": np.arange(4), "kind": "helmert"},
}


def close(actual, expected):
    """Equal to 1e-9 of the largest element of each matrix."""
    size = np.abs(expected).max(axis=(-2, -1), keepdims=True)
    assert (np.abs(actual - expected) <= RELATIVE * size).all()


@pytest.mark.parametrize("name", CASES)
def test_equals_dense_gauss_markov(make_block, dense, name):
    observations = make_block(**CASES[name])
    found, expected = adjust(observations), dense(observations)
    np.testing.assert_allclose(found.points, expected.points, rtol=0, atol=NANOMETRE)
    np.testing.assert_allclose(
        found.residuals, expected.residuals, rtol=0, atol=NANOMETRE
    )
    assert found.redundancy == expected.redundancy
    assert found.sum_of_squares == pytest.approx(expected.sum_of_squares, rel=RELATIVE)
    free = ~observations.is_fixed
    close(found.point_cofactors[free], expected.point_cofactors[free])
    close(found.adjusted_cofactors, expected.adjusted_cofactors)
    assert (found.point_cofactors[~free] == 0.0).all()
    for m in range(observations.n_models):
        np.testing.assert_allclose(
            found.affinities[m][:, 1:], expected.affinity_of(m), rtol=1e-9, atol=1e-10
        )


@pytest.mark.parametrize("name", CASES)
def test_parameters_have_the_cofactors_of_dense_gauss_markov(make_block, dense, name):
    observations = make_block(**CASES[name])
    found, expected = adjust(observations).parameter_cofactors, dense(observations)
    for m, is_affine in enumerate(observations.is_affine):
        u = 6 if is_affine else 4
        # the dense unknowns belong to (x - centroid) / 60
        jacobian = np.eye(u)
        x, y = expected.centroid[m] / 60.0
        jacobian[2:] /= 60.0
        if is_affine:
            jacobian[0, 2], jacobian[0, 4] = -x, -y
            jacobian[1, 3], jacobian[1, 5] = -x, -y
        else:
            jacobian[0, 2:], jacobian[1, 2:] = (-x, y), (-y, -x)
        wanted = jacobian @ expected.model_cofactors[m] @ jacobian.T
        error = np.sqrt(np.diag(wanted))
        correlation = (found[m][:u, :u] - wanted) / np.outer(error, error)
        # shift and scale of a machine's frame far from its model are nearly dependent
        assert np.abs(correlation).max() < 1e-8


@pytest.mark.parametrize(
    ("kind", "families", "n_flights"),
    [
        ("helmert", (AFFINITY,), 1),
        ("helmert", (AFFINITY,), 2),
        ("helmert", (AFFINITY, QUADRATIC), 1),
        ("affine", (QUADRATIC,), 2),
        ("affine", (QUADRATIC, CUBIC), 1),
    ],
)
def test_common_parameters_equal_dense_gauss_markov(
    make_block, dense, kind, families, n_flights
):
    observations = make_block("grid", kind, affinity=4e-4, n_flights=n_flights)
    terms = tuple(CommonTerms(k, families) for k in range(n_flights))
    found, expected = adjust(observations, terms), dense(observations, terms)
    np.testing.assert_allclose(found.common, expected.common, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(found.points, expected.points, rtol=0, atol=NANOMETRE)
    np.testing.assert_allclose(
        found.residuals, expected.residuals, rtol=0, atol=NANOMETRE
    )
    close(found.common_cofactors[None], expected.common_cofactors[None])
    close(found.point_cofactors, expected.point_cofactors)
    assert found.redundancy == expected.redundancy
    assert found.sum_of_squares == pytest.approx(expected.sum_of_squares, rel=RELATIVE)


def shared_errors(observations, seed=5):
    """Five errors of some centimetres that bend each model, in its own unit."""
    rng = np.random.default_rng(seed)
    x, y = (observations.xy / 60.0).T
    terms = np.stack([np.ones_like(x), x, y, x * y, x**2], -1)
    bent = np.stack([terms, terms[:, ::-1]], 1) * 3e-3
    # a flight that was oriented by others shares nothing
    size = rng.uniform(0.5, 2.0, (observations.n_models, 5))
    size[observations.flight == 1] = 0.0
    return bent * size[observations.model][:, None]


@pytest.mark.parametrize(
    "name",
    [
        *("affine", "helmert", "both kinds", "affine, two flights", "one model"),
        *("ring", "affine, correlated control", "helmert, own weights"),
    ],
)
def test_shared_errors_equal_generalized_least_squares(make_block, dense, name):
    """As unknowns with a prior, or as correlations of the measurements: the same."""
    plain = make_block(**CASES[name])
    observations = replace(plain, orientation=shared_errors(plain))
    found, expected = adjust(observations), dense(plain)
    linear = found.affinities[plain.model][:, :, 1:]
    on_ground = linear @ observations.orientation
    n_rows = 2 * len(plain.model)
    correlated = np.eye(len(expected.design))
    root = np.zeros((len(correlated), 5 * plain.n_models))
    for row, m in enumerate(plain.model):
        weighted = on_ground[row] / plain.standard_error[row]
        root[2 * row : 2 * row + 2, 5 * m : 5 * m + 5] = weighted
    whiten = np.linalg.inv(np.linalg.cholesky(correlated + root @ root.T))
    design, right_side = whiten @ expected.design, whiten @ expected.right_side
    size = np.sqrt((design**2).sum(axis=0))
    q, r = np.linalg.qr(design / size)
    x, exact = np.zeros(design.shape[1]), design.astype(np.longdouble)
    for _ in range(3):  # refined as the dense adjustment is
        rest = np.asarray(right_side - exact @ x, float)
        x = x + np.linalg.solve(r, q.T @ rest) / size
    inverse = np.linalg.inv(r) / size[:, None]
    cofactors = (inverse @ inverse.T)[-2 * plain.n_points :, -2 * plain.n_points :]
    points = x[-2 * plain.n_points :].reshape(-1, 2)
    origin = np.nanmean(plain.control, axis=0)
    np.testing.assert_allclose(found.points - origin, points, rtol=0, atol=NANOMETRE)
    blocks = cofactors.reshape(plain.n_points, 2, plain.n_points, 2)
    each = np.arange(plain.n_points)
    close(found.point_cofactors, blocks[each, :, each])
    rest = design @ x - right_side
    assert found.sum_of_squares == pytest.approx(rest @ rest, rel=1e-8)
    assert found.redundancy == expected.redundancy
    # what is left of a measurement, and what its model shares
    shared = np.einsum("nak,nk->na", on_ground, found.orientation[plain.model])
    left = (expected.design @ x - expected.right_side)[:n_rows].reshape(-1, 2)
    left = left * plain.standard_error[:, None]
    np.testing.assert_allclose(found.residuals - shared, left, rtol=0, atol=NANOMETRE)


@pytest.mark.parametrize("kind", ["affine", "helmert", "mixed"])
def test_shared_errors_of_no_size_change_nothing(make_block, kind):
    plain = make_block("grid", kind, affinity=4e-4)
    nothing = np.zeros((len(plain.model), 2, 5))
    terms = (CommonTerms(0, (QUADRATIC,)),)
    found = adjust(replace(plain, orientation=nothing), terms)
    expected = adjust(plain, terms)
    for name in ("points", "residuals", "control_residuals", "affinities"):
        actual, wanted = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(actual, wanted, rtol=1e-12, atol=NANOMETRE)
    for name in ("point_cofactors", "adjusted_cofactors", "parameter_cofactors"):
        actual = getattr(found, name)
        close(actual[..., :4, :4], getattr(expected, name)[..., :4, :4])
    assert found.sum_of_squares == pytest.approx(expected.sum_of_squares, rel=1e-9)


def test_a_block_that_is_adjusted_again_keeps_its_terms(make_block):
    observations = make_block("grid", "helmert")
    terms = (CommonTerms(0, (AFFINITY,)),)
    found, plain = adjust(observations, terms), adjust(observations)
    again = found.readjusted(observations)
    assert again.terms == terms
    np.testing.assert_array_equal(again.common, found.common)
    np.testing.assert_array_equal(again.points, found.points)
    np.testing.assert_array_equal(found.with_terms(()).points, plain.points)
    assert len(plain.with_terms(terms).common) == len(found.common) == 2


def test_a_rough_solution_is_rough_by_less_than_a_tenth_of_a_millimetre(make_block):
    observations = make_block("grid", "helmert", affinity=4e-4)
    found = adjust(observations, (CommonTerms(0, (AFFINITY,)),))
    larger = 3.0 * observations.standard_error * (1.0 + (observations.model == 1))
    changed = replace(observations, standard_error=larger)
    exact, rough = found.readjusted(changed), found.readjusted(changed, is_rough=True)
    np.testing.assert_allclose(rough.points, exact.points, rtol=0.0, atol=1e-4)
    assert rough.sum_of_squares == pytest.approx(exact.sum_of_squares, rel=1e-6)
    assert not np.allclose(exact.points, found.points, rtol=0.0, atol=1e-4)


def test_the_affinity_of_the_film_is_found(make_block):
    observations = make_block("grid", "helmert", affinity=4e-4)
    found = adjust(observations, (CommonTerms(0, (AFFINITY,)),))
    error = np.sqrt(found.common_cofactors[0, 0])
    # the correction takes the affinity back
    assert found.common[0] == pytest.approx(-4e-4, abs=4.0 * error)


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_coordinates_far_from_the_origin_lose_nothing(make_block, kind):
    far = (5e6, 5.3e6)
    here, there = make_block("grid", kind), make_block("grid", kind, origin=far)
    near, distant = adjust(here), adjust(there)
    # the given coordinates themselves are rounded to 1e-9 m there
    np.testing.assert_allclose(
        distant.points - far, near.points, rtol=0, atol=4 * np.spacing(5.3e6)
    )
    close(distant.point_cofactors, near.point_cofactors)
    assert distant.s_0 == pytest.approx(near.s_0, rel=1e-6)


def test_models_far_from_their_origin_lose_nothing(make_block):
    observations = make_block("grid", "affine")
    near = adjust(observations)
    moved = {**vars(observations), "xy": observations.xy + 4096.0}
    far = adjust(type(observations)(**moved))
    np.testing.assert_allclose(far.points, near.points, rtol=0, atol=5e-9)


def test_order_of_models_and_points_does_not_matter(make_block):
    observations = make_block("grid", "affine", "correlated")
    rng = np.random.default_rng(1)
    new_model = rng.permutation(observations.n_models)
    new_point = rng.permutation(observations.n_points)
    rows = np.argsort(new_model[observations.model], kind="stable")
    old_model, old_point = np.argsort(new_model), np.argsort(new_point)
    shuffled = type(observations)(
        model=new_model[observations.model][rows],
        point=new_point[observations.point][rows],
        xy=observations.xy[rows],
        standard_error=observations.standard_error[rows],
        is_affine=observations.is_affine[old_model],
        flight=observations.flight[old_model],
        control=observations.control[old_point],
        control_covariance=observations.control_covariance[old_point],
    )
    first, second = adjust(observations), adjust(shuffled)
    np.testing.assert_allclose(
        second.points[new_point], first.points, rtol=0, atol=NANOMETRE
    )
    close(second.point_cofactors[new_point], first.point_cofactors)


@pytest.fixture(scope="module")
def whitened(make_block, dense):
    """A block of affine models, and its whitened system as statsmodels solves it."""
    observations = make_block("grid", "affine", weights=True)
    expected = dense(observations)
    return observations, sm.OLS(expected.right_side, expected.design).fit(method="qr")


def test_equals_statsmodels(whitened):
    observations, fit = whitened
    found, ols = adjust(observations), fit.model
    assert found.s_0 == pytest.approx(np.sqrt(fit.scale), rel=1e-9)
    n_rows = len(observations.xy)
    influence = fit.get_influence()
    leverage = influence.hat_matrix_diag[: 2 * n_rows].reshape(-1, 2)
    np.testing.assert_allclose(found.leverage, leverage, rtol=1e-9, atol=1e-12)
    control = influence.hat_matrix_diag[2 * n_rows :].reshape(-1, 2)
    held = found.control_leverage[observations.is_control]
    np.testing.assert_allclose(held, control, rtol=1e-9)
    of_points = found.leverage.sum() + held.sum()
    assert of_points == pytest.approx(len(ols.endog) - found.redundancy, rel=1e-12)
    t = fit.resid[: 2 * n_rows].reshape(-1, 2) / np.sqrt(fit.scale)
    tests = judge_observations(found, observations)
    is_tested = np.isfinite(tests.w)
    assert is_tested.any()
    t = t[is_tested] / np.sqrt(1.0 - leverage[is_tested])
    np.testing.assert_allclose(tests.w[is_tested], np.hypot(*t.T), rtol=1e-7)


@pytest.mark.parametrize("which", range(3))
def test_a_gross_error_is_tested_as_by_dummy_variables(whitened, which):
    observations, fit = whitened
    ols = fit.model
    found = adjust(observations)
    tests = judge_observations(found, observations)
    row = int(np.argsort(np.nan_to_num(tests.w))[-1 - 10 * which])
    dummies = np.zeros((len(ols.endog), 2))
    dummies[2 * row, 0] = dummies[2 * row + 1, 1] = 1.0
    larger = sm.OLS(ols.endog, np.column_stack([ols.exog, dummies])).fit(method="qr")
    f, p, _ = larger.compare_f_test(fit)
    assert tests.p_value[row] == pytest.approx(p, rel=1e-6)
    # endog = design · x + ∇ / σ where ∇ is the error of T − X
    gross = larger.params[-2:] * observations.standard_error[row]
    np.testing.assert_allclose(tests.error[row], -gross, rtol=1e-6)
    assert p == pytest.approx(stats.f.sf(f, 2, larger.df_resid), rel=1e-9)


def test_control_is_tested_as_by_dummy_variables(whitened):
    observations, fit = whitened
    ols = fit.model
    tests = judge_control(adjust(observations))
    places = np.flatnonzero(observations.is_control)
    first = 2 * len(observations.xy)
    for k in (0, 3, 5):
        dummies = np.zeros((len(ols.endog), 2))
        dummies[first + 2 * k, 0] = dummies[first + 2 * k + 1, 1] = 1.0
        exog = np.column_stack([ols.exog, dummies])
        larger = sm.OLS(ols.endog, exog).fit(method="qr")
        p = larger.compare_f_test(fit)[1]
        assert tests.p_value[places[k]] == pytest.approx(p, rel=1e-6)
        # the given coordinates are wrong by the dummy, in units of 2 cm
        np.testing.assert_allclose(
            tests.error[places[k]], larger.params[-2:] * 0.02, rtol=1e-6
        )


def test_a_strip_of_ten_thousand_models(make_block):
    """Against banded Cholesky of scipy on the points' shares, which it also fills."""
    from scipy.linalg import solveh_banded

    # helmert models that share two points with each neighbour: with the models
    # eliminated in place of the points, the normal equations of the points are a band
    n_models = 10_000
    rng = np.random.default_rng(5)
    # model k holds the points 2k … 2k + 3 at the corners of a square
    corner = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    model = np.repeat(np.arange(n_models), 4)
    point = (2 * np.arange(n_models)[:, None] + np.arange(4)).ravel()
    n_points = 2 * n_models + 2
    true = np.column_stack(
        [np.arange(n_points) // 2 * 500.0, np.arange(n_points) % 2 * 500.0]
    )
    xy = np.tile(corner * 500.0, (n_models, 1)) + rng.normal(0, 0.03, (4 * n_models, 2))
    control = np.full((n_points, 2), np.nan)
    control[::40] = true[::40]
    control[1::40] = true[1::40]
    covariance = np.zeros((n_points, 2, 2))
    covariance[np.isfinite(control[:, 0])] = 4e-4 * np.eye(2)
    from einschalt.theory.block_adjustment.observations import BlockObservations

    observations = BlockObservations(
        model=model,
        point=point,
        xy=xy,
        standard_error=np.full(len(model), 0.03),
        is_affine=np.zeros(n_models, dtype=bool),
        flight=np.zeros(n_models, dtype=int),
        control=control,
        control_covariance=covariance,
    )
    found = adjust(observations)
    # what a model leaves of its four points, in complex numbers: the inverse of the
    # band holds the variances of the points
    z = xy @ [1.0, 1j]
    w = 1.0 / 0.03**2
    band = np.zeros((6, n_points), dtype=complex)
    start = true @ [1.0, 1j]
    right = np.zeros(n_points, dtype=complex)
    for k in range(n_models):
        own = z[4 * k : 4 * k + 4]
        g = np.column_stack([np.ones(4), own - own.mean()])
        share = w * (np.eye(4) - g @ np.linalg.solve(g.conj().T @ g, g.conj().T))
        right[2 * k : 2 * k + 4] -= share @ (start[2 * k : 2 * k + 4] - start[2 * k])
        for i in range(4):
            for j in range(i + 1):
                band[i - j, 2 * k + j] += share[i, j]
    is_control = observations.is_control
    band[0, is_control] += 1.0 / 4e-4
    right[is_control] += (control @ [1.0, 1j] - start)[is_control] / 4e-4
    # unknown are corrections to the truth; a model says nothing of its own shift, so
    # that its part of the right side may be counted from its corner
    expected = start + solveh_banded(band, right, lower=True)
    np.testing.assert_allclose(found.points @ [1.0, 1j], expected, rtol=0, atol=1e-6)
    some = np.array([0, 1, 20, 5_000, 10_019, 20_001])
    unit = np.zeros((n_points, len(some)), dtype=complex)
    unit[some, np.arange(len(some))] = 1.0
    variance = solveh_banded(band, unit, lower=True)[some, np.arange(len(some))].real
    np.testing.assert_allclose(found.point_cofactors[some, 0, 0], variance, rtol=1e-7)
