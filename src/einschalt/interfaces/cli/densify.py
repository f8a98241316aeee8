"""``einschalt densify``: a block's coordinates, with tables, map and report."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import tell, with_exit_status
from einschalt.interfaces.cli.paths import output_option, overwrite_option
from einschalt.interfaces.cli.progress import stage_progress

# the values that Settings allows: it is not imported here, so that help comes at once
Method = Literal["pipeline", "simultaneous"]
CoverageMean = Literal["all", "most_central"]
Weighting = Literal["plain", "weighted"]
ModelDeformation = Literal["modelled", "tested", "ignored"]
VarianceComponents = Literal["given", "estimated"]
Outliers = Literal["keep", "snoop", "huber", "tukey"]
Distribution = Literal["none", "natural_neighbour", "inverse_distance", "multiquadric"]
Screening = Literal["propagated", "practice_1968", "off"]
TOLERANCE = (
    "Total standard error that a point may have: metres, or vermv_1994, vermv_2010, "
    "vermv_2016."
)


def _option(kind, text):
    return Annotated[
        kind | None, typer.Option(show_default="that of block.toml", help=text)
    ]


@with_exit_status
def densify(
    block: Annotated[
        Path,
        typer.Argument(metavar="BLOCK", help="Folder of the block, or block.toml."),
    ],
    output: Annotated[Path, output_option("Folder for the results.")],
    method: _option(
        Method,
        "The two-step way of 1971, or all models of all flights in one adjustment.",
    ) = None,
    coverage_mean: _option(
        CoverageMean,
        "Values that make a point's mean: of every model, or per coverage of the most "
        "central one (1971).",
    ) = None,
    weighting: _option(Weighting, "Arithmetic mean, or weights 1 / M².") = None,
    outliers: _option(
        Outliers,
        "Gross errors of the low flight: named only, taken out one by one, or given "
        "less weight by a robust norm.",
    ) = None,
    screening: _option(
        Screening,
        "Limits of the differences of a point's coverages: from the propagated "
        "precision, three standard errors as in 1968, or none.",
    ) = None,
    iterations: _option(
        int,
        "How often the low flight is transformed at most, each time onto the "
        "coordinates that it gave, with control held.",
    ) = None,
    model_deformation: _option(
        ModelDeformation,
        "With method simultaneous: deformations that all models of a flight share are "
        "modelled where a test finds them, only tested, or neither.",
    ) = None,
    variance_components: _option(
        VarianceComponents,
        "With method simultaneous: errors of control and flights as they were given, "
        "or as the residuals show them.",
    ) = None,
    significance: _option(
        float,
        "Probability with which a model or point without gross errors is suspect.",
    ) = None,
    residual_distribution: _option(
        Distribution,
        "Distribute the residuals of control points to the points between them, for a "
        "cadastre that must fit.",
    ) = None,
    tolerance: _option(str, TOLERANCE) = None,
    confidence: _option(
        float, "Probability with which the confidence ellipses hold the true point."
    ) = None,
    ellipse_scale: Annotated[
        float | None,
        typer.Option(
            show_default="a round factor that makes them visible",
            help="How much larger the ellipses are drawn in block.gpkg.",
        ),
    ] = None,
    overwrite: Annotated[bool, overwrite_option()] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")
    ] = False,
):
    """Compute a block's points, and how good they are.

    Writes points, models, residuals, orientations (each .csv and .parquet),
    failures.csv, block.gpkg, report.html, summary.txt and provenance.json. Results of
    the same block are replaced; a folder with anything else is refused. Models that
    fail do not stop the others; they are said, and the exit status is 0.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces import python_api  # noqa: PLC0415
    from einschalt.interfaces.files.ellipse_layer import (  # noqa: PLC0415
        require_scale,
    )
    from einschalt.interfaces.files.output_folder import held_folder  # noqa: PLC0415
    from einschalt.interfaces.files.result_folder import (  # noqa: PLC0415
        output_of,
        write_result,
    )

    # before the work, which would be lost
    require_scale(ellipse_scale)
    read = python_api.read_block(block)
    chosen = {
        "method": method,
        "coverage_mean": coverage_mean,
        "weighting": weighting,
        "outliers": outliers,
        "screening": screening,
        "iterations": iterations,
        "model_deformation": model_deformation,
        "variance_components": variance_components,
        "significance": significance,
        "residual_distribution": residual_distribution,
        "tolerance": tolerance,
        "confidence": confidence,
    }
    given = {name: value for name, value in chosen.items() if value is not None}
    settings = type(read.settings)(**{**read.settings.model_dump(), **given})
    with (
        held_folder(output, output_of(read, overwrite=overwrite)),
        stage_progress(is_quiet=quiet) as progress,
    ):
        result = python_api.densify(read, settings, progress=progress)
        progress("writing", 1.0)
        options = {"ellipse_scale": ellipse_scale, "overwrite": overwrite}
        write_result(result, output, **options, beside=True)
    if not quiet:
        tell(result.summary())
        tell(f"Results in {output}, report in {output / 'report.html'}")
