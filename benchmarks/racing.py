"""How a race is run, judged and printed."""

import ctypes
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from statistics import median
from time import perf_counter
from unittest.mock import patch

import numpy as np

ROUNDS = 5
MEMORY, CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")
PEAK_ANEW = "5"  # what Linux wants to read there


@dataclass(frozen=True)
class Bound:
    """What a ratio must keep, and what is wanted of it where that is more."""

    floor: float
    is_most: bool
    goal: float | None = None

    def keeps(self, ratio):
        """Whether a ratio keeps the floor."""
        return ratio <= self.floor if self.is_most else ratio >= self.floor

    def reaches(self, ratio):
        """Whether a ratio reaches the goal, which is the floor where there is none."""
        goal = self.floor if self.goal is None else self.goal
        return ratio <= goal if self.is_most else ratio >= goal

    @property
    def text(self):
        """Floor, and goal in brackets."""
        goal = "" if self.goal is None else f" ({self.goal:g})"
        return f"{'<=' if self.is_most else '>='} {self.floor:g}{goal}"


def at_least(floor, goal=None):
    """Nothing below it."""
    return Bound(floor, is_most=False, goal=goal)


def at_most(floor, goal=None):
    """Nothing above it."""
    return Bound(floor, is_most=True, goal=goal)


@dataclass(frozen=True)
class Contender:
    """Somebody who does the work."""

    name: str
    run: Callable  # does it once, without arguments
    n_units: int  # how many units (models, pairs, …) that is
    # how many times longer than ours it must take for one unit
    bound: Bound | None = None


@dataclass(frozen=True)
class Outcome:
    """A row of the table: a contender, or anything else that is bounded."""

    name: str
    figure: str  # what was measured, as it is printed
    ratio: float
    bound: Bound | None = None
    peak_mb: float = math.nan  # memory that it took at most, beyond what was there

    @property
    def is_kept(self):
        """Whether the floor is kept; True where there is none."""
        return self.bound is None or self.bound.keeps(self.ratio)

    @property
    def is_reached(self):
        """Whether the goal is reached; True where there is none."""
        return self.bound is None or self.bound.reaches(self.ratio)


@dataclass(frozen=True)
class Race:
    """Rows that belong together."""

    title: str
    outcomes: tuple
    # seconds by number of models or pairs: a line of the figure
    growth: dict | None = None

    @property
    def is_kept(self):
        """Whether every floor is kept."""
        return all(outcome.is_kept for outcome in self.outcomes)


NAME_WIDTH = 58


def report(title, outcomes, growth=None) -> Race:
    """Print rows, all races in the same columns.

    ``growth`` are seconds by number of models or pairs, for the figure.
    """
    print(f"\n{title}")
    for outcome in outcomes:
        bound = outcome.bound.text if outcome.bound else ""
        peak = "" if math.isnan(outcome.peak_mb) else f"{outcome.peak_mb:.0f} MB"
        print(
            f"  {outcome.name:<{NAME_WIDTH}} {outcome.figure:>16} {peak:>9}"
            f" {outcome.ratio:>9.3g}  {bound:<16} {_verdict(outcome)}".rstrip(),
            flush=True,
        )
    return Race(title, tuple(outcomes), growth)


def _verdict(outcome):
    if outcome.bound is None:
        return ""
    if not outcome.is_kept:
        return "FAIL"
    return "pass" if outcome.is_reached else "pass, goal missed"


def race(title, unit, ours, peers, *, rounds=ROUNDS, n_bytes=None) -> Race:
    """Run all contenders in turn and print who takes how long.

    One round before does not count, but for our peak of memory. ``n_bytes`` are what
    ours reads and writes at least: then a copy of as many takes part.
    """
    everybody = [ours, *peers]
    if n_bytes:
        everybody.append(_copy_of(n_bytes, ours.n_units))
    peak = peak_mb(ours.run)
    for contender in everybody[1:]:
        contender.run()
    seconds = {contender.name: [] for contender in everybody}
    for _ in range(rounds):
        for contender in everybody:
            taken = seconds_of(contender.run) / contender.n_units
            seconds[contender.name].append(taken)
    outcomes = [
        Outcome(
            c.name,
            in_unit(median(seconds[c.name])),
            ratio_of(seconds[c.name], seconds[ours.name]),
            c.bound,
            peak if c is ours else math.nan,
        )
        for c in everybody
    ]
    return report(f"{title} (unit = {unit}, {rounds} rounds)", outcomes)


MOST_COPIES, COPIES_WANTED = 9.0, 6.0


def _copy_of(n_bytes, n_units):
    source = np.ones(n_bytes // 16)
    target = np.empty_like(source)
    return Contender(
        f"memory copy of the same {n_bytes / 1e6:.0f} MB",
        lambda: np.copyto(target, source),
        n_units,
        at_least(round(1.0 / MOST_COPIES, 3), round(1.0 / COPIES_WANTED, 3)),
    )


def seconds_of(run):
    """Time that something takes by the clock."""
    begin = perf_counter()
    run()
    return perf_counter() - begin


def ratio_of(theirs, ours):
    """Median of the ratios of the rounds."""
    return median(t / o for t, o in zip(theirs, ours, strict=True))


def in_unit(seconds):
    """Seconds as they are printed."""
    if seconds < 1e-3:
        return f"{1e6 * seconds:.2f} µs"
    return f"{1e3 * seconds:.1f} ms" if seconds < 1.0 else f"{seconds:.2f} s"


def peak_mb(run):
    """Memory that something takes at most, beyond what this process has [MB].

    NaN where the system does not tell.
    """
    if not CLEAR.exists():
        run()
        return math.nan
    if hasattr(
        ctypes.pythonapi, "malloc_trim"
    ):  # what is kept for later would not count
        ctypes.pythonapi.malloc_trim(0)
    CLEAR.write_text(PEAK_ANEW)
    before = _resident("VmRSS")
    run()
    return max(0.0, (_resident("VmHWM") - before) / 1e3)


def peak_gib():
    """Memory that this process has taken at most.

    The resource module would begin with the memory of the process that started it.
    """
    return _resident("VmHWM") / 2**20


def _resident(name):
    return int(MEMORY.read_text().split(f"{name}:")[1].split()[0])


def cpu_of_children():
    """Seconds of the processor that all ended children have taken."""
    times = os.times()
    return times.children_user + times.children_system


def exponent(seconds, sizes):
    """Exponent p of time ~ size^p between two sizes."""
    return math.log(seconds[1] / seconds[0]) / math.log(sizes[1] / sizes[0])


def one_core():
    """Let our kernels use one core only, as the peers do."""
    return patch.dict(os.environ, EINSCHALT_CORES="1")


def peer(name):
    """Import a peer, or say that it takes no part: None."""
    try:
        return import_module(name)
    except ImportError:
        print(f"\n{name} is not installed: it takes no part")
        return None
