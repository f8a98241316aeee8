"""The process of a run: ``python -m einschalt.interfaces.local_page.run_process``.

Its first line of standard input is what to do, as JSON; another line, or the end of the
input, is an interruption, as from a keyboard: whoever wanted the results is gone. It
answers with lines of JSON: stages, rows of a batch, and in the end one that says what
became of it.
"""

import json
import math
import os
import signal
import sys
import threading
import time
import traceback
from pathlib import Path

from einschalt.foundations.errors import BlockError, EinschaltError, OutputError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import translated, written_in
from einschalt.foundations.system_errors import reason_of
from einschalt.foundations.told_errors import told
from einschalt.interfaces import python_api
from einschalt.interfaces.batch.memory_errors import lack_of_memory
from einschalt.interfaces.files.input_files import checksum_or_none
from einschalt.interfaces.files.output_folder import held_folder
from einschalt.interfaces.files.result_folder import output_of, write_result
from einschalt.interfaces.files.written_files import PROVENANCE
from einschalt.interfaces.local_page import words
from einschalt.pipeline.progress import Stage, share_of_work

GRACE_SECONDS = 120.0  # for files that are being put into their places


def main():
    """Do what the first line says."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8", errors="backslashreplace")
    os.dup2(2, 1)  # what libraries print must not fall among the answers

    def say(**answer):
        try:
            answers.write(json.dumps(answer, default=str) + "\n")
            answers.flush()
        except BrokenPipeError:  # the server is gone, and _listen ends the run
            os.dup2(os.open(os.devnull, os.O_WRONLY), answers.fileno())

    line = sys.stdin.readline()
    try:
        threading.Thread(target=_listen, daemon=True).start()
        if line:
            question = json.loads(line)
            with written_in(question["language"]):
                _answer(question, say)
    except KeyboardInterrupt:  # before it began
        say(end="cancelled")


def _listen():
    """Interrupt the run when it is cancelled, or nobody waits for it any more."""
    sys.stdin.readline()
    if hasattr(signal, "pthread_kill"):  # it also ends waiting
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)
    time.sleep(GRACE_SECONDS)
    os._exit(1)


def _answer(question, say):
    work = {"densify": _densify, "batch": _batch}[question["kind"]]
    provenance = Path(question["output"]) / PROVENANCE
    before = checksum_or_none(provenance)
    try:
        work(question, say)
    except KeyboardInterrupt:
        # it may have come when all was written
        is_done = question["kind"] == "densify"
        is_done = is_done and checksum_or_none(provenance) not in (before, None)
        say(end="done" if is_done else "cancelled")
    except EinschaltError as error:
        say(end="failed", problems=_said(error))
    except Exception as error:  # noqa: BLE001 - it is the answer
        if lack_of_memory(error, "") is not None:
            say(end="failed", problems=[translated(words.NO_MEMORY)])
        elif isinstance(error, OSError):
            say(end="failed", problems=[f"{retold(reason_of(error))}."])
        else:
            traceback.print_exc()  # for whoever mends it
            say(end="failed", problems=[translated(words.FAULT)])
    else:
        say(end="done")


def _said(error):
    problems = error.problems if isinstance(error, BlockError) else [error]
    return [told(_without_option(problem)) for problem in problems]


def _without_option(error):
    """A message that tells nobody to type an option who has no command line."""
    if isinstance(error, OutputError) and "--overwrite" in (error.remedy or ""):
        return error.with_facts(remedy="Name another folder for the results")
    return error


def _densify(question, say):
    """Compute a block and write its results, as ``einschalt densify`` does."""
    output = Path(question["output"])

    def progress(stage, fraction):
        if stage != Stage.DONE:  # it is computed, and not yet written
            say(stage=str(stage), fraction=share_of_work(stage, fraction))

    progress(Stage.READING, 0.0)
    block = python_api.read_block(question["block"], question["given"])
    with held_folder(output, output_of(block)):
        result = python_api.densify(block, block.settings, progress=progress)
        progress(Stage.ASSESSMENT, 1.0)
        result.assessment  # noqa: B018
        progress(Stage.WRITING, 1.0)
        write_result(result, output)


def _batch(question, say):
    """Compute many blocks, as ``einschalt batch`` does."""

    def progress(news):
        row = {name: _plain(value) for name, value in news.row.items()}
        say(row=row, fraction=news.n_done / news.n_all, stage="batch")

    blocks, output = question["blocks"], question["output"]
    table = python_api.densify_many(blocks, output, progress=progress)
    for row in table.to_dict("records"):
        say(row={name: _plain(value) for name, value in row.items()})


def _plain(value):
    """A value of a row as JSON has it."""
    value = value.item() if hasattr(value, "item") else value
    is_number = isinstance(value, float)
    return None if is_number and not math.isfinite(value) else value


if __name__ == "__main__":
    main()
