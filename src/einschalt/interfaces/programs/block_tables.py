"""Blocks whose tables may be plain ones, or files of other programs.

``file = "markers.xml"`` in block.toml stands for the table that einschalt convert
would write of it. Where columns, a sheet, a layer or the decimal sign are said of a
file, it is a plain table.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import pandas as pd

from einschalt.foundations.errors import FileError, name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.tables import PLAN_ERRORS
from einschalt.interfaces.files import (
    block_folder,
    camera_toml,
    marker_files,
    metashape_markers,
    odm_lists,
)
from einschalt.interfaces.files.block_parts import Readers
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.files.understood_tables import NEW, NOTHING_SAID, ReadTable
from einschalt.interfaces.programs import metashape_cameras
from einschalt.interfaces.programs.foreign import Foreign, in_unit_of_system
from einschalt.interfaces.programs.recognised import head_of, reader_of

# tables of a block, and those of another program that can stand for them
STANDS_FOR = {
    "control_points": "control_points",
    "approximate_points": "control_points",
    "image_points": "image_points",
}
CAMERA_SUFFIX = ".toml"


def marker_reader_of(file):
    """Function that reads markers of this kind of file; None where it has none."""
    path = Path(file)
    suffix = path.suffix.lower()
    if suffix == ".xml":
        return metashape_markers.read_metashape
    if suffix == ".json":
        return marker_files.read_opensfm
    if suffix != ".txt":
        return None
    is_list = path.name.casefold().startswith("gcp_list")
    is_list = is_list or odm_lists.is_odm(head_of(file))
    return odm_lists.read_odm if is_list else None


def found_in(file, source=None, beside=(), crs=None) -> Foreign | None:
    """What another program has written into a file; None where it is a plain table.

    ``crs``: system of its ground coordinates, where it states none.
    """
    read = reader_of(file)
    if read is not None:
        return in_unit_of_system(read(file), source or Path(file).name, crs)
    read = marker_reader_of(file)
    if read is None:
        return None
    more = {"beside": beside} if read is marker_files.read_opensfm else {}
    markers = read(file, source or Path(file).name, **more)
    return Foreign(markers.tables(), markers.crs, markers.notes)


def understand(path, schema, said=NOTHING_SAID, *, source=None, beside=()) -> ReadTable:
    """Read a table of a block, as understand_table does, from any known file."""
    source = source or Path(path).name
    is_table = said != replace(NOTHING_SAID, crs=said.crs, unit=said.unit)
    foreign = None if is_table else found_in(path, source, beside, said.crs)
    if foreign is None:
        return understand_table(path, schema, said, source=source, beside=beside)
    return table_of(foreign, schema, source)


def table_of(foreign, schema, source) -> ReadTable:
    """The table of another program's file that can stand for one of a block.

    Points that the program calls new are no control. A FileError where there is none.
    """
    frame = foreign.tables.get(STANDS_FOR.get(schema.name))
    if frame is None:
        held = name_some((name.replace("_", " ") for name in foreign.tables), 8)
        raise FileError(
            f"holds {held or 'a camera alone'}, and no {schema.name.replace('_', ' ')}",
            expected=schema.name.replace("_", " "),
            remedy="Name the file that has them",
            file=source,
        )
    notes = list(foreign.notes)
    frame = frame.set_axis(pd.RangeIndex(1, len(frame) + 1, name="row"), axis=0)
    if "role" in frame and "role" in schema.names:
        is_new = (frame["role"] == NEW).to_numpy(dtype=bool)
        frame = frame[~is_new]
        if is_new.any():
            left_out = kept("{n:new point|new points}", n=int(is_new.sum()))
            notes.append(f"{source}: {left_out} left out of control")
    own = frame[[name for name in frame if name in _known(schema)]]
    own, left_out = _without_partial_errors(own)
    if left_out:
        said = name_some(left_out, len(left_out))
        notes.append(f"{source}: {said} left out: not every point has a positive one")
    return ReadTable(own, tuple(notes), foreign.crs)


def _without_partial_errors(frame):
    """The frame without standard errors that some points lack; their names."""
    errors = [name for name in frame if name.startswith("standard_error_")]
    partial = [name for name in errors if not (frame[name] > 0.0).all()]
    plan = set(PLAN_ERRORS) & set(frame)
    if plan & set(partial):  # both or none
        partial = [name for name in errors if name in plan or name in partial]
    if partial:
        partial += [name for name in frame if name.startswith("covariance_")]
    return frame.drop(columns=partial), partial


def _known(schema):
    is_plane = "easting" in schema.names
    return {*schema.names, *(("longitude", "latitude") if is_plane else ())}


def read_camera(path, source=None):
    """Read a camera from a camera.toml, or the only one of another program's file."""
    source = source or Path(path).name
    found = None
    if Path(path).suffix.lower() != CAMERA_SUFFIX:
        found = found_in(path, source)
    if found is None:
        return camera_toml.read_camera(path, source)
    if found.unusable and not found.cameras:
        raise metashape_cameras.no_camera(found.unusable, source)
    n_cameras = len(found.cameras) + len(found.unusable)
    if n_cameras != 1:
        raise FileError(
            f"holds {kept('{n:camera|cameras}', n=n_cameras)}",
            expected="one camera",
            remedy="Write them with einschalt convert, and name one camera.toml",
            file=source,
        )
    return camera_toml.camera_of(next(iter(found.cameras.values())), file=source)


READERS = Readers(understand, read_camera)
read_block = partial(block_folder.read_block, readers=READERS)
find_problems = partial(block_folder.find_problems, readers=READERS)
