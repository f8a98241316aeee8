"""What ``einschalt densify`` does."""

import typer

from einschalt.foundations.kept_memory import keep_freed_memory
from einschalt.foundations.language import mark, translated
from einschalt.interfaces import python_api
from einschalt.interfaces.cli.compiling import compilations_shown, usual_kernels
from einschalt.interfaces.cli.exits import REFUTED, print_error, print_out
from einschalt.interfaces.cli.outcome import report, report_suggestions
from einschalt.interfaces.cli.progress import of_whole_work, stage_progress
from einschalt.interfaces.files.ellipse_layer import require_scale
from einschalt.interfaces.files.output_folder import held_folder
from einschalt.interfaces.files.result_folder import (
    output_of,
    require_printable,
    write_result,
)
from einschalt.interfaces.provenance import figures_of
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.block.memory import has_memory_to_spare
from einschalt.pipeline.progress import Stage, stage_reporter
from einschalt.pipeline.summary.suggestions.catalogue import suggestions_of

MOST_REASONS = 3  # that a result does not stand
UNTESTED = mark("einschalt: the stated precision is not tested: give check points.")


def densify(
    block,
    output,
    given,
    *,
    ellipse_scale=None,
    pdf=None,
    no_report=False,
    overwrite=False,
    strict=False,
    quiet=False,
):
    """Compute a block, write its results and print their summary."""
    # before the work, which would be lost
    require_scale(ellipse_scale)
    require_printable(pdf, report=not no_report)
    with (
        stage_progress(is_quiet=quiet) as show,
        compilations_shown(of_whole_work(show)) as progress,
    ):
        read = python_api.read_block(block, given)
        progress.n_usual = usual_kernels(read)
        if has_memory_to_spare(read):
            keep_freed_memory()
        with held_folder(output, output_of(read, overwrite=overwrite)):
            result = python_api.densify(read, read.settings, progress=progress)
            report_progress = stage_reporter(progress)
            report_progress(Stage.ASSESSMENT)
            result.assessment  # noqa: B018
            report_progress(Stage.WRITING)
            options = {"ellipse_scale": ellipse_scale, "overwrite": overwrite}
            options |= {"report": not no_report, "paper": pdf}
            write_result(result, output, **options, beside=True)
        show(Stage.DONE, Stage.DONE.fraction)
    report(output, block=read.name, **figures_of(result))
    report_suggestions(suggestions_of(result.assessment.findings))
    if not quiet:
        print_out(result.summary())
        if no_report:
            print_out(translated("Results in {folder}", folder=output))
        else:
            message = mark("Results in {folder}, report in {page}")
            page = output / "report.html"
            print_out(translated(message, folder=output, page=page))
    supported = result.assessment.claim_is_supported
    if strict and supported is None:
        print_error(translated(UNTESTED))
    if strict and supported is False:
        if quiet:  # whoever asks for nothing else is told why
            print_error(result.summary().splitlines()[0])
            for one in _reasons(result.assessment.findings):
                print_error(f"  {one.problem}")
        raise typer.Exit(REFUTED)


def _reasons(findings):
    """What contradicts the stated precision, in words, the gravest few."""
    grave = [found for found in findings if found.gravity is Gravity.GRAVE]
    return suggestions_of(grave)[:MOST_REASONS]
