"""``einschalt check``: everything that is wrong with a block's input, at once."""

from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.settings_options import with_settings_options

EXAMPLES = (
    "einschalt check data_examples/neukirchen",
    "einschalt check BLOCK | grep low_flight.csv",
    "einschalt check BLOCK --method simultaneous",
    "einschalt check --explain standard_error_m",
)


@with_exit_status
@with_settings_options("that of block.toml")
@done_in_work
def check(
    block: Annotated[
        Path | None,
        typer.Argument(metavar="BLOCK", help="Folder of the block, or block.toml."),
    ] = None,
    explain: Annotated[
        str | None,
        typer.Option(
            metavar="<column>",
            show_default=False,
            help="Explain a column, under its own or a usual name; 'all' lists them.",
        ),
    ] = None,
    *,
    given: dict,
):
    """Report everything that is wrong with a block's input.

    Prints a table on a terminal; in a pipe one line for each problem, which begins with
    problem, model (it cannot be used, the others can) or note. The exit status is 2 if
    anything is wrong. Give it the same options as densify: some of them, such as
    --method, decide what a block needs.
    """
