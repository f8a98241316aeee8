"""BLAS on one thread: with matrices as small as ours its other threads only wait.

They wait busily, for as long as the computation: on two cores that was a fifth of what
`densify` takes of the CPU, and half of it beside other work. Blocks of 10⁴ models are
computed as fast, since what is large in them is sparse, and compiled here.
"""

from contextlib import contextmanager
from contextvars import ContextVar

from threadpoolctl import ThreadpoolController

_controller = None
# a factor is solved with a thousand times, each time with one thread: to ask BLAS for
# what it has already takes a twentieth of a pass of a small block
_has_one = ContextVar("has_one_blas_thread", default=False)


@contextmanager
def one_blas_thread():
    """Context in which BLAS has one thread; as many as before afterwards."""
    global _controller  # noqa: PLW0603 - looking for the libraries takes 10 ms
    if _has_one.get():
        yield
        return
    if _controller is None:
        _controller = ThreadpoolController()
    before = _has_one.set(True)
    try:
        with _controller.limit(limits=1, user_api="blas"):
            yield
    finally:
        _has_one.reset(before)
