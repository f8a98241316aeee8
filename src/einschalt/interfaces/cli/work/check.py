"""What ``einschalt check`` does."""

import sys
from dataclasses import replace

import typer
from rich.console import Console

from einschalt.foundations.errors import EinschaltError, SettingsError
from einschalt.interfaces.cli.exits import WRONG, print_out
from einschalt.interfaces.cli.outcome import is_recorded, report, report_problems
from einschalt.interfaces.files.columns_page import explanation_of
from einschalt.interfaces.programs.block_tables import find_problems
from einschalt.interfaces.reports import problem_list
from einschalt.pipeline.block.memory import require_memory
from einschalt.pipeline.block.output_system import with_output_system


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
    found = _with_size(_with_output(find_problems(block, given)))
    report_problems(*found.problems, *found.model_problems)
    report(
        n_problems=len(found.problems),
        n_models=len(found.model_problems),
        n_notes=len(found.notes),
    )
    if _is_terminal() and not is_recorded():
        Console().print(problem_list.problem_tables(found))
    else:
        for line in problem_list.problem_lines(found):
            print_out(line)
    print_out(f"{block}: {problem_list.conclusion(found)}")
    if found.problems or found.model_problems:
        raise typer.Exit(WRONG)


def _with_output(found):
    """Findings with what is wrong with the system in which results are to be told."""
    if found.block is None:
        return found
    try:
        with_output = with_output_system(found.block, found.block.settings)
    except EinschaltError as error:
        return replace(found, problems=(*found.problems, error))
    return replace(found, notes=with_output.notes)


def _with_size(found):
    """Findings with a lack of memory that the computation would have."""
    if found.block is None:
        return found
    try:
        require_memory(found.block)
    except EinschaltError as error:
        return replace(found, problems=(*found.problems, error))
    return found


def _is_terminal():
    return sys.stdout.isatty()
