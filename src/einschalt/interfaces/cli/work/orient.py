"""What ``einschalt orient`` does."""

from functools import partial
from pathlib import Path

import typer

from einschalt.foundations.errors import SettingsError, raise_problems
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, translated
from einschalt.foundations.near_words import nearest
from einschalt.foundations.number_parsing import MEND, describe_fault, is_number
from einschalt.foundations.tables import (
    IMAGE_PAIRS,
    MODEL_BASES,
    Y_PARALLAXES,
    check_table,
)
from einschalt.foundations.units import METRES_PER_MM
from einschalt.interfaces.cli.exits import WRONG, print_error, print_out
from einschalt.interfaces.cli.outcome import report, report_problems
from einschalt.interfaces.files import orientation_folder as to
from einschalt.interfaces.files.camera_toml import read_camera
from einschalt.interfaces.files.table_output import output_of_tables, write_tables_of
from einschalt.interfaces.files.tables_by_suffix import read_table, understand_table
from einschalt.stages.relative_orientation.dangerous_surface import (
    TERRAIN_HEIGHTS,
    FlightPlan,
    forecast_dangerous_surfaces,
)
from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)

ONE_MODEL = "1"
ONE_MODEL_SAID = mark("note: {file} has no column model_id: it is one model")
NONE_ORIENTED = mark("einschalt: no model could be oriented; failures.csv says why")
LENGTHS_MM = ("image_format", "wing")
WAYS = (
    "a TABLE of y-parallaxes with --base, a TABLE of image coordinates with "
    "--principal-distance or --camera, or --terrain with --principal-distance"
)


def orient(
    output,
    *,
    measurements,
    case,
    base,
    method,
    principal_distance,
    estimator,
    camera,
    outliers,
    terrain,
    overwrite,
    **plan,
):
    """Orient image pairs, or forecast dangerous surfaces; write and print the result.

    ``plan`` is the flight over the terrain, image_format and wing [mm].
    """
    files = (measurements, terrain, camera, _base_table(base))
    place = output_of_tables("orient", files, to.NAMES, output, overwrite=overwrite)
    for name in LENGTHS_MM:
        plan[name] = _in_metres(plan[name])
    if terrain is not None:
        _refuse("--terrain", TABLE=measurements, case=case, base=base)
        _refuse("--terrain", method=method, estimator=estimator, camera=camera)
        result = _forecast(terrain, _in_metres(principal_distance), _given(plan))
        write, is_done = partial(to.write_forecast, result), True
    elif principal_distance is not None or camera is not None:
        _refuse("--principal-distance or --camera", method=method, **plan)
        options = {"case": case, "estimator": estimator, "outliers": outliers}
        seen_by = camera if principal_distance is None else principal_distance
        if principal_distance is not None:
            _refuse("--principal-distance", camera=camera)
        result, distance = _from_images(measurements, seen_by, base, _given(options))
        write = partial(to.write_image_orientation, result, distance)
        is_done = bool(result.converged.any())
    else:
        _refuse("--base", estimator=estimator, outliers=outliers, **plan)
        options = _given({"case": case, "method": method})
        result, parallaxes = _from_parallaxes(measurements, base, options)
        write = partial(to.write_parallax_orientation, result, parallaxes)
        is_done = result.is_usable
    write_tables_of(place, output, write)
    report(output, n_models=len(result.models))
    print_out(result.summary())
    print_out()
    print_out(translated("Results in {folder}", folder=output))
    if not is_done:
        report_problems("no model could be oriented")
        print_error(translated(NONE_ORIENTED))
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
    for name, value in others.items():
        if value is not None:
            said = name if name.isupper() else f"--{name.replace('_', '-')}"
            raise SettingsError(
                f"{said} is given beside {option}",
                expected=WAYS,
                remedy=f"Leave {said} out",
            )


def _require(value, name):
    if value is None:
        raise SettingsError(f"{name} is missing", expected=WAYS)


def _forecast(terrain, principal_distance, plan):
    _require(principal_distance, "--principal-distance")
    plan = FlightPlan(principal_distance=principal_distance, **plan)
    return forecast_dangerous_surfaces(_read(terrain, TERRAIN_HEIGHTS), plan)


def _from_parallaxes(file, base, options):
    _require(file, "TABLE")
    _require(base, "--base")
    parallaxes = _read(file, Y_PARALLAXES)
    return orient_from_parallaxes(parallaxes, _base(base), **options), parallaxes


def _from_images(file, seen_by, base, options):
    """Orient images that were seen by a principal distance, or a camera's file."""
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
    if is_number(text):
        return float(text)
    if text[:1] in "+-.0123456789" and not Path(text).is_file():
        found, expected, remedy = describe_fault(text, "millimetres")
        remedy = "" if remedy == MEND else remedy
        raise SettingsError(
            f"--base: {found}", expected=f"{expected}, or a table", remedy=remedy
        )
    return read_table(Path(text), MODEL_BASES)


def _read(file, schema):
    """Read and check a table."""
    read = understand_table(file, schema)
    frame = read.frame
    _refuse_other_kind(frame, schema, file.name)
    if _is_one_model(frame) and schema.name != "terrain":
        print_error(translated(ONE_MODEL_SAID, file=file.name))
        frame = frame.assign(model_id=ONE_MODEL)
    checked = check_table(frame, schema, source=file.name)
    raise_problems(checked.problems)
    for note in (*read.notes, *checked.notes):
        print_error(translated("note: {note}", note=retold(note)))
    # without the columns that the check has filled in
    return checked.frame[[name for name in checked.frame if name in frame]]


def _is_one_model(frame):
    """Whether a table says nothing of models, and could not hold several."""
    # a name that was only mistaken is told by the check of the columns
    if nearest("model_id", list(frame)):
        return False
    return "point_id" not in frame or not frame["point_id"].duplicated().any()


def _refuse_other_kind(frame, schema, file_name):
    """Refuse a table of image coordinates for parallaxes, or the other way round."""
    kinds = {
        Y_PARALLAXES: (f"{file_name} holds y-parallaxes", "Give --base for them"),
        IMAGE_PAIRS: (
            f"{file_name} holds image coordinates",
            "Give --principal-distance or --camera",
        ),
    }
    if set(schema.number_names) <= set(frame):
        return
    for kind, (found, remedy) in kinds.items():
        if set(kind.number_names) <= set(frame):
            raise SettingsError(found, expected=WAYS, remedy=remedy)
