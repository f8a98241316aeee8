"""What a command did, for other programs: the one JSON object of ``--json``.

    {"command": "check", "status": 0, "problems": [], "paths": [], "figures": {…}}

``status`` is the exit status, ``problems`` what went wrong, or was found in a result
(found, expected, remedy, file, row, point, model; what is not known is null),
``paths`` what was written, and ``figures`` the headline figures: metres and numbers by
name.
"""

import json
from contextlib import contextmanager
from dataclasses import dataclass, field

from einschalt.foundations.errors import FACTS, facts_of


@dataclass
class Outcome:
    """What a command has reported so far."""

    command: str
    problems: list = field(default_factory=list)
    paths: list = field(default_factory=list)
    figures: dict = field(default_factory=dict)

    def as_json(self, status):
        """One JSON object, on one line."""
        content = {"command": self.command, "status": status}
        for name in ("problems", "paths", "figures"):
            content[name] = getattr(self, name)
        # ASCII: no console and no pipe can spoil a name
        return json.dumps(_plain(content), allow_nan=False)


RUNNING = []  # the outcome of the command that runs, if it was asked for


@contextmanager
def recorded(command):
    """Record what a command reports: Outcome."""
    RUNNING.append(Outcome(command))
    try:
        yield RUNNING[-1]
    finally:
        RUNNING.pop()


def is_recorded():
    """Whether an object was asked for: text then goes to standard error."""
    return bool(RUNNING)


def report(*paths, **figures):
    """Report what was written, and headline figures; nothing where nobody asked."""
    if RUNNING:
        RUNNING[-1].paths += map(str, paths)
        RUNNING[-1].figures |= figures


@contextmanager
def figures_under(name):
    """Keep the figures that are reported inside under a name: one block of several."""
    if not RUNNING:
        yield
        return
    outer, RUNNING[-1].figures = RUNNING[-1].figures, {}
    try:
        yield
    finally:
        RUNNING[-1].figures = outer | {name: RUNNING[-1].figures}


def report_problems(*problems):
    """Report what went wrong: errors, or texts."""
    if RUNNING:
        RUNNING[-1].problems += [
            facts for problem in problems for facts in facts_of(problem)
        ]


def report_facts(facts):
    """Report faults of which only the facts are known, in the order of FACTS."""
    if RUNNING:
        RUNNING[-1].problems += [
            {name: one.get(name) for name in FACTS} for one in facts
        ]


def report_suggestions(suggestions):
    """Report what was found in a result, whose work is done: problems with remedies."""
    if RUNNING:
        RUNNING[-1].problems += [
            dict.fromkeys(FACTS)
            | {"found": "; ".join((one.problem, *one.details))}
            | {"remedy": one.remedy or None}
            for one in suggestions
        ]


def report_fault(error):
    """Report an error that the program should not make."""
    said = " ".join(str(error).split())
    name = type(error).__name__
    problem = {
        "found": f"{name}: {said}" if said else name,
        "expected": "no such error: it is a fault of the program",
        "remedy": "Report it, with the traceback on standard error",
    }
    RUNNING[-1].problems.append(dict.fromkeys(FACTS) | problem)


def _plain(value):
    """What JSON can hold: a number that is none becomes null."""
    if isinstance(value, dict):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if value is None or isinstance(value, str | bool | int):
        return value
    if hasattr(value, "item"):  # a number of numpy
        return _plain(value.item())
    if isinstance(value, float):
        return value if abs(value) < float("inf") else None  # nor is NaN below it
    return str(value)
