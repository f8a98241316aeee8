"""Covariance of all points of a Neukirchen block: time against the fits, and memory.

There is no peer: a two-step densification is propagated nowhere else. What is carried
is compared with plain Monte Carlo in tests/truth.
"""

import tracemalloc
from statistics import median

import einschalt as es
from benchmarks.racing import ROUNDS, Outcome, at_most, ratio_of, report, seconds_of
from einschalt.foundations.batches import segments
from einschalt.foundations.names import encode
from einschalt.stages.error_propagation.error_model import (
    model_of_both_flights,
    model_of_high_flight,
)
from einschalt.stages.stage4_error_propagation import propagate_model
from einschalt.stages.stage5_double_coverage import average_coverages, with_positions
from einschalt.stages.value_weights import value_weights

LARGEST_RATIO = 3.0  # of the time that the fits of both flights take
LARGEST_MEMORY = 1.0  # GB
MODES = ("all", "most_central")


def run():
    """Time the propagation of each mode.

    Returns
    -------
    list of Race
    """
    block = es.simulate_block("neukirchen", seed=1)
    outcomes = []
    for mode in MODES:
        outcomes += _judge(block, mode, _propagated)
    outcomes += _judge(block, "all", _with_weights)
    title = f"Propagation of {len(block.truth)} points against the fits of both flights"
    return [report(f"{title} ({ROUNDS} rounds)", outcomes)]


def _judge(block, mode, work):
    high, low = _fits(block, mode)
    values = with_positions(
        low.values(block.low_flight.model_points), block.low_flight.model_points
    )
    means = average_coverages(values, coverage_mean=mode)
    title = mode if work is _propagated else f"{mode}, rigorous weights included"
    fits, propagated = [], []
    work(block, high, low, means)
    for _ in range(ROUNDS):
        fits.append(seconds_of(lambda: _fits(block, mode)))
        propagated.append(seconds_of(lambda: work(block, high, low, means)))
    ratio = ratio_of(propagated, fits)
    tracemalloc.start()
    work(block, high, low, means)
    gigabytes = tracemalloc.get_traced_memory()[1] / 1e9
    tracemalloc.stop()
    return [
        Outcome(
            f"{title}: time, ratio to the fits",
            f"{1e3 * median(propagated):.1f} ms",
            ratio,
            at_most(LARGEST_RATIO),
        ),
        Outcome(
            f"{title}: most memory [GB]",
            f"{1e3 * gigabytes:.0f} MB",
            gigabytes,
            at_most(LARGEST_MEMORY),
        ),
    ]


def _propagated(block, high, low, means):
    points = {name: flight.model_points for name, flight in block.flights.items()}
    return propagate_model(
        model_of_both_flights(block, points, high, low).with_means(means), means
    )


def _with_weights(block, high, low, means):
    """Rigorous weights in both flights by joint covariances, and the propagation."""
    points = {name: flight.model_points for name, flight in block.flights.items()}
    of_high = model_of_high_flight(block, points["high_flight"], high.transformation)
    _weigh(high.means, of_high)
    model = model_of_both_flights(block, points, high, low)
    _weigh(means, model)
    return propagate_model(model.with_means(means), means)


def _weigh(means, model):
    points = encode(means.used["point_id"])
    start = segments(points.codes, len(points)).start
    rows, covariances = means.row_numbers, model.covariances_of_values
    return value_weights("rigorous", None, rows, start, covariances)


def _fits(block, mode):
    high = es.approximate_coordinates(
        block.high_flight.model_points, block.control_points, coverage_mean=mode
    )
    return high, es.transform_models(block.low_flight.model_points, high.points)
