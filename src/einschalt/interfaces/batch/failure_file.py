"""failure.json: why a block of a batch failed, in its result folder."""

import traceback
from contextlib import suppress

from einschalt.foundations.errors import (
    BlockError,
    ChangedFileError,
    EinschaltError,
    FileError,
    facts_of,
)
from einschalt.interfaces.batch.block_task import output_of_task
from einschalt.interfaces.files.atomic import make_folder, write_text
from einschalt.interfaces.files.output_folder import require_free
from einschalt.interfaces.files.written_files import FAILURE, sealed_text
from einschalt.pipeline.batch.local_engine import ProcessEndedError
from einschalt.pipeline.progress import Stage

PASSING = (ProcessEndedError, ChangedFileError)
NOTE = (
    "The block failed. Other files in this folder, if there are any, are of an earlier "
    "run."
)
NOTE_OF_WRITING = (
    "The block failed while its result was written. Other files in this folder may be "
    "of this run or of an earlier one."
)


def keep_failure(task, row, error):
    """Write failure.json, where that is possible."""
    content = {
        "schema": 1,
        "program": "einschalt",
        "note": NOTE_OF_WRITING if row["stage"] == Stage.WRITING.key else NOTE,
        "stage": row["stage"],
        "reason": row["reason"],
        "remedy": row["remedy"],
        "problems": _problems(error),
        "facts": facts_of(error),
        "is_final": _is_final(error, row["stage"]) and task.is_of_present_input(),
        "signature": task.signature,
    }
    if not isinstance(error, (EinschaltError, MemoryError)):  # to be reported
        content["traceback"] = traceback.format_exception(error)
    # on a full disk, or in a folder of somebody else, the row of the table says it all
    with suppress(FileError):
        output = output_of_task(task)
        require_free(task.folder, output)
        content["origin"] = output.source.origin(task.folder)
        write_text(make_folder(task.folder) / FAILURE, sealed_text(content))


def _problems(error):
    if isinstance(error, BlockError):
        return [str(problem) for problem in error.problems]
    return [str(error)]


def _is_final(error, stage):
    """Whether the same input would fail again on any computer."""
    if not isinstance(error, EinschaltError) or stage == Stage.WRITING.key:
        return False
    errors = error.problems if isinstance(error, BlockError) else [error]
    return not any(isinstance(one, PASSING) for one in errors)
