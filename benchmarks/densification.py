"""Blocks of 100 to 72 000 models: time must grow as the block does.

There is no peer; judged are the exponent p in time ~ models^p over a decade, for the
whole and for every stage, and what the largest block takes, in a process of its own:
three fifths of a country of 120 000 low-flight models, since 24 GB hold no more of it,
against three fifths of what is wanted for the whole.
"""

import subprocess
import sys
from statistics import median
from time import perf_counter

import numpy as np

import einschalt as es
from benchmarks.racing import Outcome, at_most, exponent, peak_gib, report
from einschalt.foundations.kept_memory import keep_freed_memory

# side of the square [m]: the low flight then has about 100, 1000 and 10 000 models
SIDES = (6_500.0, 21_500.0, 68_000.0)
COUNTRY, SHARE = 236_800.0, 0.6  # side [m]: 120 000 low-flight models
ROUNDS = 3
LARGEST_EXPONENT = 1.1
MOST_SECONDS = at_most(120, 20 * SHARE)
MOST_WITH_SUMMARY = at_most(240, 30 * SHARE)
MOST_GIB = at_most(14, 6 * SHARE)


def run():
    """Time the pipeline on growing blocks.

    Returns
    -------
    list of Race
    """
    blocks = [_block(side) for side in SIDES]
    results = [es.densify(block) for block in blocks]
    for block, result in zip(blocks, results, strict=True):
        _assert_right(block, result)
    n_models = [result.figures.n_models_low for result in results]
    del results
    runs = [[_stages(block) for block in blocks] for _ in range(ROUNDS)]
    seconds = {
        stage: [median(one[place][stage] for one in runs) for place in range(3)]
        for stage in runs[0][0]
    }
    growth = dict(zip(n_models, seconds["the whole"], strict=True))
    stages = report(
        f"Two steps, blocks of {n_models} low-flight models: milliseconds, and the "
        "exponent from the second to the third",
        [_judge(stage, times, n_models) for stage, times in seconds.items()],
    )
    del blocks, runs
    return [stages, _country(growth)]


def _block(side):
    geometry = es.BlockGeometry(width=side, height=side)
    return es.simulate_block("neukirchen", seed=1, geometry=geometry)


def _stages(block):
    """Time of each stage, and of the whole [s]."""
    times = []
    es.densify(block, progress=lambda title, _: times.append((title, perf_counter())))
    ends = [*times[1:], times[-1]]
    seconds = {
        title: end - begin
        for (title, begin), (_, end) in zip(times[:-1], ends, strict=False)
    }
    return {**seconds, "the whole": times[-1][1] - times[0][1]}


def _judge(stage, seconds, n_models):
    return Outcome(
        stage,
        " ".join(f"{1e3 * value:.0f}" for value in seconds),
        exponent(seconds[1:], n_models[1:]),
        at_most(LARGEST_EXPONENT),
    )


def _assert_right(block, result):
    both = result.points.merge(block.truth, on="point_id", suffixes=("", "_true"))
    off = np.hypot(
        both["easting"] - both["easting_true"],
        both["northing"] - both["northing_true"],
    )
    # Neukirchen's mean of two coverages is 5 to 6 cm, whatever the extent
    assert len(both) == len(block.truth)
    assert 0.03 < np.sqrt(np.mean(off**2)) < 0.10


def _country(growth):
    """Models of a country, with propagated covariances and with a summary."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.densification"],
        capture_output=True,
        text=True,
        check=True,
    )
    n_low, n_high, n_measured, densified, summed_up, gib = map(
        float, done.stdout.split()
    )
    rows = [
        Outcome("densified", f"{densified:.1f} s", densified, MOST_SECONDS),
        Outcome(
            "densified, judged and summed up",
            f"{summed_up:.1f} s",
            summed_up,
            MOST_WITH_SUMMARY,
        ),
        Outcome("memory", f"{gib:.1f} GiB", gib, MOST_GIB),
    ]
    size = f"{n_low:.0f} low and {n_high:.0f} high models, {n_measured:.0f} points"
    return report(
        f"Two steps: {SHARE:g} of a country, {size} in them",
        rows,
        growth | {int(n_low): densified},
    )


def _alone():
    """Densify a part of a country; print its size, seconds, and GiB."""
    keep_freed_memory()  # as a command does
    block = _block(SIDES[0])
    assert es.densify(block).summary()
    block = _block(COUNTRY * np.sqrt(SHARE))
    begin = perf_counter()
    result = es.densify(block)
    densified = perf_counter() - begin
    assert result.summary()
    summed_up = perf_counter() - begin
    flights = block.low_flight, block.high_flight
    n_models = [flight.n_models for flight in flights]
    n_measured = sum(len(flight.model_points) for flight in flights)
    print(*n_models, n_measured, densified, summed_up, peak_gib())


if __name__ == "__main__":
    _alone()
