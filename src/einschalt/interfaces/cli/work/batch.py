"""What ``einschalt batch`` does."""

from time import perf_counter

import typer

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, translated
from einschalt.interfaces import python_api
from einschalt.interfaces.batch.batch_run import plan_batch
from einschalt.interfaces.batch.block_search import find_blocks
from einschalt.interfaces.batch.block_state import read_failure
from einschalt.interfaces.cli.exits import REFUTED, WRONG, print_error, print_out
from einschalt.interfaces.cli.outcome import (
    is_recorded,
    report,
    report_facts,
    report_problems,
)
from einschalt.interfaces.cli.progress import batch_progress
from einschalt.pipeline.batch.block_table import refuted, summarize_batch, untested
from einschalt.pipeline.progress import Stage

SOME_FAILED = 1
TABLES = mark("Table of all blocks in {table}, .parquet and .html")
UNTESTED = mark("einschalt: stated precision not tested: {names}")
EXCLUDE = mark("einschalt: {options} exclude each other. Give one of them.")
WOULD = mark("{n} of {n_all} blocks would be computed; nothing was written")
MODES = {"resume": "unfinished", "only_failed": "failed", "everything": "all"}


def batch(
    folder, output, *, given, overwrite, strict, dry_run, quiet, memory, **options
):
    """Compute the blocks below a folder, and print the outcome of each."""
    started = perf_counter()
    where = {name: options[name] for name in ("scheduler", "workers")}
    where |= {"memory_gb": memory, "time_limit_s": options["time_limit"]}
    how = {"which": _which(options), "overwrite": overwrite}
    blocks = find_blocks(folder, output)
    if dry_run:
        python_api.chosen_engine(**where)  # what is wrong with it
        _tell_plan(plan_batch(blocks, output, given=given, **how))
        return
    with batch_progress(is_quiet=quiet) as progress:
        how |= {"settings": given, "progress": progress}
        table = python_api.densify_many(blocks, output, **where, **how)
    is_refuted = strict and len(refuted(table)) > 0
    if strict:
        _tell_untested(untested(table))
    duration = perf_counter() - started
    _end(table, duration, output, is_refuted=is_refuted, is_quiet=quiet)


def _tell_untested(names):
    if names:
        names = ", ".join(map(printable, names))
        print_error(translated(UNTESTED, names=names))


def _which(options):
    asked = [name for name in MODES if options[name]]
    if len(asked) > 1:
        names = ("--" + name.replace("_", "-") for name in asked)
        said = " and ".join(names).replace("--everything", "--all")
        report_problems(f"{said} exclude each other")
        print_error(translated(EXCLUDE, options=retold(said)))
        raise typer.Exit(WRONG)
    return MODES[asked[0]] if asked else "changed"


def _end(table, duration, output, *, is_refuted, is_quiet):
    report(output, **table["outcome"].value_counts().to_dict())
    failed = table[table["outcome"] == "failed"]
    if is_recorded():  # facts of each are in a file
        for row in failed.to_dict("records"):
            report_facts(facts_of_block(row, output / row["block"]))
    has_failed = len(failed) > 0
    if has_failed or is_refuted or not is_quiet:
        # blocks that failed are errors: whoever asks for nothing else is told of them
        say = print_error if is_quiet else print_out
        say(summarize_batch(table, duration))
        say(translated(TABLES, table=output / "blocks.csv"))
    if has_failed:
        raise typer.Exit(SOME_FAILED)
    if is_refuted:
        raise typer.Exit(REFUTED)


def facts_of_block(row, folder):
    """Facts of what was wrong with a block, each with its name before the file."""
    failure = read_failure(folder) or {}
    facts = failure.get("facts")
    # where nothing could be written, or not now, the table says it all
    if failure.get("reason") != row["reason"] or not _are_facts(facts):
        facts = [{"found": row["reason"], "remedy": row["remedy"] or None}]
    name = row["block"]
    return [
        one | {"file": f"{name}/{one['file']}" if one.get("file") else name}
        for one in facts
    ]


def _are_facts(facts):
    """Whether a file of ours says them, which anybody may have changed."""
    is_list = isinstance(facts, list) and len(facts) > 0
    return is_list and all(isinstance(one, dict) and one.get("found") for one in facts)


def _tell_plan(plan):
    for name in plan.names:
        if name in plan.reasons:
            print_out(_planned("run", name, plan.reasons[name]))
        else:
            row = plan.rows[name]
            said = row["reason"] or "done by the interrupted run"
            # its result has no place: a failure that is known before
            word = "fail" if row.get("stage") == Stage.WRITING.key else "keep"
            print_out(_planned(word, name, said))
    n_run, n_all = len(plan.to_run), len(plan.names)
    report(n_to_run=n_run, n_blocks=n_all)
    print_out(translated(WOULD, n=n_run, n_all=n_all))


def _planned(word, name, reason):
    """A line of the plan; its first word is looked for by other programs."""
    return f"{word:<4}  {printable(name)}: {retold(printable(reason))}"
