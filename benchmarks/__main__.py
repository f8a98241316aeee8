"""Run all races, or those that are named; exit status 1 when a floor is missed."""

import os
import sys
from importlib import import_module
from time import perf_counter

# set before numpy is imported: on matrices as small as these the threads of a BLAS
# only wait for each other, and go on waiting while the next contender runs
for library in ("OPENBLAS_NUM", "MKL_NUM", "OMP_NUM"):
    os.environ.setdefault(f"{library}_THREADS", "1")

RACES = (
    "transformation",
    "robust",
    "table_to_table",
    "coverage_mean",
    "relative_orientation",
    "block_adjustment",
    "monte_carlo",
    "own_deformation",
    "propagation",
    "densification",
    "reading",
    "writing",
    "commands",
    "batches",
)


def main(names):
    """Run races one after the other, and keep what came of them.

    Gives the exit status: 0 passed, 1 a floor was missed, 2 there is no such race.
    """
    unknown = [name for name in names if name not in RACES]
    if unknown:
        print(f"unknown race {unknown[0]}; expected {', '.join(RACES)}")
        return 2
    begin, races = perf_counter(), {}
    for name in names or RACES:
        began = perf_counter()
        races[name] = import_module(f"benchmarks.{name}").run()
        print(f"\n{name}: {perf_counter() - began:.0f} s", flush=True)
    # imported last: it takes along what draws
    from benchmarks.record import keep  # noqa: PLC0415

    return keep(races, perf_counter() - begin)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
