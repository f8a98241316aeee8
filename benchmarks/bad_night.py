"""Blocks that hang, explode or lose their process, among others that are sound.

What the faults do stands here, in a module that workers can import.
"""

import os
import signal
import time
from functools import partial

import numpy as np

CHUNK_BYTES = 50_000_000


def hang():
    """Do nothing, for longer than anybody waits."""
    time.sleep(3600.0)


def explode():
    """Take memory, and fill it, until there is none left."""
    held = []
    while True:
        held.append(np.ones(CHUNK_BYTES, dtype=np.uint8))


def end_process():
    """End as the system ends a process that it has no memory for."""
    os.kill(os.getpid(), signal.SIGKILL)


FAULTS = {"hanging": hang, "exploding": explode, "killed": end_process}


class BadNight:
    """An engine for which blocks with the names of faults have these faults.

    ``stand_in(task)`` gives the row of a block that need not be computed, or None.
    """

    def __init__(self, engine, stand_in=None):
        self.engine, self.stand_in = engine, stand_in

    def answers(self, function, tasks):
        """Answers of the engine, with the faults."""
        return self.engine.answers(partial(_run, function, self.stand_in), tasks)


def _run(function, stand_in, task):
    if task.name in FAULTS:
        FAULTS[task.name]()
    row = None if stand_in is None else stand_in(task)
    return function(task) if row is None else row


def not_computed(task):
    """Row of a sound block, without the time that it takes."""
    if task.name == "huge":
        return None
    return {"block": task.name, "outcome": "done"}
