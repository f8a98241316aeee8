"""What ``einschalt transform`` does."""

from dataclasses import replace

import typer

from einschalt.foundations.errors import (
    SettingsError,
    TableError,
    name_some,
    raise_problems,
)
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, translated
from einschalt.foundations.projections import label_of
from einschalt.foundations.tables import Column, Schema, check_table
from einschalt.interfaces.cli.exits import WRONG, print_error, print_out
from einschalt.interfaces.cli.outcome import report, report_problems
from einschalt.interfaces.files.table_output import output_of_tables, write_tables_of
from einschalt.interfaces.files.tables_by_suffix import (
    understand_table,
    write_in_both_formats,
)
from einschalt.interfaces.files.written_files import PROVENANCE
from einschalt.interfaces.publication.operations_of_results import Frames
from einschalt.interfaces.publication.publish import require_name
from einschalt.interfaces.publication.published_results import (
    DISTRIBUTION,
    IDENTICAL,
    TRIANGLES,
    identical_points,
    transform_models,
)
from einschalt.interfaces.publication.published_results import publish as publish_result
from einschalt.interfaces.publication.stated_systems import (
    require_places,
    require_systems,
)
from einschalt.stages.transformation_kinds import (
    TRANSFORMATION_KINDS,
    ground_schema,
    model_schema,
)
from einschalt.stages.triangulated_transformation import CONTRADICTS, CORNERS

ONE_MODEL = "1"
NONE_DONE = mark("einschalt: no model could be transformed; failures.csv says why")
WITHOUT_MODELS = mark("note: {file} has no column model_id: it is one model")
AXES = {"x": "easting", "y": "northing", "z": "height"}  # of models, and of old frames
TABLES = ("parameters", "models", "residuals", "failures", "points", IDENTICAL)
OF_DISTRIBUTION = (TRIANGLES, DISTRIBUTION, "left_out")
NAMES = (
    *(
        f"{name}{suffix}"
        for name in (*TABLES, *OF_DISTRIBUTION)
        for suffix in (".csv", ".parquet")
    ),
    PROVENANCE,
)
NAMES_OF_CORNERS = ("model_id", "point_id", *CORNERS)
CORNERS_GIVEN = Schema(
    "triangles", tuple(Column(name, "id") for name in NAMES_OF_CORNERS), ()
)
FEW_LEFT_OUT, MANY_LEFT_OUT = 0.01, 0.1  # shares of the identical points
# a tenth of a millimetre, and a hundredth of it for what is small
DECIMALS = {
    **dict.fromkeys(("easting", "northing", "height"), 4),
    **dict.fromkeys(("residual_easting", "residual_northing", "residual_height"), 5),
    **dict.fromkeys(("m_0", "s_0", "m_t"), 5),
    **dict.fromkeys(("standard_error_easting", "standard_error_northing"), 5),
    **dict.fromkeys(("leverage", "redundancy_number", "deviation"), 4),
}


