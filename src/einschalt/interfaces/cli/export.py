"""``einschalt export``: a result for CAD, Excel, GIS and other adjustments."""

from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import Overwrite, given_path

EXAMPLES = (
    "einschalt export out/neukirchen --to points.dxf points.xlsx",
    "einschalt export out/neukirchen --to points.kml --to control.con",
    "einschalt export BLOCK --to adjusted.gkf",
)


@with_exit_status
@done_in_work
def export(
    result: Annotated[
        Path,
        typer.Argument(
            metavar="RESULT",
            parser=given_path,
            help="Folder that einschalt densify has written; or a block, which is "
            "computed first: its result has all covariances between points.",
        ),
    ],
    more: Annotated[
        list[Path] | None, typer.Argument(metavar="FILES", hidden=True)
    ] = None,
    files: Annotated[
        list[Path] | None,
        typer.Option(
            "--to",
            metavar="FILES...",
            show_default=False,
            help="Files to be written, one after the other; the suffix determines "
            "the format.",
        ),
    ] = None,
    overwrite: Overwrite = False,
):
    """Write a result for CAD, Excel, GIS and other adjustments.

    .dxf (points, numbers, ellipses, residual vectors on layers), .xlsx (a sheet per
    table, with units), .shp, .parquet (GeoParquet), .kml, .xml (LandXML CgPoints), .csv
    (reference of Metashape), .con (control of PAT-B, after its manual), .gkf (GNU Gama)
    and .snx (SINEX): adjusted points with covariances for the next adjustment.
    """
