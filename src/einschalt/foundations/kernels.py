"""Compiled kernels: numba's, kept for the sources that they were compiled from.

numba keeps a kernel for the file in which it stands, so that one that calls another
file's went stale when that file changed. Here the sources of all that a kernel calls
count, by their text, not by their time. To load a kernel takes none of what compiling
takes, and who waits for a compilation can be told (`compilations_told_to`).
"""

import gc
import time
from collections.abc import Callable
from contextlib import contextmanager
from functools import cache, wraps
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import NamedTuple

import numba
import numpy as np
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher
from numba.core.runtime import rtsys

from einschalt.foundations.kernel_parts import compiler_of_parts

PACKAGE = __name__.partition(".")[0]
NUMBERS = (bool, int, float, complex, str, tuple, np.generic, np.ndarray)


class Compilation(NamedTuple):
    """What someone who waits may want to know when a kernel is to be compiled."""

    name: str
    n_kernels: int  # that this process has loaded or begun to compile, this one too
    n_compiled: int  # that it has compiled before this one
    seconds: float  # since it began to compile the first one


class _Watch:
    """What this process has loaded and compiled, and who is told of it."""

    def __init__(self):
        self.listeners = []
        self.n_kernels = self.n_compiled = 0
        self.begin = None

    def announce(self, name):
        self.begin = time.monotonic() if self.begin is None else self.begin
        seconds = time.monotonic() - self.begin
        news = Compilation(name, self.n_kernels, self.n_compiled, seconds)
        self.n_compiled += 1
        for tell in tuple(self.listeners):  # other threads may come and go
            tell(news)


_watch = _Watch()


@contextmanager
def compilations_told_to(tell: Callable[[Compilation], None]):
    """Have ``tell`` called before each kernel that is compiled, by any thread."""
    _watch.listeners.append(tell)
    try:
        yield
    finally:
        _watch.listeners.remove(tell)


def compiled(function=None, **options):
    """Compile a function when it is first called, and keep it for later processes.

    Options are those of ``numba.njit``.
    """
    if function is None:
        return lambda function: compiled(function, **options)
    # nothing here is called through its address, so there is no wrapper for that
    defaults = {"nogil": True, "no_cfunc_wrapper": True}
    kernel = numba.njit(**(defaults | options))(function)
    kernel._cache = KernelCache(kernel)  # as njit(cache=True) sets its own
    kernel.compile = _collecting_nothing(kernel.compile)
    of_parts = {"no_cpython_wrapper": True, "pipeline_class": compiler_of_parts()}
    inner = defaults | options | of_parts
    part = cache(lambda: numba.njit(**inner)(function))
    # other kernels call it without the way in from Python, a tenth of the compiling
    kernel.get_call_template = lambda *given: part().get_call_template(*given)
    kernel.get_overload = lambda signature: part().get_overload(signature)
    return kernel


def _collecting_nothing(compile_for):
    """Let no garbage be looked for, a fifth of the time that compiling takes.

    A compilation makes millions of objects, most of which stay until it ends.
    """

    @wraps(compile_for)
    def compile_uncollected(signature):
        was_enabled = gc.isenabled()
        gc.disable()
        try:
            return compile_for(signature)
        finally:
            if was_enabled:
                gc.enable()

    return compile_uncollected


class KernelCache(FunctionCache):
    """numba's cache of one kernel, made when the kernel is first called."""

    def __init__(self, kernel):
        """Look for no folder yet: most kernels of a run are never called."""
        self._kernel = kernel
        self._py_func = kernel.py_func
        self.enable()

    def __getattr__(self, name):
        """Find the folder, and what the kernel was compiled from."""
        if name not in {"_name", "_impl", "_cache_path", "_cache_file"}:
            raise AttributeError(name)
        super().__init__(self._py_func)
        self._cache_file._source_stamp = source_stamp(self._kernel)
        return getattr(self, name)

    def load_overload(self, sig, target_context):
        """Give the kernel for these types, or None where it has to be compiled.

        numba would get everything ready for compiling first, 0.15 s of each process; it
        does so anyway before it compiles.
        """
        rtsys.initialize(target_context)
        _watch.n_kernels += 1
        with self._guard_against_spurious_io_errors():
            found = self._load_overload(sig, target_context)
            if found is not None:
                return found
        _watch.announce(self._py_func.__name__)
        return None


def source_stamp(kernel) -> str:
    """Digest of the files, numbers and options that make a kernel what it is.

    Those are its own file, those of all functions of the package that it calls, by
    whatever way, and the numbers and options that these take from their modules.
    """
    files, others = {}, set()
    waiting, seen = [kernel], set()
    while waiting:
        one = waiting.pop()
        if one in seen:
            continue
        seen.add(one)
        if isinstance(one, Dispatcher):
            others.add(f"{one.__name__} {_option_text(one.targetoptions)}")
        function = getattr(one, "py_func", one)
        files[function.__module__] = _digest(function.__code__.co_filename)
        for name, value in _used(function):
            if isinstance(value, Dispatcher | FunctionType) and _is_ours(value):
                waiting.append(value)
            elif isinstance(value, ModuleType) and _is_ours(value):
                files[value.__name__] = _digest(value.__file__)
            elif isinstance(value, NUMBERS):
                others.add(f"{name}={value!r}")
    parts = [*sorted(files.items()), *sorted(others)]
    return sha256(repr(parts).encode()).hexdigest()


def _is_ours(value):
    name = value.__name__ if isinstance(value, ModuleType) else value.__module__
    return name.partition(".")[0] == PACKAGE


def _option_text(options):
    return sorted(
        (k, sorted(v) if isinstance(v, set) else v) for k, v in options.items()
    )


@cache
def _digest(file):
    return sha256(Path(file).read_bytes()).hexdigest()


def _used(function):
    """Names that a function takes from its module or an outer function, with values."""
    code = function.__code__
    for name in sorted(_names(code)):
        if name in function.__globals__:
            yield name, function.__globals__[name]
    cells = function.__closure__ or ()
    for name, cell in zip(code.co_freevars, cells, strict=True):
        yield name, cell.cell_contents


def _names(code):
    inner = (one for one in code.co_consts if isinstance(one, CodeType))
    return set(code.co_names).union(*map(_names, inner))


@compiled
def copy_values(target, source):
    """Do ``target[:] = source`` for vectors of one length, in a kernel.

    To compile numba's own takes 2.5 s, of which most is the text of an error.
    """
    for k in range(target.size):
        target[k] = source[k]


@compiled
def place_of_least(values):
    """``np.argmin`` of a vector, in a kernel: the first NaN, if there is any."""
    least = 0
    for k in range(values.size):
        if np.isnan(values[k]):
            return k
        if values[k] < values[least]:
            least = k
    return least
