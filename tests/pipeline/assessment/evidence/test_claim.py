"""A claim that does not stand says so, and one that stands is left in peace."""

from dataclasses import replace

import numpy as np
import pytest
from tests.given_approximations import onto_given_approximations

from einschalt.interfaces.reports.page_plots import plots
from einschalt.pipeline.assessment.credibility import Reason, taken_up_by_models
from einschalt.pipeline.assessment.findings.claim import claim_that_does_not_stand
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import BlockNoise, simulate_block
from einschalt.pipeline.summary.summary import summarize

pytestmark = pytest.mark.slow

COVERAGES = "coverage differences"
HIGH = "coverage differences, high flight"
RESIDUALS = "residuals of the low flight"
NEIGHBOURS = "correlation of neighbouring residuals"
PLANE = ["easting", "northing"]


@pytest.fixture(scope="module")
def block():
    return simulate_block("neukirchen", seed=0)


@pytest.fixture(scope="module")
def shared(block):
    """Approximate coordinates of photographs whose orientation is wrong."""
    return densify(onto_given_approximations(block, photograph_error=0.1, seed=1))


@pytest.fixture(
    scope="module",
    params=[
        ("affine", {"coverage_mean": "most_central"}),
        ("helmert", {"weighting": "weighted"}),
        ("affine", {"weighting": "rigorous"}),
    ],
    ids=str,
)
def twelve(request):
    """Claims of clean blocks, and squares of control left out by its covariance."""
    kind, settings = request.param
    claims, squares = [], []
    for seed in range(12):
        block = simulate_block("demo", seed=seed)
        flights = {
            name: replace(flight, transformation=kind)
            for name, flight in block.flights.items()
        }
        result = densify(replace(block, **flights), Settings(**settings))
        claims.append(result.claim)
        squares.append(result.left_out_control.normalized_square)
    return claims, squares


def test_control_left_out_differs_by_the_standard_errors_that_are_given(twelve):
    """Squares by their covariances, over blocks; their scatter says how sure it is."""
    _, squares = twelve
    scatter = np.std(squares, ddof=1) / np.sqrt(len(squares))
    assert np.mean(squares) == pytest.approx(1.0, abs=3.0 * scatter)
    assert scatter < 0.15


def test_predictions_are_what_other_blocks_have(twelve):
    """The mean over simulated blocks is what one block predicts for itself."""
    observed, predicted = [], []
    for claim in twelve[0]:
        assert [test.name for test in claim.tests][:3] == [COVERAGES, HIGH, RESIDUALS]
        observed.append([test.observed**2 for test in claim.tests[:3]])
        predicted.append([test.predicted**2 for test in claim.tests[:3]])
    ratio = np.mean(observed, axis=0) / np.mean(predicted, axis=0)
    # some 80 points and two coordinates a block, many of them alike: 4 % of a variance
    np.testing.assert_allclose(ratio, 1.0, atol=0.16)


def test_a_good_block_stands(block):
    result = densify(block)
    claim = result.claim
    assert claim.is_supported
    assert not claim.is_assumed
    assert claim.enlargement == 1.0
    assert claim_that_does_not_stand(result.examination) is None
    for name in (COVERAGES, HIGH, RESIDUALS):
        test = claim.of(name)
        assert test.observed == pytest.approx(test.predicted, rel=0.06)
    assert "Is the stated precision supported? (total, RMS)" in summarize(result)


def test_errors_that_photographs_share_are_called_out(shared):
    claim = shared.claim
    assert not claim.is_supported
    assert claim.of(NEIGHBOURS).p_value < 1e-4
    assert (
        claim.of("control points").observed > 1.2 * claim.of("control points").predicted
    )
    found = claim_that_does_not_stand(shared.examination)
    parts = {part["kind"]: part for part in found.facts["rejected"]}
    assert -0.1 < parts["correlation"]["observed"] < -0.0
    assert parts["residuals"]["observed"] < parts["residuals"]["predicted"]
    assert found.remedy == "shared_errors_as_stated"
    first = summarize(shared).splitlines()[0]
    assert "including stated errors that models absorbed)" in first


