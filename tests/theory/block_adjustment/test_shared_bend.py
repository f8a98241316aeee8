"""Bends in height that models share, against least squares with every unknown."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import least_squares
from tests.theory.block_adjustment.test_spatial_solution import (
    Dense,
    a_block,
    assert_close,
    turned_by,
)

from einschalt.theory.block_adjustment.common_border import UndeterminedTermsError
from einschalt.theory.block_adjustment.shared_bend import (
    OF_HEIGHTS,
    SCALE,
    AnswerToBends,
    BendTerms,
    MadeByErrors,
    bent_heights,
    examine_bends,
    positions_of_flights,
    scaled_heights,
)
from einschalt.theory.block_adjustment.spatial_solution import adjust_spatially

BENT_BY = np.array([0.04, -0.02, 0.03])  # at the edge of a model [mm at 1:8000]


def with_flights(observations, n_flights=2):
    flight = np.arange(observations.n_models) % n_flights
    return replace(observations, flight=flight)


def a_bent_block(seed=0, bent_by=BENT_BY, n_flights=1, **more):
    """A block whose heights are bent, the terms of its flights, and the truth."""
    observations, truth = a_block(seed=seed, **more)
    observations = with_flights(observations, n_flights)
    terms = all_terms(observations)
    xyz = observations.xyz.copy()
    xyz -= terms.of_flights([0]).columns @ bent_by
    return replace(observations, xyz=xyz), terms, truth


def all_terms(observations):
    is_ground = np.ones(len(observations.model), dtype=bool)
    position = positions_of_flights(observations, is_ground)
    every = bent_heights(position)
    flight = observations.flight[observations.model]
    flights = np.unique(observations.flight)
    every = np.concatenate([every, scaled_heights(observations, is_ground)], axis=2)
    columns = [np.where((flight == k)[:, None, None], every, 0.0) for k in flights]
    names = (*OF_HEIGHTS, SCALE) * len(flights)
    numbers = np.repeat(flights, len(OF_HEIGHTS) + 1)
    return BendTerms(np.concatenate(columns, axis=2), numbers, names, position)


def bends_of(terms):
    """Columns of the bends of all flights."""
    return terms.of_flights(np.unique(terms.flight)).columns


class DenseBent(Dense):
    """The coefficients of the bend are unknowns too, the last of all."""

    def residuals(self, x):
        n_terms = self.given.shared_bend.shape[2]
        moved = self.given.shared_bend @ x[len(x) - n_terms :]
        self.xyz = self.given.xyz - self.centroid[self.given.model] + moved
        return super().residuals(x[: len(x) - n_terms])

    def solve(self, found):
        models = found.parameters.copy()
        arm = models[:, 3:4] * turned_by(models[:, 4:], self.centroid)
        models[:, :3] += arm - self.origin
        points = (found.points - self.origin)[self.is_free]
        x = np.concatenate([models.ravel(), points.ravel(), found.common])
        rng = np.random.default_rng(1)
        x += 1e-3 * np.maximum(np.abs(x), 1e-3) * rng.standard_normal(len(x))
        x = least_squares(self.residuals, x, jac=self.jacobian, x_scale="jac").x
        for _ in range(8):
            x = x - np.linalg.lstsq(self.jacobian(x), self.residuals(x))[0]
        return x


@pytest.mark.parametrize("control", ["even", "correlated", "held"])
def test_equals_least_squares_with_every_unknown(control):
    observations, terms, _ = a_bent_block(control=control, n_flights=2)
    observations = replace(observations, shared_bend=bends_of(terms))
    found = adjust_spatially(observations)
    dense = DenseBent(observations, found)
    x = dense.solve(found)
    n_models, n_terms = observations.n_models, 2 * len(OF_HEIGHTS)
    np.testing.assert_allclose(found.common, x[-n_terms:], rtol=0, atol=1e-8)
    _, points = dense.unpacked(x[:-n_terms])
    np.testing.assert_allclose(found.points, points + dense.origin, rtol=0, atol=1e-8)
    v = dense.residuals(x)
    assert found.redundancy == len(v) - len(x)
    assert found.sum_of_squares == pytest.approx(v @ v, rel=1e-9)
    jacobian = dense.jacobian(x)
    size = np.linalg.norm(jacobian, axis=0)
    q, r = np.linalg.qr(jacobian / size)
    root = np.linalg.inv(r)
    cofactors = root @ root.T / np.outer(size, size)
    assert_close(found.common_cofactors, cofactors[-n_terms:, -n_terms:], 1e-6)
    for k, p in enumerate(np.flatnonzero(~observations.is_fixed)):
        at = slice(7 * n_models + 3 * k, 7 * n_models + 3 * k + 3)
        assert_close(found.point_cofactors[p], cofactors[at, at], 1e-6)
    for m in range(n_models):
        at = slice(7 * m + 3, 7 * m + 7)
        own = found.parameter_cofactors[m][3:, 3:]
        assert_close(own, cofactors[at, at], 1e-6)
    n_rows = len(observations.xyz)
    hat = (q**2).sum(axis=1)[: 3 * n_rows].reshape(-1, 3)
    np.testing.assert_allclose(found.leverage, hat, rtol=0, atol=1e-8)


def test_the_answer_to_errors_is_that_of_other_measurements():
    observations, terms, _ = a_bent_block()
    observations = replace(observations, shared_bend=bends_of(terms))
    found = adjust_spatially(observations)
    rng = np.random.default_rng(4)
    moves = 1e-6 * rng.standard_normal(observations.xyz.shape)  # mm
    on_ground = np.einsum("nij,nj->ni", found.linear[observations.model], moves)
    held = np.zeros((*observations.control.shape, 1))
    points, residuals = found.answer_to(on_ground[:, :, None], held)
    moved = replace(observations, xyz=observations.xyz + moves)
    other = found.adjusted_anew(moved)
    largest = np.abs(other.points - found.points).max()
    expected = (other.points - found.points, other.residuals - found.residuals)
    for answer, difference in zip((points, residuals), expected, strict=True):
        np.testing.assert_allclose(
            answer[:, :, 0], difference, rtol=0, atol=2e-3 * largest
        )


def test_bent_heights_have_the_error_that_is_claimed():
    squares, plain = [], []
    for seed in range(20):
        observations, terms, truth = a_bent_block(seed)
        found = adjust_spatially(replace(observations, shared_bend=bends_of(terms)))
        error = (found.points - truth)[:, 2]
        squares.append(np.mean(error**2 / found.point_cofactors[:, 2, 2]))
        away = found.common - BENT_BY
        assert away @ np.linalg.solve(found.common_cofactors, away) < 25.0
        rough = adjust_spatially(observations)
        away = (rough.points - truth)[:, 2] ** 2
        plain.append(np.mean(away / rough.point_cofactors[:, 2, 2]))
    assert np.mean(squares) == pytest.approx(1.0, abs=0.25)
    assert np.mean(plain) > 2.0


def examined(observations):
    solution, terms = adjust_spatially(observations), all_terms(observations)
    answer = AnswerToBends.of(solution, terms)
    made = MadeByErrors(answer.normals, 1.0)
    return examine_bends(solution, terms, answer, made, 0.001)


def test_p_values_of_straight_models_are_uniform():
    blocks = (with_flights(a_block(seed=seed)[0]) for seed in range(60))
    p = [test.p_value for block in blocks for test in examined(block)[0]]
    assert stats.kstest(p, "uniform").pvalue > 0.01


def test_the_bent_flight_is_found_with_its_size_and_the_other_one_gets_terms_too():
    bent_by = 1.5 * BENT_BY
    observations, terms, _ = a_bent_block(bent_by=bent_by, n_flights=2)
    tests, found = examined(observations)
    assert tests[0].p_value < 1e-6 < tests[1].p_value
    assert found == [0, 1]
    moved = 8.0 * terms.of_flights([0]).columns[:, 2] @ bent_by
    away = np.abs(terms.position).max(axis=1)
    is_own = terms.columns[:, 2, 0] != 0.0
    plane = np.column_stack([np.ones(len(moved)), terms.position]) * is_own[:, None]
    moved -= plane @ np.linalg.lstsq(plane, moved)[0]
    of_parts = (is_own, is_own & (away < 0.35), is_own & (away > 0.75))
    expected = [np.sqrt(np.mean(moved[part] ** 2)) for part in of_parts]
    sizes = [tests[0].size, tests[0].size_middle, tests[0].size_edge]
    np.testing.assert_allclose(sizes, expected, rtol=0.2)


def test_a_bend_that_no_residual_shows_is_not_tested():
    """Of one model three control points show nothing but how it lies."""
    observations, _ = a_block("one model", n_points=30, every=10)
    assert np.count_nonzero(observations.is_control) == 3
    tests, found = examined(observations)
    assert np.isnan(tests[0].p_value)
    assert not found
    columns = bends_of(all_terms(observations))
    with pytest.raises(UndeterminedTermsError):
        adjust_spatially(replace(observations, shared_bend=columns))


def test_a_bend_of_many_times_the_errors_of_heights_is_none():
    """Where it hardly shows other errors seem to be one."""
    observations, _, _ = a_bent_block(bent_by=4.0 * BENT_BY)
    tests, found = examined(observations)
    assert np.isnan(tests[0].p_value)
    assert not found
