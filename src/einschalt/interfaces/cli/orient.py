"""``einschalt orient``: relative orientation; dangerous surfaces before a flight."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import Overwrite, Results, optional

EXAMPLES = (
    "einschalt orient y_parallaxes.csv --base 92 --output out",
    "einschalt orient image_pairs.csv --principal-distance 153 --output out",
    (
        "einschalt orient --terrain heights.csv --principal-distance 152 "
        "--scale-number 8000 --output out"
    ),
)


_parallaxes = partial(optional, "Parallaxes")
_images = partial(optional, "Images")
_terrain = partial(optional, "Terrain")


@with_exit_status
@done_in_work
def orient(
    output: Results,
    measurements: Annotated[
        Path | None,
        typer.Argument(
            metavar="TABLE",
            help="Y-parallaxes: model_id, point_id, x, y, z, y_parallax [mm]; or "
            "image coordinates: model_id, point_id, x_left, y_left, x_right, y_right "
            "[mm]. CSV or Parquet; without model_id all points form one model.",
        ),
    ] = None,
    case: Annotated[
        Literal["independent", "dependent_left", "dependent_right"] | None,
        typer.Option(
            help="Which bundles move.",
            show_default="independent for parallaxes, dependent_right for images",
        ),
    ] = None,
    base: _parallaxes(
        str, "base [mm], or a table with model_id, base. Of images: their base length."
    ) = None,
    method: _parallaxes(
        Literal["least_squares", "krames", "gruber"],
        "method for the elements (default: least_squares).",
    ) = None,
    principal_distance: _images(
        float, "principal distance [mm]; for terrain that of the planned camera."
    ) = None,
    estimator: _images(
        Literal["rigorous", "determinants"],
        "what is minimised (default: rigorous).",
    ) = None,
    camera: _images(
        Path,
        "a camera.toml, instead of --principal-distance; TABLE is then in its pixels.",
    ) = None,
    outliers: _images(
        Literal["keep", "snoop", "huber", "tukey"],
        "keep points that contradict their model, remove them, or give them less "
        "weight (default: keep).",
    ) = None,
    terrain: _terrain(
        Path, "instead of TABLE: model_id, h1 … h6, heights in standard points [m]."
    ) = None,
    scale_number: _terrain(float, "scale number in points 1 and 2.") = None,
    flying_height: _terrain(float, "flying height above points 1 and 2 [m].") = None,
    altitude: _terrain(
        float, "altitude of the flight, in the height system of the table [m]."
    ) = None,
    image_format: _terrain(float, "side of the image [mm] (default: 230).") = None,
    forward_overlap: _terrain(
        float, "forward overlap, 0 to 1 or as 60% (default: 0.6)."
    ) = None,
    wing: _terrain(
        float,
        "distance of points 3 to 6 from the base in the image [mm] (default: 100).",
    ) = None,
    overwrite: Overwrite = False,
):
    """Orient image pairs, and report those near a dangerous surface.

    With --base from y-parallaxes (y of the moved bundle minus y of the fixed one); with
    --principal-distance from image coordinates; with --terrain before the flight, from
    the heights below the two projection centres (h1, h2) and in the wings beside them
    (h3, h5 beside h1; h4, h6 beside h2).

    Writes parameters, cofactors, residuals, contradiction (of parallaxes), model_points
    and model_precision (of images), dangerous_surface and failures, each .csv and
    .parquet, summary.txt, provenance.json, residual_parallaxes.svg, and Krames'
    construction for the first six-point models. Results of the same tables are
    replaced; a folder with any other content is rejected. Models that fail do not stop
    the others.
    """
