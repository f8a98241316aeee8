"""An auxiliary PROJ database: frames and operations of our own, found by name.

Where the environment variable PROJ_AUX_DB names it, PROJ (8.1 and later) reads it
beside its own: ``Transformer.from_crs("EINSCHALT:NAME", "EPSG:…")`` finds the
operation, and so does what is built on PROJ. It has the layout of the PROJ by which it
is written.
"""

import sqlite3
from contextlib import closing, contextmanager
from pathlib import Path

import pyproj

from einschalt.foundations.errors import FileError

AUTHORITY = "EINSCHALT"
KINDS = ("table", "view")
LIMITS = ("extent", "scope")
READS_GRIDS = (9, 4)
SWAPPED = "+step +proj=axisswap +order=2,1"
GEOGRAPHIC = "_GEOGRAPHIC"  # ends the codes of what frames are projected from


def write_database(path, operations, target, *, description, like=None):
    """Write frames and operations, all into one ``target`` (a pyproj.CRS).

    ``operations`` have code, title, frame and system (pyproj.CRS, in which steps begin
    and end), steps (of a PROJ pipeline, in easting and northing), accuracy_m, area.
    ``like``: the proj.db of the PROJ that is to read it, whose layout it gets; that of
    this one where left out.
    """
    with _written(path) as database:
        _copy_layout(database, like or own_database())
        code = _code_of_target(database, target, operations)
        # an authority that lists the northing first is given it first
        is_swapped = target.axis_info[0].direction == "north"
        for one in operations:
            _add_operation(database, one, code, description, is_swapped=is_swapped)
            _add_geographic(database, one, target, description)


def frame_wkt(operation):
    """WKT of the frame from which an operation leads, by the name of its authority."""
    return _named_frame(operation).to_wkt(pretty=True)


def _named_frame(operation):
    """The frame, and the one of longitudes from which it is projected, by our names."""
    content = operation.frame.to_json_dict()
    content["id"] = {"authority": AUTHORITY, "code": operation.code}
    base = {"authority": AUTHORITY, "code": operation.code + GEOGRAPHIC}
    content["base_crs"]["id"] = base
    return pyproj.CRS.from_json_dict(content)


@contextmanager
def _written(path):
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute("begin")  # the disk is waited for once, not for each table
        yield database
        database.execute("commit")


def own_database():
    """Path of the database of the PROJ that runs here."""
    return Path(pyproj.datadir.get_data_dir()) / "proj.db"


def require_database(path):
    """Refuse what is no database of PROJ."""
    try:
        with closing(_opened(path)) as known:
            known.execute("select key from metadata").fetchall()
    except sqlite3.Error as error:
        raise FileError(
            f"is no database of PROJ: {error}",
            expected="the file proj.db of the PROJ that is to use the publication",
            file=path,
        ) from error


def require_grids_are_read(path):
    """Refuse a PROJ that does not read grids of shifts in plane systems."""
    with closing(_opened(path)) as known:
        found = known.execute("select value from metadata where key = 'PROJ.VERSION'")
        version = (found.fetchone() or ("",))[0]
    parts = [int(part) for part in version.split(".")[:2] if part.isdecimal()]
    if len(parts) == 2 and tuple(parts) < READS_GRIDS:
        raise FileError(
            f"is of PROJ {version}, which reads no grids of shifts in plane systems",
            expected="PROJ 9.4 or later",
            remedy="Distribute in triangles: PROJ 7.2 and later read them",
            file=path,
        )


def _opened(path):
    return sqlite3.connect(f"{Path(path).absolute().as_uri()}?mode=ro", uri=True)


def _copy_layout(database, path):
    """Make the tables and views of a PROJ's own database, without their rows."""
    with closing(_opened(path)) as known:
        for kind in KINDS:
            made = known.execute(
                "select sql from sqlite_master where type = ? and sql is not null "
                "and name not like 'sqlite%'",
                (kind,),
            )
            for (statement,) in made:
                database.execute(statement)
        layout = known.execute(
            "select key, value from metadata where key like 'DATABASE.LAYOUT%'"
        )
        database.executemany("insert into metadata values (?, ?)", layout)


