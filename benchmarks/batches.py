"""Batches: what a block costs beside its computation, and what a second worker gains.

There is no peer; judged are the overhead of a block (time in a batch of one worker over
time of reading, computing and writing alone) and the speed of two workers against one.
The first block of each worker holds its start-up and is taken off. A machine that
others use is now faster, now slower: so rounds are short and many, every other one is
turned round, and ratios are taken within a round.
"""

import time
from pathlib import Path
from statistics import fmean, median
from tempfile import TemporaryDirectory

import einschalt as es
from benchmarks.racing import Outcome, report
from einschalt.interfaces.batch.batch_run import batch_folder, plan_batch, run_batch
from einschalt.interfaces.batch.block_search import find_blocks
from einschalt.pipeline.batch.local_engine import LocalEngine

N_BLOCKS = 12
SIDE = 5_000.0
ROUNDS = 8
LARGEST_OVERHEAD = 0.05
LEAST_SPEED_UP = 1.8


def run():
    """Time batches of equal blocks.

    Returns
    -------
    bool
        Whether overhead and speed-up keep their floors.
    """
    with TemporaryDirectory() as folder:
        root = Path(folder)
        geometry = es.BlockGeometry(width=SIDE, height=SIDE)
        for seed in range(N_BLOCKS):
            block = es.simulate_block("neukirchen", seed=seed, geometry=geometry)
            block.write(root / "blocks" / f"block_{seed:02d}")
        rounds = [_round(root, number) for number in range(ROUNDS)]
    one, two, alone = (median(times) for times in zip(*rounds, strict=True))
    overhead = median(r[0] / r[2] - 1.0 for r in rounds)
    speed_up = median(r[0] / r[1] for r in rounds)
    outcomes = [
        Outcome("a block alone", f"{1e3 * alone:.0f} ms", 1.0, "", True),
        Outcome(
            "a block in a batch, overhead",
            f"{1e3 * one:.0f} ms",
            overhead,
            f"<= {LARGEST_OVERHEAD}",
            overhead <= LARGEST_OVERHEAD,
        ),
        Outcome(
            "two workers, times faster",
            f"{1e3 * two:.0f} ms",
            speed_up,
            f">= {LEAST_SPEED_UP}",
            speed_up >= LEAST_SPEED_UP,
        ),
    ]
    return report(f"Batches of {N_BLOCKS} blocks ({ROUNDS} rounds)", outcomes)


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
        es.densify(es.read_block(block)).write(root / "alone" / block.name)
    return (time.perf_counter() - begin) / (len(blocks) - 1)
