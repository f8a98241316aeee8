"""Progress of a computation on standard error: a bar on a terminal, lines elsewhere."""

import sys
from contextlib import contextmanager

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
