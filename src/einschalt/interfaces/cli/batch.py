"""``einschalt batch``: every block below a folder, again and again."""

from pathlib import Path
from time import perf_counter
from typing import Annotated

import typer

from einschalt.foundations.shown_names import printable
from einschalt.interfaces.cli.densify import (
    TOLERANCE,
    CoverageMean,
    Distribution,
    Method,
    ModelDeformation,
    Outliers,
    Screening,
    VarianceComponents,
    Weighting,
)
from einschalt.interfaces.cli.exits import complain, tell, with_exit_status
from einschalt.interfaces.cli.paths import given_path, output_option, overwrite_option
from einschalt.interfaces.cli.progress import batch_progress

SOME_FAILED = 1
MODES = {"resume": "unfinished", "only_failed": "failed", "everything": "all"}


def _setting(kind, text):
    return Annotated[
        kind | None, typer.Option(show_default="that of each block.toml", help=text)
    ]


def _flag(name, text):
    return Annotated[bool, typer.Option(name, help=text)]


@with_exit_status
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
    overwrite: Annotated[bool, overwrite_option()] = False,
    method: _setting(Method, "How blocks are computed.") = None,
    coverage_mean: _setting(CoverageMean, "Values that make a point's mean.") = None,
    weighting: _setting(Weighting, "Arithmetic mean, or weights 1 / M².") = None,
    outliers: _setting(Outliers, "What happens to gross errors.") = None,
    screening: _setting(Screening, "Limits of differences of coverages.") = None,
    iterations: _setting(int, "Passes of the low flight at most.") = None,
    model_deformation: _setting(
        ModelDeformation, "With method simultaneous: deformations of a flight."
    ) = None,
    variance_components: _setting(
        VarianceComponents, "With method simultaneous: errors as given, or as shown."
    ) = None,
    significance: _setting(float, "Of the tests for gross errors.") = None,
    residual_distribution: _setting(
        Distribution, "How residuals of control points are distributed."
    ) = None,
    tolerance: _setting(str, TOLERANCE) = None,
    confidence: _setting(float, "Of the confidence ellipses.") = None,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")
    ] = False,
):
    """Compute every block below a folder, and say what became of each.

    Writes one folder per block, named after it, with the files that densify writes,
    and blocks.csv, blocks.parquet and blocks.html: one row per block. A block whose
    result is there is skipped, unless its tables, its settings or the version of the
    program have changed; where a folder holds anything but its result, it fails. A
    block that fails does not stop the others.

    Exit status: 0 when every block that was asked for has its result, 1 when some
    failed, 2 when the call is wrong or the folder cannot be written, 130 when
    interrupted.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces import python_api  # noqa: PLC0415
    from einschalt.interfaces.batch.batch_run import plan_batch  # noqa: PLC0415
    from einschalt.interfaces.batch.block_search import find_blocks  # noqa: PLC0415

    started = perf_counter()
    given = _given(
        method=method,
        coverage_mean=coverage_mean,
        weighting=weighting,
        outliers=outliers,
        screening=screening,
        iterations=iterations,
        model_deformation=model_deformation,
        variance_components=variance_components,
        significance=significance,
        residual_distribution=residual_distribution,
        tolerance=tolerance,
        confidence=confidence,
    )
    which = _mode(resume=resume, only_failed=only_failed, everything=everything)
    blocks = find_blocks(folder, output)
    if dry_run:
        python_api.chosen_engine(scheduler, workers, memory)  # what is wrong with it
        options = {"given": given, "which": which, "overwrite": overwrite}
        _tell_plan(plan_batch(blocks, output, **options))
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
            overwrite=overwrite,
            progress=progress,
        )
    _end(table, perf_counter() - started, output, is_quiet=quiet)


def _end(table, seconds, output, *, is_quiet):
    # imported when the command runs, as above
    from einschalt.pipeline.batch import summarize_batch  # noqa: PLC0415

    has_failed = (table["outcome"] == "failed").any()
    if has_failed or not is_quiet:
        # blocks that failed are errors: whoever asks for nothing else is told of them
        say = complain if is_quiet else tell
        say(summarize_batch(table, seconds))
        say(f"Table of all blocks in {output / 'blocks.csv'}, .parquet and .html")
    if has_failed:
        raise typer.Exit(SOME_FAILED)


def _given(**settings):
    return {name: value for name, value in settings.items() if value is not None}


def _mode(**flags):
    asked = [name for name, is_asked in flags.items() if is_asked]
    if len(asked) > 1:
        names = ("--" + name.replace("_", "-") for name in asked)
        said = " and ".join(names).replace("--everything", "--all")
        complain(f"einschalt: {said} exclude each other. Give one of them.")
        raise typer.Exit(2)
    return MODES[asked[0]] if asked else "changed"


def _tell_plan(plan):
    for name in plan.names:
        if name in plan.reasons:
            tell(f"run   {printable(name)}: {printable(plan.reasons[name])}")
        else:
            row = plan.rows[name]
            said = row["reason"] or "done by the interrupted run"
            # its result has no place: a failure that is known before
            word = "fail" if row.get("stage") == "writing" else "keep"
            tell(f"{word}  {printable(name)}: {printable(said)}")
    n_run, n_all = len(plan.to_run), len(plan.names)
    tell(f"{n_run} of {n_all} blocks would be computed; nothing was written")
