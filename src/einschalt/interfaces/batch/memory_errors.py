"""Lack of memory, however a library says it."""

import errno

from einschalt.foundations.errors import EinschaltError

SAID = (
    "cannot allocate memory",
    "cannot map zero-fill pages",
    "failed to map segment",
    "can't start new thread",
    "failed to launch worker thread",
    "out of memory",
    "bad_alloc",
)


def lack_of_memory(error, stage) -> MemoryError | None:
    """Tell a lack of memory from other faults; its ``stage`` goes along with it."""
    cause, seen = error, []
    while cause is not None and not any(cause is one for one in seen):
        seen.append(cause)
        if _says_it(cause):
            shortage = MemoryError(str(cause))
            shortage.stage = stage
            return shortage
        cause = cause.__cause__ or cause.__context__
    return None


def _says_it(error):
    if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
        return True
    # our own messages quote names of the user, who may call a block what he likes
    said = "" if isinstance(error, EinschaltError) else str(error).casefold()
    return any(text in said for text in SAID)
