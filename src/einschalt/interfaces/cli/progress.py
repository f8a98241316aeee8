"""Progress of a computation on standard error: a bar on a terminal, lines elsewhere."""

import math
import sys
import time
from contextlib import contextmanager
from datetime import datetime, timedelta
from threading import Timer

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import (
    figure,
    language,
    mark,
    translated,
    written_in,
)
from einschalt.interfaces.cli.exits import print_error
from einschalt.pipeline.progress import Stage, share_of_work

PATIENCE = 1.0  # seconds without a word
LINES_OF_A_STAGE = 10
"""Where lines are written instead of a bar, as into the log of a batch."""
OUTCOMES = {
    "done": mark("{block} done"),
    "skipped": mark("{block} skipped"),
    "failed": mark("{block} failed: {reason}"),
}


@contextmanager
def stage_progress(*, is_quiet):
    """Give what shows the title of a stage and the fraction that is done.

    In the language of its user: the computation that reports knows English alone. Into
    a pipe go few lines, and none before a second has passed.
    """
    spoken = language()
    with _shown(_few_lines(), is_quiet=is_quiet) as show:

        def shown(title, fraction):
            with written_in(spoken):
                show(retold(str(title)), fraction)

        yield shown


def of_whole_work(show):
    """Give what shows the stages of a computation as parts of the whole work.

    That is done when its results are written: whoever writes them shows it.
    """

    def shown(title, fraction):
        if title != Stage.DONE:
            show(title, share_of_work(title, fraction))

    return shown


@contextmanager
def late_steps():
    """Give what shows a title and a fraction once a second has passed.

    A step that takes longer than that is shown in its midst.
    """
    begin, last = time.monotonic(), []
    with stage_progress(is_quiet=False) as show:

        def late(title, fraction):
            last[:] = [(title, fraction)]
            if time.monotonic() - begin > PATIENCE:
                show(title, fraction)

        def show_last():
            for step in tuple(last):
                show(*step)

        waiting = Timer(PATIENCE, show_last)
        waiting.daemon = True
        waiting.start()
        try:
            yield late
        finally:
            waiting.cancel()
            waiting.join()  # it may be showing the step just now


@contextmanager
def late_progress():
    """Give the same; what is compiled is shown meanwhile."""
    # imported when something is computed that takes numba along anyway
    from einschalt.interfaces.cli import compiling  # noqa: PLC0415

    with late_steps() as late, compiling.compilations_shown(late) as progress:
        progress.n_usual = compiling.OF_LAYOUTS
        yield progress


@contextmanager
def _shown(line, *, is_quiet):
    """Give what shows a text and a fraction: nothing, a bar, or a line for each."""
    if is_quiet:
        yield _silent
    elif sys.stderr.isatty():
        with _bar() as advance:
            yield advance
    else:
        yield line


def _silent(_title, _fraction):
    """Show nothing."""


def _few_lines():
    """Give what writes a line where a stage begins, and where a part of it is done."""
    begin, last = time.monotonic(), None

    def line(title, fraction):
        nonlocal last
        # rounded: fractions that are sums do not hit the tenth
        reached = title, math.floor(fraction * LINES_OF_A_STAGE + 1e-9)
        if reached == last or time.monotonic() - begin < PATIENCE:
            return
        last = reached
        print_error(f"{figure(fraction, '4.0%')}  {title}")

    return line


@contextmanager
def _bar():
    # imported when the bar is drawn, for a quick start
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, Progress, TextColumn  # noqa: PLC0415

    columns = (TextColumn("{task.description}", markup=False), BarColumn(40))
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=1.0)

        def advance(title, fraction):
            progress.update(task, description=f"{title:<24}", completed=fraction)

        yield advance


@contextmanager
def batch_progress(*, is_quiet):
    """Give what shows the blocks of a batch as they finish, and when it will end."""
    with _shown(_text, is_quiet=is_quiet) as show:
        yield lambda news: show(batch_line(news), news.n_done / news.n_all)


def _text(text, _fraction):
    print_error(text)


def batch_line(news, now=None):
    """Write what became of a block, and when all will have been computed."""
    row = news.row
    facts = {"block": row["block"], "reason": retold(row.get("reason") or "")}
    outcome = printable(translated(OUTCOMES[row["outcome"]], **facts))
    line = f"{news.n_done}/{news.n_all}  {outcome}"
    if news.seconds_left is None or news.n_done == news.n_all:
        return line
    now = now or datetime.now().astimezone()
    try:
        end = now + timedelta(seconds=news.seconds_left)
    except OverflowError:  # a block of some bytes before one of terabytes
        return line
    is_today = end.date() == now.date()
    until = f"{end:%H:%M:%S}" if is_today else f"{end:%Y-%m-%d %H:%M}"
    return translated("{line}  (ETA {time})", line=line, time=until)