def _code_of_target(database, target, operations):
    known = target.to_authority(min_confidence=100)
    if known is not None:
        return known
    code = f"{operations[0].code}_TARGET"
    _insert(
        database,
        "projected_crs",
        **_own(code, target.name),
        text_definition=target.to_wkt(),
    )
    return AUTHORITY, code


def _add_operation(database, one, target, description, *, is_swapped):
    frame = _own(one.code, one.frame.name) | {"description": description}
    definition = _named_frame(one).to_wkt()
    _insert(database, "projected_crs", **frame, text_definition=definition)
    steps = f"+step {one.steps}"
    ends = (AUTHORITY, one.code), target
    _insert_steps(
        database,
        one,
        one.code,
        ends,
        f"{steps} {SWAPPED}" if is_swapped else steps,
        description,
    )
    _add_extent(database, one)
    _add_usages(database, one.code, one.code, ("projected_crs", "other_transformation"))


def _add_geographic(database, one, target, description):
    """Add the same operation between the geographic systems of both ends.

    Through these PROJ goes on to third plane systems. Without them it would take the
    two for the same ("ballpark"), some 100 m off; as it still does to other geographic
    systems, for which it seeks no way over a third one.
    """
    ends = target.geodetic_crs.to_authority(min_confidence=100)
    if ends is None:
        return
    frame = _named_frame(one)
    base, code = frame.geodetic_crs, one.code + GEOGRAPHIC
    _insert(
        database,
        "geodetic_crs",
        **_own(code, base.name),
        type="geographic 2D",
        text_definition=base.to_wkt(),
    )
    onto, off = (
        _steps_between(base, frame),
        _steps_between(one.system, target.geodetic_crs),
    )
    steps = f"{onto} +step {one.steps} {off}"
    ends = (AUTHORITY, code), ends
    _insert_steps(database, one, code, ends, steps, description)
    _add_usages(database, code, one.code, ("geodetic_crs", "other_transformation"))


def _steps_between(source, target):
    """Steps of a plane system and the geographic one from which it is projected."""
    way = pyproj.Transformer.from_crs(source, target).to_proj4()
    return "+step " + way.removeprefix("+proj=pipeline +step ")


def _insert_steps(database, one, code, ends, steps, description):
    (source, source_code), (target, target_code) = ends
    _insert(
        database,
        "other_transformation",
        **_own(code, one.title),
        description=description,
        method_auth_name="PROJ",
        method_code="PROJString",
        method_name=f"+proj=pipeline {steps}",
        source_crs_auth_name=source,
        source_crs_code=source_code,
        target_crs_auth_name=target,
        target_crs_code=target_code,
        accuracy=one.accuracy_m,
    )


def _add_extent(database, one):
    """Say where the frame and the operation are to be used."""
    west, south, east, north = one.area
    _insert(
        database,
        "extent",
        **_own(one.code, one.title),
        description=f"Identical points of {one.title}",
        south_lat=south,
        north_lat=north,
        west_lon=west,
        east_lon=east,
    )
    scope = {"auth_name": AUTHORITY, "code": one.code, "deprecated": 0}
    _insert(database, "scope", **scope, scope="As its publication says")


def _add_usages(database, code, limits, tables):
    """Say of what has a code in tables that it is used within limits (their code)."""
    for table in tables:
        named = {"object_table_name": table, "code": f"{code}_{table}"}
        parts = {f"{part}_auth_name": AUTHORITY for part in ("object", *LIMITS)}
        parts |= {f"{part}_code": limits for part in LIMITS} | {"object_code": code}
        _insert(database, "usage", auth_name=AUTHORITY, **named, **parts)


def _own(code, name):
    return {"auth_name": AUTHORITY, "code": code, "name": name, "deprecated": 0}


def _insert(database, table, **values):
    marks = ", ".join("?" * len(values))
    statement = f"insert into {table} ({', '.join(values)}) values ({marks})"
    database.execute(statement, tuple(values.values()))
