"""``einschalt orient``: relative orientation; dangerous surfaces before a flight."""

from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import WRONG, complain, tell, with_exit_status
from einschalt.interfaces.cli.paths import output_option, overwrite_option

ONE_MODEL = "1"
METRES_PER_MM = 1e-3
WAYS = (
    "a TABLE of y-parallaxes with --base, a TABLE of image coordinates with "
    "--principal-distance or --camera, or --terrain with --principal-distance"
)


def _option(kind, text, *, panel):
    return Annotated[
        kind | None, typer.Option(show_default=False, help=f"{panel}: {text}")
    ]


def _parallaxes(kind, text):
    return _option(kind, text, panel="Parallaxes")


def _images(kind, text):
    return _option(kind, text, panel="Images")


def _terrain(kind, text):
    return _option(kind, text, panel="Terrain")


@with_exit_status
def orient(
    output: Annotated[Path, output_option("Folder for the results.")],
    measurements: Annotated[
        Path | None,
        typer.Argument(
            metavar="TABLE",
            help="Y-parallaxes: model_id, point_id, x, y, z, y_parallax [mm]; or image "
            "coordinates: model_id, point_id, x_left, y_left, x_right, y_right [mm]. "
            "CSV or Parquet; without model_id it is one model.",
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
        "how the elements are found (default: least_squares).",
    ) = None,
    principal_distance: _images(
        float, "principal distance [mm]; for terrain that of the camera to be flown."
    ) = None,
    estimator: _images(
        Literal["rigorous", "determinants"],
        "what is made smallest (default: rigorous).",
    ) = None,
    camera: _images(
        Path, "a camera.toml, in place of --principal-distance: TABLE in its pixels."
    ) = None,
    outliers: _images(
        Literal["keep", "snoop", "huber", "tukey"],
        "keep points that contradict their model, take them out, or give them less "
        "weight (default: keep).",
    ) = None,
    terrain: _terrain(
        Path, "instead of TABLE: model_id, h1 … h6, heights in standard points [m]."
    ) = None,
    scale_number: _terrain(float, "of the image scale in points 1 and 2.") = None,
    flying_height: _terrain(float, "above the points 1 and 2 [m].") = None,
    altitude: _terrain(float, "of the flight, in the system of heights [m].") = None,
    image_format: _terrain(float, "side of the image [mm] (default: 230).") = None,
    forward_overlap: _terrain(float, "0 to 1 (default: 0.6).") = None,
    wing: _terrain(
        float, "points 3 to 6 from the base in the image [mm] (default: 100)."
    ) = None,
    overwrite: Annotated[bool, overwrite_option()] = False,
):
    """Orient image pairs, and say which are near a dangerous surface.

    With --base from y-parallaxes, y of the moved bundle less y of the fixed one; with
    --principal-distance from image coordinates; with --terrain before the flight, from
    the heights below the two projection centres (h1, h2) and in the wings beside them
    (h3, h5 beside h1; h4, h6 beside h2).

    Writes parameters, cofactors, residuals, contradiction (of parallaxes), model_points
    and model_precision (of images), dangerous_surface and failures, each .csv and
    .parquet, summary.txt, provenance.json, residual_parallaxes.svg, and of the first
    six-point models Krames' construction. Results of the same tables are replaced; a
    folder with anything else is refused. Models that fail do not stop the others.
    """
    # imported when the command runs, so that help does not wait for it
    from einschalt.interfaces.files import orientation_folder as to  # noqa: PLC0415
    from einschalt.interfaces.files.table_output import results_of_tables  # noqa: PLC0415

    files = (measurements, terrain, camera, _base_table(base))
    results = results_of_tables("orient", files, to.NAMES, output, overwrite=overwrite)
    plan = {
        "scale_number": scale_number,
        "flying_height": flying_height,
        "altitude": altitude,
        "image_format": _in_metres(image_format),
        "forward_overlap": forward_overlap,
        "wing": _in_metres(wing),
    }
    if terrain is not None:
        _refuse("--terrain", TABLE=measurements, case=case, base=base)
        _refuse("--terrain", method=method, estimator=estimator, camera=camera)
        result = _forecast(terrain, _in_metres(principal_distance), _given(plan))
        write, more = to.write_forecast, ()
        is_done = True
    elif principal_distance is not None or camera is not None:
        _refuse("--principal-distance or --camera", method=method, **plan)
        options = {"case": case, "estimator": estimator, "outliers": outliers}
        seen_by = camera if principal_distance is None else principal_distance
        if principal_distance is not None:
            _refuse("--principal-distance", camera=camera)
        result, distance = _from_images(measurements, seen_by, base, _given(options))
        write, more = to.write_image_orientation, (distance,)
        is_done = bool(result.converged.any())
    else:
        _refuse("--base", estimator=estimator, outliers=outliers, **plan)
        options = _given({"case": case, "method": method})
        result, parallaxes = _from_parallaxes(measurements, base, options)
        write, more = to.write_parallax_orientation, (parallaxes,)
        is_done = result.is_usable
    results.write(write, result, *more)
    tell(result.summary())
    tell(f"\nResults in {output}")
    if not is_done:
        complain("einschalt: no model could be oriented; failures.csv says why")
        raise typer.Exit(WRONG)


def _base_table(base):
    """Table that a base names; it may be a number instead."""
    return Path(base) if base is not None and Path(base).is_file() else None


def _given(options):
    return {name: value for name, value in options.items() if value is not None}


def _in_metres(length_mm):
    return None if length_mm is None else length_mm * METRES_PER_MM


def _refuse(option, **others):
    """Refuse what says nothing beside an option."""
    # imported when the command runs, so that help does not wait for it
    from einschalt.foundations.errors import SettingsError  # noqa: PLC0415

    for name, value in others.items():
        if value is not None:
            said = name if name.isupper() else f"--{name.replace('_', '-')}"
            raise SettingsError(
                f"{said} is given beside {option}",
                expected=WAYS,
                remedy=f"Leave {said} out",
            )


def _require(value, name):
    # imported when the command runs, so that help does not wait for it
    from einschalt.foundations.errors import SettingsError  # noqa: PLC0415

    if value is None:
        raise SettingsError(f"{name} is missing", expected=WAYS)


def _forecast(terrain, principal_distance, plan):
    # imported when the command runs, so that help does not wait for it
    from einschalt.stages.relative_orientation.dangerous_surface import (  # noqa: PLC0415
        TERRAIN_HEIGHTS,
        FlightPlan,
        forecast_dangerous_surfaces,
    )

    _require(principal_distance, "--principal-distance")
    plan = FlightPlan(principal_distance=principal_distance, **plan)
    return forecast_dangerous_surfaces(_read(terrain, TERRAIN_HEIGHTS), plan)


def _from_parallaxes(file, base, options):
    # imported when the command runs, so that help does not wait for it
    from einschalt.foundations.tables import Y_PARALLAXES  # noqa: PLC0415
    from einschalt.stages.relative_orientation.orient_from_parallaxes import (  # noqa: PLC0415
        orient_from_parallaxes,
    )

    _require(file, "TABLE")
    _require(base, "--base")
    parallaxes = _read(file, Y_PARALLAXES)
    return orient_from_parallaxes(parallaxes, _base(base), **options), parallaxes


def _from_images(file, seen_by, base, options):
    """Orient images that were seen by a principal distance, or a camera's file."""
    # imported when the command runs, so that help does not wait for it
    from einschalt.foundations.errors import SettingsError  # noqa: PLC0415
    from einschalt.foundations.number_texts import is_number  # noqa: PLC0415
    from einschalt.foundations.tables import IMAGE_PAIRS  # noqa: PLC0415
    from einschalt.interfaces.files.camera_toml import read_camera  # noqa: PLC0415
    from einschalt.stages.relative_orientation.orient_from_images import (  # noqa: PLC0415
        orient_from_images,
    )

    _require(file, "TABLE")
    if base is not None and not is_number(base):
        raise SettingsError(
            f"--base = {base!r}", expected="the length of the base, beside images"
        )
    options["base_length"] = None if base is None else float(base)
    pairs, distance = _read(file, IMAGE_PAIRS), seen_by
    if isinstance(seen_by, Path):
        camera = read_camera(seen_by, seen_by.name)
        distance = camera.principal_distance_mm
        for names in (["x_left", "y_left"], ["x_right", "y_right"]):
            pairs[names] = camera.xy_from_measured(pairs[names].to_numpy(dtype=float))
    return orient_from_images(pairs, distance, **options), distance


def _base(text):
    """Take a base as it was written: a number, or the name of a table."""
    # imported when the command runs, so that help does not wait for it
    from einschalt.foundations.errors import SettingsError  # noqa: PLC0415
    from einschalt.foundations.number_texts import (  # noqa: PLC0415
        MEND,
        is_number,
        say_number,
    )
    from einschalt.foundations.tables import MODEL_BASES  # noqa: PLC0415
    from einschalt.interfaces.files.tables_by_suffix import read_table  # noqa: PLC0415

    if is_number(text):
        return float(text)
    if text[:1] in "+-.0123456789" and not Path(text).is_file():
        found, expected, remedy = say_number(text, "millimetres")
        remedy = "" if remedy == MEND else remedy
        raise SettingsError(
            f"--base: {found}", expected=f"{expected}, or a table", remedy=remedy
        )
    return read_table(Path(text), MODEL_BASES)


def _read(file, schema):
    """Read and check a table."""
    # imported when the command runs, so that help does not wait for it
    from einschalt.foundations.errors import raise_problems  # noqa: PLC0415
    from einschalt.foundations.tables import check_table  # noqa: PLC0415
    from einschalt.interfaces.files.tables_by_suffix import read_table  # noqa: PLC0415

    frame = read_table(file, schema)
    _refuse_other_kind(frame, schema, file.name)
    if _is_one_model(frame) and schema.name != "terrain":
        complain(f"note: {file.name} has no column model_id: it is one model")
        frame = frame.assign(model_id=ONE_MODEL)
    checked = check_table(frame, schema, source=file.name)
    raise_problems(checked.problems)
    for note in checked.notes:
        complain(f"note: {note}")
    # without the columns that the check has filled in
    return checked.frame[[name for name in checked.frame if name in frame]]


def _is_one_model(frame):
    """Whether a table says nothing of models, and could not hold several."""
    # a name that was only mistaken is told by the check of the columns
    if get_close_matches("model_id", [name.casefold() for name in frame], n=1):
        return False
    return "point_id" not in frame or not frame["point_id"].duplicated().any()


def _refuse_other_kind(frame, schema, file_name):
    """Refuse a table of image coordinates for parallaxes, or the other way round."""
    # imported when the command runs, so that help does not wait for it
    from einschalt.foundations.errors import SettingsError  # noqa: PLC0415
    from einschalt.foundations.tables import (  # noqa: PLC0415
        IMAGE_PAIRS,
        Y_PARALLAXES,
    )

    kinds = {
        Y_PARALLAXES: ("y-parallaxes", "Give --base for them"),
        IMAGE_PAIRS: ("image coordinates", "Give --principal-distance or --camera"),
    }
    if set(schema.number_names) <= set(frame):
        return
    for kind, (what, remedy) in kinds.items():
        if set(kind.number_names) <= set(frame):
            raise SettingsError(
                f"{file_name} holds {what}", expected=WAYS, remedy=remedy
            )
