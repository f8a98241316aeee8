"""Run all races, or those that are named; exit status 1 when a floor is missed."""

import os
import sys
from importlib import import_module

# set before numpy is imported: on matrices as small as these the threads of a BLAS
# only wait for each other, and go on waiting while the next contender runs
for library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

RACES = (
    "transformation",
    "table_to_table",
    "relative_orientation",
    "densification",
    "robust",
    "propagation",
    "batches",
    "block_adjustment",
    "own_deformation",
    "reading",
)


def main(names):
    """Run races one after the other.

    Parameters
    ----------
    names : sequence of str
        All where it is empty.

    Returns
    -------
    int
        Exit status: 0 passed, 1 a floor was missed, 2 there is no such race.
    """
    unknown = [name for name in names if name not in RACES]
    if unknown:
        print(f"unknown race {unknown[0]}; expected {', '.join(RACES)}")
        return 2
    kept = [import_module(f"benchmarks.{name}").run() for name in names or RACES]
    print("\nevery floor is kept" if all(kept) else "\na floor was missed")
    return 0 if all(kept) else 1


sys.exit(main(sys.argv[1:]))
