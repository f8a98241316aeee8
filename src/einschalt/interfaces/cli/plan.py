"""``einschalt plan``: what precision a flight will give, before it is flown."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import tell, with_exit_status

# the values that planning knows: it is not imported here, so that help comes at once
Kind = Literal["affine", "helmert", "rigid"]
Edge = Literal["kovarik", "mid_edge", "corner", "lattice"]
CameraName = Literal[
    "film_wide",
    "film_normal",
    "film_super_wide",
    "ultracam_eagle",
    "dmc_3",
    "uav_full_frame",
    "uav_one_inch",
]


def _values(text, *names):
    shown = "values as 6000,8000 or first:last:step"
    return Annotated[
        list[str] | None,
        typer.Option(*names, metavar="VALUES", show_default=False, help=text + shown),
    ]


def _number(text, *names):
    return Annotated[
        float | None,
        typer.Option(*names, show_default="that of the camera", help=text),
    ]


@with_exit_status
def plan(
    scale_number: _values(
        "Denominators of the image scale: ", "--scale-number", "--scale"
    ) = None,
    spacing: _values(
        "Mean distances of points [m]: ", "--spacing", "--point-spacing"
    ) = None,
    m_0: _values("Total errors of approximate coordinates [m]: ", "--m-0") = None,
    m_g_um: _values(
        "Total errors of a measured point in the image [µm]: ", "--m-g-um"
    ) = None,
    kind: Annotated[
        Kind, typer.Option("--kind", "--transformation", help="How models are fitted.")
    ] = "affine",
    edge: Annotated[
        Edge,
        typer.Option(
            help="Where the edge of a model is: by the rule of 1971, or in its "
            "geometry with points evenly spread or on a lattice."
        ),
    ] = "kovarik",
    camera: Annotated[CameraName, typer.Option(help="Camera and usual flight.")] = (
        "film_wide"
    ),
    image_format: Annotated[
        str | None,
        typer.Option(
            show_default="that of the camera",
            help="Side of the image [mm], or ALONGxACROSS the strip, as 68.0x105.8.",
        ),
    ] = None,
    principal_distance: _number("Principal distance [mm].") = None,
    forward_overlap: _number("Of consecutive images, 0 to 1.") = None,
    side_overlap: _number("Of neighbouring strips, 0 to 1.") = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Table to write, as plan.csv or plan.parquet."
        ),
    ] = None,
):
    """Say what precision a flight will give, before it is flown.

    Tables of points in a model, of the transformation's error, and of the total error
    in the middle and at the edge of models, after Kovarik 1971; and the scale beyond
    which a lower flight loses accuracy. What is left out is that of the camera.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces.cli.plan_values import flight_of, numbers  # noqa: PLC0415
    from einschalt.pipeline.camera_presets import DEFAULT_M_0  # noqa: PLC0415
    from einschalt.pipeline.planning import (  # noqa: PLC0415
        best_columns,
        frame_of,
        precision_table,
    )
    from einschalt.pipeline.planning_text import describe_table  # noqa: PLC0415

    given = {
        "image_format": image_format,
        "principal_distance": principal_distance,
        "forward_overlap": forward_overlap,
        "side_overlap": side_overlap,
    }
    flight = flight_of(camera, kind, edge, given)
    preset = flight.preset
    axes = {
        "scale_number": numbers("--scale-number", scale_number, preset.scale_numbers),
        "spacing": numbers("--spacing", spacing, preset.spacings),
        "m_0": numbers("--m-0", m_0, DEFAULT_M_0),
        "m_g_um": numbers("--m-g-um", m_g_um, preset.m_g_um),
    }
    table = precision_table(axes, flight.model, flight.principal_distance)
    best = best_columns(axes, flight.model, flight.principal_distance)
    tell(describe_table(table, best))
    if output is not None:
        # imported when a table is written: the text needs no pandas
        from einschalt.interfaces.files.tables_by_suffix import (  # noqa: PLC0415
            write_table,
        )

        write_table(frame_of(table.columns()), output)
        tell(f"\nTable in {output}")
