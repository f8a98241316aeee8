"""``python -m fuzz [N]``: N inputs over all readers, going on where the last run ended.

Every input follows from its number alone, so that a finding can be repeated: with
``python -m fuzz 1 --first NUMBER``. What was found, and how far it is, stands in
``out/fuzz``. Two processes share the work: ``--first 0``, ``--first 10000000``.
"""

import argparse
import faulthandler
import itertools
import json
import resource
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random

from fuzz.mutations import mutated
from fuzz.readers import readers, verdict

OUT = Path("out/fuzz")
STATE = OUT / "state.json"
# of an input of at most 64 KiB, in processor time: others may want the computer as well
SLOW_SECONDS = 5.0
HANG_SECONDS = 30.0
WAIT_SECONDS = 1800  # by the clock, for what hangs and does nothing
MOST_GIB = 3
REPORTED = 30.0
ALARMS = (signal.SIGPROF, signal.SIGALRM)


class Hang(BaseException):
    """An input took so long that it was interrupted; no reader may catch it."""


class Fuzzer:
    """All readers, and the inputs that they get.

    Parameters
    ----------
    folder : Path
        An empty one.
    """

    def __init__(self, folder):
        self.readers = readers(folder)
        self.others = [seed for reader in self.readers for seed in reader.seeds]
        weights = [reader.weight for reader in self.readers]
        self.weights = list(itertools.accumulate(weights))
        self.done, self.found = Counter(), Counter()

    def input_of(self, number):
        """Make the input of a number.

        Parameters
        ----------
        number : int

        Returns
        -------
        Reader, bytes
        """
        random = Random(number)
        (reader,) = random.choices(self.readers, cum_weights=self.weights)
        return reader, mutated(random.choice(reader.seeds), random, self.others)

    def feed(self, number):
        """Give the input of a number to its reader.

        Parameters
        ----------
        number : int

        Returns
        -------
        str
            What is wrong; empty where nothing is, or it was found before.
        """
        reader, data = self.input_of(number)
        before = time.process_time()
        try:
            said = verdict(reader, data)
        except Hang:
            said = f"hangs: no end after {HANG_SECONDS:g} s"
        took = time.process_time() - before
        if took > SLOW_SECONDS:
            said = f"slow: took {took:.1f} s"
        self.done[reader.name] += 1
        if not said:
            return ""
        key = f"{reader.name}: {said[:100]}"
        self.found[key] += 1
        if self.found[key] > 1:
            return ""
        file = OUT / f"{number}-{reader.path.name}"
        OUT.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
        return f"input {number}, {reader.name}: {said[:600]}; kept as {file}"


def run(first, count, seconds=float("inf"), *, say=None, keep=None):
    """Feed inputs to the readers.

    Parameters
    ----------
    first, count : int
        Numbers of the inputs.
    seconds : float, optional
        After so long it ends early.
    say : callable, optional
        Takes a line.
    keep : callable, optional
        Takes the number of the next input, now and then.

    Returns
    -------
    Fuzzer
        With ``done`` (inputs of each reader) and ``found`` (findings, how often).
    """
    say, keep = say or _print, keep or (lambda _number: None)
    with tempfile.TemporaryDirectory(prefix="fuzz", dir=_fast_folder()) as place:
        fuzzer = Fuzzer(Path(place))
        before = {sign: signal.signal(sign, _interrupt) for sign in ALARMS}
        try:
            started = last = time.perf_counter()
            for number in range(first, first + count):
                signal.setitimer(signal.ITIMER_PROF, HANG_SECONDS)
                signal.alarm(WAIT_SECONDS)
                # what hangs in a library hears no signal: its input stays in the folder
                faulthandler.dump_traceback_later(2 * WAIT_SECONDS, exit=True)
                finding = fuzzer.feed(number)
                if finding:
                    say(finding)
                now = time.perf_counter()
                if now - last > REPORTED or now - started > seconds:
                    keep(number + 1)
                    last = now
                if now - started > seconds:
                    break
            else:
                keep(first + count)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.alarm(0)
            for sign, handler in before.items():
                signal.signal(sign, handler)
            faulthandler.cancel_dump_traceback_later()
    _report(fuzzer, time.perf_counter() - started, say)
    return fuzzer


def _interrupt(_signal, _frame):
    raise Hang


def _report(fuzzer, seconds, say):
    n_done = fuzzer.done.total()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    say(
        f"{n_done} inputs in {seconds:.0f} s, {n_done / seconds:.0f} a second, "
        f"at most {memory:.0f} MiB, {len(fuzzer.found)} findings"
    )


def _fast_folder():
    memory = Path("/dev/shm")
    return memory if memory.is_dir() else None


def _print(line):
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main():
    """Read the arguments, run, and remember where to go on."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=1_000_000)
    parser.add_argument("--first", type=int, help="number of the first input")
    parser.add_argument("--seconds", type=float, default=float("inf"))
    given = parser.parse_args()
    state = {"next": 0}
    if STATE.exists():
        state = json.loads(STATE.read_text())
    first = state["next"] if given.first is None else given.first

    def keep(following):
        _print(f"{following - first} inputs of this run, next is {following}")
        if given.first is None:
            OUT.mkdir(parents=True, exist_ok=True)
            STATE.write_text(json.dumps({"next": following}))

    resource.setrlimit(resource.RLIMIT_DATA, (MOST_GIB * 2**30,) * 2)
    fuzzer = run(first, given.count, given.seconds, keep=keep)
    for name, number in sorted(fuzzer.done.items()):
        _print(f"  {name}: {number}")
    sys.exit(1 if fuzzer.found else 0)


if __name__ == "__main__":
    main()
