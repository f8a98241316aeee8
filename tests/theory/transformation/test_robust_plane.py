"""Each model in one compiled loop: as the slow way, and as statsmodels."""

from dataclasses import replace

import numpy as np
import pytest
import statsmodels.api as sm

from einschalt.foundations import batches
from einschalt.theory.adjustment.norms import HUBER, TUKEY
from einschalt.theory.adjustment.robust import fit_robustly
from einschalt.theory.transformation.affine import fit_affine
from einschalt.theory.transformation.helmert import fit_helmert
from einschalt.theory.transformation.point_tests import CommonPoints
from einschalt.theory.transformation.rigid import fit_rigid
from einschalt.theory.transformation.robust_plane import fit_plane_robustly

FITS = {"affine": fit_affine, "helmert": fit_helmert, "rigid": fit_rigid}
NORMS = {"huber": HUBER[2], "tukey": TUKEY[2]}
SIGMA = 0.02


def fit_by(kind):
    def fit_of(points):
        return FITS[kind](points.source, points.target, points.weights, points.start)

    return fit_of


def models(seed=0, n_models=300, far=5e6):
    """Models of 2 to 120 points far from the origin, one point in twenty gross."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(2, 40, n_models)
    counts[:3] = 120, 65, 64  # more than are sorted by insertion, and just as many
    start = np.concatenate([[0], np.cumsum(counts)])
    xy = rng.uniform(-100, 100, (start[-1], 2))
    weights = rng.uniform(0.5, 2.0, start[-1])
    noise = rng.normal(0.0, SIGMA, xy.shape) / np.sqrt(weights)[:, None]
    gross = rng.normal(0.0, 0.5, xy.shape) * (rng.random((start[-1], 1)) < 0.05)
    return CommonPoints(xy, xy + far + noise + gross, weights, start)


@pytest.mark.parametrize("name", NORMS)
@pytest.mark.parametrize("kind", FITS)
def test_each_in_one_go_is_all_step_by_step(kind, name):
    points, fit_of = models(), fit_by(kind)
    begun = fit_robustly(points, fit_of, HUBER[2]).weights if name == "tukey" else None
    slow = fit_robustly(points, fit_of, NORMS[name], begun)
    quick = fit_plane_robustly(points, fit_of, NORMS[name], begun)
    rests = slow.is_converged & quick.is_converged
    assert rests.mean() > 0.98
    rows = rests[points.model]
    # at 5e6 m a coordinate is known to 1e-9, a residual of 0.01 to 1e-7 of itself
    np.testing.assert_allclose(
        quick.weights[rows], slow.weights[rows], rtol=0, atol=2e-5
    )
    np.testing.assert_allclose(
        quick.fit.s_0[rests], slow.fit.s_0[rests], rtol=1e-4, equal_nan=True
    )


def test_a_model_alone_is_as_among_others():
    points, fit_of = models(), fit_by("affine")
    together = fit_plane_robustly(points, fit_of, HUBER[2])
    for k in range(0, 300, 17):
        rows, part = points.of_models(np.array([k]))
        alone = fit_plane_robustly(part, fit_of, HUBER[2])
        np.testing.assert_array_equal(alone.weights, together.weights[rows])


def test_result_does_not_depend_on_the_threads(monkeypatch):
    points, fit_of = models(n_models=4000), fit_by("affine")
    assert len(points.weights) > batches.ROWS_WORTH_A_THREAD
    results = []
    for count in (1, 2, 5):
        monkeypatch.setattr(batches, "n_cores", lambda n=count: n)
        results.append(fit_plane_robustly(points, fit_of, TUKEY[2]).weights)
    np.testing.assert_array_equal(results[1], results[0])
    np.testing.assert_array_equal(results[2], results[0])


@pytest.mark.parametrize("name", NORMS)
def test_eastings_alone_are_rlm_of_statsmodels(name):
    """Northings without residuals: then lengths are those of the eastings alone."""
    points = models(seed=4, n_models=30, far=0.0)
    target = np.column_stack([points.target[:, 0], points.source[:, 1]])
    points = replace(points, target=target)
    norms = {"huber": sm.robust.norms.HuberT, "tukey": sm.robust.norms.TukeyBiweight}
    norm, fit_of = NORMS[name], fit_by("affine")
    begun = fit_plane_robustly(points, fit_of, HUBER[2]).weights
    robust = fit_plane_robustly(points, fit_of, norm, begun)
    n_compared = 0
    for k in np.flatnonzero(robust.is_converged & (np.diff(points.start) > 10)):
        rows, part = points.of_models(np.array([k]))
        n = len(rows)
        # our scale: median / √(2 ln 2 · f / 2n); that of RLM: median / 0.67449
        ours = np.sqrt(2.0 * np.log(2.0) * (2 * n - 6) / (2 * n))
        root = np.sqrt(part.weights)
        rlm = sm.RLM(
            part.target[:, 0] * root,
            sm.add_constant(part.source) * root[:, None],
            M=norms[name](norm.limit * 0.6744897501960817 / ours),
        )
        start = robust.fit.parameters[k, :3]
        expected = rlm.fit(tol=1e-12, maxiter=500, conv="coefs", start_params=start)
        np.testing.assert_allclose(start, expected.params, atol=2e-6)
        factors = robust.weights[rows] / part.weights
        np.testing.assert_allclose(factors, expected.weights, atol=2e-4)
        n_compared += 1
    assert n_compared > 15


def test_models_that_cannot_be_fitted_keep_their_weights():
    points = models(n_models=4)
    line = points.source.copy()
    rows = slice(points.start[3], points.start[4])
    line[rows, 1] = 2.0 * line[rows, 0]
    points = replace(points, source=line)
    robust = fit_plane_robustly(points, fit_by("affine"), HUBER[2])
    np.testing.assert_array_equal(robust.weights[rows], points.weights[rows])
    assert np.isnan(robust.fit.parameters[3]).all()
    assert np.isfinite(robust.fit.parameters[:3]).all()


def test_exact_models_stay_as_they_are():
    points = models(n_models=5, far=0.0)
    exact = replace(points, target=2.0 * points.source)
    robust = fit_plane_robustly(exact, fit_by("helmert"), TUKEY[2])
    np.testing.assert_allclose(
        robust.fit.solution.linear, 2.0 * np.eye(2)[None].repeat(5, 0), atol=1e-12
    )
