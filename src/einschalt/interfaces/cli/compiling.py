"""What is said while kernels are compiled, once after installation: half a minute."""

import sys
import time
from contextlib import contextmanager

from einschalt.foundations.kernels import compilations_told_to

PAUSE, PAUSE_IN_A_LOG = 2.0, 5.0  # seconds between two of these texts
ENOUGH = 3  # kernels after which the time of the others can be guessed
# that a block of the kind makes use of, as counted for the example blocks
IN_THE_PLANE, FROM_IMAGES = 25, 34
OF_LAYOUTS = 12  # as counted for plans, with an area or without


def usual_kernels(block) -> int:
    """About how many kernels a block of this kind makes use of."""
    if any(flight.is_oriented_numerically for flight in block.flights.values()):
        return FROM_IMAGES
    return IN_THE_PLANE


@contextmanager
def compilations_shown(show):
    """Give what shows a title and a fraction; what is compiled is shown meanwhile."""
    progress = _Progress(show)
    with compilations_told_to(progress.tell):
        yield progress


class _Progress:
    """Shows stages as they are reported, and compilations at the last one's place."""

    def __init__(self, show):
        self.show = show
        self.n_usual = IN_THE_PLANE
        self.fraction = 0.0
        self.last = None

    def __call__(self, title, fraction):
        self.fraction = fraction
        self.show(title, fraction)

    def tell(self, news):
        now = time.monotonic()
        pause = PAUSE if sys.stderr.isatty() else PAUSE_IN_A_LOG
        if self.last is None or now - self.last >= pause:
            self.last = now
            self.show(compiling_text(news, self.n_usual), self.fraction)


def compiling_text(news, n_usual) -> str:
    """Write which kernel is compiled, of how many, and how long that will still take.

    >>> from einschalt.foundations.kernels import Compilation
    >>> compiling_text(Compilation("_fit", 12, 10, 9.0), 40)
    'compiling 12 of about 40 kernels, once after installation, 26 s left'
    """
    if news.n_kernels > n_usual:  # a way of more kernels than usual
        return f"compiling kernel {news.n_kernels}, once after installation"
    if news.n_compiled < ENOUGH:
        return (
            f"compiling {news.n_kernels} of about {n_usual} kernels, once after "
            "installation"
        )
    seconds = news.seconds / news.n_compiled * (n_usual - news.n_kernels + 1)
    return (
        f"compiling {news.n_kernels} of about {n_usual} kernels, once after "
        f"installation, {seconds:.0f} s left"
    )
