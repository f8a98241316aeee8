"""Blocks of 100, 1000 and 10 000 models: time must grow as the block does.

There is no peer; judged is the exponent p in time ~ models^p over the last decade, for
the whole and for every stage.
"""

from statistics import median
from time import perf_counter

import numpy as np

import einschalt as es
from benchmarks.racing import Outcome, report

# side of the square [m]: the low flight then has about 100, 1000 and 10 000 models
SIDES = (6_500.0, 21_500.0, 68_000.0)
ROUNDS = 3
LARGEST_EXPONENT = 1.1


def run():
    """Time the pipeline on growing blocks.

    Returns
    -------
    bool
        Whether no exponent is too large.
    """
    blocks = [
        es.simulate_block(
            "neukirchen", seed=1, geometry=es.BlockGeometry(width=side, height=side)
        )
        for side in SIDES
    ]
    results = [es.densify(block) for block in blocks]
    for block, result in zip(blocks, results, strict=True):
        _assert_right(block, result)
    n_models = [result.figures.n_models_low for result in results]
    runs = [[_stages(block) for block in blocks] for _ in range(ROUNDS)]
    outcomes = []
    for stage in runs[0][0]:
        seconds = [
            median(one[place][stage] for one in runs) for place in range(len(blocks))
        ]
        outcomes.append(_judge(stage, seconds, n_models))
    return report(
        f"Densification, blocks of {n_models} low-flight models: milliseconds, and the "
        "exponent from the second to the third",
        outcomes,
    )


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
    exponent = np.log(seconds[2] / seconds[1]) / np.log(n_models[2] / n_models[1])
    return Outcome(
        stage,
        " ".join(f"{1e3 * value:.0f}" for value in seconds),
        float(exponent),
        f"<= {LARGEST_EXPONENT}",
        bool(exponent <= LARGEST_EXPONENT),
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
