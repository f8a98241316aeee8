"""A cluster as engine: tasks run on the workers of a Dask scheduler.

``dask[distributed]`` is the optional extra ``cluster``; nothing else imports it.
"""

import gc
from functools import partial

from einschalt.foundations.arguments import require_text
from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.batch.local_engine import (
    Answer,
    EngineError,
    LocalEngine,
    ProcessEndedError,
)

SECONDS_TO_CONNECT = 30
BYTES_PER_GB = 1e9
EXPECTED = "the address of a running Dask scheduler, such as tcp://10.0.0.5:8786"


class DaskEngine:
    """Workers of a cluster, at the address of its ``scheduler``: ``tcp://host:port``.

    They import the same version of einschalt, and see the same folders under the same
    paths. What a worker does not answer is given to another one by Dask itself, three
    times. With a ``time_limit_s`` [s] or ``memory_gb`` [GB] a worker computes each task
    in a process of its own, which it ends when the time is over, and which may use that
    memory, or what the worker itself may.
    """

    def __init__(self, scheduler, *, memory_gb=None, time_limit_s=None):
        require_text("scheduler", scheduler, expected=EXPECTED)
        self.scheduler = scheduler
        given = {"memory_gb": memory_gb, "time_limit_s": time_limit_s}
        LocalEngine(1, **given)  # what is wrong with them is said here
        self.limits = {name: one for name, one in given.items() if one is not None}

    def answers(self, function, tasks):
        """Call the function with each task; yield answers as they come.

        A SettingsError where Dask is not installed, or no scheduler answers at the
        address; an EngineError where it is gone. What was computed stays.
        """
        distributed = _distributed()
        if self.limits:
            function = partial(in_own_process, function, self.limits)
        client = self._connected(distributed)
        # of a scheduler that is gone it prints tracebacks beside what is said below
        distributed.client.logger.setLevel("CRITICAL")
        try:
            futures = {
                client.submit(function, task, pure=False): place
                for place, task in enumerate(tasks)
            }
            for future in distributed.as_completed(futures, loop=client.loop):
                yield self._answer(future, futures[future], distributed)
        finally:
            client.close(timeout=2)

    def _connected(self, distributed):
        try:
            return distributed.Client(
                self.scheduler, timeout=SECONDS_TO_CONNECT, set_as_default=False
            )
        except (OSError, ValueError, TypeError):
            pass  # said below, where nothing holds what is left of the client
        # it ends here: left to itself it may end while another thread starts, and each
        # would wait for the other
        gc.collect()
        raise SettingsError(
            f"no scheduler answers at {self.scheduler!r}",
            expected=EXPECTED,
            remedy="Start it with: dask scheduler",
        )

    def _answer(self, future, place, distributed):
        if future.status == "finished":
            return Answer(place, value=future.result())
        if future.status != "error":  # cancelled or lost: nobody is there to ask
            raise EngineError(
                f"the scheduler at {self.scheduler} is gone",
                expected="a scheduler that runs until the end",
                remedy="Start it again, and run the same call: what is done stays",
            )
        error = future.exception()
        if isinstance(error, distributed.KilledWorker):
            error = ProcessEndedError(
                "the workers that computed it ended without an answer",
                expected="enough memory, and libraries that do not crash",
                remedy="Give the workers more memory, or run fewer on a computer",
            )
        return Answer(place, error=error)


def in_own_process(function, limits, task):
    """Call a function with a task in a process that has limits, see LocalEngine."""
    limits = {"memory_gb": _memory_of_worker(), **limits}
    (answer,) = LocalEngine(1, **limits).answers(function, [task])
    if answer.error is not None:
        raise answer.error
    return answer.value


def _memory_of_worker():
    """What Dask lets this worker use [GB]; it does not see a process of its own."""
    limit = _distributed().get_worker().memory_manager.memory_limit
    return None if limit is None else limit / BYTES_PER_GB


def _distributed():
    try:
        # imported where a cluster is used: it is an extra, and takes its time
        import distributed  # noqa: PLC0415
    except ImportError as error:
        raise SettingsError(
            "Dask is not installed",
            expected="the package distributed, for batches on a cluster",
            remedy="pip install '.[cluster]' in the folder of the project",
        ) from error
    return distributed
