"""Clean observations are refused as often as each test says, and not more often.

100 000 points and more, errors independent and normal, weights of 0.5 to 2 where the
fit takes them. Bounds are those that chance leaves with the probability 0.001 on
either side: binomial, with the scatter between models where the tests of one model
share their residuals.
"""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom, chi2, norm

from einschalt.stages.stage3_model_transformation import transform_models
from einschalt.theory.adjustment.multiple_testing import (
    is_rejected_by_holm,
)
from einschalt.theory.adjustment.norms import HUBER
from einschalt.theory.adjustment.reliability import (
    external_t,
    redundancy_numbers,
    standardized_residuals,
    tau_p_value,
)
from einschalt.theory.adjustment.robust import snoop
from einschalt.theory.transformation.affine import fit_affine
from einschalt.theory.transformation.helmert import fit_helmert
from einschalt.theory.transformation.point_tests import (
    CommonPoints,
    fitted_point_tests,
    other_point_tests,
    plan_sums,
)
from einschalt.theory.transformation.rigid import fit_rigid
from einschalt.theory.transformation.robust_plane import fit_plane_robustly

N_POINTS = 120_000
SIGMA = 0.05
CHANCE = 0.001
ORIGIN = np.array([4.5e6, 5.3e6])
LEVELS = (0.05, 0.01, 0.001)
FITS = {"affine": fit_affine, "helmert": fit_helmert, "rigid": fit_rigid}


