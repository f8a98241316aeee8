"""Affine and helmert of 100 000 models with everything that belongs to them.

Full means parameters, covariance, residuals, m_0 and leverages. The peers take a few
hundred models: their time for one does not depend on how many there are.
"""

import numpy as np
import statsmodels.api as sm
from skimage.transform import AffineTransform, SimilarityTransform

from benchmarks.model_generator import generate
from benchmarks.racing import Contender, one_core, race
from einschalt.theory.transformation import affine, helmert

N_MODELS = 100_000
N_LOOP, N_SKIMAGE, N_STATSMODELS = 1000, 500, 200
OURS = {
    # easting and northing share one 3 × 3 matrix
    "affine": (affine.fit_affine, affine.affine_axis_cofactors),
    "helmert": (helmert.fit_helmert, helmert.helmert_cofactors),
}
SKIMAGE = {"affine": AffineTransform, "helmert": SimilarityTransform}


def run():
    """Run the race of each kind.

    Returns
    -------
    bool
        Whether every floor is kept.
    """
    models = generate(N_MODELS)
    kept = []
    for kind in OURS:
        _assert_same(kind, models)
        ours = Contender(
            "einschalt, one core, full", lambda k=kind: _ours(k, models), N_MODELS
        )
        peers = [
            Contender(
                "numpy lstsq loop, full",
                lambda k=kind: _each(_by_lstsq, k, models, N_LOOP),
                N_LOOP,
                floor=30,
            ),
            Contender(
                "statsmodels OLS with influence, full",
                lambda k=kind: _each(_by_statsmodels, k, models, N_STATSMODELS),
                N_STATSMODELS,
                floor=300,
            ),
            Contender(
                f"skimage {SKIMAGE[kind].__name__}, parameters only",
                lambda k=kind: _each(_by_skimage, k, models, N_SKIMAGE),
                N_SKIMAGE,
                floor=80,
            ),
        ]
        with one_core():
            kept.append(race(f"Transformation, {kind}", "model", ours, peers))
        everywhere = Contender(
            "einschalt, all cores, full", lambda k=kind: _ours(k, models), N_MODELS
        )
        race(f"Transformation, {kind}", "model", everywhere, [])
    return all(kept)


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
