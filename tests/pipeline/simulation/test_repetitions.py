"""Truth against claim, repeated on any engine."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.batch.local_engine import Answer, LocalEngine
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.repetitions import (
    Experiment,
    chance_of_error,
    describe_trial,
    repeat_simulation,
    summarize_repetitions,
)
from einschalt.pipeline.simulation.simulate_block import simulate_block


class HereEngine:
    def answers(self, function, tasks):
        # the last first: the order of the table must not depend on it
        for place in reversed(range(len(tasks))):
            yield Answer(place, function(tasks[place]))


@pytest.fixture(scope="module")
def table():
    return repeat_simulation(Experiment("demo"), 3, HereEngine(), first_seed=5)


@pytest.mark.slow
def test_same_table_in_other_processes(table):
    elsewhere = repeat_simulation(Experiment("demo"), 3, LocalEngine(2), first_seed=5)
    assert elsewhere.equals(table)


def test_true_error_and_ellipses_against_a_loop(table):
    block = simulate_block("demo", seed=6)
    result = densify(block)
    truth = block.truth.set_index("point_id")
    squares, inside = [], []
    for point in result.points[result.points["role"] == "new"].itertuples():
        true = truth.loc[point.point_id]
        error = np.array([point.easting - true.easting, point.northing - true.northing])
        squares.append(error @ error)
        covariance = np.array(
            [
                [point.standard_error_easting**2, point.covariance_en],
                [point.covariance_en, point.standard_error_northing**2],
            ]
        )
        # the density at the edge of the 95 % ellipse is a twentieth of the peak's
        density = multivariate_normal(np.zeros(2), covariance)
        inside.append(density.pdf(error) >= 0.05 * density.pdf(np.zeros(2)))
    row = table.iloc[1]
    assert row["seed"] == 6
    assert row["n_points"] == len(squares)
    assert row["error_total"] == pytest.approx(np.sqrt(np.mean(squares)), rel=1e-12)
    assert row["share_in_ellipses"] == pytest.approx(np.mean(inside), abs=1e-12)
    assert row["standard_error_total"] == result.figures.mean_total


def test_summary(table):
    lines = summarize_repetitions(table).splitlines()
    assert lines[0] == "3 repetitions, new points (total, RMS)"
    assert [line.split()[-1] for line in lines[1:5]] == ["cm"] * 4
    assert lines[5].startswith("  true position within the 95 % ellipses: 9")


@pytest.mark.parametrize("number", [0, -1, 2.5])
def test_number_of_repetitions(number):
    with pytest.raises(SettingsError, match=r"n_repetitions = .*a whole number from 1"):
        repeat_simulation(Experiment("demo"), number, HereEngine())


def test_chance_is_that_of_errors_that_points_share(good_result):
    """By all covariances, of which the figure draws some."""
    errors = good_result.solution.errors
    points = good_result.solution.points
    new = np.flatnonzero((points["role"] == "new").to_numpy())
    pairs = np.stack(np.meshgrid(new, new, indexing="ij"), axis=-1).reshape(-1, 2)
    of_pairs = errors.covariance_at(pairs)
    whole = np.block(
        [[of_pairs[i * len(new) + j] for j in range(len(new))] for i in range(len(new))]
    )
    drawn = np.random.default_rng(1).standard_normal((len(whole), 4000))
    values, vectors = np.linalg.eigh(whole)
    error = vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * drawn)
    rms = np.sqrt((error**2).sum(axis=0) / len(new))
    chance = chance_of_error(good_result)
    # 4000 draws are known to 2 %; the figure is of first order, and of pairs drawn
    assert chance == pytest.approx(rms.std(), rel=0.1)
    independent = np.sqrt(np.mean(rms**2)) / np.sqrt(4.0 * len(new))
    assert chance > 1.5 * independent


@pytest.mark.parametrize(("size", "said"), [(0.0073, "7.30 mm"), (0.04, "4.00 cm")])
def test_a_trial_is_told_in_the_unit_of_repetitions(size, said):
    """It was 0.73 cm where the repetitions of the same plan had 7.3 mm."""
    row = {"n_points": 9, "standard_error_total": size, "error_total": size}
    lines = describe_trial(size, row, chance=size / 10.0).splitlines()
    assert lines[1].endswith(f" {said}")
    assert lines[3].endswith(f"{said[-2:]} by chance)")


def test_blocks_of_a_source_are_repeated_in_place_of_a_preset():
    made = []

    def source(seed):
        made.append(seed)
        return simulate_block("demo", seed=seed, title="Own")

    table = repeat_simulation(Experiment(source=source), 2, HereEngine(), first_seed=4)
    assert sorted(made) == [4, 5] == list(table["seed"])
    lines = summarize_repetitions(table, planned=0.0345).splitlines()
    assert lines[1].split() == ["planned", "3.5", "cm"]
    assert lines[2].startswith("  true error")
