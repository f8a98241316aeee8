"""One adjustment of models that are bent, against one that looks for no such thing.

There is no peer. What is timed is the whole adjustment of `densify`: sizes of the
deformations are estimated and tested, and the models adjusted with them. The other one
tests the same block for what models share, and goes no further.
"""

from dataclasses import replace
from statistics import median
from time import process_time
from unittest import mock

import numpy as np

import einschalt as es
from benchmarks.racing import ROUNDS, Outcome, at_most, report
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.densification.simultaneous import adjust_flights
from einschalt.pipeline.settings import Settings
from einschalt.stages.simultaneous import adjustment
from einschalt.stages.stage2_relative_orientation import relative_orientation

LARGEST_RATIO, WANTED = 4.5, 3.0
BENT_M = 0.08  # at the edge of a model, on the ground


def run():
    """Time both adjustments.

    Returns
    -------
    list of Race
    """
    block = es.simulate_block("neukirchen", seed=1)
    rng = np.random.default_rng(1)
    block = replace(block, low_flight=_bent(block.low_flight, rng))
    # what is not modelled costs nothing
    assert _adjusted(block).deformations["own_is_modelled"].any()
    seconds = []
    for _ in range(ROUNDS):
        with_them = _seconds(block)
        with mock.patch.object(adjustment, "find_own_deformation", _nothing):
            assert not _adjusted(block).deformations["own_is_modelled"].any()
            seconds.append((with_them, _seconds(block)))
    ratio = median(with_them / without for with_them, without in seconds)
    outcome = report(
        f"{block.low_flight.n_models} models that are bent, each in its own way "
        f"({ROUNDS} rounds, seconds of the CPU)",
        [
            Outcome(
                "one adjustment: time, ratio to one that looks for none",
                f"{1e3 * median(with_them for with_them, _ in seconds):.0f} ms",
                ratio,
                at_most(LARGEST_RATIO, WANTED),
            )
        ],
    )
    return [outcome]


def _bent(flight, rng):
    """A flight whose models are displaced by quadratic polynomials of their own."""
    points = flight.model_points
    by_model = points.groupby(["coverage", "model_id"])
    xy = points[["x", "y"]] - by_model[["x", "y"]].transform("mean")
    x, y = (xy / xy.abs().max()).to_numpy().T
    terms = np.column_stack([x * x, x * y, y * y])
    size = BENT_M / (flight.scale_number * METRES_PER_MM)
    of_model = size * rng.standard_normal((by_model.ngroups, 3, 2))
    moved = np.einsum("nk,nkc->nc", terms, of_model[by_model.ngroup()])
    return replace(flight, model_points=points.assign(**_named(points, moved)))


def _named(points, moved):
    return {name: points[name] + moved[:, k] for k, name in enumerate("xy")}


def _nothing(*_):
    return None


def _adjusted(block):
    flights = {name: relative_orientation(f) for name, f in block.flights.items()}
    return adjust_flights(block, Settings(), flights)


def _seconds(block):
    begin = process_time()
    _adjusted(block)
    return process_time() - begin
