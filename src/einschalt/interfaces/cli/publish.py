"""``einschalt publish``: a result as a transformation that PROJ finds by name."""

from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import (
    CRS,
    Overwrite,
    SourceCRS,
    given_path,
    output_option,
)

EXAMPLES = (
    "einschalt publish out/neukirchen --as NEUKIRCHEN",
    "einschalt publish out/old_to_new --as OLD --crs EPSG:3067 --source-crs EPSG:2393",
)


@with_exit_status
@done_in_work
def publish(
    result: Annotated[
        Path,
        typer.Argument(
            metavar="RESULT",
            parser=given_path,
            help="Folder that einschalt densify or transform has written.",
        ),
    ],
    name: Annotated[
        str,
        typer.Option(
            "--as",
            metavar="<name>",
            help="Name by which PROJ finds it, as EINSCHALT:NAME.",
        ),
    ],
    output: Annotated[
        Path | None,
        output_option("Folder for the publication; if omitted, RESULT/NAME."),
    ] = None,
    crs: CRS = None,
    source_crs: SourceCRS = None,
    installed_at: Annotated[
        str | None,
        typer.Option(
            show_default="where they are written",
            help="Folder in which the files will be when they are used; empty for "
            "PROJ's own search path.",
        ),
    ] = None,
    proj_db: Annotated[
        Path | None,
        typer.Option(
            parser=given_path,
            metavar="<path>",
            show_default="that of this PROJ",
            help="The file proj.db of the PROJ that is to use the database.",
        ),
    ] = None,
    overwrite: Overwrite = False,
):
    """Publish a result for PROJ, GDAL and QGIS.

    Writes operations.csv (each transformation as PROJ string and WKT, with accuracy and
    area), NAME.json (triangles, PROJ's tinshift) or NAME.tif (grid of shifts, GTG),
    NAME.db (auxiliary PROJ database), NAME.wkt (the frame), left_out.csv, README.md
    (how to use it, and its accuracy) and provenance.json. Every form is run in PROJ,
    forwards and backwards, before it is published.
    """
