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
        Path, typer.Argument(metavar="FOLDER", help="Of the block; made if need be.")
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
            "--schema", help="Write block.schema.json beside, for editors of TOML."
        ),
    ] = False,
    yes: Annotated[
        bool,
        typer.Option("--yes", "-y", help="Ask nothing: take what is suggested."),
    ] = False,
    crs: _asked(str, "System of the coordinates, such as EPSG:31255.") = None,
    name: _asked(str, "Name of the block.") = None,
    high_scale: _asked(float, "Scale number of the high flight.") = None,
    low_scale: _asked(float, "Scale number of the low flight.") = None,
    high_m_g_um: _asked(
        float, "TOTAL error of one setting of the high flight [µm]."
    ) = None,
    low_m_g_um: _asked(float, "The same of the low flight [µm].") = None,
    principal_distance_mm: _asked(float, "Of flights with image points [mm].") = None,
    control_error_m: _asked(
        float, "TOTAL standard error of the control points [m]."
    ) = None,
    easting: _asked(str, "Column that is the easting of the ground points.") = None,
    northing: _asked(str, "Column that is the northing.") = None,
    decimal: _asked(
        Literal[",", "."], "What a comma or point in the numbers is, if it is unclear."
    ) = None,
):
    """Write a first block.toml, of what files hold.

    Looks at the files, says what each of them is and why, and asks on a terminal what
    they cannot tell. Elsewhere it ends with status 2 and names the option; --yes takes
    what is suggested. An option goes before what the files say. No file is changed,
    and none is written over.
    """
