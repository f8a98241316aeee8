"""What ``einschalt check`` does."""

import sys

import typer
from rich.console import Console

from einschalt.interfaces.cli.exits import WRONG, print_out
from einschalt.interfaces.files.block_folder import find_problems
from einschalt.interfaces.reports import problem_list


def check(block, given=None):
    """Print everything that is wrong with a block's input.

    ``given``: settings that go before those of block.toml.
    """
    found = find_problems(block, given)
    if _is_terminal():
        Console().print(problem_list.problem_tables(found))
    else:
        for line in problem_list.problem_lines(found):
            print_out(line)
    print_out(f"{block}: {problem_list.conclusion(found)}")
    if found.problems or found.model_problems:
        raise typer.Exit(WRONG)


def _is_terminal():
    return sys.stdout.isatty()