def clean_points(seed):
    rng = np.random.default_rng(seed)
    counts = rng.integers(5, 36, 2 * N_POINTS // 40)
    start = np.concatenate([[0], np.cumsum(counts)])
    n = int(start[-1])
    xy = rng.uniform(-400.0, 400.0, (n, 2))
    weights = rng.uniform(0.5, 2.0, n)
    noise = rng.normal(0.0, SIGMA, (n, 2)) / np.sqrt(weights)[:, None]
    return CommonPoints(xy, xy + ORIGIN + noise, weights, start)


@pytest.fixture(scope="module", params=FITS)
def clean(request):
    points = clean_points(seed=list(FITS).index(request.param))
    fit_of = FITS[request.param]

    def fit_points(part):
        return fit_of(part.source, part.target, part.weights, part.start)

    fit = fit_points(points)
    return SimpleNamespace(kind=request.param, points=points, fit=fit, of=fit_points)


def assert_refuses(p_values, model, level):
    """The share below the level is the level, within what chance leaves.

    Tests of one model are not quite independent: the standard error of the share is
    the binomial one times the square root of what the scatter between models adds.
    """
    rejected = (p_values < level).astype(float)
    share, n = rejected.mean(), len(rejected)
    binomial = np.sqrt(level * (1.0 - level) / n)
    per_model = np.bincount(model, weights=rejected - level)
    scatter = np.sqrt(np.sum(per_model**2)) / n
    assert abs(share - level) < norm.isf(CHANCE) * max(binomial, scatter)


@pytest.mark.parametrize("level", LEVELS)
def test_w_tau_and_t_of_each_coordinate(clean, level):
    points, fit = clean.points, clean.fit
    assert len(points.weights) > 100_000
    r = redundancy_numbers(fit.leverage)
    unit = standardized_residuals(
        fit.residuals * np.sqrt(points.weights)[:, None], r, 1.0
    )
    f = fit.redundancy[points.model][:, None]
    s_0 = fit.s_0[points.model][:, None]
    model = np.repeat(points.model, 2)
    # Baarda's w, σ being known
    assert_refuses(2.0 * norm.sf(np.abs(unit / SIGMA)).ravel(), model, level)
    # Pope's τ and Student's t, σ being that of the model
    tau = unit / s_0
    assert_refuses(tau_p_value(tau, f).ravel(), model, level)
    assert np.nanmax(tau**2 / f) <= 1.0 + 1e-9
    assert np.isfinite(external_t(tau, f)).all()


@pytest.mark.parametrize("level", LEVELS)
def test_both_coordinates_of_a_point_together(clean, level):
    tests = fitted_point_tests(clean.fit, clean.points)
    assert_refuses(tests.p_value, clean.points.model, level)


@pytest.mark.parametrize("level", LEVELS)
def test_points_that_took_no_part(clean, level):
    is_fitted = np.random.default_rng(9).random(len(clean.points.weights)) < 0.8
    kept, others = clean.points.chosen(is_fitted), clean.points.chosen(~is_fitted)
    fit = clean.of(kept)
    _, tests = other_point_tests(
        fit, plan_sums(fit, kept.weights, kept.start), others.model, others
    )
    is_tested = np.isfinite(tests.p_value)
    assert is_tested.mean() > 0.95
    assert_refuses(tests.p_value[is_tested], others.model[is_tested], level)


@pytest.mark.parametrize("level", LEVELS)
def test_families_of_a_model(clean, level):
    """Holm: any false alarm in a model, with the probability of the level at most.

    The worst of n independent tests would reach it up to α²/2; the tests of one model
    are nearly independent.
    """
    points = clean.points
    p_value = fitted_point_tests(clean.fit, points).p_value
    n_models = len(points.start) - 1

    is_rejected = is_rejected_by_holm(p_value, level, points.start)
    by_holm = np.maximum.reduceat(is_rejected, points.start[:-1])
    assert by_holm.sum() <= binom.isf(CHANCE, n_models, level)
    # no less either: a test that never speaks would keep every level
    assert by_holm.sum() >= binom.ppf(CHANCE, n_models, 0.8 * level)


def test_snooping_takes_a_point_from_few_clean_models(clean):
    level = 0.01
    is_out = snoop(
        clean.points, lambda part: fitted_point_tests(clean.of(part), part), level
    )
    n_models = len(clean.points.start) - 1
    with_loss = np.add.reduceat(is_out, clean.points.start[:-1]) > 0
    assert with_loss.sum() <= binom.isf(CHANCE, n_models, level)
    assert with_loss.sum() >= binom.ppf(CHANCE, n_models, 0.8 * level)


@pytest.mark.parametrize("level", LEVELS)
def test_squares_of_a_model_against_a_known_size(clean, level):
    f = clean.fit.redundancy
    p_value = chi2.sf(clean.fit.sum_of_squares / SIGMA**2, f)
    n_models = len(f)
    low, high = binom.ppf([CHANCE, 1.0 - CHANCE], n_models, level)
    assert low <= np.count_nonzero(p_value < level) <= high
    # and the lower tail: residuals that are too small
    assert low <= np.count_nonzero(p_value > 1.0 - level) <= high


def test_table_of_residuals_names_few_suspects():
    points = clean_points(seed=11)
    names = [f"P{k}" for k in range(len(points.weights))]
    model = pd.DataFrame(points.source, columns=["x", "y"]).assign(
        model_id=points.model.astype(str), point_id=names, weight=points.weights
    )
    ground = pd.DataFrame(points.target, columns=["easting", "northing"]).assign(
        point_id=names
    )
    residuals = transform_models(model, ground).residuals
    assert_refuses(residuals["p_value"].to_numpy(), points.model, 0.001)
    n_models = len(points.start) - 1
    n_alarms = residuals.groupby("model_id")["is_suspect"].any().sum()
    assert n_alarms <= binom.isf(CHANCE, n_models, 0.001)


def test_robust_fits_of_clean_models_lose_five_per_cent(clean):
    """What the norms are tuned for: a variance of the estimates 1 / 0.95 times larger.

    In models of 20 points and more; in smaller ones the scale costs more.
    """
    counts = np.diff(clean.points.start)
    _, part = clean.points.of_models(np.flatnonzero(counts >= 20))
    plain, robust = clean.of(part), fit_plane_robustly(part, clean.of, HUBER[2]).fit
    true = part.source + ORIGIN

    def squares(fit):
        return np.mean((fit.apply(part.model, part.source) - true) ** 2)

    assert 1.02 < squares(robust) / squares(plain) < 1.09
