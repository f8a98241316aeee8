"""Progress of a computation on standard error: a bar on a terminal, lines elsewhere."""

import sys
from contextlib import contextmanager
from datetime import datetime, timedelta

from einschalt.interfaces.cli.exits import complain


@contextmanager
def stage_progress(*, is_quiet):
    """Show the stages of a computation while they run.

    Parameters
    ----------
    is_quiet : bool
        Show nothing.

    Yields
    ------
    callable
        To be called with the title of a stage and the fraction that is done.
    """
    if is_quiet:
        yield _silent
    elif sys.stderr.isatty():
        with _bar() as advance:
            yield advance
    else:
        yield _line


def _silent(_title, _fraction):
    """Show nothing."""


def _line(title, fraction):
    complain(f"{fraction:4.0%}  {title}")


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
    """Show the blocks of a batch as they are finished, and when it will end.

    Parameters
    ----------
    is_quiet : bool
        Show nothing.

    Yields
    ------
    callable
        To be called with the news after each block.
    """
    if is_quiet:
        yield _no_news
    elif sys.stderr.isatty():
        with _bar() as advance:
            yield lambda news: advance(_batch_line(news), news.n_done / news.n_all)
    else:
        yield lambda news: complain(_batch_line(news))


def _no_news(_news):
    """Show nothing."""


def _batch_line(news):
    row = news.row
    reason = f": {row['reason']}" if row["outcome"] == "failed" else ""
    line = f"{news.n_done}/{news.n_all}  {row['block']} {row['outcome']}{reason}"
    if news.seconds_left is None or news.n_done == news.n_all:
        return line
    # on the clock of the one who waits
    end = datetime.now().astimezone() + timedelta(seconds=news.seconds_left)
    return f"{line}  (until about {end:%H:%M:%S})"
