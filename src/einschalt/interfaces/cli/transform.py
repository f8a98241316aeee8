"""``einschalt transform``: one transformation per model, for any two sets of points."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import with_exit_status
from einschalt.interfaces.cli.paths import output_option, overwrite_option

EXAMPLES = (
    "einschalt transform model_points.csv ground_points.csv --output out",
    "einschalt transform old.csv new.csv --kind helmert --output out",
    "einschalt transform old.csv new.csv --output out --apply more_points.csv",
)


@with_exit_status
def transform(
    model_points: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL_POINTS",
            help="Table (CSV or Parquet): model_id, point_id, x, y, and z for "
            "helmert_3d; also weight. Without model_id it is one model.",
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
    output: Annotated[Path, output_option("Folder for the results.")],
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
    overwrite: Annotated[bool, overwrite_option()] = False,
):
    """Fit one transformation per model, and transform points.

    Writes parameters, models, residuals, failures and points, each .csv and .parquet,
    and provenance.json. Results of the same tables are replaced; a folder with anything
    else is refused.
    Residuals are transformed less given. Models that fail do not stop the others.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces.cli.work.transform import transform_tables  # noqa: PLC0415

    files = (model_points, ground_points, apply)
    transform_tables(*files, output, kind, overwrite=overwrite)
