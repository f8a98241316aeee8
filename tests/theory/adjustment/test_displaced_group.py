"""Given points that lie among the others and are displaced: these, and no others."""

import numpy as np
import pytest

from einschalt.theory.adjustment.displaced_group import find_displaced_group

SIGMA = 0.05
N = 24


def network(seed, n=N, n_free=3):
    """What is known of the errors of points that a plane with few unknowns joins."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(-2000.0, 2000.0, (n, 2))
    # models take up an affinity of the whole network, and half of what is left
    design = np.column_stack([np.ones(n), xy])[:, :n_free]
    basis = np.linalg.qr(design)[0]
    information = 0.5 * (np.eye(n) - basis @ basis.T) / SIGMA**2
    return xy, information, rng


def scores_of(information, errors, rng):
    """Scores of displaced points beside what chance makes, as their covariance is."""
    values, vectors = np.linalg.eigh(information)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    normal = rng.standard_normal((len(values), 2)) @ [1.0, 1j]
    return root @ normal + information @ errors


@pytest.mark.parametrize("size", [0.6, 1.5, 45.0])
@pytest.mark.parametrize("n_in", [4, 7, 11])
def test_exactly_the_displaced_points_are_found(size, n_in):
    for seed in range(5):
        xy, information, rng = network(seed)
        rows = np.sort(rng.choice(N, n_in, replace=False))
        shift = size * np.exp(1j * rng.uniform(0.0, 2.0 * np.pi))
        errors = np.zeros(N, dtype=complex)
        errors[rows] = shift
        scores = scores_of(information, errors, rng)
        found = find_displaced_group(scores, information, xy, 0.001)
        assert list(found.rows) == list(rows)
        miss = np.hypot(*(found.shift - [shift.real, shift.imag]))
        assert miss < 4.0 * found.standard_error < 0.4


def heights_of(information, errors, rng):
    """The same of one coordinate."""
    return scores_of(information, errors, rng).real


@pytest.mark.parametrize("size", [1.5, 45.0])
@pytest.mark.parametrize("n_in", [4, 7, 11])
def test_heights_have_groups_as_well(size, n_in):
    for seed in range(5):
        xy, information, rng = network(seed)
        rows = np.sort(rng.choice(N, n_in, replace=False))
        errors = size * np.isin(np.arange(N), rows)
        scores = heights_of(information, errors, rng)
        found = find_displaced_group(scores, information, xy, 0.001)
        assert list(found.rows) == list(rows)
        assert found.shift[1] == 0.0
        assert abs(found.shift[0] - size) < 4.0 * found.standard_error < 0.4


@pytest.mark.parametrize("n_wrong", [1, 2, 4, 6])
def test_single_wrong_heights_are_no_group(n_wrong):
    """Of six numbers four may be alike by chance, to the errors of the test."""
    n_groups = 0
    for seed in range(30):
        xy, information, rng = network(seed)
        errors = np.zeros(N)
        errors[:n_wrong] = rng.normal(0.0, 1.0, n_wrong)
        scores = heights_of(information, errors, rng)
        n_groups += find_displaced_group(scores, information, xy, 0.001) is not None
    assert n_groups <= (3 if n_wrong == 6 else 0)


@pytest.mark.parametrize("size", [0.1, 0.5, 5.0])
@pytest.mark.parametrize("axes", [scores_of, heights_of])
def test_larger_errors_of_all_points_are_no_group(size, axes):
    """Of the points alone: what models add to the misfit is as stated."""
    for seed in range(30):
        xy, information, rng = network(seed)
        errors = size * (rng.standard_normal((N, 2)) @ [1.0, 1j])
        errors = errors if axes is scores_of else errors.real
        scores = axes(information, errors, rng)
        assert find_displaced_group(scores, information, xy, 0.001) is None


def test_the_smaller_part_is_told_with_its_own_sign():
    xy, information, rng = network(1)
    errors = np.where(np.arange(N) < 18, 1.0 + 0j, 0.0)
    scores = scores_of(information, errors, rng)
    found = find_displaced_group(scores, information, xy, 0.001)
    assert list(found.rows) == list(range(18, N))
    np.testing.assert_allclose(found.shift, [-1.0, 0.0], atol=0.1)


def test_chance_makes_no_group():
    """Of 300 good networks about 0.05 of 300 have one at that level, or fewer."""
    found = 0
    for seed in range(300):
        xy, information, rng = network(seed)
        scores = scores_of(information, np.zeros(N), rng)
        found += find_displaced_group(scores, information, xy, 0.05) is not None
    assert found <= 0.05 * 300


def test_larger_errors_than_stated_make_no_group():
    for seed in range(50):
        xy, information, rng = network(seed)
        scores = 1.8 * scores_of(information, np.zeros(N), rng)
        assert find_displaced_group(scores, information, xy, 0.001) is None


def test_single_wrong_points_are_no_group():
    for seed in range(30):
        xy, information, rng = network(seed)
        errors = np.zeros(N, dtype=complex)
        errors[:3] = rng.normal(0.0, 1.0, (3, 2)) @ [1.0, 1j]
        scores = scores_of(information, errors, rng)
        assert find_displaced_group(scores, information, xy, 0.001) is None


@pytest.mark.parametrize("size", [0.1, 0.3, 1.0])
def test_smooth_strain_is_no_group(size):
    for seed in range(20):
        xy, information, rng = network(seed)
        bend = (xy[:, 0] / 2000.0) ** 2 + 1j * xy[:, 0] * xy[:, 1] / 2000.0**2
        scores = scores_of(information, size * bend, rng)
        assert find_displaced_group(scores, information, xy, 0.001) is None


def test_a_region_that_explains_as_much_stands():
    xy, information, rng = network(2)
    errors = np.where(np.arange(N) < 6, 0.8 + 0.2j, 0.0)
    scores = scores_of(information, errors, rng)
    assert find_displaced_group(scores, information, xy, 0.001, range(6)) is None
    part = find_displaced_group(scores, information, xy, 0.001, range(3))
    assert list(part.rows) == list(range(6))


def test_few_points_have_no_group():
    xy, information, rng = network(3, n=5)
    errors = np.where(np.arange(5) < 2, 5.0 + 0j, 0.0)
    scores = scores_of(information, errors, rng)
    assert find_displaced_group(scores, information, xy, 0.05) is None
