"""Interruptions: what another process or a shell ends like the keyboard, and when.

Python hears of signals in its main thread alone, and turns only that of the keyboard
into an exception: others would end it at once, with staged files and locks left behind.
"""

import signal
import threading
from contextlib import contextmanager

# a supervisor, ``timeout``, the end of a session; Windows has no SIGHUP
ENDING = [
    getattr(signal, n) for n in ("SIGTERM", "SIGHUP", "SIGXCPU") if hasattr(signal, n)
]


class Terminated(KeyboardInterrupt):
    """A signal asks the process to end: its number, as ``number``."""

    def __init__(self, number):
        super().__init__(signal.Signals(number).name)
        self.number = number


def _end(number, _frame):
    raise Terminated(number)


@contextmanager
def ended_in_order():
    """Let signals that end a process raise :class:`Terminated` instead.

    One that is ignored, as under ``nohup``, stays so.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    usual = [one for one in ENDING if signal.getsignal(one) is signal.SIG_DFL]
    for one in usual:
        signal.signal(one, _end)
    try:
        yield
    finally:
        for one in usual:
            signal.signal(one, signal.SIG_DFL)


@contextmanager
def uninterrupted():
    """Let interruptions wait until this is done; the first of them is then heard."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    waiting = []
    heard = [one for one in (signal.SIGINT, *ENDING) if callable(signal.getsignal(one))]
    former = {
        one: signal.signal(one, lambda *said: waiting.append(said)) for one in heard
    }
    try:
        yield
    finally:
        for one, handler in former.items():
            signal.signal(one, handler)
    if waiting:
        former[waiting[0][0]](*waiting[0])
