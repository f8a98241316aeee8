"""``einschalt densify``: a block's coordinates, with tables, map and report."""

from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import with_exit_status
from einschalt.interfaces.cli.paths import output_option, overwrite_option
from einschalt.interfaces.cli.settings_options import with_settings_options

EXAMPLES = (
    "einschalt densify data_examples/neukirchen --output out/neukirchen",
    "einschalt densify BLOCK --output out --coverage-mean most_central",
    "einschalt densify BLOCK --output out --weighting weighted --quiet",
)


@with_exit_status
@with_settings_options("that of block.toml")
def densify(
    block: Annotated[
        Path,
        typer.Argument(metavar="BLOCK", help="Folder of the block, or block.toml."),
    ],
    output: Annotated[Path, output_option("Folder for the results.")],
    *,
    given: dict,
    ellipse_scale: Annotated[
        float | None,
        typer.Option(
            show_default="a round factor that makes them visible",
            help="How much larger the ellipses are drawn in block.gpkg.",
        ),
    ] = None,
    overwrite: Annotated[bool, overwrite_option()] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")
    ] = False,
):
    """Compute a block's points, and how good they are.

    Writes points, models, residuals, orientations (each .csv and .parquet),
    failures.csv, block.gpkg, report.html, summary.txt, assessment.json and
    provenance.json. Results of the same block are replaced; a folder with anything else
    is refused. Models that fail do not stop the others; they are said, and the exit
    status is 0.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces.cli.work.densify import densify_folder  # noqa: PLC0415

    options = {"ellipse_scale": ellipse_scale, "overwrite": overwrite}
    densify_folder(block, output, given, **options, is_quiet=quiet)
