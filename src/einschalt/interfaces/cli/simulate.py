"""``einschalt simulate``: a block whose truth is known, as a folder."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import optional, output_option, overwrite_option

EXAMPLES = (
    "einschalt simulate --output out/simulated",
    "einschalt simulate --output out/simulated --preset demo --seed 7",
    "einschalt simulate --output out/blunders --gross-errors 0.01",
    "einschalt simulate --output out/truth --repeat 20 --high-scale 12000",
    "einschalt simulate --output out/film --film-affinity 2e-4 --n-check 50",
)

# the values that the simulation knows: it is not imported here, so that help comes at
# once
PresetName = Literal["neukirchen", "demo"]
Measurement = Literal["machine", "parallaxes", "images"]
Transformation = Literal["affine", "helmert", "rigid", "helmert_3d"]


_geometry = partial(optional, "Geometry")
_noise = partial(optional, "Noise")


@with_exit_status
@done_in_work
def simulate(
    output: Annotated[Path, output_option("Folder for the block.")],
    preset: Annotated[
        PresetName,
        typer.Option(help="Kovarik's test block of 1190 points, or a small one."),
    ] = "neukirchen",
    seed: Annotated[int, typer.Option(help="The same seed gives the same block.")] = 0,
    width: _geometry(float, "extent from west to east [m].") = None,
    height: _geometry(float, "extent from south to north [m].") = None,
    point_spacing: _geometry(float, "mean distance of points [m].") = None,
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
    ) = None,
    forward_overlap: _geometry(float, "of consecutive images, 0 to 1.") = None,
    side_overlap: _geometry(float, "of neighbouring strips, 0 to 1.") = None,
    n_coverages: _geometry(int, "number of coverages of each flight.") = None,
    n_check: _geometry(
        int, "number of new points with given coordinates, as check points."
    ) = None,
    measurement: _geometry(
        Measurement,
        "contents of the tables: coordinates of oriented models, these with "
        "y-parallaxes, or image coordinates.",
    ) = None,
    transformation: _geometry(Transformation, "how models are fitted.") = None,
    control_standard_error: _noise(float, "of given coordinates, total [m].") = None,
    high_m_g_um: _noise(float, "of a measured point, total, in the image [µm].") = None,
    low_m_g_um: _noise(float, "the same for the low flight [µm].") = None,
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
    of geometry and noise that are omitted are those of the preset. With --repeat only
    repetitions.csv is written: for each seed the true and the claimed error of the new
    points.
    """
