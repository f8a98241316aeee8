"""Regions displaced in given points that check each other, on a grid."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from einschalt.theory.adjustment.around_region import Around
from einschalt.theory.adjustment.displaced_regions import (
    FEWEST_POINTS,
    find_displaced_regions,
    regions_of,
)
from einschalt.theory.adjustment.reliability import noncentrality
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

SIGMA = 0.05  # of one coordinate [m]
GRID = np.stack(np.meshgrid(*[np.arange(9) * 300.0] * 2), axis=-1).reshape(-1, 2)
N = len(GRID)
# each point is checked by the others, all of them together by nothing
INFORMATION = (np.eye(N) - 1.0 / N) / SIGMA**2
WEIGHTS = np.full(N, SIGMA**-2.0)
SHIFT = np.array([0.12, -0.16])
# half of the shift is two standard errors of a point: a few are taken for the others
MOST_POINTS = 0.85


def errors(seed, size=SIGMA):
    return size * np.random.default_rng(seed).standard_normal((N, 2))


class Checks:
    """What the points know of each other."""

    def __init__(self, given, information=INFORMATION):
        self.information = information
        self.scores = information @ (given @ np.array([1.0, 1j]))

    def times(self, columns):
        return self.information @ columns

    def draw(self, n_draws, seed):
        shape = (len(self.scores), n_draws)
        drawn = SIGMA * np.random.default_rng(seed).standard_normal(shape)
        return self.information @ drawn


def all_found_in(given):
    return find_displaced_regions(Checks(given), WEIGHTS, GRID).regions


def found_in(given):
    found = all_found_in(given)
    return found[0] if found else None


def inside(middle, radius):
    return np.hypot(*(GRID - middle).T) <= radius


def overlap(found, is_in):
    rows = set(np.flatnonzero(is_in))
    return len(rows & set(found.rows)) / len(rows | set(found.rows))


@pytest.mark.parametrize(
    ("middle", "radius"), [((1200.0, 1200.0), 650.0), ((0.0, 300.0), 800.0)]
)
def test_a_displaced_region_is_found(middle, radius):
    is_in = inside(middle, radius)
    found = found_in(errors(1) + np.outer(is_in, SHIFT))
    assert overlap(found, is_in) > MOST_POINTS
    assert found.shift == pytest.approx(SHIFT, abs=4.0 * found.standard_error)
    n_in = len(found.rows)
    known = np.sqrt(1.0 / n_in + 1.0 / (N - n_in)) * SIGMA
    assert found.standard_error == pytest.approx(known)
    assert found.p_value < FINDING_SIGNIFICANCE


def test_a_strip_beyond_a_slanting_line():
    is_in = GRID @ [1.0, 1.0] > 3350.0
    found = found_in(errors(2) + np.outer(is_in, SHIFT))
    assert overlap(found, is_in) > MOST_POINTS


def test_the_smaller_part_is_named():
    is_in = inside((1200.0, 1200.0), 1350.0)
    assert is_in.sum() > N / 2
    found = found_in(errors(3) + np.outer(is_in, 2.0 * SHIFT))
    assert overlap(found, ~is_in) > MOST_POINTS
    assert found.shift == pytest.approx(-2.0 * SHIFT, abs=4.0 * found.standard_error)


def test_errors_of_the_stated_size_are_no_region():
    assert not [seed for seed in range(40) if found_in(errors(seed)) is not None]


@pytest.mark.slow
def test_larger_errors_are_no_region():
    larger = [found_in(errors(seed, 1.5 * SIGMA)) for seed in range(40)]
    assert larger.count(None) == len(larger)


@pytest.mark.parametrize("seed", [10, 11, 12, 13])
def test_a_region_among_errors_that_are_larger_than_stated(seed):
    is_in = inside((1200.0, 1200.0), 650.0)
    larger = errors(seed, 3.0 * SIGMA)
    assert found_in(larger) is None
    given = larger + 4.0 * np.outer(is_in, SHIFT)
    scan = find_displaced_regions(Checks(given), WEIGHTS, GRID)
    (found,) = scan.regions
    assert overlap(found, is_in) > MOST_POINTS
    assert found.shift == pytest.approx(4.0 * SHIFT, abs=4.0 * found.standard_error)
    assert 2.0 < scan.enlargement < 4.5
    n_in = len(found.rows)
    known = np.sqrt(1.0 / n_in + 1.0 / (N - n_in)) * SIGMA * scan.enlargement
    assert found.standard_error == pytest.approx(known)


@pytest.mark.slow
@pytest.mark.parametrize("length", [600.0, 2000.0])
def test_a_smooth_pattern_is_no_region(length):
    root = np.linalg.cholesky(np.exp(-cdist(GRID, GRID) / length) + 1e-9 * np.eye(N))
    rng = np.random.default_rng(4)
    smooth = [4.0 * SIGMA * root @ rng.standard_normal((N, 2)) for _ in range(20)]
    found = [found_in(errors(k) + field) for k, field in enumerate(smooth)]
    assert found.count(None) == len(found)


def _among_larger_errors():
    """What looks like a region where all errors are larger than stated."""
    return errors(61, 1.5 * SIGMA)


def _in_a_smooth_pattern():
    is_in = inside((1200.0, 1200.0), 650.0)
    root = np.linalg.cholesky(np.exp(-cdist(GRID, GRID) / 1500.0) + 1e-9 * np.eye(N))
    smooth = root @ np.random.default_rng(101).standard_normal((N, 2))
    return errors(1) + 1.2 * SIGMA * smooth + np.outer(is_in, SHIFT)


@pytest.mark.parametrize(
    ("test", "passed", "given"),
    [
        ("tail", 0.0, _among_larger_errors()),
        ("smoothness", 1.0, _in_a_smooth_pattern()),
    ],
)
def test_one_test_alone_keeps_a_region_from_being_named(
    test, passed, given, monkeypatch
):
    assert found_in(given) is None
    monkeypatch.setattr(Around, test, lambda _: passed)
    assert found_in(given) is not None


def of_all(parts, shifts):
    return sum(np.outer(part, shift) for part, shift in zip(parts, shifts, strict=True))


PLACES = [(300.0, 300.0), (2100.0, 1800.0), (300.0, 2100.0)]
SHIFTS = [(0.3, 0.0), (0.0, 0.3), (-0.2, -0.25)]


@pytest.mark.parametrize("n_regions", [2, 3])
@pytest.mark.parametrize("seed", [5, 6, 7])
def test_each_of_several_regions_is_found(n_regions, seed):
    parts = [inside(middle, 500.0) for middle in PLACES[:n_regions]]
    found = all_found_in(errors(seed) + of_all(parts, SHIFTS[:n_regions]))
    assert len(found) == n_regions
    for part, shift in zip(parts, SHIFTS, strict=False):
        region = max(found, key=lambda one: overlap(one, part))
        assert overlap(region, part) > MOST_POINTS
        assert region.shift == pytest.approx(shift, abs=4.0 * region.standard_error)
        assert region.p_value < FINDING_SIGNIFICANCE
    # each is known beside the others
    n_in = [len(region.rows) for region in found]
    known = np.sqrt(1.0 / np.array(n_in) + 1.0 / (N - sum(n_in))) * SIGMA
    assert [region.standard_error for region in found] == pytest.approx(known)
    rows = np.concatenate([region.rows for region in found])
    assert len(np.unique(rows)) == len(rows)


def test_regions_that_touch_are_told_apart():
    first, second = inside((900.0, 1200.0), 500.0), inside((1800.0, 1200.0), 500.0)
    second &= ~first
    found = all_found_in(errors(9) + of_all([first, second], [(0.3, 0.0), (0.1, 0.3)]))
    assert len(found) == 2
    for part in (first, second):
        assert max(overlap(region, part) for region in found) > MOST_POINTS


def test_of_too_many_regions_none_is_named():
    parts = [inside(middle, 500.0) for middle in [*PLACES, (2100.0, 300.0)]]
    found = all_found_in(errors(8) + of_all(parts, [*SHIFTS, (0.25, -0.2)]))
    assert found == ()


@pytest.mark.parametrize("seed", [3, 6, 24])
def test_regions_that_are_all_points_are_none(seed):
    """Of an axis out of scale; that all are moved alike shows nowhere.

    It ended in a singular matrix.
    """
    rng, n = np.random.default_rng(seed), 16
    places = rng.uniform(0.0, 3000.0, (n, 2))
    moved = places * [0.3, 0.0] + rng.normal(0.0, 1.0, (n, 2))
    checks = Checks(moved, n * np.eye(n) - 1.0)
    found = find_displaced_regions(checks, np.full(n, float(n)), places)
    assert found.regions == ()


LARGE = np.stack(np.meshgrid(*[np.arange(32) * 300.0] * 2), axis=-1).reshape(-1, 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    "is_in",
    [
        np.hypot(*(LARGE - 4800.0).T) < 2700.0,  # 253 points about the middle
        np.hypot(*LARGE.T) < 5600.0,  # 282 in a corner
        np.abs(LARGE[:, 1] - 4500.0) < 1400.0,  # a band from side to side
        np.abs(LARGE @ [0.6, 0.8] - 6500.0) < 1300.0,  # a slanting one
    ],
)
def test_large_regions_are_followed_along_their_rim(is_in):
    n = len(LARGE)
    rng = np.random.default_rng(9)
    given = SIGMA * rng.standard_normal((n, 2)) + np.outer(is_in, SHIFT)
    checks = Checks(given, (np.eye(n) - 1.0 / n) / SIGMA**2)
    scan = find_displaced_regions(checks, np.full(n, SIGMA**-2.0), LARGE)
    (found,) = scan.regions
    assert overlap(found, is_in) > 0.95
    assert found.shift == pytest.approx(SHIFT, abs=4.0 * found.standard_error)
    assert scan.p_value < 1e-20


def test_the_clearest_of_many_regions_is_told_where_none_is_named():
    scan = find_displaced_regions(Checks(errors(3)), WEIGHTS, GRID)
    assert scan.regions == ()
    assert 100 < scan.n_tried < 3000
    expected = min(scan.n_tried * np.exp(-scan.square / 2.0), 1.0)
    assert scan.p_value == pytest.approx(expected)
    assert scan.p_value > FINDING_SIGNIFICANCE


def test_few_points_have_no_region():
    few = np.arange(2 * FEWEST_POINTS - 1)
    checks = Checks(np.full((len(few), 2), 1.0), np.eye(len(few)))
    assert find_displaced_regions(checks, WEIGHTS[few], GRID[few]).regions == ()


def test_regions_are_of_all_sizes_and_not_too_many():
    regions = regions_of(GRID).toarray()
    size = regions.sum(axis=1)
    assert size.min() == FEWEST_POINTS
    assert N // 3 < size.max() <= N // 2
    many = np.random.default_rng(6).uniform(0.0, 1e4, (5000, 2))
    assert 1000 < regions_of(many).shape[0] < 4000


def test_how_far_a_region_may_be_displaced_is_known_where_none_is():
    """Of a grid whose points check each other: by the smallest part that counts."""
    scan = find_displaced_regions(Checks(errors(3)), WEIGHTS, GRID)
    n_in = np.ceil(0.1 * N)
    information = n_in * (1.0 - n_in / N) / SIGMA**2
    delta = noncentrality(FINDING_SIGNIFICANCE / scan.n_tried, degrees=2)
    assert scan.detectable.largest == pytest.approx(delta / information**0.5, rel=0.1)
    assert scan.detectable.median < scan.detectable.largest
    moved = errors(3) + SHIFT * inside(GRID[N // 2], 700.0)[:, None]
    assert find_displaced_regions(Checks(moved), WEIGHTS, GRID).detectable is None
