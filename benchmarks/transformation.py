"""Affine and helmert of 100 000 models with everything that belongs to them.

Full means parameters, covariance, residuals, m_0 and leverages; tested, what tells of
every point how it fits the others, and the probability of that; studentized, the
residual of every coordinate over its standard error. The peers take a few hundred
models: their time for one does not depend on how many there are.
"""

import numpy as np
import statsmodels.api as sm
from skimage.transform import AffineTransform, SimilarityTransform

from benchmarks.model_generator import generate
from benchmarks.racing import (
    Contender,
    Outcome,
    at_least,
    at_most,
    exponent,
    in_unit,
    one_core,
    peer,
    race,
    report,
    seconds_of,
)
from einschalt.theory.transformation import affine, helmert
from einschalt.theory.transformation.point_tests import CommonPoints, fitted_point_tests

N_MODELS = 100_000
N_LOOP, N_SKIMAGE, N_STATSMODELS, N_REFITTED = 1000, 500, 200, 10
SIZES = (1_000, 10_000, 100_000, 1_000_000)
MOST_EXPONENT = 1.1
OURS = {
    # easting and northing share one 3 × 3 matrix
    "affine": (affine.fit_affine, affine.affine_axis_cofactors),
    "helmert": (helmert.fit_helmert, helmert.helmert_cofactors),
}
SKIMAGE = {"affine": AffineTransform, "helmert": SimilarityTransform}
OPENCV = {"affine": "estimateAffine2D", "helmert": "estimateAffinePartial2D"}
# read: x, y, E, N, weight; written: residuals and leverages of both coordinates
BYTES_OF_POINT, BYTES_OF_MODEL = 9 * 8, 13 * 8


def run():
    """Race each kind, the tests of points, and see how time grows.

    Returns
    -------
    list of Race
    """
    models = generate(N_MODELS)
    races = []
    for kind in OURS:
        _assert_same(kind, models)
        with one_core():
            races += [_fits(kind, models), *_tests(kind, models)]
        everywhere = _contender("all cores, full", kind, models)
        races.append(race(f"Transformation, {kind}", "model", everywhere, []))
    with one_core():
        return [*races, _growth()]


def _contender(name, kind, models):
    def full():
        return _ours(kind, models)

    return Contender(f"einschalt, {name}", full, models.n_models)


def _peer(name, solve, kind, models, n_models, bound):
    def each():
        return _each(solve, kind, models, n_models)

    return Contender(name, each, n_models, bound)


def _fits(kind, models):
    given = kind, models
    peers = [
        _peer("numpy lstsq loop, full", _by_lstsq, *given, N_LOOP, at_least(60, 100)),
        _peer(
            "statsmodels OLS with influence, full",
            _by_statsmodels,
            *given,
            N_STATSMODELS,
            at_least(300),
        ),
        _peer(
            f"skimage {SKIMAGE[kind].__name__}, parameters only",
            _by_skimage,
            *given,
            N_SKIMAGE,
            at_least(80),
        ),
    ]
    opencv = peer("cv2")
    if opencv:
        solve = getattr(opencv, OPENCV[kind])
        by_opencv = lambda _, xy, en, __: solve(xy, en - en.mean(axis=0))  # noqa: E731
        name = f"OpenCV {OPENCV[kind]} (RANSAC), parameters only"
        peers.append(_peer(name, by_opencv, *given, N_LOOP, at_least(40, 60)))
    n_bytes = len(models.xy) * BYTES_OF_POINT + models.n_models * BYTES_OF_MODEL
    ours = _contender("one core, full", *given)
    return race(f"Transformation, {kind}", "model", ours, peers, n_bytes=n_bytes)


def _tests(kind, models):
    """Every point tested: what statsmodels fits anew for each."""
    _assert_same_tests(kind, models)
    given = kind, models
    outlier_test = _peer(
        "statsmodels OLS, outlier_test",
        _by_outlier_test,
        *given,
        N_REFITTED,
        at_least(6_000, 10_000),
    )
    internal = _peer(
        "statsmodels OLS, internally studentized residuals",
        _by_internal_residuals,
        *given,
        N_STATSMODELS,
        at_least(80, 1000),
    )
    return [
        race(
            f"Transformation with {name}, {kind}",
            "model",
            Contender(
                f"einschalt, one core, full and {done}",
                lambda ours=ours: ours(*given),
                models.n_models,
            ),
            [peer],
            rounds=3,
        )
        for name, done, ours, peer in (
            ("a test of every point", "tested", _tested, outlier_test),
            ("studentized residuals", "studentized", _studentized, internal),
        )
    ]


def _growth():
    seconds = {}
    for size in SIZES:
        models = generate(size)
        _ours("affine", models)
        seconds[size] = seconds_of(lambda m=models: _ours("affine", m))
    first, *others = SIZES
    rows = [
        Outcome(
            f"{size} models",
            in_unit(seconds[size]),
            exponent((seconds[first], seconds[size]), (first, size)),
            at_most(MOST_EXPONENT) if size == SIZES[-1] else None,
        )
        for size in others
    ]
    return report("Transformation, affine, one core: exponent of time", rows, seconds)


def _ours(kind, models):
    fit_models, cofactors_of = OURS[kind]
    fit = fit_models(models.xy, models.en, models.weights, models.start)
    covariance = cofactors_of(fit) * (fit.s_0**2)[:, None, None]
    return fit, covariance, fit.m_0


def _each(solve, kind, models, n_models):
    return [solve(kind, *parts) for parts in models.one_by_one(n_models)]


