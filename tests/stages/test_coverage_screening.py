"""Coverages of a point against each other: differences, limits, suspects."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from einschalt.foundations.errors import SettingsError
from einschalt.stages.coverage_screening import (
    DIFFERENCES,
    coverage_differences,
    screen_coverages,
)
from einschalt.stages.stage5_double_coverage import average_coverages
from einschalt.theory.adjustment.point_operator import Axes

NAMES = ["easting", "northing"]


def values_of(seed, n_points=30, n_coverages=3):
    """Values of points from several models of several coverages; some miss one."""
    rng = np.random.default_rng(seed)
    rows = []
    for point in range(n_points):
        place = np.array([4.5e5, 5.3e6]) + rng.uniform(0, 1e4, 2)
        for coverage in range(1 + int(rng.integers(0, n_coverages))):
            for model in range(1 + int(rng.integers(0, 3))):
                value = place + rng.normal(0, 0.05, 2)
                rows.append((f"{point:03d}", f"{coverage + 1}", f"m{model}", *value))
    columns = ["point_id", "coverage", "model_id", *NAMES]
    table = pd.DataFrame(rows, columns=columns)
    table["standard_error_paper"] = rng.uniform(0.03, 0.1, len(table))
    return table.sample(frac=1.0, random_state=seed).reset_index(drop=True)


def by_hand(values, weights):
    """Mean of each coverage, and less the plain mean of the other coverages' means."""
    weighted = values.assign(w=weights)
    for name in NAMES:
        weighted[name] *= weights
    sums = weighted.groupby(["point_id", "coverage"])[[*NAMES, "w"]].sum()
    means = sums[NAMES].div(sums["w"], axis=0).reset_index()
    rows = []
    for point, group in means.groupby("point_id"):
        for place in range(len(group)) if len(group) > 1 else ():
            own, others = group.iloc[place], group.drop(group.index[place])
            rows.append((point, own["coverage"], *(own[NAMES] - others[NAMES].mean())))
    return pd.DataFrame(rows, columns=["point_id", "coverage", *DIFFERENCES])


@pytest.mark.parametrize("weighting", ["plain", "weighted"])
@pytest.mark.parametrize("n_coverages", [2, 3])
def test_differences_are_those_of_the_means_of_coverages(weighting, n_coverages):
    values = values_of(7, n_coverages=n_coverages)
    means = average_coverages(values, weighting=weighting)
    found = coverage_differences(means).table
    error = values["standard_error_paper"].to_numpy()
    weights = np.ones(len(values)) if weighting == "plain" else error**-2.0
    expected = by_hand(values, weights)
    key = ["point_id", "coverage"]
    both = found.merge(expected, on=key, suffixes=("", "_by_hand"), validate="1:1")
    assert len(both) == len(found) == len(expected)
    for name in DIFFERENCES:
        np.testing.assert_allclose(both[name], both[f"{name}_by_hand"], atol=2e-9)


@pytest.mark.parametrize("n_coverages", [2, 3])
def test_the_operator_gives_the_differences_and_the_needed_ones_give_all(n_coverages):
    values = values_of(3, n_coverages=n_coverages)
    differences = coverage_differences(average_coverages(values))
    origin = values[NAMES].to_numpy() - [4.5e5, 5.3e6]
    operator = differences.operator(len(values), Axes.PLANE)
    given = differences.table[DIFFERENCES].to_numpy()
    np.testing.assert_allclose(operator.of_vectors(origin), given, atol=1e-8)
    needed = differences.needed()
    spread = differences.with_others(needed.table[DIFFERENCES].to_numpy())
    np.testing.assert_allclose(np.abs(spread), np.abs(given), atol=2e-9)
    size = needed.table.groupby("point_id").size()
    assert set(size) <= {1, 3}


def two_coverages(differences):
    """Points whose second coverage is off by these differences."""
    rng = np.random.default_rng(0)
    first = np.array([4.5e5, 5.3e6]) + rng.uniform(0, 1e4, (len(differences), 2))
    parts = []
    for coverage, value in (("1", first), ("2", first + differences)):
        part = pd.DataFrame(value, columns=NAMES)
        names = [f"{place:05d}" for place in range(len(part))]
        parts.append(part.assign(coverage=coverage, point_id=names))
    return coverage_differences(average_coverages(pd.concat(parts, ignore_index=True)))


def drawn(seed, n_points=20_000):
    """Covariances of all shapes, and differences drawn from them."""
    rng = np.random.default_rng(seed)
    half = np.tril(rng.uniform(-0.02, 0.02, (n_points, 2, 2)))
    half[:, [0, 1], [0, 1]] = rng.uniform(0.02, 0.1, (n_points, 2))
    covariance = half @ np.swapaxes(half, 1, 2)
    d = np.einsum("nij,nj->ni", half, rng.standard_normal((n_points, 2)))
    return d, covariance


def test_limits_follow_from_the_propagated_covariance():
    d, covariance = drawn(1)
    both_rows = np.repeat(covariance, 2, axis=0)
    found = screen_coverages(two_coverages(d), both_rows, "propagated", 0.01)
    second = found.table[found.table["coverage"] == "2"]
    squares = np.einsum("ni,nij,nj->n", d, np.linalg.inv(covariance), d)
    expected = stats.chi2.sf(squares, 2)
    np.testing.assert_allclose(second["p_value"], expected, rtol=1e-5, atol=1e-12)
    total = np.sqrt(np.trace(covariance, axis1=1, axis2=2))
    np.testing.assert_allclose(second["standard_error_difference"], total)
    low, high = stats.binom.ppf([0.001, 0.999], len(d), 0.01)
    assert low <= len(found.suspects) <= high


