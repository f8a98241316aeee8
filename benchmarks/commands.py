"""What a user waits for: commands with all that they write, and the first run.

Judged are the seconds of the processor, which the work of others does not lengthen so
much, of whole processes: imports, reading, computing, report and tables. The first run
has an empty cache of compiled code, as after an installation. The smallest of some runs
counts: a process cannot take less than it needs.
"""

import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import einschalt
from benchmarks.racing import Outcome, at_most, cpu_of_children, report, seconds_of

EXAMPLES = Path(__file__).parents[1] / "data_examples"
PACKAGE = Path(einschalt.__file__).parent
ROUNDS = 2
BLOCKS = ("neukirchen", "sxb_strasbourg")
PLAN = ("plan", "--target", "5cm", "--spacing", "300m")


def run():
    """Time commands and the first run.

    Returns
    -------
    list of Race
    """
    with TemporaryDirectory() as folder:
        return [_warm(Path(folder)), _first(Path(folder))]


def _warm(folder):
    densify = {name: partial(_densify, name, folder / name) for name in BLOCKS}
    bare = partial(_densify, BLOCKS[0], folder / "bare", "--no-report")
    work = {
        "einschalt --version": (lambda: _einschalt("--version"), at_most(0.3)),
        "densify neukirchen": (densify[BLOCKS[0]], at_most(4, 2.5)),
        "densify neukirchen --no-report": (bare, at_most(3.5, 1.5)),
        "densify sxb_strasbourg": (densify[BLOCKS[1]], at_most(4.5, 3)),
    }
    rows = []
    for name, (once, bound) in work.items():
        once()
        taken = min(_cpu(once) for _ in range(ROUNDS))
        rows.append(Outcome(f"{name}, CPU", f"{taken:.2f} s", taken, bound))
    plan = partial(_einschalt, *PLAN)
    waited = min(seconds_of(plan) for _ in range(ROUNDS))
    rows.append(Outcome("plan a target", f"{waited:.2f} s", waited, at_most(3)))
    return report("Commands, everything compiled", rows)


def _first(folder):
    """Both demo blocks with a package that has compiled nothing, and once more."""
    source, cache = folder / "source", folder / "cache"
    unwanted = shutil.ignore_patterns("*.nbi", "*.nbc", "__pycache__")
    shutil.copytree(PACKAGE, source / PACKAGE.name, ignore=unwanted)
    found = {"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(cache)}

    def both():
        for name in BLOCKS:
            _densify(name, folder / f"first_{name}", environment=found)

    first, second = _cpu(both), _cpu(both)
    compiling = first - second
    row = Outcome(
        "both demo blocks, CPU of compiling",
        f"{compiling:.1f} s",
        compiling,
        at_most(70, 25),
    )
    return report("First run after an installation", [row])


def _densify(name, output, *options, environment=None):
    folder = str(EXAMPLES / name)
    whole = ("densify", folder, "--output", str(output), "--overwrite", *options)
    _einschalt(*whole, environment=environment)


def _einschalt(*arguments, environment=None):
    subprocess.run(
        [sys.executable, "-m", "einschalt", *arguments],
        check=True,
        capture_output=True,
        env={**os.environ, **(environment or {})},
    )


def _cpu(work):
    before = cpu_of_children()
    work()
    return cpu_of_children() - before
