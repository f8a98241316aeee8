"""Drawn errors through operators, and tails of statistics from draws."""

import numpy as np
import pytest
from scipy import sparse, stats

from einschalt.theory.adjustment.monte_carlo import (
    apply_chains,
    draw_errors,
    tail_of_mean,
    tail_of_squares,
)
from einschalt.theory.adjustment.point_operator import Axes, PointOperator


def chain(rng, shapes, axes, *, is_complex=False):
    parts = []
    for shape in shapes:
        part = rng.normal(size=shape)
        if is_complex:
            part = part + 1j * rng.normal(size=shape)
        parts.append(sparse.csr_array(part * (rng.random(shape) < 0.6)))
    return PointOperator(tuple(parts), axes)


@pytest.mark.parametrize("axes", Axes)
def test_errors_have_their_sizes(axes):
    sizes = {"control": np.array([0.01, 0.05]), "flight": np.array([0.1])}
    drawn = draw_errors(sizes, axes, n_draws=20_000, seed=1)
    found = axes.plan(drawn["control"])
    assert found.shape == (2, 2, 20_000)
    expected = np.repeat(sizes["control"], 2).reshape(2, 2)
    # 20 000 draws give a standard deviation to 0.5 %
    np.testing.assert_allclose(found.std(axis=2), expected, rtol=0.02)
    correlation = np.corrcoef(found.reshape(4, -1))
    np.testing.assert_allclose(correlation, np.eye(4), atol=0.03)


def test_axes_may_have_sizes_of_their_own():
    sizes = {"flight": np.array([[0.1, 0.1, 0.7], [0.2, 0.2, 0.9]])}
    drawn = draw_errors(sizes, Axes.SPACE, n_draws=20_000, seed=2)["flight"]
    np.testing.assert_allclose(drawn.std(axis=1), sizes["flight"].ravel(), rtol=0.02)


@pytest.mark.parametrize("is_complex", [False, True])
def test_draws_go_through_the_product_of_the_operators(is_complex):
    rng = np.random.default_rng(3)
    axes = Axes.COMPLEX if is_complex else Axes.PLANE
    chains = {
        "control": chain(rng, [(6, 4), (4, 4)], axes, is_complex=is_complex),
        "flight": chain(rng, [(6, 8)], axes),
    }
    sizes = {name: np.ones(part.n_sources) for name, part in chains.items()}
    errors = draw_errors(sizes, axes, n_draws=7, seed=4)
    found = apply_chains(errors, chains)
    expected = sum(
        part.matrix.toarray() @ errors[name] for name, part in chains.items()
    )
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_tail_of_squares_is_that_of_chi_square():
    rng = np.random.default_rng(5)
    sigma = rng.uniform(0.5, 2.0, 300)
    drawn = np.sum((sigma[:, None] * rng.standard_normal((300, 100))) ** 2, axis=0)
    # of 20 000 blocks without a fault, one in a hundred lies beyond
    blocks = np.sum((sigma[:, None] * rng.standard_normal((300, 20_000))) ** 2, axis=0)
    p_values = np.array([tail_of_squares(value, drawn) for value in blocks[:4000]])
    assert 0.003 < np.mean(p_values < 0.01) < 0.025
    many = np.sum((sigma[:, None] * rng.standard_normal((300, 5000))) ** 2, axis=0)
    degrees = 2 * np.sum(sigma**2) ** 2 / (2 * np.sum(sigma**4))
    value = np.quantile(blocks, 0.99)
    expected = stats.chi2.sf(degrees * value / np.sum(sigma**2), degrees)
    assert tail_of_squares(value, many) == pytest.approx(expected, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("n_numbers", [6, 300])
@pytest.mark.parametrize("n_draws", [12, 49])
def test_few_draws_make_no_false_alarms(n_numbers, n_draws):
    rng = np.random.default_rng(7)
    sigma = rng.uniform(0.5, 2.0, n_numbers) ** 2
    degrees = sigma.sum() ** 2 / np.sum(sigma**2)
    size = sigma.sum() / degrees  # a multiple of chi-square, as Satterthwaite has it
    drawn = size * rng.chisquare(degrees, (20_000, n_draws))
    observed = size * rng.chisquare(degrees, 20_000)
    p_values = np.array(
        [tail_of_squares(*one) for one in zip(observed, drawn, strict=True)]
    )
    for level in (0.001, 0.01, 0.99):
        chance = np.sqrt(level * (1.0 - level) / len(observed))
        rate = np.mean(p_values < level)
        assert abs(rate - level) < 4.0 * chance + 0.25 * min(level, 1.0 - level)


def test_tail_of_mean_is_that_of_a_further_value():
    rng = np.random.default_rng(6)
    drawn = rng.normal(3.0, 0.2, 30)
    expected = stats.t.sf(
        (3.5 - drawn.mean()) / (drawn.std(ddof=1) * np.sqrt(1 + 1 / 30)), 29
    )
    assert tail_of_mean(3.5, drawn) == pytest.approx(expected, rel=1e-12)


def test_draws_that_do_not_vary_say_nothing():
    assert np.isnan(tail_of_squares(1.0, np.zeros(10)))
    assert np.isnan(tail_of_mean(1.0, np.full(10, 2.0)))
