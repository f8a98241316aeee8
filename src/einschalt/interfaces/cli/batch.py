"""``einschalt batch``: every block below a folder, again and again."""

from pathlib import Path
from time import perf_counter
from typing import Annotated

import typer

from einschalt.foundations.display_names import printable
from einschalt.interfaces.cli.exits import print_error, print_out, with_exit_status
from einschalt.interfaces.cli.paths import given_path, output_option
from einschalt.interfaces.cli.progress import batch_progress
from einschalt.interfaces.cli.settings_options import with_settings_options

SOME_FAILED = 1
MODES = {"resume": "unfinished", "only_failed": "failed", "everything": "all"}


def _flag(name, text):
    return Annotated[bool, typer.Option(name, help=text)]


@with_exit_status
@with_settings_options("that of each block.toml")
def batch(
    folder: Annotated[
        Path,
        typer.Argument(
            parser=given_path,
            metavar="FOLDER",
            help="Folder below which the blocks lie.",
        ),
    ],
    output: Annotated[Path, output_option("Folder for the results.")],
    *,
    workers: Annotated[
        int | None,
        typer.Option(show_default="one per core", help="Processes at the same time."),
    ] = None,
    memory: Annotated[
        float | None,
        typer.Option(show_default="no limit", help="Memory of each process [GB]."),
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
        "Go on with an interrupted run; what it has seen fail is not tried again.",
    ) = False,
    only_failed: _flag(
        "--only-failed", "Compute only blocks that failed or were left half-done."
    ) = False,
    everything: _flag("--all", "Compute unchanged blocks as well.") = False,
    dry_run: _flag("--dry-run", "Say what would be computed, and why.") = False,
    given: dict,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")
    ] = False,
):
    """Compute every block below a folder, and say what became of each.

    Writes one folder per block, named after it, with the files that densify writes,
    and blocks.csv, blocks.parquet and blocks.html: one row per block. A block whose
    result is there is skipped, unless its tables, its settings or the version of the
    program have changed. A block that fails does not stop the others.

    Exit status: 0 when every block that was asked for has its result, 1 when some
    failed, 2 when the call is wrong or the folder cannot be written, 130 when
    interrupted.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces import python_api  # noqa: PLC0415
    from einschalt.interfaces.batch.batch_run import plan_batch  # noqa: PLC0415
    from einschalt.interfaces.batch.block_search import find_blocks  # noqa: PLC0415

    started = perf_counter()
    which = _mode(resume=resume, only_failed=only_failed, everything=everything)
    blocks = find_blocks(folder, output)
    if dry_run:
        python_api.chosen_engine(scheduler, workers, memory)  # what is wrong with it
        _tell_plan(plan_batch(blocks, output, given=given, which=which))
        return
    with batch_progress(is_quiet=quiet) as progress:
        table = python_api.densify_many(
            blocks,
            output,
            scheduler=scheduler,
            settings=given,
            workers=workers,
            memory_gb=memory,
            which=which,
            progress=progress,
        )
    _end(table, perf_counter() - started, output, is_quiet=quiet)


def _end(table, seconds, output, *, is_quiet):
    # imported when the command runs, as above
    from einschalt.pipeline.batch.block_table import summarize_batch  # noqa: PLC0415

    has_failed = (table["outcome"] == "failed").any()
    if has_failed or not is_quiet:
        # blocks that failed are errors: whoever asks for nothing else is told of them
        say = print_error if is_quiet else print_out
        say(summarize_batch(table, seconds))
        say(f"Table of all blocks in {output / 'blocks.csv'}, .parquet and .html")
    if has_failed:
        raise typer.Exit(SOME_FAILED)


def _mode(**flags):
    asked = [name for name, is_asked in flags.items() if is_asked]
    if len(asked) > 1:
        names = ("--" + name.replace("_", "-") for name in asked)
        said = " and ".join(names).replace("--everything", "--all")
        print_error(f"einschalt: {said} exclude each other. Give one of them.")
        raise typer.Exit(2)
    return MODES[asked[0]] if asked else "changed"


def _tell_plan(plan):
    for name in plan.names:
        if name in plan.reasons:
            print_out(f"run   {printable(name)}: {printable(plan.reasons[name])}")
        else:
            said = plan.rows[name]["reason"] or "done by the interrupted run"
            print_out(f"keep  {printable(name)}: {printable(said)}")
    n_run, n_all = len(plan.to_run), len(plan.names)
    print_out(f"{n_run} of {n_all} blocks would be computed; nothing was written")
