"""Approximate coordinates that share errors: no figure is below what was stated."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist
from tests.judged_alone import judged_alone
from tests.truth.disturbed_blocks import onto_grouped_approximations

from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.pipeline.summary.summary import summarize

PLANE = ["easting", "northing"]
GEOMETRY = replace(
    PRESETS["demo"].geometry,
    width=6_000.0,
    height=6_000.0,
    point_spacing=200.0,
    n_check=0,
)
OWN, SHIFT = 0.1, 0.2  # TOTAL: of each point, and of each photograph [m]
TABLE = "approximate_points"


@pytest.fixture(scope="module")
def block():
    """Photographs of 1 km are shifted, each by itself."""
    simulated = simulate_block("demo", seed=31_060, geometry=GEOMETRY)
    cells = (1e3, 1e3)
    return onto_grouped_approximations(
        simulated, OWN, SHIFT, cells, 31_060, is_stated=False
    )


def of_points(block, groups=None):
    points = block.approximate_points.drop(columns="group")
    return points if groups is None else points.assign(group=groups)


def true_error(result, block):
    points = result.points
    truth = block.truth.set_index("point_id").loc[points["point_id"], PLANE]
    away = points[PLANE].to_numpy() - truth.to_numpy()
    return float(np.sqrt(np.mean(np.sum(away**2, axis=1))))


@pytest.mark.slow
@pytest.mark.parametrize("stated", [0.05, 0.1])
def test_a_size_that_residuals_exceed_is_enlarged_as_they_are(block, stated):
    """The larger it was stated, the smaller the figure was: 10, 5.5 cm or worse."""
    result = densify(
        replace(block, approximate_points=of_points(block), approximate_m_0_m=stated)
    )
    figure, true = result.examination.credible, true_error(result, block)
    assert figure.is_lower_bound
    assert stated < figure.value < 1.1 * true
    assert figure.value > 0.75 * true
    assert "they may be larger" in " ".join(summarize(result).split())


def test_groups_of_single_points_claim_what_was_stated(block):
    names = [f"own {k}" for k in range(len(block.approximate_points))]
    result = densify(
        replace(
            block,
            approximate_points=of_points(block, names),
            group_errors_m={TABLE: SHIFT},
        )
    )
    figure = result.examination.credible
    assert not result.claim.is_supported
    assert figure.value > 0.999 * np.hypot(OWN, SHIFT)
    assert figure.value > true_error(result, block)


def test_independent_errors_keep_their_figure(block):
    """What is stated does not count where residuals of neighbours are not alike."""
    truth = block.truth[["point_id", *PLANE]].copy()
    rng = np.random.default_rng(1)
    truth[PLANE] += rng.normal(scale=OWN / np.sqrt(2.0), size=(len(truth), 2))
    result = densify(replace(block, approximate_points=truth))
    assert result.claim.is_supported
    figure, true = result.examination.credible, true_error(result, block)
    assert figure.reason is Reason.ASSUMED
    assert not figure.is_lower_bound
    # that of the budget was 0.85 times the true one
    assert figure.value == pytest.approx(true, rel=0.08)
    first = summarize(result).splitlines()[0]
    assert first.endswith("errors of approximate points taken for independent)")


@pytest.mark.slow
@pytest.mark.parametrize("own", [3.0, 0.5])
def test_points_worse_than_stated_enlarge_what_was_predicted(block, own):
    """The budget has seen the residuals: enlarged by them once more it was 39 m."""
    truth = block.truth[["point_id", *PLANE]].copy()
    rng = np.random.default_rng(5)
    truth[PLANE] += rng.normal(scale=own, size=(len(truth), 2))
    given = replace(block, approximate_points=truth, approximate_m_0_m=0.1)
    result = densify(given)
    figure, true = result.examination.credible, true_error(result, block)
    assert figure.is_lower_bound
    assert true < 1.05 * figure.value < 2.0 * true
    assert figure.factor * result.figures.mean_paper < 2.5 * true
    codes = judged_alone(result)
    # what all points have by themselves is not shared
    assert codes["claim_that_does_not_stand"].remedy == "doubt_sizes_of_errors"


def findings_of(block, errors):
    """Findings of the block with these errors of the approximate points, by code."""
    truth = block.truth[["point_id", *PLANE]].copy()
    truth[PLANE] += errors
    given = replace(block, approximate_points=truth, approximate_m_0_m=0.36)
    result = densify(given)
    return result, {found.code: found for found in result.assessment.findings}


@pytest.mark.slow
def test_coverages_that_smooth_errors_part_do_not_ask_for_a_larger_m_g(block):
    places = block.truth[PLANE].to_numpy()
    smooth = np.exp(-cdist(places, places) / 1500.0) + 1e-9 * np.eye(len(places))
    rng = np.random.default_rng(2)
    errors = np.linalg.cholesky(smooth) @ rng.standard_normal((len(places), 2))
    result, found = findings_of(block, 0.36 / np.sqrt(2.0) * errors)
    cause, budget = found["claim_that_does_not_stand"], found["contradicted_budget"]
    assert budget.explained_by == cause.code
    assert "contradicted_budget" in cause.facts["explains"]
    text = " ".join(summarize(result).split())
    assert "they share errors" in text
    assert "Raise m_g_um" not in text


def test_coverages_that_a_larger_m_g_parts_still_ask_for_it(block):
    flight = block.low_flight
    noise = np.random.default_rng(3).standard_normal((len(flight.model_points), 2))
    points = flight.model_points.copy()
    points[["x", "y"]] += 3e-3 * flight.m_g_um / np.sqrt(2.0) * noise
    coarse = replace(block, low_flight=replace(flight, model_points=points))
    errors = np.random.default_rng(4).normal(scale=0.02, size=(len(block.truth), 2))
    _, found = findings_of(coarse, errors)
    assert not found["contradicted_budget"].explained_by
