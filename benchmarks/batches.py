"""Batches: what a block costs beside its computation, and what a second worker gains.

There is no peer; judged are the overhead of a block (time in a batch of one worker over
time of reading, computing and writing alone) and the speed of two workers against one.
The first block of each worker holds its start-up and is taken off. A machine that
others use is now faster, now slower: so rounds are short and many, every other one is
turned round, and ratios are taken within a round. The processor's seconds of a block of
60 models, with report and tables, are what a longer batch takes more than a short one.
"""

import subprocess
import sys
import time
from pathlib import Path
from statistics import fmean, median
from tempfile import TemporaryDirectory

import einschalt as es
from benchmarks.racing import (
    Outcome,
    at_least,
    at_most,
    cpu_of_children,
    in_unit,
    report,
)
from einschalt.interfaces.batch.batch_run import batch_folder, plan_batch, run_batch
from einschalt.interfaces.batch.block_search import find_blocks
from einschalt.pipeline.batch.local_engine import LocalEngine
from einschalt.pipeline.densify import densify

N_BLOCKS = 8
SIDE = 5_000.0
ROUNDS = 4
LARGEST_OVERHEAD = at_most(0.05)
LEAST_SPEED_UP = at_least(1.8)
SMALL_SIDE, SHORT, LONG = 3_400.0, 8, 32  # blocks of 60 models, and how many of them
MOST_CPU = at_most(1.0, 0.3)


def run():
    """Time batches of equal blocks.

    Returns
    -------
    list of Race
    """
    with TemporaryDirectory() as folder:
        root = Path(folder)
        _write_blocks(root / "blocks", SIDE, N_BLOCKS)
        rounds = [_round(root, number) for number in range(ROUNDS)]
        return [_against_one_alone(rounds), _small_blocks(root)]


def _write_blocks(folder, side, n_blocks):
    geometry = es.BlockGeometry(width=side, height=side)
    for seed in range(n_blocks):
        block = es.simulate_block("neukirchen", seed=seed, geometry=geometry)
        block.write(folder / f"block_{seed:02d}")


def _against_one_alone(rounds):
    one, two, alone = (median(times) for times in zip(*rounds, strict=True))
    overhead = median(r[0] / r[2] - 1.0 for r in rounds)
    speed_up = median(r[0] / r[1] for r in rounds)
    rows = [
        Outcome("a block alone", in_unit(alone), 1.0),
        Outcome("in a batch, overhead", in_unit(one), overhead, LARGEST_OVERHEAD),
        Outcome("two workers, times faster", in_unit(two), speed_up, LEAST_SPEED_UP),
    ]
    return report(f"Batches of {N_BLOCKS} blocks ({ROUNDS} rounds)", rows)


def _small_blocks(root):
    """The command itself, two workers, on few blocks and on more of them."""
    taken = []
    for n_blocks in (SHORT, LONG):
        folder = root / f"small_{n_blocks}"
        _write_blocks(folder, SMALL_SIDE, n_blocks)
        n_low = es.read_block(folder / "block_00").low_flight.n_models
        before = cpu_of_children()
        command = ("batch", folder, "--output", root / f"out_{n_blocks}")
        subprocess.run(
            [sys.executable, "-m", "einschalt", *map(str, command), "--workers", "2"],
            check=True,
            capture_output=True,
        )
        taken.append(cpu_of_children() - before)
    of_block = (taken[1] - taken[0]) / (LONG - SHORT)
    name = f"a block of {n_low} models with report and tables, CPU"
    row = Outcome(name, f"{of_block:.2f} s", of_block, MOST_CPU)
    return report("A batch of small blocks, two workers", [row])


def _round(root, number):
    """Seconds per block: one worker, two workers, in one process without a batch."""
    ways = [
        lambda: _batch(root, f"{number}-1", 1),
        lambda: _batch(root, f"{number}-2", 2),
        lambda: _alone(root),
    ]
    if number % 2 == 0:
        return tuple(way() for way in ways)
    return tuple(way() for way in reversed(ways))[::-1]


def _batch(root, name, n_workers):
    """Seconds per block, from the first answers of the workers to the last answer."""
    blocks = find_blocks(root / "blocks")
    times = []
    with batch_folder(root / name) as output:
        plan = plan_batch(blocks, output)
        engine = LocalEngine(n_workers)
        run_batch(plan, engine, progress=lambda _: times.append(time.perf_counter()))
    # from the first answer of a worker, in the mean, it computes what comes after
    begin = fmean(times[:n_workers])
    return (times[-1] - begin) / (len(times) - n_workers)


def _alone(root):
    """Seconds per block in this process; the first block holds the start-up."""
    blocks = find_blocks(root / "blocks")
    for number, block in enumerate(blocks):
        if number == 1:
            begin = time.perf_counter()
        result = densify(
            es.read_block(block), kind=es.DensificationResult, compares_methods=False
        )
        result.write(root / "alone" / block.name)
    return (time.perf_counter() - begin) / (len(blocks) - 1)
