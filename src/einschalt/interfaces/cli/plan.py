"""``einschalt plan``: what precision a flight will give, before it is flown."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal, get_args

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import Overwrite, optional

EXAMPLES = (
    "einschalt plan",
    "einschalt plan --scale-number 6000:12000:1000 --spacing 200,300 --m-0 0.10",
    "einschalt plan --camera ultracam_eagle --edge lattice --output plan.csv",
    "einschalt plan --target 0.05 --spacing 300 --output out/plan",
    "einschalt plan --target 5cm --area area.gpkg --output out/plan",
    "einschalt plan --expect --scale-number 8000 --spacing 300 --output out/plan",
    "einschalt plan --scale-number 6000,8000 --terrain heights.csv",
)

# the values that planning knows: it is not imported here, so that help comes at once
Kind = Literal["affine", "helmert", "rigid"]
Edge = Literal["kovarik", "mid_edge", "corner", "lattice"]
CameraName = Literal[
    "film_wide",
    "film_normal",
    "film_super_wide",
    "ultracam_eagle",
    "dmc_3",
    "ultracam_xp",
    "dmc_ii_250",
    "uav_full_frame",
    "uav_one_inch",
    "uav_four_thirds",
]


def _of_values(text, example):
    return f"{text}: values as {example} or first:last:step"


def _values(text, example, *names):
    return Annotated[
        list[str] | None,
        typer.Option(
            *names,
            metavar="VALUES",
            show_default=False,
            help=_of_values(text, example),
        ),
    ]


def _number(text, *names):
    return Annotated[
        float | None, typer.Option(*names, show_default="that of the camera", help=text)
    ]


_expect = partial(optional, "Expect", float)


@with_exit_status
@done_in_work
def plan(
    context: typer.Context,
    scale_number: _values(
        "Denominators of the image scale", "6000,8000", "--scale-number", "--scale"
    ) = None,
    spacing: _values(
        "Mean distances of points [m]", "200,300", "--spacing", "--point-spacing"
    ) = None,
    m_0: _values(
        "Total errors of approximate coordinates [m]", "0.05,0.1", "--m-0"
    ) = None,
    m_g_um: _values(
        "Total errors of a measured point in the image [µm]", "5,10", "--m-g-um"
    ) = None,
    kind: Annotated[
        Kind, typer.Option("--kind", "--transformation", help="How models are fitted.")
    ] = "affine",
    edge: Annotated[
        Edge,
        typer.Option(
            help="Definition of the edge of a model: by the rule of 1971, or by its "
            "geometry with points evenly distributed or on a lattice."
        ),
    ] = "kovarik",
    camera: Annotated[
        CameraName,
        typer.Option(
            metavar="CAMERA",
            case_sensitive=False,
            help=f"Camera and usual flight: {', '.join(get_args(CameraName))}.",
        ),
    ] = "film_wide",
    image_format: Annotated[
        str | None,
        typer.Option(
            show_default="that of the camera",
            help="Side of the image [mm], or ALONGxACROSS the strip, as 68.0x105.8.",
        ),
    ] = None,
    principal_distance: _number("Principal distance [mm].") = None,
    forward_overlap: _number("Of consecutive images, 0 to 1 or as 60%.") = None,
    side_overlap: _number("Of neighbouring strips, 0 to 1 or as 60%.") = None,
    target: Annotated[
        float | None,
        typer.Option(
            help="Required total error [m]: finds the cheapest flights that reach it."
        ),
    ] = None,
    where: Annotated[
        Literal["everywhere", "edge", "centre"],
        typer.Option(
            help="Target: part of each model in which the target must be kept: "
            "everywhere, at the edge, or in the centre. It counts with one coverage "
            "only; with several the target is the RMS of all points."
        ),
    ] = "everywhere",
    by: Annotated[
        Literal["expected", "paper"],
        typer.Option(
            help="Target: ranked by the expected precision, or by the paper's formula. "
            "Recommended is only what keeps the target on its own layout."
        ),
    ] = "expected",
    costs: Annotated[
        str,
        typer.Option(
            metavar="NAME=COST,…",
            help="Target: prices in any currency, per image flown, model oriented, "
            "pointing at a point (setting), and control point surveyed; plans are "
            "ranked by cost. Prices that are not given have the default.",
        ),
    ] = "image=10,model=20,setting=0.5,control_point=100",
    high_over_low: _values(
        "Target: ratio of the scale numbers of high and low flight", "1.5,2"
    ) = None,
    n_settings: _values("Target: number of pointings at each point", "2,4") = None,
    n_coverages: _values(
        "Target, expect: number of coverages of the area", "2,3"
    ) = None,
    control_per_model: _values(
        "Target, expect: control in each high-flight model, 5 or 9", "5,9"
    ) = None,
    control_standard_error: Annotated[
        float, typer.Option(help="Target, expect: total error of control [m].")
    ] = 0.03,
    max_height: Annotated[
        float | None,
        typer.Option(
            show_default="120 for UAVs, else none",
            help="Maximum height of both flights above ground [m]: plans keep it; "
            "other flights above it are reported.",
        ),
    ] = None,
    expect: Annotated[
        bool,
        typer.Option(
            "--expect",
            help="Expected precision of one block, by propagation on its layout.",
        ),
    ] = False,
    high_scale_number: _expect(
        "scale number of the high flight; if omitted, 1.875 times that of the low one."
    ) = None,
    high_m_g_um: Annotated[
        float | None,
        typer.Option(
            help="Target, expect: measuring error in the high flight [µm], of one "
            "pointing for a target; if omitted, that of the low flight."
        ),
    ] = None,
    width: _expect("extent of the area from west to east [m].") = None,
    height: _expect("extent of the area from south to north [m].") = None,
    area: Annotated[
        Path | None,
        typer.Option(
            help="With --target: polygon of the area (GeoPackage, GeoJSON, shapefile): "
            "gives flight lines, photographs and control over it, validated; with "
            "--output FOLDER flight_plan.gpkg and flight_plan.kml."
        ),
    ] = None,
    area_layer: optional("Area", str, "layer of a GeoPackage with several.") = None,
    crs: optional(
        "Area",
        str,
        "plane system of the plan, such as EPSG:31255; if omitted, that of the area, "
        "or its UTM zone where the area is in degrees.",
    ) = None,
    ground_heights: Annotated[
        Path | None,
        typer.Option(
            help="Area: heights of the terrain, GeoTIFF or XYZ or a table easting, "
            "northing, height; gives altitudes, and reports where overlaps are lost."
        ),
    ] = None,
    terrain: Annotated[
        Path | None,
        typer.Option(
            help="Table model_id, h1 … h6, heights in the standard points [m]: "
            "reports which models come near a dangerous surface."
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
    figure: Annotated[
        Path | None,
        typer.Option(
            help="plan.png or plan.svg: the diagrams; with --target plans by cost; "
            "with --expect the map of precision."
        ),
    ] = None,
    overwrite: Overwrite = False,
):
    """Predict the precision of a flight before it is flown.

    Prints tables of the number of points in a model, of the error of the
    transformation, and of the total error in the middle and at the edge of models,
    after Kovarik 1971; and the scale beyond which a lower flight loses accuracy.
    Defaults come from the camera preset.

    With --target it finds the cheapest flights that reach a precision; with --expect it
    predicts the precision of one block, including errors that its points share; with
    --terrain it also reports dangerous surfaces. simulate --plan FOLDER tries what
    --output has written into a folder.

    Exit status: 0 when the work was done, 1 when no plan reaches the target, 2 when the
    input or the call is wrong, 130 when interrupted.
    """
