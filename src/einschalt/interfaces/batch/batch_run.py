"""A batch: which blocks must be computed, their computation, and the table of all.

While a batch runs, a hidden file in its folder marks the results as they were at the
start. A run that finds it continues an interrupted one: what that one has finished
counts as done, and the table becomes the one that it would have written.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

from einschalt.foundations.arguments import described, is_choice
from einschalt.foundations.batches import n_cores
from einschalt.foundations.display_names import as_unicode
from einschalt.foundations.errors import FileError, OutputError, SettingsError
from einschalt.foundations.language import language
from einschalt.interfaces.batch.batch_tables import output_of_batch, write_tables
from einschalt.interfaces.batch.block_run import row_of_result, run_block
from einschalt.interfaces.batch.block_search import (
    case_twins,
    name_blocks,
    named_like_tables,
)
from einschalt.interfaces.batch.block_state import SAID, look_at
from einschalt.interfaces.batch.block_task import BlockTask, output_of_task
from einschalt.interfaces.batch.failure_file import keep_failure
from einschalt.interfaces.files.atomic import (
    make_folder,
    said_as_file_error,
    write_text,
)
from einschalt.interfaces.files.folder_lock import locked
from einschalt.interfaces.files.output_folder import (
    Output,
    refuse_block_folder,
    require_free,
)
from einschalt.interfaces.files.plain_json import read_own_json
from einschalt.interfaces.files.written_files import MARKS, names_of_batch, sealed_text
from einschalt.pipeline.batch.block_table import (
    DONE,
    FAILED,
    NOT_ASKED,
    SKIPPED,
    Expectation,
    blocks_table,
    row_of_failure,
)
from einschalt.pipeline.progress import Stage

FAILED_BEFORE = "the last run failed"
WHICH = ("changed", "unfinished", "failed", "all")


@dataclass(frozen=True)
class BatchPlan:
    """What a batch has to do."""

    output: Path
    # the largest first, so that no worker is left alone with it at the end
    to_run: tuple[BlockTask, ...]
    reasons: dict  # why each of them must be computed
    rows: dict  # of the blocks that need no computation
    names: tuple[str, ...]  # all blocks, in the order of the table
    marks: dict  # what tells the results at the start of the run from later ones
    is_continued: bool  # whether there was an interrupted run
    place: Output  # what it writes into its own folder


def plan_batch(
    blocks, output, *, given=None, which="changed", overwrite=False
) -> BatchPlan:
    """Find out what a batch has to do; nothing is written.

    ``given`` are settings that go before those of each block.toml; ``which`` and
    ``overwrite`` are those of ``densify_many``. Raises where a block is given twice, or
    the results would fall among the blocks, into a file, or into a folder of somebody
    else.
    """
    if not is_choice(which, WHICH):
        raise SettingsError(f"which = {described(which)}", expected=" or ".join(WHICH))
    output = Path(output).absolute()
    named = name_blocks(blocks)
    _require_folder(output)
    refused = named_like_tables(named)
    sought = {name: block for name, block in named.items() if name not in refused}
    for folder in (output, *(output / name for name in sought)):
        refuse_block_folder(folder)
    marks = _marks_of_an_interrupted_run(output)
    with ThreadPoolExecutor(n_cores()) as pool:
        states = pool.map(
            lambda item: look_at(*item, output / item[0], given or {}), sought.items()
        )
        known = names_of_batch(output)
        states = [_allowed(state, known, overwrite=overwrite) for state in states]
    place = output_of_batch([state.task for state in states], overwrite=overwrite)
    require_free(output, place)
    sorting = _Sorting(which, marks or {}, place.inputs, case_twins(sought))
    for name, error in refused.items():
        sorting.rows[name] = _row_without_place(name, error)
    for state in states:
        sorting.take(state)
    return BatchPlan(
        output=output,
        to_run=tuple(sorted(sorting.to_run, key=lambda task: -task.size)),
        reasons=sorting.reasons,
        rows=sorting.rows,
        names=tuple(named),
        marks=sorting.new_marks,
        is_continued=marks is not None,
        place=place,
    )


def _allowed(state, known, *, overwrite):
    """The block with what may be replaced in the folder of its result."""
    is_known = as_unicode(state.task.name) in known
    task = replace(state.task, overwrite=overwrite, is_known=is_known)
    # workers have a context of their own
    task = replace(task, language=language())
    return replace(state, task=task)


def _require_folder(output):
    """A plan that the run could not carry out would be worth nothing."""
    if output.exists() and not output.is_dir():
        raise FileError(
            "is no folder",
            expected="a folder for the results",
            remedy="Choose another folder: a file has this name",
            file=output,
        )


def _marks_of_an_interrupted_run(output):
    marks = (read_own_json(output / MARKS) or {}).get("blocks")
    return marks if isinstance(marks, dict) else None


def _why_again(why, failure):
    """Why a block is computed; what its last run failed for is what to mend."""
    if not failure:
        return why
    reason = failure.get("reason")
    return f"{why}; {FAILED_BEFORE}: {reason}" if reason else f"{why}; {FAILED_BEFORE}"


def _row_without_place(name, error):
    """Row of a block whose result cannot be written where it would go."""
    return row_of_failure(name, error, Stage.WRITING.key)


class _Sorting:
    """Parts blocks that must be computed from those whose row is known."""

    def __init__(self, which, marks, inputs, twins):
        self.which = which
        self.twins = twins  # what is wrong with blocks that differ in case only
        self.inputs = inputs
        self.marks = marks
        self.to_run = []
        self.reasons = {}
        self.rows = {}
        self.new_marks = {}

    def take(self, state):
        name = state.task.name
        row = self._row_of_twin(name)
        if row is None and self.which != "all":
            row = self._known_row(state)
        if row is None:
            row = self._refused_row(state.task)
        if row is None:
            self.to_run.append(state.task)
            why = state.why or "asked for"
            self.reasons[name] = _why_again(why, state.failure)
            self.new_marks[name] = self.marks.get(name, state.task.former)
            return
        self.rows[name] = row
        if name in self.marks and row["outcome"] != SKIPPED:
            self.new_marks[name] = self.marks[name]

    def _row_of_twin(self, name):
        twin = self.twins.get(name)
        return twin and _row_without_place(name, twin)

    def _refused_row(self, task):
        """Row of a block whose result has no place: nobody computes it in vain."""
        try:
            require_free(task.folder, output_of_task(task, self.inputs))
        except FileError as error:
            return _row_without_place(task.name, error)
        return None

    def _known_row(self, state):
        name = state.task.name
        is_marked = name in self.marks
        is_unfinished = self.which == "unfinished" and is_marked
        if not state.why:
            if is_marked and state.task.former != self.marks[name]:
                return row_of_result(state.task, DONE, state.provenance)
            if not is_unfinished:
                return row_of_result(state.task, SKIPPED, state.provenance)
        if self.which == "failed" and not state.has_failed:
            return {"block": name, "outcome": SKIPPED, "reason": NOT_ASKED}
        if is_unfinished and state.failure and state.failure.get("is_final") is True:
            said = {key: state.failure[key] for key in SAID}
            return {"block": name, "outcome": FAILED, **said}
        return None


def run_batch(plan, engine, *, progress=None):
    """Compute the blocks of a plan, and write the table of all: one row per block.

    ``progress`` is called after each block with a :class:`BatchNews`. Where the output
    cannot be written or the engine is gone, blocks that are done stay.
    """
    marks = {"schema": 1, "program": "einschalt", "blocks": plan.marks}
    write_text(plan.output / MARKS, sealed_text(marks))
    rows = dict(plan.rows)
    try:
        for row in _computed(plan, engine, progress or _silent):
            rows[row["block"]] = row
    except BaseException:  # an interruption as well: what is done is said
        with suppress(OutputError):  # the interruption is what must be said
            write_tables(_table(plan, rows), plan.output, plan.place)
        raise
    table = _table(plan, rows)
    write_tables(table, plan.output, plan.place)
    with said_as_file_error(plan.output / MARKS):
        (plan.output / MARKS).unlink()
    return table


@contextmanager
def batch_folder(output):
    """Make the folder of a batch, and keep other batches out of it."""
    refuse_block_folder(output)
    folder = make_folder(output)
    with locked(folder):
        yield folder


@dataclass(frozen=True)
class BatchNews:
    """What a batch tells after each block."""

    row: dict  # of the table of blocks
    n_done: int
    n_all: int  # blocks to be computed
    seconds_left: float | None  # by the sizes of what is done and what is left


def _silent(_news):
    """Report no progress."""


def _computed(plan, engine, progress: Callable):
    tasks = plan.to_run
    started = perf_counter()
    expected = Expectation(total=sum(task.size for task in tasks))
    answers = engine.answers(run_block, tasks) if tasks else ()
    for n_done, answer in enumerate(answers, 1):
        task, row = tasks[answer.place], answer.value
        if answer.error is not None:
            row = _row_of_engine(task, answer.error)
        expected.done += task.size
        left = expected.seconds_left(perf_counter() - started)
        progress(BatchNews(row, n_done, len(tasks), left))
        yield row


def _row_of_engine(task, error):
    """Row of a block whose process ended without an answer, or found no memory."""
    if isinstance(error, SettingsError):
        raise error
    row = row_of_failure(task.name, error, "computation")
    keep_failure(task, row, error)
    return row


def _table(plan, rows):
    return blocks_table(rows[name] for name in plan.names if name in rows)
