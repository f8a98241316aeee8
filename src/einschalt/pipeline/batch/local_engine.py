"""Engines run many tasks, each whole: in processes of this computer, or on a cluster.

An engine has one method, ``answers(function, tasks)``: it calls the function with every
task and yields the answers as they come. Function, tasks and values cross the border
of a process, so the function stands in a module, and tasks are small. What ends a
process (a lack of memory, a crash in a library) ends one task, never the rest.

Batches of blocks and simulations run on the same engines.
"""

import os
import pickle
import queue
import struct
import subprocess
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from multiprocessing.spawn import get_executable
from numbers import Integral
from pathlib import Path
from typing import Any

from einschalt.foundations.arguments import described, finite_number
from einschalt.foundations.batches import n_cores
from einschalt.foundations.errors import EinschaltError, SettingsError
from einschalt.foundations.system_errors import reason_of
from einschalt.pipeline.batch.local_worker import LENGTH, limit_memory

SOURCE = Path(__file__).parents[2]
# BLAS threads would wait for each other, and sums would depend on their number
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
# at its limit glibc would look for room in every thread's memory, at each allocation
QUICK_TO_SAY_NO = {"MALLOC_ARENA_MAX": "1"}
TRIES_ALONE = 2
MOST_WORKERS = 1024


class ProcessEndedError(EinschaltError):
    """The process that had the task ended without an answer."""


class TimeLimitError(EinschaltError):
    """The task took longer than it may."""


class EngineError(EinschaltError):
    """The engine itself is gone: a scheduler that does not answer."""


@dataclass(frozen=True)
class Answer:
    """What became of one task."""

    place: int  # which task, counted from 0
    value: Any = None  # what the function returned
    # what it raised instead, or a ProcessEndedError
    error: Exception | None = None


def run_in_order(engine, function, tasks, *, answered=None) -> list:
    """Call a function with each task, and give the values in the order of the tasks.

    The same for every engine and any number of processes; raises what the first task
    that failed (in their order) has raised. ``answered(number)`` is called after each
    answer with how many there are.
    """
    answers = []
    for answer in engine.answers(function, list(tasks)):
        answers.append(answer)
        if answered is not None:
            answered(len(answers))
    answers.sort(key=lambda answer: answer.place)
    for answer in answers:
        if answer.error is not None:
            raise answer.error
    return [answer.value for answer in answers]


