"""The process of a run that waits at its second stage until it is ended.

Whoever ends a computation in the midst of it must not be in a hurry: a block may be
done before the order comes.
"""

import time

from einschalt.interfaces import python_api
from einschalt.interfaces.local_page import run_process
from einschalt.pipeline.progress import Stage


def _wait(_block, _settings, *, progress):
    progress(Stage.MODEL_TRANSFORMATION, Stage.MODEL_TRANSFORMATION.fraction)
    # in naps: a signal that comes just before one does not end it, but the next
    for _ in range(6000):
        time.sleep(0.1)


if __name__ == "__main__":
    python_api.densify = _wait
    run_process.main()
