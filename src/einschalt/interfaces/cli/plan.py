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


def _expect(text):
    return Annotated[
        float | None, typer.Option(show_default=False, help=f"Expect: {text}.")
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
    target: Annotated[
        float | None,
        typer.Option(
            help="Wanted total error [m]: gives the cheapest flights that reach it."
        ),
    ] = None,
    where: Annotated[
        Literal["everywhere", "edge", "centre"],
        typer.Option(help="Target: place in the models where it holds."),
    ] = "everywhere",
    by: Annotated[
        Literal["expected", "paper"],
        typer.Option(help="Target: by what is to be expected, or the paper's formula."),
    ] = "expected",
    high_over_low: _values(
        "Target: scale number of the high flight over the low one's: "
    ) = None,
    n_settings: _values("Target: how often points are set: ") = None,
    n_coverages: _values("Target, expect: how often the flights cover the area: ") = (
        None
    ),
    control_per_model: _values(
        "Target, expect: control in each high-flight model, 5 or 9: "
    ) = None,
    control_standard_error: Annotated[
        float, typer.Option(help="Target, expect: total error of control [m].")
    ] = 0.03,
    expect: Annotated[
        bool,
        typer.Option(
            "--expect",
            help="Expected precision of one block, by propagation on its layout.",
        ),
    ] = False,
    high_scale_number: _expect("scale number of the high flight") = None,
    high_m_g_um: _expect("measuring error in the high flight [µm]") = None,
    width: _expect("extent of the area from west to east [m]") = None,
    height: _expect("extent of the area from south to north [m]") = None,
    terrain: Annotated[
        Path | None,
        typer.Option(
            help="Table model_id, h1 … h6, heights in the standard points [m]: says "
            "which models come near a dangerous surface."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="plan.csv or plan.parquet for the table; a folder for tables, "
            "figures and summary.",
        ),
    ] = None,
):
    """Say what precision a flight will give, before it is flown.

    Tables of points in a model, of the transformation's error, and of the total error
    in the middle and at the edge of models, after Kovarik 1971; and the scale beyond
    which a lower flight loses accuracy. What is left out is that of the camera.

    With --target the cheapest flights that reach a precision; with --expect the
    precision of one block with all that its points share; with --terrain dangerous
    surfaces as well.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces.cli import plan_answers  # noqa: PLC0415
    from einschalt.interfaces.cli.plan_values import flight_of  # noqa: PLC0415

    given = {
        "image_format": image_format,
        "principal_distance": principal_distance,
        "forward_overlap": forward_overlap,
        "side_overlap": side_overlap,
    }
    flight = flight_of(camera, kind, edge, given)
    asked = plan_answers.Asked(
        {
            "scale_number": scale_number,
            "spacing": spacing,
            "m_0": m_0,
            "m_g_um": m_g_um,
            "high_over_low": high_over_low,
            "n_settings": n_settings,
            "n_coverages": n_coverages,
            "control_per_model": control_per_model,
        },
        *(high_scale_number, high_m_g_um, width, height, control_standard_error),
    )
    if target is not None:
        answer = plan_answers.search(flight, asked, target, where, by)
    elif expect:
        answer = plan_answers.layout(flight, asked)
    else:
        answer = plan_answers.tables(flight, asked)
    if terrain is not None:
        answer = plan_answers.with_terrain(answer, terrain, flight, asked)
    tell(answer.text)
    if output is not None:
        _write(answer, output)
        tell(f"\nPlan in {output}")


def _write(answer, output):
    """Write one table, or a folder with everything."""
    # imported when something is written: the text needs no pandas
    from einschalt.interfaces.files import tables_by_suffix  # noqa: PLC0415
    from einschalt.interfaces.files.plan_folder import write_plan  # noqa: PLC0415

    if output.suffix:
        table = next(iter(answer.tables().values()))
        tables_by_suffix.write_table(table, output)
    else:
        write_plan(output, answer.tables(), answer.figures(), answer.text)