class LocalEngine:
    """Processes of this computer.

    They are started anew, not forked, so that it works on every system, with threads,
    and without a guard in the calling script. A process that ends without an answer is
    replaced, and so is one whose task found no memory. The task is tried again at the
    end, alone, when all memory is there for it; then it is given up. There are as many
    as cores unless ``n_workers`` says otherwise; each may use ``memory_gb`` [GB]. A
    process that needs more than ``time_limit_s`` [s] for a task is ended and replaced,
    and the task given up: it would hang again.
    """

    def __init__(self, n_workers=None, *, memory_gb=None, time_limit_s=None):
        self.n_workers = n_cores() if n_workers is None else n_workers
        if not _is_number_of_processes(self.n_workers):
            raise SettingsError(
                f"workers = {described(self.n_workers)}",
                expected="a whole number from 1 to 1024",
                remedy=f"This computer has {n_cores()} cores",
            )
        self.memory_bytes = None if memory_gb is None else _bytes_of(memory_gb)
        self.time_limit_s = time_limit(time_limit_s)

    def answers(self, function, tasks):
        """Call the function with each task; yield answers as they come."""
        ended = yield from self._round(function, enumerate(tasks), self.n_workers)
        for _ in range(TRIES_ALONE):
            again = [(answer.place, tasks[answer.place]) for answer in ended]
            ended = yield from self._round(function, again, 1)
        yield from ended

    def _round(self, function, numbered, n_workers):
        """Run the tasks once; return those whose process ended, or had no memory."""
        numbered = list(numbered)
        crew = _Crew(min(n_workers, len(numbered)), self._setup())
        ended = []
        try:
            for answer in crew.answers(function, numbered):
                if isinstance(answer.error, (ProcessEndedError, MemoryError)):
                    ended.append(answer)
                else:
                    yield answer
        finally:  # also where the caller was interrupted, or wants no more
            crew.end()
        return sorted(ended, key=lambda answer: answer.place)

    def _setup(self):
        is_limited = self.memory_bytes is not None
        # BLAS allocates for each thread that calls it, and waits for ever where it
        # finds no memory: with a limit there is one, whose room was taken before
        cores = 1 if is_limited else max(n_cores() // self.n_workers, 1)
        limited = QUICK_TO_SAY_NO if is_limited else {}
        inherited = os.environ.get("PYTHONPATH")
        paths = [str(SOURCE), *([inherited] if inherited else [])]
        environment = {
            **os.environ,
            **dict.fromkeys(ONE_THREAD, "1"),
            **limited,
            "EINSCHALT_CORES": str(cores),
            "PYTHONPATH": os.pathsep.join(paths),
        }
        return _Setup(environment, self.memory_bytes, self.time_limit_s)


def _is_number_of_processes(value):
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    return is_whole and 1 <= value <= MOST_WORKERS


def _bytes_of(memory_gb):
    expected = "a number above 0 (gigabytes for each process)"
    number = finite_number("memory_gb", memory_gb, expected=expected)
    if not number > 0.0:
        raise SettingsError(f"memory_gb = {number!r}", expected=expected)
    return int(number * 1e9)


def time_limit(seconds):
    """Seconds for a task as a number, or None without a limit."""
    if seconds is None:
        return None
    expected = "a number above 0 (seconds for each task)"
    number = finite_number("time_limit_s", seconds, expected=expected)
    if not number > 0.0:
        raise SettingsError(f"time_limit_s = {number!r}", expected=expected)
    return number


@dataclass(frozen=True)
class _Setup:
    environment: dict
    memory_bytes: int | None
    time_limit_s: float | None


class _Crew:
    """Processes, each led by a thread that gives it one task after the other."""

    def __init__(self, n_workers, setup):
        self.workers = [_Worker(setup) for _ in range(n_workers)]
        self.threads = ThreadPoolExecutor(max(n_workers, 1))
        self.come = queue.SimpleQueue()
        self.left = iter(())

    def answers(self, function, numbered):
        waiting = iter(numbered)
        for worker in self.workers:  # one task each, so that nothing piles up
            self._give(worker, function, islice(waiting, 1))
        for _ in numbered:
            worker, answer = self.come.get()
            self._give(worker, function, islice(waiting, 1))
            yield answer

    def _give(self, worker, function, one):
        for place, task in one:
            self.threads.submit(self._ask, worker, function, place, task)

    def _ask(self, worker, function, place, task):
        try:
            value, error = worker.ask(function, task)
        except Exception as fault:  # noqa: BLE001 - handed to the caller, as the answer
            value, error = None, fault
        self.come.put((worker, Answer(place, value, error)))

    def end(self):
        for worker in self.workers:
            worker.end()
        self.threads.shutdown(wait=True, cancel_futures=True)
        for worker in self.workers:
            worker.stop()


class _Worker:
    """One process, started when it is first needed."""

    def __init__(self, setup):
        self.setup = setup
        self.process = None
        self.is_ended = False
        self.is_late = False
        self.is_starting = threading.Lock()

    def ask(self, function, task):
        """Value and error of one task."""
        try:
            if self.process is None:
                self._start()
            with self._time_limit():
                answer = self._exchange((function, task))
        except (OSError, EOFError):
            raise self._without_answer() from None
        if isinstance(answer[1], MemoryError):
            self.stop()  # who knows what the rest of it would be worth
        return answer

    def _start(self):
        with self.is_starting:
            if self.is_ended:
                raise EOFError
            self.process = _new_process(self.setup.environment)
        if self.setup.memory_bytes is not None:
            _, error = self._exchange((limit_memory, self.setup.memory_bytes))
            if error is not None:
                raise error

    def _exchange(self, question):
        sent = pickle.dumps(question)
        self.process.stdin.write(LENGTH.pack(len(sent)) + sent)
        self.process.stdin.flush()
        head = self.process.stdout.read(LENGTH.size)
        try:
            (size,) = LENGTH.unpack(head)
        except struct.error:
            raise EOFError from None
        body = self.process.stdout.read(size)
        if len(body) < size:
            raise EOFError
        return pickle.loads(body)

    @contextmanager
    def _time_limit(self):
        self.is_late = False
        if self.setup.time_limit_s is None:
            yield
            return
        timer = threading.Timer(self.setup.time_limit_s, self._end_late)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def _end_late(self):
        self.is_late = True
        if self.process is not None:
            self.process.kill()

    def _without_answer(self):
        if self.is_late:
            self.stop()
            return TimeLimitError(
                f"it was not done within {self.setup.time_limit_s:g} s, and was ended",
                expected="a task that ends within the time limit",
                remedy="Raise the time limit, or see what it waits for",
            )
        return ProcessEndedError(
            f"the process that computed it ended without an answer "
            f"({_said(self.stop())})",
            expected="enough memory, and libraries that do not crash",
            remedy="Run it with fewer processes, or on a computer with more memory",
        )

    def stop(self):
        """End the process, and say with which code it ended."""
        process, self.process = self.process, None
        if process is None:
            return None
        with suppress(OSError):
            process.stdin.close()
        with suppress(subprocess.TimeoutExpired):  # without input it ends by itself
            process.wait(1.0)
        process.kill()
        process.stdout.close()
        return process.wait()

    def end(self):
        """End it at once, and let no other one start."""
        with self.is_starting:
            self.is_ended = True
            if self.process is not None:
                self.process.kill()


def _new_process(environment):
    try:
        return subprocess.Popen(
            [get_executable(), "-P", "-m", "einschalt.pipeline.batch.local_worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
            # an interruption from the keyboard is ours to handle
            start_new_session=True,
        )
    except OSError as error:
        raise ProcessEndedError(
            f"no process could be started: {reason_of(error)}",
            expected="a system that lets this user start Python",
            remedy="See to the permissions of Python and to the limits of the user",
        ) from error


def _said(code):
    if code is None:
        return "it was not started"
    return f"signal {-code}" if code < 0 else f"exit status {code}"
