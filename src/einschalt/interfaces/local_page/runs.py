"""Runs that the page has started, each in a process of its own."""

import itertools
import json
import os
import subprocess
import threading
from contextlib import suppress
from multiprocessing.spawn import get_executable
from pathlib import Path

from filelock import FileLock, Timeout

from einschalt.foundations.language import mark, translated, written_in
from einschalt.interfaces.files.atomic import remove_leftovers
from einschalt.interfaces.files.folder_lock import LOCK
from einschalt.interfaces.local_page import words
from einschalt.interfaces.local_page.refusals import BusyError, MissingError
from einschalt.pipeline.batch.local_engine import ONE_THREAD, SOURCE
from einschalt.pipeline.progress import Stage

MOST_AT_ONCE = 2
MOST_KEPT = 200
PATIENCE_SECONDS = 5.0  # until a run that was cancelled is ended
PATIENCE_WHILE_WRITING = 120.0
MODULE = "einschalt.interfaces.local_page.run_process"


class Run:
    """A computation: what it does, how far it is, and how it ended.

    ``state`` is running, done, failed or cancelled.
    """

    def __init__(self, number, question, title, links):
        self.number = number
        self.question = question
        self.title = title
        self.links = links  # of its block, and of its results, as pages name them
        self.state = "running"
        self.stage = "starting"
        self.fraction = 0.0
        self.problems = []
        self.rows = {}
        self.is_cancelled = False
        self._output = Path(question["output"])
        self._made = _missing_folders(self._output)
        self._process = _started()
        with suppress(OSError):  # it has ended already: its reader tells how
            self._send(question)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def to_json(self):
        """What a page needs to show it."""
        return {
            "state": self.state,
            "stage": translated(words.STAGES.get(self.stage, self.stage)),
            "fraction": self.fraction,
            "problems": self.problems,
        }

    def cancel(self):
        """Ask it to end; it is ended where it does not listen."""
        if self.state != "running" or self.is_cancelled:
            return
        self.is_cancelled = True
        is_writing = self.stage == Stage.WRITING
        self.stage = "cancelling"
        with suppress(OSError):  # it has ended meanwhile
            self._send("cancel")
        patience = PATIENCE_WHILE_WRITING if is_writing else PATIENCE_SECONDS
        timer = threading.Timer(patience, self._process.kill)
        timer.daemon = True
        timer.start()
        threading.Thread(target=self._forget, args=(timer,), daemon=True).start()

    def end(self):
        """End it, since the session ends; wait until it has."""
        self.cancel()
        self._reader.join(PATIENCE_WHILE_WRITING)

    def _forget(self, timer):
        self._reader.join()
        timer.cancel()

    def _send(self, question):
        self._process.stdin.write(json.dumps(question).encode("ascii") + b"\n")
        self._process.stdin.flush()

    def _read(self):
        """Follow what the process says, until it ends."""
        end = None
        try:
            for line in self._process.stdout:
                end = self._take(line) or end
        finally:
            self._process.stdout.close()
            code = self._process.wait()
            with suppress(OSError):
                self._process.stdin.close()
            self._close(end, code)

    def _take(self, line):
        """Take an answer of the process; how it ends, where it says so."""
        try:
            answer = json.loads(line)
        except ValueError:  # cut off, since the process was killed while it wrote
            return None
        if "row" in answer:
            self.rows[answer["row"]["block"]] = answer["row"]
        if "stage" in answer and not self.is_cancelled:
            self.stage = answer["stage"]
        self.fraction = answer.get("fraction", self.fraction)
        self.problems = answer.get("problems", self.problems)
        return answer.get("end")

    def _close(self, end, code):
        if end is None and self.is_cancelled:
            end = "cancelled"
        elif end is None:
            end = "failed"
            with written_in(self.question["language"]):
                self.problems = [translated(words.ENDED, how=_how(code))]
        is_batch = self.question["kind"] == "batch"
        is_cut = end == "cancelled" and is_batch
        self.stage = "batch cancelled" if is_cut else end
        self.fraction = 1.0 if end == "done" else self.fraction
        try:
            if end != "done":
                self._tidy()
        finally:
            self.state = end  # last: whoever sees it finds the rest

    def _tidy(self):
        """Remove what a process that was ended may have left: never a whole file."""
        if self._output.is_dir():
            remove_leftovers(self._output)
            _remove_free_lock(self._output / LOCK)
        for folder in self._made:
            with suppress(OSError):  # it holds something
                folder.rmdir()


class Runs:
    """The runs of a session."""

    def __init__(self):
        self.all = {}
        self._numbers = itertools.count(1)
        self._is_starting = threading.Lock()

    def start(self, question, title, links) -> Run:
        """Start a run; BusyError where as many run as may.

        Of those that have ended the oldest are forgotten.
        """
        with self._is_starting:
            running = [run for run in self.all.values() if run.state == "running"]
            if len(running) >= MOST_AT_ONCE:
                raise BusyError(
                    f"{len(running)} runs are being computed",
                    expected=f"at most {MOST_AT_ONCE} at once",
                    remedy="Wait until one has ended, or cancel it",
                )
            number = next(self._numbers)
            started = Run(number, question, title, links)
            ended = [one for one, run in self.all.items() if run.state != "running"]
            for old in ended[: max(0, len(self.all) + 1 - MOST_KEPT)]:
                del self.all[old]
            self.all[number] = started
            return started

    def get(self, number) -> Run:
        """The run of a number."""
        run = self.all.get(number)
        if run is None:
            raise MissingError("there is no such run", remedy="Start it again")
        return run

    def end(self):
        """End all of them."""
        all_runs = list(self.all.values())
        for run in all_runs:
            run.cancel()
        for run in all_runs:
            run.end()


def _missing_folders(folder):
    """Folders that a run will make, the innermost first."""
    return [one for one in (folder, *folder.parents) if not one.exists()]


def _remove_free_lock(path):
    """Remove the lock of a process that is gone; one that is held stays."""
    if not path.is_file() or path.is_symlink():
        return
    with suppress(OSError, Timeout), FileLock(path, timeout=0.0):
        path.unlink()


def _started():
    inherited = os.environ.get("PYTHONPATH")
    paths = [str(SOURCE), *([inherited] if inherited else [])]
    environment = {
        **os.environ,
        **dict.fromkeys(ONE_THREAD, "1"),
        "PYTHONPATH": os.pathsep.join(paths),
    }
    return subprocess.Popen(
        [get_executable(), "-P", "-m", MODULE],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
        start_new_session=True,  # an interruption from the keyboard is ours to handle
    )


def _how(code):
    message = mark("signal {code}") if code < 0 else mark("exit status {code}")
    return translated(message, code=abs(code))
