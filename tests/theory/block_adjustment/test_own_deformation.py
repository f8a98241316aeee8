"""Deformations that each model has for itself: the likelihood, and sizes it finds."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.common_parameters import CommonTerms
from einschalt.theory.block_adjustment.observations import BlockObservations
from einschalt.theory.block_adjustment.own_deformation import (
    PLAN,
    OwnDeformation,
    bending_terms,
    bent_columns,
)
from einschalt.theory.block_adjustment.own_deformation_size import (
    NO_DEFORMATION,
    chance_of_residuals,
    estimate_own_deformation,
    sample_of_models,
)
from einschalt.theory.block_adjustment.spatial_observations import SpatialObservations
from einschalt.theory.block_adjustment.spatial_solution import adjust_models

SIGMA = 0.03
LENGTH = 100.0


def strip(seed, n_models, *, kind="affine", quadratic=0.0, spacing=10.0):
    """Two coverages of models of 100 m, laid by half a model, over a grid of points."""
    rng = np.random.default_rng(seed)
    width = LENGTH * (n_models + 1) / 2.0
    along, across = (
        np.arange(0.0, width + 1e-9, spacing),
        np.arange(0.0, 101.0, spacing),
    )
    ground = np.stack(np.meshgrid(along, across), -1).reshape(-1, 2)
    rows = [
        (m, p)
        for m in range(n_models)
        for p in np.flatnonzero(np.abs(ground[:, 0] - LENGTH * (m + 1) / 2.0) <= 50.001)
    ]
    model, point = np.array(rows).T
    centre = np.stack([LENGTH * (np.arange(n_models) + 1) / 2.0, np.full(n_models, 50)])
    xy = ground[point] - centre.T[model]
    terms = bending_terms("quadratic", xy / 50.0).real
    bends = quadratic * rng.standard_normal((n_models, 3, 2))
    error = SIGMA * rng.standard_normal(xy.shape)
    measured = xy + error + np.einsum("nk,nkc->nc", terms, bends[model])
    corners = np.isin(ground[:, 0], [along[0], along[-1], along[len(along) // 2]])
    is_control = corners & np.isin(ground[:, 1], [0.0, across[-1]])
    control = np.where(is_control[:, None], ground, np.nan)
    covariance = np.where(is_control, 0.02**2, 0.0)[:, None, None] * np.eye(2)
    observations = BlockObservations(
        model=model,
        point=point,
        xy=measured,
        standard_error=np.full(len(model), SIGMA),
        is_affine=np.full(n_models, kind == "affine"),
        flight=np.zeros(n_models, dtype=np.int64),
        control=control,
        control_covariance=covariance,
    )
    return observations, ground


def estimated(observations, places):
    sample = sample_of_models(observations, places).observations
    return estimate_own_deformation(adjust_models(sample))


def only(family, size):
    return OwnDeformation(
        np.array([0]), (family,), (PLAN,), np.array([size]), np.array([np.nan]), np.nan
    )


def dense_deviance(observations, bent):
    """−2 log of the restricted likelihood, one dense matrix, easting and northing."""
    n, n_models, n_points = len(observations.model), 4, observations.n_points
    x, y = observations.xy.T
    own = np.stack([np.ones(n), x, y], -1) / [1.0, LENGTH, LENGTH]
    design = np.zeros((n, 3 * n_models + n_points))
    for row, (m, p) in enumerate(
        zip(observations.model, observations.point, strict=True)
    ):
        design[row, 3 * m : 3 * m + 3] = own[row]
        design[row, 3 * n_models + p] = -1.0
    held = np.flatnonzero(observations.is_control)
    given = np.zeros((len(held), design.shape[1]))
    given[np.arange(len(held)), 3 * n_models + held] = 1.0
    design = np.vstack([design, given])
    right = np.vstack([np.zeros((n, 2)), observations.control[held]])
    variance = np.diag(np.r_[np.full(n, SIGMA**2), np.full(len(held), 0.02**2)])
    for m in range(n_models):
        rows = np.flatnonzero(observations.model == m)
        variance[np.ix_(rows, rows)] += bent[rows] @ bent[rows].T
    inverse = np.linalg.inv(variance)
    normals = design.T @ inverse @ design
    found = np.linalg.solve(normals, design.T @ inverse @ right)
    rest = right - design @ found
    omega = np.einsum("ic,ij,jc->", rest, inverse, rest)
    f = 2 * (len(design) - design.shape[1])
    logs = np.linalg.slogdet(variance)[1] + np.linalg.slogdet(normals)[1]
    return f * np.log(omega / f) + 2.0 * logs, f


def test_the_likelihood_is_that_of_one_dense_matrix():
    observations, _ = strip(1, 4, quadratic=0.05, spacing=25.0)
    plain = adjust(observations)
    found, expected = [], []
    for size in (0.01, 0.05, 0.3):
        bent = bent_columns(observations, only("quadratic", size))
        solution = adjust(replace(observations, bent=bent))
        f = solution.redundancy
        deviance = f * np.log(solution.sum_of_squares / f) + solution.log_determinant
        found.append(deviance - plain.log_determinant)
        dense, f_dense = dense_deviance(observations, bent)
        assert f == f_dense
        expected.append(dense)
    assert np.diff(found) == pytest.approx(np.diff(expected), rel=1e-6)


def test_the_size_found_is_the_most_likely_one():
    observations, ground = strip(2, 12, quadratic=0.05)
    own = estimated(observations, ground)
    k = own.family.index("quadratic")

    def deviance(factor):
        size = own.size.copy()
        size[k] *= factor
        bent = bent_columns(observations, replace(own, size=size))
        solution = adjust(replace(observations, bent=bent))
        f = solution.redundancy
        return f * np.log(solution.sum_of_squares / f) + solution.log_determinant

    best = deviance(1.0)
    assert deviance(0.85) > best
    assert deviance(1.15) > best


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_sizes_are_found_again(kind):
    found = [
        estimated(*strip(seed, 16, kind=kind, quadratic=0.05)) for seed in range(6)
    ]
    sizes = np.array([own.size[own.family.index("quadratic")] for own in found])
    errors = np.array(
        [own.relative_error[own.family.index("quadratic")] for own in found]
    )
    # six estimates of one size, each with its standard error
    mean_error = 0.05 * np.sqrt(np.mean(errors**2) / len(found))
    assert abs(sizes.mean() - 0.05) < 3.0 * mean_error
    assert all(own.p_value < 1e-6 for own in found)


def test_models_without_deformations_seem_to_have_none():
    chances = [
        np.nan_to_num(estimated(*strip(seed, 10)).p_value, nan=1.0)
        for seed in range(40)
    ]
    # at 0.05 two of forty are expected, and seven come once in a thousand
    assert np.sum(np.array(chances) < 0.05) <= 6
    assert min(chances) > 1e-4


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_what_follows_from_errors_is_what_an_adjustment_with_them_gives(kind):
    observations, ground = strip(3, 4, kind=kind, spacing=25.0)
    # a strip alone tells little of what all of its models share
    everywhere = np.tile(0.02**2 * np.eye(2), (len(ground), 1, 1))
    observations = replace(observations, control=ground, control_covariance=everywhere)
    families = ("quadratic",) if kind == "affine" else ("affinity", "quadratic")
    terms = (CommonTerms(0, families),)
    plain = adjust(observations, terms)
    rng = np.random.default_rng(3)
    errors = 1e-4 * rng.standard_normal((len(observations.model), 2, 1))
    given = 1e-4 * rng.standard_normal((len(ground), 2, 1))
    moved = replace(
        observations,
        xy=observations.xy + errors[:, :, 0],
        control=observations.control + given[:, :, 0],
    )
    found = adjust(moved, terms)
    points, residuals = (part[:, :, 0] for part in plain.answer_to(errors, given))
    # models are turned and scaled by some 1e-3, so are the errors on the ground
    assert np.abs(found.residuals - plain.residuals - residuals).max() < 1e-6
    assert np.abs(found.points - plain.points - points).max() < 1e-6
    assert min(np.abs(residuals).max(), np.abs(points).max()) > 1e-5


def test_residuals_without_deformations_are_as_likely_as_chance_has_it():
    chances = []
    for seed in range(60):
        observations, _ = strip(seed, 6, spacing=25.0)
        everything = only("quadratic", 1.0)
        chances.append(chance_of_residuals(adjust(observations), everything))
    # only what is larger than expected counts: half of the chances are near 1
    for level in (0.1, 0.3):
        count = int(np.sum(np.array(chances) <= level))
        assert binomtest(count, len(chances), level).pvalue > 0.01
    bent, _ = strip(61, 6, spacing=25.0, quadratic=0.05)
    assert chance_of_residuals(adjust(bent), only("quadratic", 1.0)) < 0.02


def test_a_sample_of_a_large_block_tells_the_same():
    observations, ground = strip(5, 200, quadratic=0.05, spacing=20.0)
    own = estimated(observations, ground)
    k = own.family.index("quadratic")
    assert abs(own.size[k] / 0.05 - 1.0) < 4.0 * own.relative_error[k]
    clean, ground = strip(6, 200, spacing=20.0)
    assert not estimated(clean, ground).p_value < 0.001


def test_gross_errors_are_no_deformation():
    observations, ground = strip(7, 12)
    xy = observations.xy.copy()
    xy[::97] += 5.0
    own = estimated(replace(observations, xy=xy), ground)
    assert not own.p_value < 0.01


def test_misfits_of_a_hundred_errors_are_no_deformation():
    """Names, control or units are wrong then; no photograph is bent by metres."""

    def kinds(size):
        observations, _ = strip(3, 6, quadratic=size * SIGMA)
        plain = adjust_models(observations)
        return plain.s_0, estimate_own_deformation(plain).kinds

    s_0, found = kinds(20.0)
    assert s_0 < 20.0
    assert found
    for size in (400.0, 1000.0):  # of the latter all control looks like gross errors
        s_0, found = kinds(size)
        assert s_0 > NO_DEFORMATION
        assert not found


def test_a_gross_error_hides_no_deformation():
    observations, ground = strip(9, 12, quadratic=0.04)
    xy = observations.xy.copy()
    xy[len(xy) // 2] += 5.0
    own = estimated(replace(observations, xy=xy), ground)
    assert own.p_value < 1e-4
    assert own.size[own.family.index("quadratic")] == pytest.approx(0.04, rel=0.4)


def test_drawn_errors_are_those_that_the_adjustment_takes_for_given():
    """Of orientations and deformations that all points of a model share, too."""
    observations, _ = strip(3, 4, spacing=25.0)
    rng = np.random.default_rng(2)
    n_rows = len(observations.model)
    shared = 0.05 * rng.standard_normal((n_rows, 2, 3))
    bent = 0.04 * (
        rng.standard_normal((n_rows, 2)) + 1j * rng.standard_normal((n_rows, 2))
    )
    given = replace(observations, orientation=shared, bent=bent)
    linear = np.tile([[0.0, -1.0], [1.0, 0.0]], (4, 1, 1))
    drawn = given.drawn_errors(rng, 20_000, linear)
    rows = np.flatnonzero(given.model == 1)[:2]
    found = np.einsum("acn,bdn->acbd", drawn[rows], drawn[rows]) / drawn.shape[2]
    turned = linear[0] @ shared[rows]
    turns = np.stack([bent[rows], 1j * bent[rows]], -1).reshape(2, -1)
    columns = np.concatenate([turned, np.stack([turns.real, turns.imag], 1)], axis=2)
    expected = np.einsum("ack,bdk->acbd", columns, columns)
    expected[[0, 0, 1, 1], [0, 1, 0, 1], [0, 0, 1, 1], [0, 1, 0, 1]] += SIGMA**2
    np.testing.assert_allclose(found, expected, atol=0.05 * expected.max())


def test_heights_have_sizes_of_their_own():
    plane, ground = strip(8, 10)
    rng = np.random.default_rng(8)
    n, n_points = len(plane.model), plane.n_points
    terms = bending_terms("quadratic", _positions(plane)).real
    bends = 0.08 * rng.standard_normal((10, 3))
    relief = 5.0 * np.sin(ground[:, 0] / 30.0)
    heights = relief[plane.point] + 0.05 * rng.standard_normal(n)
    heights += (terms * bends[plane.model]).sum(axis=1)
    control = np.column_stack(
        [plane.control, np.where(plane.is_control, relief, np.nan)]
    )
    covariance = np.zeros((n_points, 3, 3))
    covariance[plane.is_control] = 0.02**2 * np.eye(3)
    observations = SpatialObservations(
        model=plane.model,
        point=plane.point,
        xyz=np.column_stack([plane.xy, heights]),
        standard_error=np.tile([SIGMA, SIGMA, 0.05], (n, 1)),
        flight=plane.flight,
        control=control,
        control_covariance=covariance,
    )
    places = np.column_stack([ground, relief])
    own = estimated(observations, places)
    assert own.p_value < 1e-6
    of_height = own.size_of(0, "quadratic", "height")
    assert of_height == pytest.approx(0.08, rel=0.35)
    assert own.edge(0) < 0.02
    assert own.edge(0, "height") > 0.05


def _positions(observations):
    start = np.flatnonzero(np.r_[True, np.diff(observations.model) > 0])
    low = np.minimum.reduceat(observations.xy, start)
    high = np.maximum.reduceat(observations.xy, start)
    return (observations.xy - (low + high)[observations.model] / 2.0) / 50.0
