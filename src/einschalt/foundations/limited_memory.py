"""Limits of memory that this process was given, and what libraries make of them.

A limit of the address space (``ulimit -v``) counts what libraries reserve, four times
what they use. Where one of them finds nothing left it raises no error: Arrow and LLVM
end the process, and OpenBLAS waits for ever.
"""

import mmap
import os
import platform

from einschalt.foundations.errors import GeometryError

# measured with two cores: of what is less, one library or another ends the process
ADDRESSES_OF_LIBRARIES = 1.5e9
# more than any processor has kernels for that need no room: 100 with AVX-512
NOT_SMALL = 256


def memory_limits() -> dict:
    """Limits of this process in bytes, ``"addresses"`` and ``"data"``; inf if none."""
    if platform.system() == "Windows":
        return {"addresses": float("inf"), "data": float("inf")}
    import resource  # noqa: PLC0415 - Windows has no such module

    kinds = {"addresses": resource.RLIMIT_AS, "data": resource.RLIMIT_DATA}
    limits = {name: resource.getrlimit(kind)[0] for name, kind in kinds.items()}
    is_none = resource.RLIM_INFINITY
    return {n: float("inf" if v == is_none else v) for n, v in limits.items()}


def is_memory_limited() -> bool:
    """Whether this process has a limit of its own."""
    return min(memory_limits().values()) < float("inf")


def prepare_for_limits():
    """Refuse a limit below which libraries end the process; call it before they load.

    Raises
    ------
    GeometryError
        If the address space is smaller than what libraries reserve.
    """
    there = memory_limits()["addresses"]
    if there < ADDRESSES_OF_LIBRARIES:
        raise GeometryError(
            f"the address space of this process is limited to {there / 1e9:.3g} GB",
            expected=f"at least {gigabytes(ADDRESSES_OF_LIBRARIES)}, which libraries "
            "reserve before the first point",
            remedy="Raise the limit (ulimit -v), or limit the memory that is used, "
            "such as by a container",
        )
    if is_memory_limited():
        # each thread reserves room of its own
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def is_there_room_for(n_bytes) -> bool:
    """Whether this process may take so much memory at once; nothing is used."""
    if not is_memory_limited():
        return True
    try:
        with mmap.mmap(-1, int(n_bytes)):
            return True
    except (OSError, OverflowError, ValueError):
        return False


def take_room_for_linear_algebra():
    """Let BLAS allocate what it works with while there is memory.

    OpenBLAS, of which NumPy and SciPy have one each, ends the process or waits for ever
    where it finds none later. It allocates once for each thread that calls it: one that
    has a limit calls it from one thread only.

    Notes
    -----
    A Cholesky factorisation allocates on every processor. A product does not where the
    processor has kernels for small ones, which is up to 100 x 100 x 100 with AVX-512
    and less elsewhere (permit functions of the small-matrix kernels, OpenBLAS 0.3.31).
    """
    import numpy as np  # noqa: PLC0415 - after the limits were looked at
    from scipy.linalg import blas, lapack  # noqa: PLC0415

    matrix = np.eye(NOT_SMALL)
    np.linalg.cholesky(matrix)
    matrix @ matrix
    lapack.dpotrf(matrix)
    blas.dgemm(1.0, matrix, matrix)


def gigabytes(n_bytes) -> str:
    """Say a size of memory."""
    size = n_bytes / 1e9
    return f"{size:.2g} GB" if size < 10.0 else f"{size:.0f} GB"
