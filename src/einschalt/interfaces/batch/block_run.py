"""One block of a batch, from its folder to its result: what a worker does.

Whatever happens, the answer is a row. Beside the files of a result the folder then
holds ``previous_points.parquet`` and ``changes.csv`` where there was a result before,
or ``failure.json``.
"""

import threading
from importlib import metadata
from time import perf_counter

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import written_in
from einschalt.interfaces.batch.block_state import result_since
from einschalt.interfaces.batch.block_task import output_of_task
from einschalt.interfaces.batch.changes_file import (
    compare_with_previous,
    read_changes,
    read_largest_move,
    system_before,
)
from einschalt.interfaces.batch.failure_file import keep_failure
from einschalt.interfaces.batch.memory_errors import lack_of_memory
from einschalt.interfaces.files.atomic import make_folder, said_as_file_error
from einschalt.interfaces.files.folder_lock import locked
from einschalt.interfaces.files.output_folder import require_free
from einschalt.interfaces.files.plain_json import read_own_json
from einschalt.interfaces.files.result_folder import write_result
from einschalt.interfaces.files.written_files import FAILURE, PROVENANCE, evidence_of
from einschalt.interfaces.programs.block_tables import read_block
from einschalt.interfaces.provenance import libraries
from einschalt.pipeline.batch.block_table import DONE, row_of_failure, row_of_figures
from einschalt.pipeline.densify import densify
from einschalt.pipeline.progress import Stage

# a worker of a cluster may have several threads; figures are drawn by one at a time
ONE_AT_A_TIME = threading.Lock()
NOT_COMPARED = "not compared with the run before: that was in {}, this one is in {}"


def run_block(task) -> dict:
    """Compute a block, write its result, and give its row of the table of blocks.

    Only a MemoryError is raised. Whoever runs it decides where it is tried again; what
    is left of this process is not worth much.
    """
    started = perf_counter()
    progress = _Progress()
    try:
        with ONE_AT_A_TIME:
            return _run(task, progress)
    except Exception as error:  # one block must not stop the others
        shortage = lack_of_memory(error, progress.stage.key)
        if shortage is not None:
            raise shortage from error
        seconds = perf_counter() - started
        row = row_of_failure(task.name, error, progress.stage.key, seconds)
        keep_failure(task, row, error)
        return row


def row_of_result(task, outcome, provenance) -> dict:
    """Row of a block whose result is whole: done or skipped."""
    facts = provenance["figures"], provenance["seconds"]
    compared = ()
    if outcome == DONE:
        compared = read_changes(task.folder), read_largest_move(task.folder)
    return row_of_figures(task.name, outcome, *facts, *compared)


class _Progress:
    """Knows the stage that runs."""

    def __init__(self):
        self.stage = Stage.WRITING

    def __call__(self, stage, _fraction=0.0):
        self.stage = stage


def _run(task, progress):
    _require_versions(task.signature)
    require_free(task.folder, output_of_task(task))
    with locked(make_folder(task.folder), waits=True):
        why = _compute(task, progress) if result_since(task) is None else ""
        if evidence_of(task.folder).vouches_for(FAILURE):
            with said_as_file_error(task.folder / FAILURE):
                (task.folder / FAILURE).unlink()
        # read while nobody else may write it
        row = row_of_result(task, DONE, read_own_json(task.folder / PROVENANCE))
        return {**row, "reason": why}


def _compute(task, progress):
    """Compute and write; why nothing was compared, where systems differ."""
    progress(Stage.READING)
    block = read_block(task.block, task.given)
    # the table of a batch tells nothing of the method that was not asked for
    options = {"progress": progress, "compares_methods": False}
    result = densify(block, block.settings, **options)
    progress(Stage.ASSESSMENT)
    result.assessment  # noqa: B018
    progress(Stage.WRITING)
    before = system_before(task.folder)
    is_other = before not in (None, (result.crs,))  # that would be no movement

    def compare(new):
        if not is_other:
            compare_with_previous(result.points, task.folder, new)

    with written_in(task.language):
        write_result(
            result,
            task.folder,
            overwrite=task.overwrite,
            is_known=task.is_known,
            beside=True,
            write_more=compare,
        )
    if not is_other:
        return ""
    systems = (shortened(str(one or "no system")) for one in (*before, result.crs))
    return NOT_COMPARED.format(*systems)


def _require_versions(signature):
    """Refuse to compute what the batch would not take for its result."""
    own = {"einschalt": metadata.version("einschalt"), **libraries()}
    expected = {"einschalt": signature["version"], **signature["versions"]}
    for name, version in expected.items():
        if own.get(name) != version:
            raise SettingsError(
                f"the worker has {name}, version {own.get(name)}",
                expected=f"version {version}, as the batch has",
                remedy="Install the same versions everywhere",
            )
