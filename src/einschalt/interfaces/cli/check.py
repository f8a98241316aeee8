"""``einschalt check``: everything that is wrong with a block's input, at once."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import WRONG, print_out, with_exit_status


@with_exit_status
def check(
    block: Annotated[
        Path,
        typer.Argument(metavar="BLOCK", help="Folder of the block, or block.toml."),
    ],
):
    """Say everything that is wrong with a block's input.

    On a terminal as a table; in a pipe one line for each problem, which begins with
    problem, model (it cannot be used, the others can) or note. The exit status is 2
    where anything is wrong.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces.files.block_folder import find_problems  # noqa: PLC0415
    from einschalt.interfaces.reports import problem_list  # noqa: PLC0415

    found = find_problems(block)
    if _is_terminal():
        from rich.console import Console  # noqa: PLC0415

        Console().print(problem_list.problem_tables(found))
    else:
        for line in problem_list.problem_lines(found):
            print_out(line)
    print_out(f"{block}: {problem_list.conclusion(found)}")
    if found.problems or found.model_problems:
        raise typer.Exit(WRONG)


def _is_terminal():
    return sys.stdout.isatty()
