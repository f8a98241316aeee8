"""BLAS on one thread: with matrices as small as ours its other threads only wait.

They wait busily, for as long as the computation: on two cores that was a fifth of what
`densify` takes of the CPU, and half of it beside other work. Blocks of 10⁴ models are
computed as fast, since what is large in them is sparse, and compiled here.
"""

from threadpoolctl import ThreadpoolController

_controller = None


def one_blas_thread():
    """Context in which BLAS has one thread; as many as before afterwards."""
    global _controller  # noqa: PLW0603 - looking for the libraries takes 10 ms
    if _controller is None:
        _controller = ThreadpoolController()
    return _controller.limit(limits=1, user_api="blas")
