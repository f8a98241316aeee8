"""What ``einschalt check`` does."""

import sys

import typer
from rich.console import Console

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.cli.exits import WRONG, print_out
from einschalt.interfaces.cli.outcome import is_recorded, report, report_problems
from einschalt.interfaces.files.columns_page import explanation_of
from einschalt.interfaces.programs.full_check import everything_wrong
from einschalt.interfaces.reports import problem_list


def check(block=None, given=None, explain=None):
    """Print everything that is wrong with a block's input, or explain a column.

    ``given``: settings that go before those of block.toml.
    """
    if explain is not None:
        print_out(explanation_of(explain).rstrip("\n"))
    if block is None and explain is None:
        raise SettingsError(
            "no block is named",
            expected="a folder with block.toml",
            remedy="Write einschalt check BLOCK",
        )
    if block is None:
        return
    found = everything_wrong(block, given)
    report_problems(*found.problems, *found.model_problems)
    report(
        n_problems=len(found.problems),
        n_models=None if found.block is None else _n_models(found.block),
        n_model_problems=len(found.model_problems),
        n_notes=len(found.notes),
        notes=[str(note) for note in found.notes],
    )
    if _is_terminal() and not is_recorded():
        Console().print(problem_list.problem_tables(found))
    else:
        for line in problem_list.problem_lines(found):
            print_out(line)
    print_out(f"{block}: {problem_list.conclusion(found)}")
    if found.problems or found.model_problems:
        raise typer.Exit(WRONG)


def _n_models(block):
    return sum(flight.n_models for flight in block.flights.values())


def _is_terminal():
    return sys.stdout.isatty()
