"""``einschalt init``: a first block.toml, of what files hold."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status

EXAMPLES = (
    "einschalt init BLOCK --from control.xlsx high.csv low.csv",
    "einschalt init BLOCK --from control.gpkg high.csv low.csv --crs EPSG:31255 --yes",
    "einschalt init BLOCK --template",
)


def _asked(kind, text, *names):
    option = typer.Option(*names, show_default=False, help=text)
    return Annotated[kind | None, option]


@with_exit_status
@done_in_work
def init(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="FOLDER", help="Folder of the block; created if necessary."
        ),
    ],
    more: Annotated[
        list[Path] | None, typer.Argument(metavar="FILES", hidden=True)
    ] = None,
    files: Annotated[
        list[Path] | None,
        typer.Option(
            "--from",
            metavar="FILES...",
            show_default="those in FOLDER",
            help="Tables and cameras, one after the other.",
        ),
    ] = None,
    template: Annotated[
        bool, typer.Option("--template", help="Write an example to be filled in.")
    ] = False,
    schema: Annotated[
        bool,
        typer.Option(
            "--schema", help="Also write block.schema.json, for TOML editors."
        ),
    ] = False,
    again: Annotated[
        bool,
        typer.Option(
            "--again",
            help="Write block.toml anew; the old one is kept as block.toml.1.bak.",
        ),
    ] = False,
    yes: Annotated[
        bool,
        typer.Option("--yes", "-y", help="Ask nothing: accept all suggestions."),
    ] = False,
    crs: _asked(str, "System of the coordinates, such as EPSG:31255.") = None,
    points_crs: _asked(
        str,
        "System of the ground points, if it is another one, such as EPSG:4326 of "
        "longitudes and latitudes, or one in feet.",
    ) = None,
    name: _asked(str, "Name of the block.") = None,
    high_scale: _asked(float, "Scale number of the high flight, N of 1:N.") = None,
    low_scale: _asked(float, "Scale number of the low flight, N of 1:N.") = None,
    high_m_g_um: _asked(
        float, "TOTAL error of one setting of the high flight [µm]."
    ) = None,
    low_m_g_um: _asked(float, "The same for the low flight [µm].") = None,
    principal_distance_mm: _asked(
        float, "Principal distance of flights with image points [mm]."
    ) = None,
    pixel_size_um: _asked(
        float, "Size of a pixel of flights with image points [µm]."
    ) = None,
    control_error_m: _asked(
        float, "TOTAL standard error of the control points [m]."
    ) = None,
    point_id: _asked(str, "Column that has the names of the ground points.") = None,
    easting: _asked(str, "Column that is the easting of the ground points.") = None,
    northing: _asked(str, "Column that is the northing.") = None,
    decimal: _asked(
        Literal[",", "."], "Decimal sign of the numbers, if it is ambiguous."
    ) = None,
    angles: _asked(
        Literal["degrees", "D.MMSS"],
        "How longitudes and latitudes are written, if it is ambiguous.",
    ) = None,
):
    """Write a first block.toml from the contents of files.

    Reads the files, reports what each of them contains and why, and asks on a terminal
    for missing information. Otherwise it ends with status 2 and names the option; --yes
    accepts all suggestions. Options take precedence over the files. No file is changed
    or overwritten; what --again replaces is kept under another name.
    """