def _design(kind, xy):
    x, y = xy.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    if kind == "helmert":
        east = np.column_stack([x, -y, one, zero])
        north = np.column_stack([y, x, zero, one])
    else:
        east = np.column_stack([one, x, y, zero, zero, zero])
        north = np.column_stack([zero, zero, zero, one, x, y])
    return np.vstack([east, north])


def _whitened(kind, xy, en, weights):
    # centred: an uncentred solution loses its digits at 5·10⁶ m
    root = np.sqrt(np.concatenate([weights, weights]))
    design = _design(kind, xy - xy.mean(axis=0))
    observed = (en - en.mean(axis=0)).T.ravel()
    return design * root[:, None], observed * root, root


def _by_lstsq(kind, xy, en, weights):
    design, observed, root = _whitened(kind, xy, en, weights)
    parameters, *_ = np.linalg.lstsq(design, observed)
    misfit = design @ parameters - observed
    redundancy = len(observed) - len(parameters)
    s_0 = np.sqrt(misfit @ misfit / redundancy)
    cofactors = np.linalg.inv(design.T @ design)
    leverage = np.einsum("ni,ij,nj->n", design, cofactors, design)
    return parameters, s_0**2 * cofactors, misfit / root, np.sqrt(2) * s_0, leverage


def _by_statsmodels(kind, xy, en, weights):
    design, observed, root = _whitened(kind, xy, en, weights)
    fit = sm.OLS(observed, design).fit()
    leverage = fit.get_influence().hat_matrix_diag
    m_0 = np.sqrt(2 * fit.scale)
    return fit.params, fit.cov_params(), -fit.resid / root, m_0, leverage


def _by_skimage(kind, xy, en, _weights):
    return SKIMAGE[kind].from_estimate(xy, en).params


def _tested(kind, models):
    fit, covariance, m_0 = _ours(kind, models)
    points = CommonPoints(models.xy, models.en, models.weights, models.start)
    return fit, covariance, m_0, fitted_point_tests(fit, points)


def _studentized(kind, models):
    fit, covariance, m_0 = _ours(kind, models)
    # in one array: fresh memory takes longer than what is computed in it
    studentized = 1.0 - fit.leverage
    np.sqrt(studentized, out=studentized)
    np.divide(fit.residuals, studentized, out=studentized)
    of_point = np.sqrt(models.weights) / np.repeat(fit.s_0, models.counts)
    studentized *= of_point[:, None]
    return fit, covariance, m_0, studentized


def _by_internal_residuals(kind, xy, en, weights):
    design, observed, root = _whitened(kind, xy, en, weights)
    fit = sm.OLS(observed, design).fit()
    influence = fit.get_influence()
    return (
        *(fit.params, fit.cov_params(), -fit.resid / root, np.sqrt(2 * fit.scale)),
        *(influence.hat_matrix_diag, influence.resid_studentized_internal),
    )


def _by_outlier_test(kind, xy, en, weights):
    design, observed, _ = _whitened(kind, xy, en, weights)
    return sm.OLS(observed, design).fit().outlier_test()


def _assert_same_tests(kind, models):
    """Residuals over their standard errors, which the tests are made of."""
    studentized = _studentized(kind, models)[3]
    tests = _tested(kind, models)[3]
    w = np.where(np.isnan(tests.w), np.nan, np.hypot(*studentized.T))
    np.testing.assert_allclose(tests.w, w, rtol=1e-6)
    theirs = _each(_by_internal_residuals, kind, models, N_REFITTED)
    for k, (*_, internal) in enumerate(theirs):
        rows = slice(models.start[k], models.start[k + 1])
        ours = -studentized[rows].T.ravel()
        np.testing.assert_allclose(ours, internal, rtol=0, atol=1e-7)


def _assert_same(kind, models):
    """All give the same numbers, before anybody is timed."""
    fit, covariance, m_0 = _ours(kind, models)
    linear = [0, 1] if kind == "helmert" else [1, 2, 4, 5]
    for solve, n_models in ((_by_lstsq, N_LOOP), (_by_statsmodels, N_STATSMODELS)):
        for k, theirs in enumerate(_each(solve, kind, models, n_models)):
            rows = slice(models.start[k], models.start[k + 1])
            parameters, their_covariance, residuals, their_m_0, leverage = theirs
            np.testing.assert_allclose(
                fit.parameters[k, linear], parameters[linear], rtol=0, atol=1e-11
            )
            free = [place for place in linear if place < len(covariance[k])]
            theirs_linear = their_covariance[np.ix_(free, free)]
            np.testing.assert_allclose(
                covariance[k][np.ix_(free, free)],
                theirs_linear,
                rtol=1e-8,
                atol=1e-10 * theirs_linear.max(),
            )
            np.testing.assert_allclose(
                fit.residuals[rows].T.ravel(), residuals, rtol=0, atol=5e-9
            )
            np.testing.assert_allclose(m_0[k], their_m_0, rtol=1e-8)
            np.testing.assert_allclose(
                fit.leverage[rows].T.ravel(), leverage, rtol=1e-9
            )
    _assert_same_as_skimage(kind, models)


def _assert_same_as_skimage(kind, models):
    # it knows no weights, and its affine is not quite least squares on the ground
    fit_models, _ = OURS[kind]
    plain = fit_models(models.xy, models.en, np.ones(len(models.xy)), models.start)
    tolerance = 1e-9 if kind == "helmert" else 1e-3
    for k, theirs in enumerate(_each(_by_skimage, kind, models, N_SKIMAGE)):
        matrix, _ = plain.homogeneous(k)
        np.testing.assert_allclose(matrix, theirs[:2, :2], rtol=0, atol=tolerance)
