"""What the operating system refuses, in the words of messages."""

from einschalt.foundations.language import mark

USUAL = (
    mark("address already in use"),
    mark("bad file descriptor"),
    mark("broken pipe"),
    mark("cannot allocate memory"),
    mark("connection refused"),
    mark("database or disk is full"),
    mark("device or resource busy"),
    mark("disk quota exceeded"),
    mark("file exists"),
    mark("file name too long"),
    mark("file too large"),
    mark("input/output error"),
    mark("invalid argument"),
    mark("is a directory"),
    mark("no locks available"),
    mark("no space left on device"),
    mark("no such file or directory"),
    mark("not a directory"),
    mark("operation not permitted"),
    mark("permission denied"),
    mark("read-only file system"),
    mark("resource temporarily unavailable"),
    mark("stale file handle"),
    mark("text file busy"),
    mark("too many levels of symbolic links"),
    mark("too many open files"),
)
"""Reasons that usual systems give, for the catalogue."""


def reason_of(error: OSError) -> str:
    """Why the system refused, as it stands in a sentence.

    >>> reason_of(OSError(28, "No space left on device"))
    'no space left on device'
    """
    return (error.strerror or str(error)).rstrip(".").lower()
