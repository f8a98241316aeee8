"""Sources of error and neighbours, beside the covariances of the result."""

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.facts.precision_of_points import (
    DOMINATED,
    error_source_facts,
    neighbour_facts,
    spread_facts,
)


@pytest.mark.parametrize("name", ["good", "faulty"])
def test_squares_of_the_sources_add_up_to_the_figure(name, request):
    result = request.getfixturevalue(f"{name}_result")
    facts = error_source_facts(result.examination)
    sizes = [source.total for source in facts.sources]
    assert sizes == sorted(sizes, reverse=True)
    new = result.points[result.points["role"] == "new"]
    total = np.sqrt(np.mean(new["standard_error_total"] ** 2))
    assert facts.total == pytest.approx(total)
    assert np.sqrt(np.sum(np.square(sizes))) == pytest.approx(total)
    shares = [source.share for source in facts.sources]
    np.testing.assert_allclose(shares, np.square(sizes) / total**2)
    halved = [sizes[0] / 2.0, *sizes[1:]]
    assert facts.total_with_half_the_largest == pytest.approx(
        np.sqrt(np.sum(np.square(halved)))
    )


def test_neighbours_are_better_than_if_they_were_independent(good_result):
    facts = neighbour_facts(good_result.examination)
    table = good_result.neighbours
    pairs = table[["point_id", "neighbour_id"]].to_numpy().tolist()
    assert facts.n_pairs == len(pairs)
    place = {name: k for k, name in enumerate(good_result.errors.point_ids)}
    own = np.trace(good_result.errors.covariance[:, :2, :2], axis1=1, axis2=2)
    between = np.trace(
        good_result.covariance_between(pairs)[:, :2, :2], axis1=1, axis2=2
    )
    alone = np.array([own[place[i]] + own[place[j]] for i, j in pairs])
    assert facts.total_if_independent == pytest.approx(np.sqrt(alone.mean()))
    together = alone - 2.0 * between
    assert facts.total == pytest.approx(np.sqrt(together.mean()))
    xy = good_result.points.set_index("point_id")[["easting", "northing"]]
    ends = [xy.loc[[pair[k] for pair in pairs]].to_numpy() for k in (0, 1)]
    apart = np.hypot(*(ends[1] - ends[0]).T)
    assert facts.median_distance == pytest.approx(np.median(apart))


def test_without_propagated_errors_there_are_none(
    given_approximations_result, simultaneous_result
):
    for result in (given_approximations_result, simultaneous_result):
        assert error_source_facts(result.examination) is None
        assert neighbour_facts(result.examination) is None


def points_with(errors):
    return pd.DataFrame({"role": "new", "standard_error_checked": errors})


def test_spread_is_told_where_a_few_points_make_the_figure(good_result):
    few = np.r_[np.full(95, 0.05), np.full(5, 0.40)]
    facts = spread_facts(points_with(few))
    assert facts.median == 0.05
    assert facts.most == pytest.approx(np.quantile(few, 0.95))
    assert facts.rms == pytest.approx(np.sqrt(np.mean(few**2)))
    # most of the squares are then beyond those of the median
    assert np.sum(few**2 - 0.05**2) > 0.5 * np.sum(few**2)
    assert facts.rms > DOMINATED * facts.median
    assert spread_facts(good_result.points) is None
    assert spread_facts(points_with(few[-19:])) is None
    known = points_with(few).assign(role="control")
    assert spread_facts(known) is None
    # errors spread as Rayleigh has them are no few bad points
    drawn = np.random.default_rng(1).rayleigh(0.05, 2000)
    assert spread_facts(points_with(drawn)) is None
