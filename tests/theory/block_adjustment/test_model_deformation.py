"""Deformations that the models of a flight share: found, sized, and not invented."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.distance import cdist

from einschalt.theory.block_adjustment import model_deformation
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    CUBIC,
    QUADRATIC,
    CommonTerms,
)
from einschalt.theory.block_adjustment.model_deformation import (
    EDGE,
    MIDDLE,
    examine_deformation,
    neighbour_autocorrelation,
)

TERMS = {"affine": (QUADRATIC, CUBIC), "helmert": (AFFINITY, QUADRATIC, CUBIC)}


def places(observations):
    """Position of each observation in the frame of the camera, 1 at the edge.

    The models of make_block are measured in one frame, and lie in it at any angle.
    """
    models = range(observations.n_models)
    of_models = [observations.xy[observations.model == m] for m in models]
    centres = [(xy.min(axis=0) + xy.max(axis=0)) / 2.0 for xy in of_models]
    halves = [np.ptp(xy, axis=0).max() / 2.0 for xy in of_models]
    return (observations.xy - np.median(centres, axis=0)) / np.median(halves)


def bend(observations, coefficients, is_bent=True):
    """Displace x by quadratic terms of the position [model units]."""
    x, y = places(observations).T
    moved = np.column_stack([x * x, x * y, y * y]) @ coefficients
    xy = observations.xy.copy()
    xy[:, 0] += np.where(is_bent, moved, 0.0)
    return replace(observations, xy=xy)


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_is_the_f_test_of_dense_gauss_markov(make_block, dense, kind):
    observations = bend(make_block("grid", kind), [0.01, -0.005, 0.004])
    found = examine_deformation(adjust(observations), 0)
    smaller = dense(observations)
    larger = dense(observations, (CommonTerms(0, TERMS[kind]),))
    k = smaller.redundancy - larger.redundancy
    assert k == len(found.terms.names) == (14 if kind == "affine" else 16)
    per_degree = (smaller.sum_of_squares - larger.sum_of_squares) / k
    f = per_degree / (larger.sum_of_squares / larger.redundancy)
    assert found.f_statistic == pytest.approx(f, rel=1e-8)
    p = stats.f.sf(f, k, larger.redundancy)
    assert found.p_value == pytest.approx(p, rel=1e-6)


def test_terms_that_are_known_are_not_tested_again(make_block, dense):
    observations = make_block("grid", "helmert", affinity=4e-4)
    known = (CommonTerms(0, (AFFINITY,)),)
    found = examine_deformation(adjust(observations, known), 0)
    smaller, larger = (
        dense(observations, (CommonTerms(0, families),))
        for families in ((AFFINITY,), TERMS["helmert"])
    )
    k = smaller.redundancy - larger.redundancy
    assert k == 14
    per_degree = (smaller.sum_of_squares - larger.sum_of_squares) / k
    f = per_degree / (larger.sum_of_squares / larger.redundancy)
    assert found.f_statistic == pytest.approx(f, rel=1e-6)
    everything = (CommonTerms(0, TERMS["helmert"]),)
    nothing_left = examine_deformation(adjust(observations, everything), 0)
    assert np.isnan(nothing_left.p_value)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_blocks_without_deformation_have_uniform_p_values(make_block, kind):
    p = [
        examine_deformation(adjust(make_block("grid", kind, seed=seed)), 0).p_value
        for seed in range(150)
    ]
    assert stats.kstest(p, "uniform").pvalue > 0.01
    # at 5 %: what chance allows with the probability 0.001
    assert np.sum(np.array(p) < 0.05) <= stats.binom.ppf(0.999, 150, 0.05)


def test_only_the_flight_that_is_deformed_is_named(make_block):
    plain = make_block("dense grid", "affine", n_flights=2)
    is_second = plain.flight[plain.model] == 1
    solution = adjust(bend(plain, [0.03, -0.02, 0.02], is_second))
    assert examine_deformation(solution, 1).p_value < 1e-6
    # the other one has to stand for a part of it until that is modelled
    second = (CommonTerms(1, TERMS["affine"]),)
    solution = adjust(bend(plain, [0.03, -0.02, 0.02], is_second), second)
    assert examine_deformation(solution, 0).p_value > 0.001


def test_size_is_that_of_the_displacement_that_no_affinity_takes_up(make_block):
    observations = make_block("dense grid", "affine")
    x, y = places(observations).T
    moved = np.column_stack([x * x, x * y, y * y]) @ [0.3, -0.2, 0.25]
    design = np.column_stack([np.ones(len(x)), x, y])
    moved = moved - design @ np.linalg.lstsq(design, moved)[0]
    ground = np.abs(moved) * 8.0  # scale 1 : 8000, model units are mm
    found = examine_deformation(adjust(bend(observations, [0.3, -0.2, 0.25])), 0)
    away = np.maximum(np.abs(x), np.abs(y))
    for size, part in (
        (found.size, away >= 0.0),
        (found.size_middle, away < MIDDLE),
        (found.size_edge, away > EDGE),
    ):
        # known to a few millimetres, with errors of 3 cm in hundreds of points
        assert size == pytest.approx(np.sqrt(np.mean(ground[part] ** 2)), abs=0.01)


def test_a_flight_that_is_too_small_is_not_judged(make_block):
    eleven_points = make_block("one model", "affine", every=2)
    found = examine_deformation(adjust(eleven_points), 0)
    assert np.isnan([found.p_value, found.size]).all()


def test_points_that_cannot_tell_terms_apart_are_not_judged(make_block):
    """Points in the same four places of every model carry no cubic polynomial."""
    corners = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]) * 60.0
    plain = make_block("dense grid", "affine")
    n_models, n_points = 25, 36
    i, j = np.divmod(np.arange(n_models), 5)
    steps = [(0, 0), (0, 1), (1, 0), (1, 1)]
    point = np.column_stack([(i + a) * 6 + j + b for a, b in steps]).ravel()
    ground = np.column_stack(np.divmod(np.arange(n_points), 6)) * 960.0
    rng = np.random.default_rng(2)
    noise = rng.normal(0.0, 0.004, (4 * n_models, 2))
    covariance = np.tile(4e-4 * np.eye(2), (n_points, 1, 1))
    observations = replace(
        plain,
        model=np.repeat(np.arange(n_models), 4),
        point=point,
        xy=np.tile(corners, (n_models, 1)) + noise * 1e-9,
        standard_error=np.full(4 * n_models, 0.03),
        control=ground + rng.normal(0.0, 0.02, ground.shape),
        control_covariance=covariance,
    )
    assert np.isnan(examine_deformation(adjust(observations), 0).p_value)


def test_likeness_is_the_correlation_with_the_nearest_point(make_block):
    observations = make_block("grid", "affine", weights=True, n_flights=2)
    solution = adjust(observations)
    for flight in (0, 1):
        products, squares = [], []
        for m in np.flatnonzero(observations.flight == flight):
            rows = observations.model == m
            v = solution.residuals[rows] / observations.standard_error[rows, None]
            apart = cdist(observations.xy[rows], observations.xy[rows])
            np.fill_diagonal(apart, np.inf)
            products.append(np.sum(v * v[apart.argmin(axis=1)]))
            squares.append(np.sum(v**2))
        found = neighbour_autocorrelation(solution, flight)
        assert found.correlation == pytest.approx(
            sum(products) / sum(squares), rel=1e-9
        )


def test_error_of_the_likeness_is_the_one_that_it_has(make_block):
    """Half of the points and more are the nearest of their own nearest point."""
    observations = make_block("grid", "affine", weights=True)
    rng = np.random.default_rng(5)
    z = []
    for _ in range(400):
        shape = (len(observations.xy), 2)
        errors = rng.standard_normal(shape) * observations.standard_error[:, None]
        solution = SimpleNamespace(observations=observations, residuals=errors)
        found = neighbour_autocorrelation(solution, 0)
        z.append(found.correlation / found.standard_error)
    # the variance of 400 values is known to 7 %
    assert np.mean(np.square(z)) == pytest.approx(1.0, abs=3.3 * np.sqrt(2.0 / 400))


def test_residuals_are_alike_only_where_models_are_bent(make_block):
    plain = make_block("dense grid", "affine")
    assert not neighbour_autocorrelation(adjust(plain), 0).is_large
    rng = np.random.default_rng(1)
    own = rng.normal(0.0, 0.03, (plain.n_models, 3))[plain.model]
    x, y = places(plain).T
    xy = plain.xy.copy()
    xy[:, 0] += np.einsum("nk,nk->n", np.column_stack([x * x, x * y, y * y]), own)
    bent = adjust(replace(plain, xy=xy))
    assert neighbour_autocorrelation(bent, 0).is_large
    # no common term takes up what each model has for itself
    terms = (CommonTerms(0, TERMS["affine"]),)
    assert neighbour_autocorrelation(adjust(bent.observations, terms), 0).is_large


def test_a_flight_without_residuals_is_like_nothing(make_block):
    observations = make_block("one model", "affine", every=2)
    few = observations.of_rows(np.array([0, 4, 8]), np.array([0])).observations
    exact = replace(few, control=few.xy * 8.0, control_covariance=np.zeros((3, 2, 2)))
    found = neighbour_autocorrelation(adjust(exact), 0)
    assert not found.is_large


def test_a_flight_that_is_left_no_residuals_is_not_judged(make_block, monkeypatch):
    solution = adjust(make_block("grid", "affine"))
    exact = replace(solution, sum_of_squares=0.0)
    monkeypatch.setattr(model_deformation, "adjust", lambda *_, **__: exact)
    assert np.isnan(examine_deformation(solution, 0).p_value)