def transform(
    model_points,
    ground_points,
    apply,
    output,
    kind,
    distribute,
    cell,
    triangles,
    outliers,
    publish,
    crs,
    source_crs,
    *,
    overwrite,
):
    """Fit one transformation per model, and write and print what it gives.

    Without ``apply`` the points of the models are transformed.
    """
    _require_options(distribute, cell, publish, crs, source_crs)
    files = (model_points, ground_points, apply, triangles)
    place = output_of_tables("transform", files, NAMES, output, overwrite=overwrite)
    source, target, applied = _read(model_points, ground_points, apply, kind)
    if publish is not None:
        frames, names = Frames(publish, crs, source_crs), (model_points, ground_points)
        require_places(source, target, frames, [file.name for file in names])
    fit = transform_models(source, target, kind=kind)
    if fit.is_usable and distribute != "none":
        options = {"method": distribute, "outliers": outliers, "cell": cell}
        fit = fit.distributed(_triangles(triangles), **options)
    tables = _tables(fit, source, applied, apply or model_points)
    write_tables_of(
        place, output, lambda new: write_in_both_formats(tables, new, decimals=DECIMALS)
    )
    n_usable = int(fit.models["is_usable"].sum())
    report(output, n_models=len(fit.models), n_usable=n_usable, m_0=fit.m_0)
    print_out(fit.summary())
    _say_what_is_left_out(fit, distribute, outliers)
    _say_what_is_outside(fit, tables["points"])
    if len(fit.models) == 1 and fit.is_usable and distribute == "none":
        pipeline = fit.proj_pipeline(fit.models["model_id"][0])
        print_out(f"\n{translated('As a PROJ pipeline:')}\n{pipeline}")
    print_out("\n" + translated("Results in {folder}", folder=output))
    if not fit.is_usable:
        report_problems("no model could be transformed")
        print_error(translated(NONE_DONE))
        raise typer.Exit(WRONG)
    if publish is not None:
        published = publish_result(
            output,
            publish,
            output / publish,
            crs=crs,
            source_crs=source_crs,
            overwrite=overwrite,
        )
        report_problems(*published.doubts)
        print_out(f"\n{published}")


def _require_options(distribute, cell, publish, crs, source_crs):
    """Refuse options that are none, or would say nothing."""
    if cell is not None and distribute in ("none", TRIANGLES):
        raise SettingsError(
            f"--cell is given, with --distribute {distribute}",
            expected="none: only collocation and natural_neighbour have a grid",
        )
    if publish is not None:
        require_name(publish)
        require_systems(crs, source_crs)
        return
    named = {"--crs": crs, "--source-crs": source_crs}
    for option, system in named.items():
        if system is not None:
            raise SettingsError(
                f"{option} {label_of(system)} is given, without --publish",
                expected="none: points stay in the systems of their tables",
                remedy=f"Publish the transformation with --publish, or take {option} "
                "out",
            )


def _say_what_is_left_out(fit, distribute, outliers):
    """Say why identical points took no part, where they are many."""
    left_out = getattr(fit, "left_out", None)
    n_points = len(fit.observed.rows)
    if left_out is None or len(left_out) <= FEW_LEFT_OUT * n_points:
        return
    message = mark("{n} of {n_all:identical point|identical points} left out")
    said = translated(message, n=len(left_out), n_all=n_points)
    if not (left_out["reason"] == CONTRADICTS).all():
        folds = translated(
            "with them the transformation folds, and could not be undone"
        )
        said += f": {folds}"
    is_kept = outliers == "keep" or (distribute == TRIANGLES and outliers is None)
    if is_kept:
        finds = translated(
            "--outliers set_aside finds wrong ones before anything folds"
        )
        said += f"; {finds}"
    message = mark("note: {said}; reasons are in left_out.csv")
    if len(left_out) > MANY_LEFT_OUT * n_points:
        message = mark(
            "warning: {said}. Do not use it before you know why; reasons are in "
            "left_out.csv"
        )
    print_error(translated(message, said=said))


def _say_what_is_outside(fit, points):
    """Count the points that got no coordinates from a model that is usable."""
    usable = fit.models.loc[fit.models["is_usable"].astype(bool), "model_id"]
    lacks = points["easting"].isna() & points["model_id"].isin(usable)
    if lacks.any():
        outside = points.loc[lacks, "point_id"]
        message = mark(
            "note: {n} of {n_all:point|points} lie outside, without coordinates: "
            "{names}"
        )
        if len(outside) == 1:
            message = mark(
                "note: {n} of {n_all:point|points} lies outside, without coordinates: "
                "{names}"
            )
        facts = {"n": len(outside), "n_all": len(points)}
        print_error(translated(message, names=retold(name_some(outside)), **facts))


