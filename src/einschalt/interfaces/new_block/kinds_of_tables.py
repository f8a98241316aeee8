"""Kinds of tables that a block can have, and ground points that are of none.

Ground points have the unit of their system, where it is said; what their columns say
must not contradict it.
"""

from dataclasses import replace

from einschalt.foundations import tables
from einschalt.foundations.column_words import PLANE, in_other_unit
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    EinschaltError,
    FileError,
    TableError,
    name_some,
    raise_problems,
)
from einschalt.foundations.projections import read_source_crs
from einschalt.interfaces.files import point_layers
from einschalt.interfaces.files.points_of_systems import (
    GEOGRAPHIC,
    require_columns,
    schema_in,
)
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.files.written_angles import AnglesError

# by what they require, the most particular first
KINDS = {
    "y_parallaxes": tables.Y_PARALLAXES,
    "image_points": tables.IMAGE_POINTS,
    "models": tables.IMAGE_MODELS,
    "base": tables.MODEL_BASES,
    "model_points": tables.MEASURED_MODEL_POINTS,
    "ground": tables.CONTROL_POINTS,
}
MOST_OTHERS = 8
SAY_SYSTEM = (
    "Give --points-crs EPSG:4326, or the system of the receiver (in block.toml: crs of "
    "[control_points])"
)


def fitting_schema(kind, table, said):
    """Schema of a kind of table, in the system that its points have."""
    names = set(table.frame.columns)
    is_geographic = set(GEOGRAPHIC) <= names and kind == "ground"
    if not is_geographic:
        return meant_schema(kind, table.crs or said.crs, is_geographic=False)
    system = table.crs or said.crs
    if system is None or not read_source_crs(system).is_geographic:
        system = point_layers.WGS_84
    return meant_schema(kind, system)


def has_table_of(kind, table, said):
    """Whether all columns are there, and something states the system of degrees."""
    names = {c.name for c in fitting_schema(kind, table, said).columns if c.is_required}
    is_geographic = set(GEOGRAPHIC) <= names
    system = table.crs or said.crs
    is_stated = system is not None and read_source_crs(system).is_geographic
    return names <= set(table.frame) and (is_stated or not is_geographic)


def meant_schema(kind, crs, *, is_geographic=None):
    """Schema of a kind of table in a system: ground points have its unit.

    ``is_geographic``: of the columns, where they are known.
    """
    schema = KINDS[kind]
    if kind != "ground" or crs is None:
        return schema
    system = read_source_crs(crs)
    if is_geographic is not None and system.is_geographic != is_geographic:
        return schema
    return schema_in(schema, system)


def refuse_other_coordinates(file, said):
    """Refuse ground points in another unit, or in another kind of system.

    Nothing is done where a file holds no ground points.
    """
    _refuse_other_unit(file, said)
    _refuse_degrees(file, said)
    if said.crs is not None:
        _refuse_plane(file, said)


def _refuse_other_unit(file, said):
    """Refuse points in a unit that has no one meaning, as Rechtswert [ft]."""
    for kind in KINDS:
        schema = meant_schema(kind, said.crs)
        own = replace(said, columns={})
        try:
            frame = understand_table(file, schema, own, source=file.source).frame
        except EinschaltError:  # another kind of table: that is said
            continue
        names = [c.name for c in schema.columns if c.is_required]
        lacking = [name for name in names if name not in frame]
        if lacking and all(in_other_unit(list(frame), schema, n) for n in lacking):
            checked = tables.check_table(frame, schema, source=file.source)
            raise_problems(checked.problems)


def _refuse_degrees(file, said):
    """Refuse longitudes and latitudes of which no file states the system."""
    if holds_degrees(file, said):
        raise _degrees_of_no_system(file.source)


def _degrees_of_no_system(source):
    return FileError(
        "holds longitudes and latitudes, and nothing tells of which system",
        expected="eastings and northings, or a layer that states its system",
        remedy=SAY_SYSTEM,
        file=source,
    )


def system_of_foreign(table, said, source):
    """System that is said of a table of another program: that of its degrees.

    A FileError where the table has degrees, and nothing tells of which system.
    """
    if table.crs is not None or not set(GEOGRAPHIC) <= set(table.frame):
        return said.crs
    system = said.degrees_crs or said.crs
    if system is None or not read_source_crs(system).is_geographic:
        raise _degrees_of_no_system(source)
    return system


def holds_degrees(file, said):
    """Whether a file has ground points whose columns are longitude and latitude."""
    schema = schema_in(KINDS["ground"], read_source_crs(point_layers.WGS_84))
    try:
        names = understand_table(file, schema, said, source=file.source).frame.columns
    except AnglesError:
        return True
    except EinschaltError:  # another kind of table: that is said
        return False
    return {c.name for c in schema.columns if c.is_required} <= set(names)


def refuse_nameless(file, said):
    """Refuse ground points that no column names.

    Nothing is done where a file holds no ground points.
    """
    try:
        frame = understand_table(file, KINDS["ground"], said, source=file.source).frame
    except EinschaltError:  # another kind of table: that is said
        return
    names = list(map(str, frame.columns))
    if not {*PLANE} <= {*names} or "point_id" in names:
        return
    others = [name for name in names if name and name not in KINDS["ground"].names]
    raise TableError(
        f"has eastings and northings, and none of its columns is known to name the "
        f"points: {name_some(map(repr, others), MOST_OTHERS) or 'there is no other'}",
        expected="a column such as point_id, Punktnummer or Name",
        remedy=f'Name it: columns = {{point_id = "{shortened(others[0])}"}} in '
        "block.toml"
        if others
        else "Add a column of names",
        file=file.source,
    )


def _refuse_plane(file, said):
    """Refuse eastings and northings that are said to be of a geographic system."""
    try:
        frame = understand_table(file, KINDS["ground"], said, source=file.source).frame
    except EinschaltError:  # another kind of table: that is said
        return
    require_columns(frame, read_source_crs(said.crs), file.source)
