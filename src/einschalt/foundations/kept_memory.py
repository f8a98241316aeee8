"""Memory that arrays have given back, kept for those that come next.

The C library of Linux asks the system for each array of more than 32 MB anew, and gives
it back with the array: each page of it is fetched and filled with zeros, which takes as
long as what is then computed in it. With what is kept a block of 71 100 models of the
low flight takes 20 % less time and 5 % more memory (a million models adjusted at once:
12 % more), so that blocks which leave no room for that do without.
"""

import os

from einschalt.foundations.limited_memory import is_memory_limited

# of mallopt, <malloc.h>
M_TRIM_THRESHOLD, M_MMAP_MAX = -1, -4
LARGEST_INT = 2**31 - 1
# what users say of it themselves
OWN_WORDS = ("GLIBC_TUNABLES", "MALLOC_MMAP_MAX_", "MALLOC_TRIM_THRESHOLD_")


def keep_freed_memory():
    """Let this process keep what it gives back: one that computes, and ends.

    Nothing happens with another C library, where memory is limited, and where the
    environment says how memory is managed.

    Returns
    -------
    bool
        Whether it is kept.
    """
    if is_memory_limited() or any(name in os.environ for name in OWN_WORDS):
        return False
    import ctypes  # noqa: PLC0415 - for the help of commands it is not needed

    mallopt = getattr(ctypes.pythonapi, "mallopt", None)
    if mallopt is None:
        return False
    is_set = (mallopt(M_MMAP_MAX, 0), mallopt(M_TRIM_THRESHOLD, LARGEST_INT))
    return all(is_set)
