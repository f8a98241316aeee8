"""Where compiled code is kept: without a place for it numba refuses to compile.

It keeps it beside the source, or below the user's own folder for caches. A service may
be allowed to write neither: it gets a folder for as long as it runs, which the
processes that it starts share.
"""

import os
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
CACHE = "NUMBA_CACHE_DIR"
PREFIX = "einschalt-"
NO_CACHE = (
    "no folder for compiled code can be written, so every run compiles anew, which "
    "takes about 20 s. Set NUMBA_CACHE_DIR to a folder of your own."
)


def provide_cache():
    """Give numba a folder of this process, where it would find no other."""
    if os.environ.get(CACHE) or any(_can_hold(path) for path in _usual()):
        return
    # imported where they are needed: every command would wait for them
    import atexit  # noqa: PLC0415
    import shutil  # noqa: PLC0415
    import tempfile  # noqa: PLC0415

    try:
        # nobody else can write into it: what lies in it is run
        folder = tempfile.mkdtemp(prefix=PREFIX)
    except OSError:  # nowhere at all: numba says so
        return
    os.environ[CACHE] = folder
    atexit.register(shutil.rmtree, folder, ignore_errors=True)


def is_cache_temporary() -> bool:
    """Whether what is compiled is lost when this process ends, or that of its start."""
    return Path(os.environ.get(CACHE, "")).name.startswith(PREFIX)


def _usual():
    """Where numba looks."""
    yield PACKAGE
    if os.name == "nt":
        yield Path(os.environ.get("LOCALAPPDATA", ""), "numba")
    else:
        home = Path(os.path.expanduser("~"))  # noqa: PTH111 - raises nothing
        yield Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache", "numba")
        yield home / "Library" / "Caches" / "numba"


def _can_hold(folder):
    """Whether the folder is there and can be written, or can be made."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return os.access(folder, os.W_OK | os.X_OK)
