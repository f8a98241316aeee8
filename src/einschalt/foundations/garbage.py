"""Garbage in circles: Python need not look for it among what stays.

It looks each time that some hundred new objects are there, and now and then among all
that there are: the modules of this program and of its libraries, a million objects.
"""

import gc
from contextlib import contextmanager

# new objects less those that are gone; Python would look 70 times as often, for nothing
RUBBISH_WORTH_A_LOOK = 50_000


@contextmanager
def made_for_good():
    """Look for none meanwhile, nor ever after among what is made, as modules are.

    To look took 0.4 s of densify.
    """
    gc.disable()
    try:
        yield
        gc.freeze()
        gc.set_threshold(RUBBISH_WORTH_A_LOOK)
    finally:
        gc.enable()


def clear_garbage(*, for_good=False):
    """Look for all of it; what is left may be taken for none from now on."""
    gc.collect()
    if for_good:
        gc.freeze()
