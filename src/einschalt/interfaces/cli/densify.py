"""``einschalt densify``: a block's coordinates, with tables, map and report."""

from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import print_out, with_exit_status
from einschalt.interfaces.cli.paths import output_option
from einschalt.interfaces.cli.progress import stage_progress
from einschalt.interfaces.cli.settings_options import with_settings_options
from einschalt.pipeline.progress import Stage


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
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")
    ] = False,
):
    """Compute a block's points, and how good they are.

    Writes points, models, residuals, orientations (each .csv and .parquet),
    failures.csv, block.gpkg, report.html, summary.txt and provenance.json. Models that
    fail do not stop the others; they are said, and the exit status is 0.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces import python_api  # noqa: PLC0415
    from einschalt.interfaces.files.ellipse_layer import (  # noqa: PLC0415
        require_scale,
    )
    from einschalt.interfaces.files.result_folder import (  # noqa: PLC0415
        refuse_block_folder,
    )

    # before the work, which would be lost
    refuse_block_folder(output)
    require_scale(ellipse_scale)
    read = python_api.read_block(block)
    settings = read.settings.updated(given)
    with stage_progress(is_quiet=quiet) as progress:
        result = python_api.densify(read, settings, progress=progress)
        progress(Stage.WRITING, Stage.WRITING.fraction)
        result.write(output, ellipse_scale=ellipse_scale)
    if not quiet:
        print_out(result.summary())
        print_out(f"Results in {output}, report in {output / 'report.html'}")
