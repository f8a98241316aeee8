"""block.gpkg: the result as map layers that QGIS opens styled.

Layers: ``points``, with all that is known of them; ``residual_vectors``, from the given
to the transformed coordinates, exaggerated as their description says; ``ellipses``,
confidence ellipses of the points, exaggerated as well; ``models``, the outline of the
points of each model. Coordinates are in the system of the results, or in
an engineering system where it has none. Equal results give equal files: the dates in
the file are fixed, the real one stands in provenance.json.
"""

import shutil
import sqlite3
import tempfile
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa

from einschalt.foundations.frame_columns import columns_of, values_of, with_columns
from einschalt.foundations.key_columns import row_codes
from einschalt.foundations.names import rows_of_names
from einschalt.foundations.projections import read_crs
from einschalt.interfaces.files import map_shapes
from einschalt.interfaces.files.arrow_columns import table_as_arrow
from einschalt.interfaces.files.atomic import replacing
from einschalt.interfaces.files.ellipse_layer import ellipse_layer
from einschalt.interfaces.files.gdal_files import written
from einschalt.interfaces.files.map_layers import Layer, exaggeration
from einschalt.interfaces.files.qgis_styles import add_styles, claim_of

GEOMETRY = "geom"
DATE = "1970-01-01T00:00:00.000Z"
# the file is forced to the disk once, when it is whole
GDAL_OPTIONS = {
    "OGR_CURRENT_DATE": DATE,
    "OGR_SQLITE_SYNCHRONOUS": "OFF",
    "OGR_SQLITE_JOURNAL": "MEMORY",
}
LOCAL_SYSTEM = (
    'ENGCRS["Local system, not georeferenced",EDATUM["Unknown"],CS[Cartesian,2],'
    'AXIS["easting (E)",east,ORDER[1],LENGTHUNIT["metre",1]],'
    'AXIS["northing (N)",north,ORDER[2],LENGTHUNIT["metre",1]]]'
)
MODEL_KEY = ["flight", "coverage", "model_id"]


def write_geopackage(result, path, *, ellipse_scale=None):
    """Write a result as GeoPackage, whole or not at all.

    Without ``ellipse_scale`` a round factor makes the confidence ellipses visible.
    """
    positions = _positions(result)
    layers = [
        _models_layer(result, positions),
        _residuals_layer(result, positions),
        ellipse_layer(result, ellipse_scale),
        _points_layer(result),
    ]
    columns = {one.name: distinct_names(one.attributes) for one in layers}

    def finish(file):
        add_styles(file, DATE, columns, claim_of(result))

    write_layers(layers, result.crs, path, finish)


def write_layers(layers, crs_name, path, finish=None):
    """Write layers as GeoPackage, whole or not at all.

    ``crs_name``: None for a local system. ``finish(file)`` adds to the file.
    """
    # imported when a file is written: GDAL takes its time
    import pyogrio  # noqa: PLC0415

    crs = LOCAL_SYSTEM if crs_name is None else read_crs(crs_name).to_wkt()
    with (
        replacing(path) as hidden,
        written(path, (RuntimeError, sqlite3.Error)),
        _gdal_options(pyogrio),
        _readable(hidden) as file,
    ):
        for layer in layers:
            pyogrio.write_arrow(
                _as_arrow(layer),
                file,
                layer=layer.name,
                driver="GPKG",
                geometry_name=GEOMETRY,
                geometry_type=layer.geometry_type,
                crs=crs,
                append=layer is not layers[0],
                layer_options={"DESCRIPTION": layer.description},
                # readers of 2018 open it as well, such as QGIS 3.22
                dataset_options={"VERSION": "1.2"},
            )
        if finish is not None:
            finish(file)


@contextmanager
def _readable(path):
    """Write under a name that GDAL can read, where a folder has one that it cannot."""
    if str(path).isprintable() and "!" not in str(path):  # which parts zip archives
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "block.gpkg"
        yield file
        shutil.copyfile(file, path)


