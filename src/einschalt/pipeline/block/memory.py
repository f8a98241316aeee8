"""What memory a block needs, before it is asked for.

The propagation of errors holds what an error of each point to which a model was fitted
does to each point of the model, and what any two models of a point share: a matched
cloud of a million points in one model, measured in both flights, would need terabytes,
and so would a point with one name in all models of a large block.
"""

import os
from contextlib import suppress
from pathlib import Path

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.limited_memory import (
    gigabytes,
    is_there_room_for,
    memory_limits,
)
from einschalt.foundations.names import encode, encode_pairs

# measured, everything together: blocks with 1000 to 1500 points in a model in both
# flights; a point in 1000 and in 3000 models; clouds of 10⁵, 3·10⁵ and 10⁶ points
BYTES_OF_PROGRAM = 0.3e9  # libraries and compiled code, before the first table
BYTES_PER_PAIR = 64
BYTES_PER_TWO_MODELS = 300
BYTES_PER_MEASUREMENT = 4000
SHARE_OF_ALL = 0.8
OF_THIS_GROUP = Path("/sys/fs/cgroup/memory.max")  # of containers, on Linux
RAISE_LIMIT = "Raise the limit (ulimit -v or -d)"
THIN_OUT = "Take fewer points of a model, such as a tenth of a matched cloud"


def needed_bytes(block) -> dict:
    """Memory for pairs of points, pairs of models, and measurements, by what it is for.

    Keys are the words of messages: what there is too much of, and what to do then.
    """
    n_pairs = n_two_models = n_all = 0.0
    largest = most = 0
    for name, flight in block.flights.items():
        table = flight.model_table()
        if table.empty:
            continue
        point = encode(table["point_id"])
        is_known = encode(_known_points(block, name)).locate(point) >= 0
        model = encode_pairs(table["coverage"], table["model_id"]).codes
        n_of_model = np.bincount(model)
        n_fitted = np.bincount(model, is_known[point.codes])
        models_of_point = np.bincount(point.codes)
        n_pairs += float(n_fitted @ n_of_model)
        # models that share many points are pairs of models once only
        shared = float(models_of_point.astype(float) @ models_of_point)
        n_two_models += min(shared, float(len(n_of_model)) ** 2)
        n_all += len(table)
        largest = max(largest, int(n_of_model.max()))
        most = max(most, int(models_of_point.max()))
    return {
        (f"up to {largest} points in a model", THIN_OUT): BYTES_PER_PAIR * n_pairs,
        (
            f"a point in {most} models",
            "Give points of different places different names, or take models out",
        ): BYTES_PER_TWO_MODELS * n_two_models,
        (f"{n_all:.0f} measured points", THIN_OUT): BYTES_PER_MEASUREMENT * n_all,
    }


def _known_points(block, name):
    """Points to which the models of a flight are fitted."""
    control = block.control_points
    if name == "high_flight":
        return [] if control is None else control["point_id"]
    known = [] if block.approximate_points is None else [block.approximate_points]
    high = block.flights.get("high_flight")
    known += [] if high is None else [high.model_table()]
    known += [] if known or control is None else [control]
    return np.concatenate([part["point_id"].to_numpy(object) for part in known])


def require_memory(block):
    """Refuse a block that surely needs more memory than this process may have."""
    needed, there = needed_bytes(block), allowed_bytes()
    total = BYTES_OF_PROGRAM + sum(needed.values())
    largest, remedy = max(needed, key=needed.get)
    found = f"the block needs about {gigabytes(total)} of memory, with {largest}"
    if total > there:
        expected = f"at most the {gigabytes(there)} that this process may have"
        raise GeometryError(found, expected=expected, remedy=remedy)
    if not is_there_room_for(total):
        expected = (
            f"what is left of the {gigabytes(there)} that this process may have, most "
            "of which libraries reserve"
        )
        raise GeometryError(found, expected=expected, remedy=RAISE_LIMIT)


def has_memory_to_spare(block) -> bool:
    """Whether a block leaves room for memory that is given back and not yet needed."""
    needed = BYTES_OF_PROGRAM + sum(needed_bytes(block).values())
    return needed <= SHARE_OF_ALL * allowed_bytes()


def allowed_bytes() -> float:
    """Memory of this computer, or limit of this process or group; inf if unknown."""
    found = list(memory_limits().values())
    if "SC_PHYS_PAGES" in getattr(os, "sysconf_names", ()):  # not on Windows
        found.append(float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))
    with suppress(OSError, ValueError):  # no such file, or "max"
        found.append(float(OF_THIS_GROUP.read_text(encoding="ascii")))
    return min(found)
