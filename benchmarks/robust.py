"""Robust fits of all models, one in fifty points with a gross error.

The peer takes each model alone and gives no leverages and no covariances. Its scale
and its limit are others than ours, its iteration is the same; that both come to the
same where scale and limit are made the same is shown in the tests.
"""

from dataclasses import replace

import numpy as np
import statsmodels.api as sm

from benchmarks.model_generator import generate
from benchmarks.racing import Contender, at_least, one_core, race
from benchmarks.transformation import _whitened
from einschalt.theory.adjustment.norms import HUBER, TUKEY
from einschalt.theory.transformation import affine, helmert
from einschalt.theory.transformation.point_tests import CommonPoints
from einschalt.theory.transformation.robust_plane import fit_plane_robustly

N_MODELS, N_STATSMODELS = 20_000, 60
GROSS_SHARE, GROSS = 0.02, 3.0  # m
FITS = {"affine": affine.fit_affine, "helmert": helmert.fit_helmert}
NORMS = {
    "huber": (HUBER[2], sm.robust.norms.HuberT()),
    "tukey": (TUKEY[2], sm.robust.norms.TukeyBiweight()),
}
FLOOR = 500
# median over the models; ours takes both coordinates of a point for good or bad
LARGEST_DIFFERENCE = 0.25  # standard errors


def run():
    """Run the race of each kind and norm.

    Returns
    -------
    list of Race
    """
    models = _with_gross_errors(generate(N_MODELS, seed=3))
    races = []
    for kind in FITS:
        for name, (ours, theirs) in NORMS.items():
            _assert_alike(kind, models, ours, theirs)
            with one_core():
                races.append(
                    race(
                        f"Robust transformation, {kind}, {name}",
                        "model",
                        Contender(
                            "einschalt, one core, full",
                            lambda k=kind, n=ours: _ours(k, models, n),
                            N_MODELS,
                        ),
                        [
                            Contender(
                                "statsmodels RLM, parameters",
                                lambda k=kind, n=theirs: _theirs(k, models, n),
                                N_STATSMODELS,
                                at_least(FLOOR),
                            )
                        ],
                    )
                )
    return races


def _with_gross_errors(models):
    rng = np.random.default_rng(4)
    is_gross = rng.random(len(models.en)) < GROSS_SHARE
    moved = models.en.copy()
    moved[is_gross] += rng.normal(0.0, GROSS, (np.count_nonzero(is_gross), 2))
    return replace(models, en=moved)


def _ours(kind, models, norm):
    def fit_of(points):
        return FITS[kind](points.source, points.target, points.weights, points.start)

    points = CommonPoints(models.xy, models.en, models.weights, models.start)
    return fit_plane_robustly(points, fit_of, norm).fit


def _theirs(kind, models, norm):
    estimates = []
    for xy, en, weights in models.one_by_one(N_STATSMODELS):
        design, observed, _ = _whitened(kind, xy, en, weights)
        estimates.append(sm.RLM(observed, design, M=norm).fit())
    return estimates


def _assert_alike(kind, models, ours, theirs):
    fit = _ours(kind, models, ours)
    linear = [0, 1] if kind == "helmert" else [1, 2, 4, 5]
    off = [
        (fit.parameters[k, linear] - peer.params[linear]) / peer.bse[linear]
        for k, peer in enumerate(_theirs(kind, models, theirs))
    ]
    assert np.median(np.abs(off)) < LARGEST_DIFFERENCE