@contextmanager
def _gdal_options(pyogrio):
    before = {name: pyogrio.get_gdal_config_option(name) for name in GDAL_OPTIONS}
    pyogrio.set_gdal_config_options(GDAL_OPTIONS)
    try:
        yield
    finally:
        pyogrio.set_gdal_config_options(before)


def _as_arrow(layer):
    table = table_as_arrow(layer.attributes)
    names = distinct_names(table.column_names)
    return pa.table([*table.columns, layer.geometries], names=[*names, GEOMETRY])


def distinct_names(names):
    """Tell column names apart that SQLite, which ignores case, takes for one.

    The second of two equal names, and those that GDAL keeps for itself, bear a number.

    >>> distinct_names(["x", "X", "fid"])
    ['x', 'X_2', 'fid_2']
    """
    taken = {"fid", GEOMETRY}
    distinct = []
    for name in map(str, names):
        number = 2
        free = name
        while free.casefold() in taken:
            free = f"{name}_{number}"
            number += 1
        taken.add(free.casefold())
        distinct.append(free)
    return distinct


def _positions(result):
    """Easting and northing of every point that has any, the best first."""
    plane = ["point_id", "easting", "northing"]
    known = (result.approximations, result.control_points, result.points)
    table = pd.concat([columns_of(one, plane) for one in known if one is not None])
    return table.drop_duplicates("point_id").set_index("point_id")


def _plane(frame):
    return values_of(frame, ["easting", "northing"])


def _points_layer(result):
    xyz, kind = _plane(result.points), "Point"
    if "height" in result.points and result.points["height"].notna().all():
        height = result.points["height"].to_numpy(dtype=float)
        xyz, kind = np.column_stack([xyz, height]), "Point Z"
    return Layer(
        "points",
        result.points,
        map_shapes.points(xyz),
        kind,
        "Densified points; lengths in metres, standard errors total",
    )


def _residuals_layer(result, positions):
    residuals = result.residuals
    given = _plane(positions.reindex(residuals["point_id"]))
    shift = values_of(residuals, ["residual_easting", "residual_northing"])
    factor = exaggeration(_plane(result.points), shift)
    return Layer(
        "residual_vectors",
        with_columns(residuals, exaggeration=factor),
        map_shapes.lines(np.stack([given, given + factor * shift], axis=1)),
        "LineString",
        f"Residuals, transformed minus given, drawn {factor:g} times as long",
    )


def _models_layer(result, positions):
    flights = result.block.flights.items()
    held = pd.concat(
        [with_columns(f.model_table(), flight=name) for name, f in flights]
    )
    group, _ = pd.factorize(row_codes([held[name] for name in MODEL_KEY]))
    is_first = ~pd.Series(group).duplicated().to_numpy()
    models = columns_of(held, MODEL_KEY)[is_first]
    place = rows_of_names(held["point_id"], positions.index)
    xy = np.vstack([_plane(positions), [[np.nan, np.nan]]])[place]
    is_known = ~np.isnan(xy[:, 0])
    order = np.argsort(group[is_known], kind="stable")
    xy = xy[is_known][order]
    return Layer(
        "models",
        _with_outcome(models, result),
        map_shapes.hulls(xy, group[is_known][order], len(models)),
        "Polygon",
        "Models, outlined by the ground coordinates of their points",
    )


def _with_outcome(models, result):
    """Join what became of each model; one that fell out early has its reason."""
    outcome = result.models.drop_duplicates(MODEL_KEY)
    joined = models.merge(outcome, how="left", on=MODEL_KEY)
    joined["is_usable"] = joined["is_usable"].eq(True).astype(bool)
    if len(result.failures):
        early = result.failures.drop_duplicates(MODEL_KEY)
        reasons = models.merge(early[[*MODEL_KEY, "reason"]], how="left", on=MODEL_KEY)
        joined["reason"] = joined["reason"].fillna(reasons["reason"])
    return joined