def test_of_three_coverages_the_worst_counts_once():
    values = values_of(5, n_points=400, n_coverages=3)
    differences = coverage_differences(average_coverages(values))
    needed = len(differences.table)
    covariance = np.broadcast_to(0.002 * np.eye(2), (needed, 2, 2))
    found = screen_coverages(differences, covariance, "propagated", 0.05).table
    d = differences.table[DIFFERENCES].to_numpy()
    single = stats.chi2.sf(np.sum(d**2, axis=1) / 0.002, 2)
    worst = pd.Series(single).groupby(found["point_id"]).min()
    size = found.groupby("point_id").size()
    expected = np.minimum(worst * np.where(size == 2, 1, size), 1.0)
    of_point = found.groupby("point_id")["p_value"].first()
    np.testing.assert_allclose(of_point, expected, rtol=1e-9)
    np.testing.assert_array_equal(found["is_suspect"], found["p_value"] < 0.05)


def test_without_propagation_the_differences_themselves_set_the_limits():
    rng = np.random.default_rng(2)
    d = rng.normal(0, 0.03, (20_000, 2))
    is_gross = np.arange(len(d)) < 200
    d[is_gross] += 1.0
    found = screen_coverages(two_coverages(d), None, "propagated", 0.01)
    assert not found.is_propagated
    second = found.table[found.table["coverage"] == "2"]
    # the gross errors, 1 % of all, move the median by that much
    total = second["standard_error_difference"].to_numpy()
    np.testing.assert_allclose(total, np.sqrt(2) * 0.03, rtol=0.03)
    is_suspect = second["is_suspect"].to_numpy()
    assert is_suspect[is_gross].all()
    low, high = stats.binom.ppf([0.001, 0.999], len(d) - 200, 0.01)
    assert 0.8 * low <= is_suspect[~is_gross].sum() <= high


def test_practice_of_1968_takes_three_standard_errors_of_each_coordinate():
    rng = np.random.default_rng(3)
    # North Rhine-Westphalia at 1:5000: 5.5 cm for one value, 24 cm for a difference
    d = rng.normal(0, np.sqrt(2) * 0.055, (20_000, 2))
    d[:50, 0] = 0.9
    found = screen_coverages(two_coverages(d), None, "practice_1968", 0.001)
    second = found.table[found.table["coverage"] == "2"]
    assert second["p_value"].isna().all()
    assert np.isnan(found.significance)
    within = np.abs(d[~second["is_suspect"].to_numpy()])
    beyond = np.abs(d[second["is_suspect"].to_numpy()]).max(axis=1)
    assert within.max() < beyond.min()
    # a normal distribution cut off at three standard errors has 0.9733 of its variance
    limit = beyond.min()
    assert 0.215 < limit < 0.24
    share = np.mean(second["is_suspect"].to_numpy()[50:])
    assert 0.004 < share < 0.008


def test_nothing_is_tested_where_screening_is_off():
    found = screen_coverages(two_coverages(np.ones((5, 2))), None, "off", 0.001)
    assert not found.table["is_suspect"].any()
    assert found.summary() == "5 points in several coverages, 0 suspects"


def test_an_unknown_practice_is_refused():
    with pytest.raises(
        SettingsError, match="screening = 'on' is unknown; expected pro"
    ):
        screen_coverages(two_coverages(np.ones((5, 2))), None, "on", 0.001)


def test_points_in_one_coverage_are_passed_over():
    values = values_of(1, n_coverages=1)
    differences = coverage_differences(average_coverages(values))
    assert differences.table.empty
    found = screen_coverages(differences, None, "propagated", 0.001)
    assert found.n_tested == 0
    assert len(found.suspects) == 0


def test_coverages_of_rigorous_means_are_compared_with_the_weights_they_have():
    values = values_of(7)
    root = np.random.default_rng(2).normal(0.0, 0.02, (2 * len(values), 400))
    blocks = (root @ root.T).reshape(len(values), 2, len(values), 2)
    means = average_coverages(
        values,
        weighting="rigorous",
        covariances=lambda pairs: blocks[pairs[:, 0], :, pairs[:, 1]],
    )
    found = coverage_differences(means)
    assert found.shares.shape == (len(found.rows), 2, 2)
    origin = values[NAMES].to_numpy() - [4.5e5, 5.3e6]
    operator = found.operator(len(values), Axes.PLANE)
    given = found.table[DIFFERENCES].to_numpy()
    np.testing.assert_allclose(operator.of_vectors(origin), given, atol=1e-8)
    own = values.set_index(["point_id", "coverage"])[NAMES]
    for row in found.table.itertuples():
        several = found.table[found.table["point_id"] == row.point_id]
        others = several.loc[several["coverage"] != row.coverage, NAMES].mean()
        less = [row.easting, row.northing] - others.to_numpy()
        np.testing.assert_allclose(given[row.Index], less, atol=2e-9)
        if len(one := own.loc[[(row.point_id, row.coverage)]]) == 1:
            at = one.iloc[0].to_numpy()
            np.testing.assert_allclose([row.easting, row.northing], at, atol=1e-9)
