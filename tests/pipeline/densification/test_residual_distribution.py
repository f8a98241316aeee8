"""The setting residual_distribution, from the block to the summary."""

import numpy as np
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.block.block import Block, Flight, plain_fields
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block

METHODS = ("natural_neighbour", "inverse_distance", "multiquadric")


@pytest.fixture(scope="module")
def block():
    return simulate_block("demo", seed=4)


@pytest.mark.parametrize("method", METHODS)
def test_control_has_its_given_coordinates_and_standard_error(block, method):
    points = densify(block, Settings(residual_distribution=method)).solution.points
    control = block.control_points.set_index("point_id")
    known = points[points["role"] == "control"].set_index("point_id")
    assert len(known) > 3
    given = control.loc[known.index]
    columns = ["easting", "northing"]
    np.testing.assert_allclose(known[columns], given[columns], atol=1e-7)
    np.testing.assert_allclose(
        known["standard_error_total"], given["standard_error_m"], rtol=1e-6
    )


def test_the_distributed_part_can_be_taken_off(block):
    plain = densify(block).solution.points
    points = densify(
        block, Settings(residual_distribution="natural_neighbour")
    ).solution.points
    for name in ("easting", "northing"):
        np.testing.assert_allclose(
            points[name] - points[f"distributed_{name}"], plain[name], atol=1e-9
        )
    control = plain["role"] == "control"
    np.testing.assert_array_equal(
        points.loc[control, "difference_easting"],
        plain.loc[control, "difference_easting"],
    )
    assert "distributed_easting" not in plain


@pytest.mark.slow
def test_summary_says_how_far_points_were_moved(block):
    text = densify(block, Settings(residual_distribution="inverse_distance")).summary()
    assert "Residuals of control, distributed by inverse distance (total)" in text
    assert "distributed" not in densify(block).summary()


def test_a_block_without_control_is_refused(block):
    low = Flight(**plain_fields(block.low_flight))
    truth = block.truth[["point_id", "easting", "northing"]]
    without = Block(low_flight=low, approximate_points=truth)
    with pytest.raises(SettingsError, match="the block has no control points"):
        densify(without, Settings(residual_distribution="multiquadric"))


@pytest.mark.slow
def test_propagated_error_is_the_true_one_after_the_distribution():
    settings = Settings(residual_distribution="natural_neighbour")
    squares = []
    for seed in range(20):
        block = simulate_block("demo", seed=seed)
        result = densify(block, settings)
        columns = ["easting", "northing"]
        order = result.solution.points["point_id"]
        truth = block.truth.set_index("point_id").loc[order, columns]
        error = result.solution.points[columns].to_numpy() - truth.to_numpy()
        inverse = np.linalg.inv(result.errors.covariance)
        squares.append(np.einsum("ni,nij,nj->n", error, inverse, error).mean() / 2.0)
    scatter = np.std(squares, ddof=1) / np.sqrt(len(squares))
    assert np.mean(squares) == pytest.approx(1.0, abs=3.0 * scatter)
    assert scatter < 0.05
