"""What ``einschalt batch`` does."""

from time import perf_counter

import typer

from einschalt.foundations.display_names import printable
from einschalt.interfaces import python_api
from einschalt.interfaces.batch.batch_run import plan_batch
from einschalt.interfaces.batch.block_search import find_blocks
from einschalt.interfaces.cli.exits import print_error, print_out
from einschalt.interfaces.cli.progress import batch_progress
from einschalt.pipeline.batch.block_table import summarize_batch
from einschalt.pipeline.progress import Stage

SOME_FAILED = 1


def run_blocks(folder, output, given, where, which, *, overwrite, is_dry_run, is_quiet):
    """Compute the blocks below a folder, and print the outcome of each."""
    started = perf_counter()
    blocks = find_blocks(folder, output)
    if is_dry_run:
        python_api.chosen_engine(**where)  # what is wrong with it
        options = {"given": given, "which": which, "overwrite": overwrite}
        _tell_plan(plan_batch(blocks, output, **options))
        return
    with batch_progress(is_quiet=is_quiet) as progress:
        table = python_api.densify_many(
            blocks,
            output,
            **where,
            settings=given,
            which=which,
            overwrite=overwrite,
            progress=progress,
        )
    _end(table, perf_counter() - started, output, is_quiet=is_quiet)


def _end(table, seconds, output, *, is_quiet):
    has_failed = (table["outcome"] == "failed").any()
    if has_failed or not is_quiet:
        # blocks that failed are errors: whoever asks for nothing else is told of them
        say = print_error if is_quiet else print_out
        say(summarize_batch(table, seconds))
        say(f"Table of all blocks in {output / 'blocks.csv'}, .parquet and .html")
    if has_failed:
        raise typer.Exit(SOME_FAILED)


def _tell_plan(plan):
    for name in plan.names:
        if name in plan.reasons:
            print_out(f"run   {printable(name)}: {printable(plan.reasons[name])}")
        else:
            row = plan.rows[name]
            said = row["reason"] or "done by the interrupted run"
            # its result has no place: a failure that is known before
            word = "fail" if row.get("stage") == Stage.WRITING.key else "keep"
            print_out(f"{word}  {printable(name)}: {printable(said)}")
    n_run, n_all = len(plan.to_run), len(plan.names)
    print_out(f"{n_run} of {n_all} blocks would be computed; nothing was written")
