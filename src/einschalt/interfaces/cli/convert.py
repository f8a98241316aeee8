"""``einschalt convert``: tables and markers of other programs, as plain tables."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status

EXAMPLES = (
    "einschalt convert markers.xml out/tables",
    "einschalt convert markers.xml out/gcp_list.txt",
    "einschalt convert sparse/0 out/tables",
    "einschalt convert Punkte.xlsx control_points.csv",
)


@with_exit_status
@done_in_work
def convert(
    given: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            help="A file of another program (Metashape, ODM, OpenSfM, MicMac, "
            "PhotoModeler, GDAL, QGIS, IGN, LandXML, KML, DXF, GSI, SDR, Nikon, "
            "JobXML, PAT-B, BINGO, Match-AT, GNU Gama, SINEX), a folder of COLMAP or "
            "MicMac, or a table of any kind.",
        ),
    ],
    output: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="A folder for control_points.csv, image_points.csv …; for markers "
            "also gcp_list.txt; for a table a .csv or .parquet.",
        ),
    ],
    kind: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="<name>",
            show_default="by name and content",
            help="Format of a file of another program, such as ign-opk; also one of "
            "your own.",
        ),
    ] = None,
    sheet: Annotated[
        str | None,
        typer.Option(show_default="the only one", help="Sheet of a workbook."),
    ] = None,
    layer: Annotated[
        str | None,
        typer.Option(show_default="the only one", help="Layer of a GeoPackage."),
    ] = None,
    crs: Annotated[
        str | None,
        typer.Option(
            show_default="not known",
            help="System of the coordinates, if no file states it.",
        ),
    ] = None,
    decimal: Annotated[
        Literal[",", "."] | None,
        typer.Option(show_default="by the table", help="Decimal sign of the numbers."),
    ] = None,
    angles: Annotated[
        Literal["degrees", "D.MMSS"] | None,
        typer.Option(
            show_default="by the table",
            help="How longitudes and latitudes are written, if it is ambiguous.",
        ),
    ] = None,
):
    """Convert the measurements of another program to plain tables.

    Names of columns, kinds of points, decimal commas and encodings are interpreted as
    by check, and reported. Coordinates remain in their system, pixels as they were
    counted. Existing files are not overwritten.
    """
