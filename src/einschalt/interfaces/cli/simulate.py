"""``einschalt simulate``: a block whose truth is known, as a folder."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal, get_args

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import (
    given_path,
    optional,
    output_option,
    overwrite_option,
)
from einschalt.interfaces.cli.plan import CameraName

EXAMPLES = (
    "einschalt simulate --output out/simulated",
    "einschalt simulate --output out/simulated --preset demo --seed 7",
    "einschalt simulate --output out/blunders --gross-errors 0.01",
    "einschalt simulate --output out/truth --repeat 20 --high-scale 12000",
    "einschalt simulate --output out/film --film-affinity 2e-4 --n-check 50",
    "einschalt simulate --output out/digital --camera dmc_3 --low-scale 20000",
    "einschalt simulate --output out/tried --plan out/plan",
    "einschalt simulate --output out/trials --plan out/plan --repeat 20",
)

# the values that the simulation knows: it is not imported here, so that help comes at
# once
PresetName = Literal["neukirchen", "demo"]
Measurement = Literal["machine", "parallaxes", "images"]
Transformation = Literal["affine", "helmert", "rigid", "helmert_3d"]


_geometry = partial(optional, "Geometry")
_noise = partial(optional, "Noise")
_plan = partial(optional, "Plan")
_camera = partial(optional, "Camera")


@with_exit_status
@done_in_work
def simulate(
    output: Annotated[Path, output_option("Folder for the block.")],
    preset: Annotated[
        PresetName | None,
        typer.Option(
            show_default="Kovarik's block",
            help="Kovarik's test block of 1190 points, or a small one.",
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(
            parser=given_path,
            metavar="<path>",
            show_default=False,
            help="Folder of einschalt plan --output: simulates the planned block, and "
            "computes it to compare planned and simulated precision.",
        ),
    ] = None,
    row: _plan(int, "another plan of its plans.csv, from 1.") = None,
    compare: Annotated[
        bool, typer.Option(help="Plan: compute the block to compare its precision.")
    ] = True,
    title: Annotated[
        str | None,
        typer.Option(
            show_default="what was simulated", help="Name of the block in its results."
        ),
    ] = None,
    camera: Annotated[
        CameraName | None,
        typer.Option(
            metavar="CAMERA",
            case_sensitive=False,
            show_default=False,
            help="Camera: preset with its usual flight, as of einschalt plan: "
            f"{', '.join(get_args(CameraName))}.",
        ),
    ] = None,
    image_format: _camera(
        str, "side of the image [mm], or ALONGxACROSS the strip, as 68.0x105.8."
    ) = None,
    principal_distance: _camera(float, "principal distance [mm].") = None,
    seed: Annotated[int, typer.Option(help="The same seed gives the same block.")] = 0,
    width: _geometry(float, "extent from west to east [m].") = None,
    height: _geometry(float, "extent from south to north [m].") = None,
    point_spacing: _geometry(
        float, "mean distance of points [m].", "--point-spacing", "--spacing"
    ) = None,
    high_scale_number: _geometry(
        float,
        "denominator of the high flight's image scale.",
        "--high-scale-number",
        "--high-scale",
    ) = None,
    low_scale_number: _geometry(
        float,
        "denominator of the low flight's image scale.",
        "--low-scale-number",
        "--low-scale",
        "--scale-number",
        "--scale",
    ) = None,
    forward_overlap: _geometry(
        float, "of consecutive images, 0 to 1 or as 60%."
    ) = None,
    side_overlap: _geometry(float, "of neighbouring strips, 0 to 1 or as 60%.") = None,
    n_coverages: _geometry(int, "number of coverages of each flight.") = None,
    control_per_model: _geometry(
        int, "control in each high-flight model, 5 or 9."
    ) = None,
    n_check: _geometry(
        int, "number of new points with given coordinates, as check points."
    ) = None,
    measurement: _geometry(
        Measurement,
        "contents of the tables: coordinates of oriented models, these with "
        "y-parallaxes, or image coordinates.",
    ) = None,
    transformation: _geometry(
        Transformation, "how models are fitted.", "--transformation", "--kind"
    ) = None,
    control_standard_error: _noise(float, "of given coordinates, total [m].") = None,
    high_m_g_um: _noise(float, "of a measured point, total, in the image [µm].") = None,
    low_m_g_um: _noise(
        float, "the same for the low flight [µm].", "--low-m-g-um", "--m-g-um"
    ) = None,
    film_affinity: _noise(float, "scale along the strip minus that across.") = None,
    gross_errors: _noise(float, "share of measured points, both flights.") = None,
    gross_error_um: _noise(float, "size of a gross error in the image [µm].") = None,
    network_strain: _noise(float, "largest strain of given coordinates [m].") = None,
    repeat: Annotated[
        int | None,
        typer.Option(
            show_default=False,
            help="Repetitions: number of blocks to simulate and compute, to compare "
            "claimed and true precision.",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            show_default="one per core",
            help="Repetitions: number of parallel processes.",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            show_default="this computer",
            help="Repetitions: Dask scheduler, tcp://host:port.",
        ),
    ] = None,
    overwrite: Annotated[
        bool, overwrite_option("Replace an existing block, or existing repetitions.")
    ] = False,
):
    """Simulate a block whose true coordinates are known.

    Writes a block folder that check and densify read, and truth.csv beside it. Options
    of geometry and noise that are omitted are those of the preset, of the camera's
    usual flight, or of the plan. With --plan the block has the photographs, models,
    points, control and errors of a plan. With --repeat only repetitions.csv is written:
    for each seed the true and the claimed error of the new points.
    """