def _tables(fit, source, applied, apply_file):
    """Everything that is written, by name."""
    try:
        points = fit.transform(applied)
    except TableError as error:  # a model that was not fitted, or in which coverage
        raise error.with_facts(file=apply_file.name) from None
    tables = {
        "parameters": _parameters(fit),
        "models": fit.models,
        "residuals": fit.residuals,
        "failures": fit.failures,
    }
    if hasattr(fit, "nets"):
        tables |= {TRIANGLES: fit.triangles, "left_out": fit.left_out}
    if hasattr(fit, "grids"):
        tables |= {DISTRIBUTION: fit.distribution, "left_out": fit.left_out}
    keyed = {name: _with_given_keys(table, source) for name, table in tables.items()}
    return keyed | {"points": points, IDENTICAL: identical_points(fit)}


def _triangles(file):
    """Read the triangles that the user gives, as text."""
    if file is None:
        return None
    return understand_table(file, CORNERS_GIVEN).frame


def _read(model_file, ground_file, apply_file, kind):
    """Read and check all files, and raise all their problems together."""
    of_models = model_schema(TRANSFORMATION_KINDS[kind])
    models = _checked(model_file, of_models)
    ground = _checked(ground_file, ground_schema(TRANSFORMATION_KINDS[kind]))
    if apply_file is None:
        raise_problems([*models.problems, *ground.problems])
        source = _of_model(models.frame, ONE_MODEL)
        return source, ground.frame, source
    applied = _checked(apply_file, of_models)
    raise_problems([*models.problems, *ground.problems, *applied.problems])
    source = _of_model(models.frame, ONE_MODEL)
    if "model_id" in applied.frame:
        return source, ground.frame, applied.frame
    only = _only_model(source, model_file, apply_file)
    return source, ground.frame, _of_model(applied.frame, only)


def _of_model(points, model_id):
    """Say the model of points that were given without one."""
    return points if "model_id" in points else points.assign(model_id=model_id)


def _only_model(models, model_file, apply_file):
    """Name the model to which points without a model_id belong."""
    model_ids = models["model_id"].unique()
    if len(model_ids) == 1:
        return model_ids[0]
    raise TableError(
        f"it has no column model_id, and {model_file.name} holds "
        f"{len(model_ids)} models",
        expected="the model by which each point is to be transformed",
        remedy=f"Add a column model_id, such as {model_ids[0]!r}",
        file=apply_file.name,
    )


def _checked(file, schema):
    """Check one table, with no more columns than were given."""
    read = _of_frame(file, schema, understand_table(file, schema))
    raw = read.frame
    if "model_id" in schema.names and "model_id" not in raw:
        print_error(translated(WITHOUT_MODELS, file=file.name))
        schema = schema.without("model_id")
    checked = check_table(raw, schema, source=file.name)
    for note in (*read.notes, *checked.notes):
        print_error(translated("note: {note}", note=retold(note)))
    # coverages that were not given shall not stand in the results
    given = [name for name in checked.frame if name in raw]
    return replace(checked, frame=checked.frame[given])


def _of_frame(file, schema, read):
    """Points of an old frame: its easting and northing are the x and y of a model."""
    if not {"x", "y"} <= set(schema.names) - set(read.frame):
        return read
    ground = understand_table(file, ground_schema(TRANSFORMATION_KINDS["helmert_3d"]))
    if not {"easting", "northing"} <= set(ground.frame):
        return read
    named = {new: old for new, old in AXES.items() if old in ground.frame}
    taken = ", ".join(f"{new} = {old}" for new, old in named.items())
    frame = ground.frame.rename(columns={old: new for new, old in named.items()})
    notes = (*ground.notes, f"{file.name}: {taken}, as coordinates of the old frame")
    return replace(ground, frame=frame, notes=notes)


def _with_given_keys(table, points):
    """Leave out the coverages of models whose table has none."""
    return table if "coverage" in points else table.drop(columns="coverage")


def _parameters(fit):
    """Parameters beside the names of their models; both have the same order."""
    parameters = fit.parameters.reset_index(drop=True)
    return fit.models[["coverage", "model_id"]].join(parameters)
