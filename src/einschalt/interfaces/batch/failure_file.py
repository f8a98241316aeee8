"""failure.json: why a block of a batch failed, in its result folder."""

import json
import traceback
from contextlib import suppress

from einschalt.foundations.errors import BlockError, EinschaltError, FileError
from einschalt.interfaces.batch.block_state import FAILURE
from einschalt.interfaces.files.atomic import make_folder, write_text
from einschalt.pipeline.batch import WRITING
from einschalt.pipeline.engine import ProcessEndedError

NOTE = (
    "The block failed. Other files in this folder, if there are any, are of an earlier "
    "run."
)


def keep_failure(folder, row, error, signature):
    """Write failure.json, where that is possible.

    Parameters
    ----------
    folder : Path
        Of the block's result.
    row : dict
        Of the table of blocks.
    error : Exception
    signature : dict
        Version, settings and checksums of the inputs.
    """
    content = {
        "schema": 1,
        "program": "einschalt",
        "note": NOTE,
        "stage": row["stage"],
        "reason": row["reason"],
        "remedy": row["remedy"],
        "problems": _problems(error),
        "is_final": _is_final(error, row["stage"]),
        "signature": signature,
    }
    if not isinstance(error, EinschaltError):  # to be reported
        content["traceback"] = traceback.format_exception(error)
    # on a full disk the row of the table says it all
    with suppress(FileError):
        text = json.dumps(content, indent=2, ensure_ascii=False)
        write_text(make_folder(folder) / FAILURE, f"{text}\n")


def _problems(error):
    if isinstance(error, BlockError):
        return [str(problem) for problem in error.problems]
    return [str(error)]


def _is_final(error, stage):
    """Whether the same input would fail again on any computer."""
    is_of_computer = stage == WRITING or isinstance(error, ProcessEndedError)
    return isinstance(error, EinschaltError) and not is_of_computer


__all__ = ["FAILURE", "keep_failure"]
