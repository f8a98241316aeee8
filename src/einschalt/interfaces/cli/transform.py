"""``einschalt transform``: one transformation per model, for any two sets of points."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import CRS, Overwrite, Results, SourceCRS

EXAMPLES = (
    "einschalt transform model_points.csv ground_points.csv --output out",
    "einschalt transform old.csv new.csv --kind helmert --output out",
    "einschalt transform old.csv new.csv --output out --apply more_points.csv",
    (
        "einschalt transform old.csv new.csv --kind helmert --distribute triangles "
        "--output out --publish OLD --crs EPSG:3067"
    ),
    (
        "einschalt transform old.csv new.csv --distribute collocation --output out "
        "--publish OLD --crs EPSG:31467"
    ),
)


@with_exit_status
@done_in_work
def transform(
    model_points: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL_POINTS",
            help="Table (CSV or Parquet): model_id, point_id, x, y, and z for "
            "helmert_3d; also weight. Without model_id all points form one model.",
        ),
    ],
    ground_points: Annotated[
        Path,
        typer.Argument(
            metavar="GROUND_POINTS",
            help="Table: point_id, easting, northing [m], and height for helmert_3d; "
            "also weight.",
        ),
    ],
    output: Results,
    kind: Annotated[
        Literal["affine", "helmert", "rigid", "helmert_3d"],
        typer.Option(help="Transformation of every model."),
    ] = "affine",
    apply: Annotated[
        Path | None,
        typer.Option(
            help="Table of the points to transform.",
            show_default="the points of MODEL_POINTS",
        ),
    ] = None,
    distribute: Annotated[
        Literal["none", "triangles", "collocation", "natural_neighbour"],
        typer.Option(
            help="Distribution of the residuals: none; linear in triangles of "
            "identical points, which are then reproduced exactly; or by a grid of "
            "shifts, from collocation (without noise) or natural neighbours.",
        ),
    ] = "none",
    cell: Annotated[
        float | None,
        typer.Option(
            min=0.001,
            show_default="chosen",
            help="Width of the cells of the grid [m].",
        ),
    ] = None,
    triangles: Annotated[
        Path | None,
        typer.Option(
            show_default="Delaunay triangles",
            help="Table of the triangles: three columns with the names of the corners.",
        ),
    ] = None,
    outliers: Annotated[
        Literal["keep", "set_aside"] | None,
        typer.Option(
            show_default="keep with triangles, set_aside with grids",
            help="Identical points that contradict their neighbours: distributed like "
            "all others, or left out.",
        ),
    ] = None,
    publish: Annotated[
        str | None,
        typer.Option(
            metavar="<name>",
            show_default=False,
            help="Publish the transformation for PROJ under this name, in a "
            "subfolder of this name (see einschalt publish).",
        ),
    ] = None,
    crs: CRS = None,
    source_crs: SourceCRS = None,
    overwrite: Overwrite = False,
):
    """Fit one transformation per model, and transform points.

    Writes parameters, models, residuals, failures, points and identical_points, each
    .csv and .parquet, with --distribute also left_out and triangles or distribution,
    and provenance.json. Results of the same tables are replaced; a folder with any
    other content is rejected. Residuals are transformed minus given. Models that fail
    do not stop the others.
    """