@pytest.mark.parametrize("photograph_error", [0.1, 0.2, 0.5])
def test_the_stated_error_is_the_figure_where_models_took_it_up(photograph_error):
    """Residuals show a little of it; before, the claim was a tenth of the truth."""
    claimed, true = [], []
    for seed in range(3):
        block = simulate_block("demo", seed=seed)
        error = {"photograph_error": photograph_error, "seed": seed}
        result = densify(onto_given_approximations(block, **error))
        figure = result.examination.credible
        assert figure.reason is Reason.STATED
        assert not figure.is_lower_bound
        new = result.points[result.points["role"] == "new"]
        truth = block.truth.set_index("point_id").loc[new["point_id"], PLANE]
        away = new[PLANE].to_numpy() - truth.to_numpy()
        claimed.append(figure.value**2)
        true.append(np.mean(np.sum(away**2, axis=1)))
    assert np.sqrt(np.mean(claimed) / np.mean(true)) == pytest.approx(1.0, abs=0.1)


def test_nothing_was_taken_up_where_nothing_was_stated(block):
    given = onto_given_approximations(
        block, photograph_error=0.1, seed=1, is_stated=False
    )
    result = densify(given)
    assert taken_up_by_models(result.examination) == 0.0
    assert result.examination.credible.is_lower_bound
    first = summarize(result).splitlines()[0]
    assert "cm or worse (total, mean of two coverages)" in first


def test_without_control_and_without_a_stated_error_the_residuals_tell(block):
    given = onto_given_approximations(
        block, photograph_error=0.1, seed=1, is_stated=False
    )
    result = densify(replace(given, control_points=None))
    names = [test.name for test in result.claim.rejected]
    assert NEIGHBOURS in names
    assert "control points" not in [test.name for test in result.claim.tests]


def test_a_measuring_error_that_was_given_too_small_does_not_stand(block):
    low = replace(block.low_flight, m_g_um=5.0 / 1.5)
    result = densify(replace(block, low_flight=low))
    names = [test.name for test in result.claim.rejected]
    assert COVERAGES in names
    assert 1.1 < result.claim.enlargement < 1.5
    found = claim_that_does_not_stand(result.examination)
    parts = {part["quantity"]: part for part in found.facts["rejected"]}
    assert parts[COVERAGES]["kind"] == "rms"
    assert parts[COVERAGES]["observed"] > parts[COVERAGES]["predicted"]
    assert found.remedy == "doubt_sizes_of_errors"


def test_film_that_no_helmert_transformation_takes_up_does_not_stand():
    noise = BlockNoise(film_affinity=3e-4)
    block = simulate_block("neukirchen", seed=1, noise=noise)
    low = replace(block.low_flight, transformation="helmert")
    result = densify(replace(block, low_flight=low))
    assert not result.claim.is_supported
    assert densify(block).claim.is_supported


def test_a_few_gross_errors_are_no_wrong_claim():
    noise = BlockNoise(low_gross_error_share=0.01)
    block = simulate_block("neukirchen", seed=3, noise=noise)
    assert densify(block, Settings(outliers="snoop")).claim.is_supported


def test_where_sizes_are_not_known_nothing_is_claimed(block):
    control = block.control_points.drop(columns="standard_error_m")
    result = densify(replace(block, control_points=control))
    assert result.claim.tests == ()
    assert result.claim.is_supported
    assert "Is the stated precision" not in summarize(result)
    assert "correlogram" not in plots(result)


def test_the_distribution_of_residuals_changes_no_test(block):
    plain = densify(block)
    moved = densify(block, Settings(residual_distribution="natural_neighbour"))
    assert moved.claim.tests == plain.claim.tests


def test_the_plot_shows_what_was_measured_over_what_is_expected(shared):
    shown, field = plots(shared)["correlogram"], shared.claim.residuals
    np.testing.assert_allclose(
        shown["measured"], field.correlogram.correlation, atol=1e-4
    )
    middle = field.expected.correlation.mean(axis=1)
    low, high = np.array(shown["low"]), np.array(shown["high"])
    np.testing.assert_allclose((low + high) / 2.0, middle, atol=1e-4)
    assert (low < high).all()
