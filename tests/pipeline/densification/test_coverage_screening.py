"""Screening of whole blocks by the differences of their coverages."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from einschalt.pipeline.assessment.findings.suspects import coverages_that_differ
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of

SEEDS = range(7)


def with_gross_error(block, n_models):
    """All values of one point of the second coverage 40 cm off, that is 50 µm."""
    points = block.low_flight.model_points.copy()
    second = points[points["coverage"] == "2"]
    sizes = second.groupby("point_id").size()
    name = sizes.index[sizes == n_models][0]
    is_it = (points["coverage"] == "2") & (points["point_id"] == name)
    points.loc[is_it, "x"] += 0.05
    low = replace(block.low_flight, model_points=points)
    return replace(block, low_flight=low), name


@pytest.fixture(scope="module", params=["all", "most_central"])
def clean(request):
    settings = Settings(coverage_mean=request.param)
    return [
        densify(simulate_block("neukirchen", seed=seed), settings) for seed in SEEDS
    ]


@pytest.mark.slow
def test_probabilities_of_clean_points_are_those_that_are_said(clean):
    p_value = np.concatenate(
        [run.coverages.drop_duplicates("point_id")["p_value"] for run in clean]
    )
    # neighbours share the transformations of their models: half of them are counted
    for level in (0.05, 0.01):
        limits = stats.binom.ppf([0.0005, 0.9995], len(p_value) // 2, level)
        low, high = limits / (len(p_value) // 2)
        assert low <= np.mean(p_value < level) <= high


def test_clean_points_are_suspects_as_often_as_the_significance_says(clean):
    n_points = sum(run.solution.screening.n_tested for run in clean)
    n_suspects = sum(run.solution.points["is_suspect"].sum() for run in clean)
    low, high = stats.binom.ppf([0.0005, 0.9995], n_points, 0.001)
    assert low <= n_suspects <= high
    assert sum(coverages_that_differ(run.examination) is not None for run in clean) == 0


@pytest.mark.slow
def test_a_suspect_keeps_the_values_of_its_coverages_and_is_said():
    block, name = with_gross_error(simulate_block("demo", seed=1), 2)
    result = densify(block, Settings(coverage_mean="most_central"))
    marked = result.points.set_index("point_id")["is_suspect"]
    assert marked[name]
    # the gross error is kept: it spoils its models, and may take a neighbour with it
    assert marked.sum() <= 3
    kept = result.coverages.set_index("point_id").loc[name]
    assert list(kept["coverage"]) == ["1", "2"]
    mean = kept[["easting", "northing"]].mean()
    point = result.points.set_index("point_id").loc[name]
    np.testing.assert_allclose(point[["easting", "northing"]].astype(float), mean)
    assert np.hypot(*kept[["difference_easting", "difference_northing"]].iloc[0]) > 0.2
    found = coverages_that_differ(result.examination)
    assert found.names[0] == name
    assert 0.2 < found.observed == found.facts["largest"]
    said = str(suggestion_of(found))
    assert re.match(r"\d points? with coverages that differ significantly", said)
    assert f" cm: {name}" in said
    assert "coverages.csv" in said
    # of the gross error that takes part, and told under it
    told = {f.code: f.explained_by for f in result.assessment.findings}
    assert told["coverages_that_differ"] == "kept_gross_measurements"
    assert "differing coverages" in result.summary().replace("\n        ", " ")


@pytest.mark.slow
def test_practice_of_1968_finds_it_too_and_off_marks_nothing():
    block, name = with_gross_error(simulate_block("demo", seed=1), 2)
    practice = densify(block, Settings(screening="practice_1968"))
    assert practice.points.set_index("point_id")["is_suspect"][name]
    assert name in coverages_that_differ(practice.examination).names
    off = densify(block, Settings(screening="off"))
    assert not off.points["is_suspect"].any()
    assert len(off.coverages) == len(practice.coverages)
    assert coverages_that_differ(off.examination) is None


def test_without_propagation_the_differences_set_the_limits():
    block, name = with_gross_error(simulate_block("demo", seed=1), 2)
    given = densify(block).approximations[["point_id", "easting", "northing"]]
    block = Block(
        name="Given",
        approximate_points=given,
        approximate_m_0_m=0.09,
        low_flight=block.low_flight,
    )
    result = densify(block)
    assert not result.solution.screening.is_propagated
    marked = result.points.set_index("point_id")["is_suspect"]
    assert marked[name]
    assert marked.sum() <= 3
