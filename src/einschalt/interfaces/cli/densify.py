"""``einschalt densify``: a block's coordinates, with tables, map and report."""

from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import Block, Overwrite, Quiet, Results, Strict
from einschalt.interfaces.cli.settings_options import with_settings_options

EXAMPLES = (
    "einschalt densify data_examples/neukirchen --output out/neukirchen",
    "einschalt densify BLOCK --output out --coverage-mean most_central",
    "einschalt densify BLOCK --output out --weighting weighted --quiet",
)


@with_exit_status
@with_settings_options("that of block.toml")
@done_in_work
def densify(
    block: Block,
    output: Results,
    *,
    given: dict,
    ellipse_scale: Annotated[
        float | None,
        typer.Option(
            show_default="a round factor that makes them visible",
            help="Factor by which the ellipses are enlarged in block.gpkg.",
        ),
    ] = None,
    pdf: Annotated[
        Literal["a4", "letter"] | None,
        typer.Option(
            show_default="report.html alone",
            help="Also print the report to report.pdf, in this paper size; needs an "
            "installed Chromium.",
        ),
    ] = None,
    no_report: Annotated[
        bool,
        typer.Option(
            "--no-report", help="Write everything but report.html, which saves time."
        ),
    ] = False,
    overwrite: Overwrite = False,
    strict: Strict = False,
    quiet: Quiet = False,
):
    """Compute the points of a block, and their precision.

    Writes points, models, residuals, orientations (each .csv and .parquet),
    failures.csv, block.gpkg, report.html, summary.txt, assessment.json and
    provenance.json. Results of the same block are replaced; a folder with any other
    content is rejected.

    Exit status: 0 when the work was done (failed models are reported), 2 when the input
    or the call is wrong, 130 when interrupted; with --strict 3 when everything was
    written, but something contradicts the stated precision.
    """
