"""How a race is run, judged and printed."""

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from unittest.mock import patch

ROUNDS = 5


@dataclass(frozen=True)
class Contender:
    """Somebody who does the work.

    Attributes
    ----------
    name : str
    run : callable
        Does the work once, without arguments.
    n_units : int
        How many units (models, pairs, …) that is.
    floor : float, optional
        How many times longer than ours it must at least take for one unit.
    """

    name: str
    run: Callable
    n_units: int
    floor: float | None = None


@dataclass(frozen=True)
class Outcome:
    """A line of the table: one contender, or anything else that has a floor.

    Attributes
    ----------
    name : str
    figure : str
        What was measured, as it is printed.
    ratio : float
    limit : str
        As it is printed.
    passes : bool
    """

    name: str
    figure: str
    ratio: float
    limit: str
    passes: bool


def race(title, unit, ours, peers, *, rounds=ROUNDS):
    """Run all contenders in turn and print who takes how long.

    Parameters
    ----------
    title, unit : str
    ours : Contender
    peers : sequence of Contender
    rounds : int
        After one round that does not count.

    Returns
    -------
    bool
        Whether every floor is kept.
    """
    everybody = [ours, *peers]
    for contender in everybody:
        contender.run()
    seconds = {contender.name: [] for contender in everybody}
    for _ in range(rounds):
        for contender in everybody:
            seconds[contender.name].append(_seconds(contender.run) / contender.n_units)
    outcomes = [_judge(c, seconds[c.name], seconds[ours.name]) for c in everybody]
    return report(f"{title} (unit = {unit}, {rounds} rounds)", outcomes)


def _seconds(run):
    begin = perf_counter()
    run()
    return perf_counter() - begin


def _judge(contender, theirs, ours):
    ratio = median(t / o for t, o in zip(theirs, ours, strict=True))
    floor = contender.floor
    return Outcome(
        contender.name,
        f"{1e6 * median(theirs):.2f} µs",
        ratio,
        "" if floor is None else f">= {floor:g}",
        floor is None or ratio >= floor,
    )


def report(title, outcomes):
    """Print a table of outcomes.

    Parameters
    ----------
    title : str
    outcomes : sequence of Outcome

    Returns
    -------
    bool
        Whether all pass.
    """
    width = max(len(outcome.name) for outcome in outcomes)
    print(f"\n{title}")
    for outcome in outcomes:
        verdict = ("pass" if outcome.passes else "FAIL") if outcome.limit else ""
        print(
            f"  {outcome.name:<{width}}  {outcome.figure:>14}  {outcome.ratio:>9.3g}"
            f"  {outcome.limit:>9}  {verdict}".rstrip()
        )
    return all(outcome.passes for outcome in outcomes)


def one_core():
    """Let our kernels use one core only, as the peers do."""
    return patch("einschalt.foundations.batches.n_cores", return_value=1)
