"""Precision of estimates of a robust norm, by repeating them with drawn errors."""

from types import SimpleNamespace

import numpy as np
import pytest
import statsmodels.api as sm

from einschalt.theory.adjustment.norms import HUBER, TUKEY, Norm
from einschalt.theory.block_adjustment.norm_precision import variances_by_norm


class OneModel:
    """A linear model in place of a block, one coordinate a point."""

    def __init__(self, design):
        n, p = design.shape
        self._pseudo_inverse, self._design = np.linalg.pinv(design), design
        self.redundancy = n - p
        self.observations = SimpleNamespace(standard_error=np.ones(n))

    def answer_to(self, errors, control_errors, *, is_rough=False):  # noqa: ARG002
        found = self._pseudo_inverse @ errors[:, 0]
        return found[:, None], errors - (self._design @ found)[:, None]


@pytest.fixture
def design():
    return np.random.default_rng(1).standard_normal((400, 5))


def drawn(rng, shape, share, factor):
    return rng.standard_normal(shape) * np.where(rng.random(shape) < share, factor, 1.0)


def ratio_of(model, errors, norms):
    n = len(errors)
    control = np.zeros((n, 1, errors.shape[2]))
    given = model, errors, control, norms, np.ones(n, dtype=bool)
    plain, robust = variances_by_norm(*given)
    return robust / plain


def test_equal_weights_are_least_squares(design):
    errors = np.random.default_rng(2).standard_normal((400, 1, 50))
    norm = Norm(np.ones_like, 1.0)
    assert ratio_of(OneModel(design), errors, [norm]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("norm", [HUBER[1], TUKEY[1]])
def test_normal_errors_lose_five_per_cent(design, norm):
    errors = np.random.default_rng(3).standard_normal((400, 1, 2000))
    found = ratio_of(OneModel(design), errors, [norm])
    assert found == pytest.approx(1.0 / 0.95, abs=0.03)


@pytest.mark.parametrize("share", [0.07, 0.15])
def test_ratio_is_that_of_h1_of_statsmodels(design, share):
    """Huber's covariance of one model with many points, over that of least squares."""
    rng = np.random.default_rng(4)
    found = ratio_of(
        OneModel(design), drawn(rng, (400, 1, 500), share, 4.0), [HUBER[1]]
    )
    ratios = []
    for _ in range(60):
        y = drawn(rng, 400, share, 4.0)
        fit = sm.RLM(y, design, M=sm.robust.norms.HuberT(1.345)).fit(cov="H1")
        plain = sm.OLS(y, design).fit()
        ratios.append(np.trace(fit.bcov_scaled) / np.trace(plain.cov_params()))
    assert found == pytest.approx(np.mean(ratios), rel=0.06)


def test_residuals_of_the_other_sign_are_the_same(design):
    """Blocks in space tell residuals of errors, those in plan of their opposites."""
    model = OneModel(design)
    errors = drawn(np.random.default_rng(5), (400, 1, 100), 0.1, 5.0)
    expected = ratio_of(model, errors, [HUBER[1], TUKEY[1]])
    straight = model.answer_to

    def turned(errors, control_errors, *, is_rough=False):
        points, residuals = straight(errors, control_errors, is_rough=is_rough)
        return points, -residuals

    model.answer_to = turned
    found = ratio_of(model, errors, [HUBER[1], TUKEY[1]])
    assert found == pytest.approx(expected, rel=1e-9)
