"""``einschalt batch``: every block below a folder, again and again."""

from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import (
    Overwrite,
    Quiet,
    Results,
    Strict,
    given_path,
)
from einschalt.interfaces.cli.settings_options import with_settings_options

EXAMPLES = (
    "einschalt batch data_examples --output out/all",
    "einschalt batch BLOCKS --output out --workers 8 --memory 4",
    "einschalt batch BLOCKS --output out --resume",
    "einschalt batch BLOCKS --output out --scheduler tcp://10.0.0.5:8786",
)


def _flag(name, text):
    return Annotated[bool, typer.Option(name, help=text)]


@with_exit_status
@with_settings_options("that of each block.toml")
@done_in_work
def batch(
    folder: Annotated[
        Path,
        typer.Argument(
            parser=given_path,
            metavar="FOLDER",
            help="Folder below which the blocks lie.",
        ),
    ],
    output: Results,
    *,
    workers: Annotated[
        int | None,
        typer.Option(show_default="one per core", help="Number of parallel processes."),
    ] = None,
    memory: Annotated[
        float | None,
        typer.Option(
            show_default="no limit", help="Memory that each block may use [GB]."
        ),
    ] = None,
    time_limit: Annotated[
        float | None,
        typer.Option(
            show_default="no limit",
            help="Seconds that a block may take; after that it fails, and the others "
            "continue.",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            show_default="this computer",
            help="Dask scheduler of a cluster, tcp://host:port.",
        ),
    ] = None,
    resume: _flag(
        "--resume",
        "Continue an interrupted run; blocks that failed in it are not tried again.",
    ) = False,
    only_failed: _flag(
        "--only-failed", "Compute only blocks that failed or were left half-done."
    ) = False,
    everything: _flag("--all", "Compute unchanged blocks as well.") = False,
    dry_run: _flag("--dry-run", "Report what would be computed, and why.") = False,
    overwrite: Overwrite = False,
    strict: Strict = False,
    given: dict,
    quiet: Quiet = False,
):
    """Compute every block below a folder, and report the outcome of each.

    Writes one folder per block, named after it, with the files that densify writes, and
    blocks.csv, blocks.parquet and blocks.html: one row per block. A block that already
    has a result is skipped, unless its tables, its settings or the version of the
    program have changed; if its folder contains anything else, the block fails. A block
    that fails does not stop the others.

    Exit status: 0 when every requested block has its result, 1 when some failed, 2 when
    the call is wrong or the folder cannot be written, 130 when interrupted; with
    --strict 3 when none failed, but something contradicts the stated precision of some.
    """
