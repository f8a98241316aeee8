"""Gross errors of a flight, found in the simultaneous adjustment of its models."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.interfaces.files.result_folder import write_result
from einschalt.pipeline.block.block import Block, plain_fields
from einschalt.pipeline.densification.gross_errors import (
    COLUMNS,
    find_gross_measurements,
    is_gross,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.stages.stage2_relative_orientation import relative_orientation

KEY = ["flight", "coverage", "model_id", "point_id"]
SNOOPED = Settings(outliers="snoop")
FLIGHTS = ("high_flight", "low_flight")


def flights_of(block):
    return {name: relative_orientation(f) for name, f in block.flights.items()}


def found_in(block, settings=SNOOPED):
    return find_gross_measurements(block, flights_of(block), settings).table


def rows(table):
    return set(table[KEY].itertuples(index=False, name=None))


def changed(block, **values):
    known = Block.__dataclass_fields__
    plain = {k: v for k, v in plain_fields(block).items() if k in known}
    return Block(**{**plain, **values})


@pytest.fixture(scope="module", params=["high", "low"])
def spoilt(request):
    """Neukirchen with 1 % gross errors of 50 µm in one flight."""
    noise = BlockNoise(**{f"{request.param}_gross_error_share": 0.01})
    return simulate_block("neukirchen", seed=2, noise=noise)


@pytest.fixture(scope="module")
def kept(spoilt):
    """The result with all gross errors in it."""
    return densify(spoilt)


@pytest.fixture(scope="module")
def snooped(spoilt):
    return densify(spoilt, SNOOPED)


def test_nearly_all_are_found_and_little_else(spoilt):
    found = found_in(spoilt)
    true = rows(spoilt.gross_errors)
    flight = next(iter(true))[0]
    assert found.columns.tolist() == COLUMNS
    assert len(rows(found) & true) >= 0.95 * len(true)
    # good ones: the partner of a wrong one where a point was measured twice
    counts = spoilt.flights[flight].model_points["point_id"].value_counts()
    good = rows(found) - true
    assert all(counts[point] == 2 for *_, point in good)
    assert {point for *_, point in good} <= {point for *_, point in true}
    # 50 µm on the ground: what the models miss the points by
    scale = spoilt.flights[flight].scale_number
    miss = np.hypot(found["residual_easting"], found["residual_northing"])
    assert np.median(miss) == pytest.approx(50e-6 * scale, rel=0.15)
    is_pair = found["point_id"].map(counts) == 2
    assert (found.loc[~is_pair, "p_value"] < 0.001).all()


def test_an_m_g_that_was_given_wrongly_changes_nothing(spoilt):
    # beside the flight only the control knows of it, which has hardly a say
    flights = {
        name: replace(getattr(spoilt, name), m_g_um=3.0 * getattr(spoilt, name).m_g_um)
        for name in FLIGHTS
    }
    wrong = changed(spoilt, **flights)
    right = rows(found_in(spoilt))
    found = rows(found_in(wrong))
    assert len(right ^ found) <= 0.05 * len(right)


@pytest.mark.slow
def test_clean_blocks_have_none():
    n_found = n_models = 0
    for seed in range(4):
        block = simulate_block("neukirchen", seed=seed)
        n_found += len(found_in(block))
        n_models += sum(
            len(f.model_points[["coverage", "model_id"]].drop_duplicates())
            for f in block.flights.values()
        )
    # 0.001 a model: 1.3 in all; six have the probability 0.002
    assert n_models > 1200
    assert n_found <= 5


def test_deformed_models_are_no_gross_errors():
    noise = BlockNoise(low_deformation_um=20.0, high_deformation_um=10.0)
    block = simulate_block("neukirchen", seed=0, noise=noise)
    found = found_in(block)
    assert len(found) <= 10  # of 8600


def test_nothing_is_looked_for_where_everything_is_kept(spoilt, kept):
    assert len(found_in(spoilt, Settings())) == 0
    assert len(kept.gross_measurements) == 0


def test_flights_that_cannot_be_adjusted_simultaneously_are_left_alone():
    geometry = replace(PRESETS["demo"].geometry, transformation="rigid")
    block = simulate_block("demo", seed=1, geometry=geometry)
    assert len(found_in(block)) == 0


def test_flights_without_control_are_left_alone():
    block = simulate_block("demo", seed=1)
    approximate = block.truth[["point_id", "easting", "northing"]]
    given = {"approximate_points": approximate, "high_flight": None}
    alone = changed(block, **given, control_points=None)
    assert len(found_in(alone)) == 0
    assert np.isfinite(densify(alone, SNOOPED).solution.points["easting"]).all()
    check = changed(
        block, **given, control_points=block.control_points.assign(role="check")
    )
    assert len(found_in(check)) == 0
    assert np.isfinite(densify(check, SNOOPED).solution.points["easting"]).all()


def test_rows_of_one_flight():
    points = pd.DataFrame(
        [("1", "1/2", "a"), ("1", "1/2", "b"), ("2", "1/2", "a")],
        columns=KEY[1:],
    )
    found = points.iloc[[2]].assign(flight="low_flight")
    assert is_gross(found, "low_flight", points).tolist() == [False, False, True]
    assert not is_gross(found, "high_flight", points).any()


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["snoop", "huber", "tukey"])
def test_they_take_no_part(spoilt, kept, snooped, outliers):
    is_snooped = outliers == "snoop"
    result = snooped if is_snooped else densify(spoilt, Settings(outliers=outliers))
    out = rows(result.gross_measurements)
    fitted = {
        "high_flight": result.solution.high.transformation.observed,
        "low_flight": result.solution.low.observed,
    }
    for name, observed in fitted.items():
        assert not out & rows(observed.rows.assign(flight=name))
    high, low = result.solution.high.means.used, result.solution.means.used
    assert not out & rows(high.assign(flight="high_flight"))
    assert not out & rows(low.assign(flight="low_flight"))
    # no point is lost, though some have no approximate coordinates
    assert len(result.solution.points) == len(kept.solution.points)
    assert len(result.approximations) >= 0.99 * len(kept.approximations)
    # fitted points keep a row in the residuals, and are suspects there
    residuals = result.residuals
    named = residuals[residuals["is_suspect"]]
    assert rows(residuals) & out <= rows(named)
    assert result.figures.mean_total < 1.03 * kept.figures.mean_total


def test_sizes_of_errors_are_those_of_the_good_measurements(snooped):
    found = snooped.components
    assert abs(found.high_flight.estimated - 7.5) < 4 * found.high_flight.standard_error
    assert abs(found.low_flight.estimated - 5.0) < 4 * found.low_flight.standard_error


@pytest.mark.slow
def test_all_are_written(tmp_path):
    noise = BlockNoise(low_gross_error_share=0.03, low_gross_error_um=200.0)
    block = simulate_block("demo", seed=2, noise=noise)
    result = densify(block, SNOOPED)
    assert len(result.gross_measurements) > 0
    write_result(result, tmp_path)
    written = pd.read_csv(tmp_path / "gross_measurements.csv", dtype=str)
    assert rows(written) == rows(result.gross_measurements)
    write_result(densify(block), tmp_path)
    assert not (tmp_path / "gross_measurements.csv").exists()


def test_a_point_that_two_measurements_dispute_has_no_approximate_coordinates():
    block = simulate_block("demo", seed=1)
    points = block.high_flight.model_points
    counts = points["point_id"].value_counts()
    control = set(block.control_points["point_id"])
    pairs = sorted(p for p, n in counts.items() if n == 2 and p not in control)
    row = points.index[points["point_id"] == pairs[0]][0]
    moved = points.copy()
    moved.loc[row, "x"] += 0.2  # mm: 3 m on the ground
    wrong = replace(block.high_flight, model_points=moved)
    result = densify(changed(block, high_flight=wrong), SNOOPED)
    assert set(result.gross_measurements["point_id"]) == {pairs[0]}
    assert len(result.gross_measurements) == 2
    assert pairs[0] not in set(result.approximations["point_id"])
    # the low flight gives its coordinates without, as it would have with
    kept = densify(block).solution.points.set_index("point_id").loc[pairs[0]]
    found = result.solution.points.set_index("point_id").loc[pairs[0]]
    off = np.hypot(
        found["easting"] - kept["easting"], found["northing"] - kept["northing"]
    )
    assert off < 3.0 * kept["standard_error_total"]
    assert found["standard_error_total"] > kept["standard_error_total"]


def test_a_wrong_control_point_is_not_laid_to_its_measurements():
    block = simulate_block("demo", seed=1)
    control = block.control_points.copy()
    is_control = control["role"] == "control"
    counts = block.high_flight.model_points["point_id"].value_counts()
    n_models = control["point_id"].map(counts).where(is_control, 0).fillna(0)
    place = n_models.idxmax()
    control.loc[place, "easting"] += 3.0
    wrong = changed(block, control_points=control)
    found = densify(wrong, SNOOPED).gross_measurements
    assert control.loc[place, "point_id"] not in set(found["point_id"])


def test_without_high_flight_the_low_one_is_searched():
    noise = BlockNoise(low_gross_error_share=0.01)
    block = simulate_block("neukirchen", seed=3, noise=noise)
    approximate = block.truth[["point_id", "easting", "northing"]]
    alone = changed(
        block,
        approximate_points=approximate,
        approximate_m_0_m=0.05,
        high_flight=None,
    )
    found = rows(densify(alone, SNOOPED).gross_measurements)
    # of two measurements of a point either may be wrong
    counts = block.low_flight.model_points["point_id"].value_counts()
    true = {row for row in rows(block.gross_errors) if counts[row[-1]] > 2}
    assert len(found & true) >= 0.97 * len(true)
