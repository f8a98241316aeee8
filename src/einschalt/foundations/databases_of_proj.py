"""PROJ's own database, and those that PROJ_AUX_DB names, such as published ones.

With one that it cannot read PROJ has none at all, and knows no code of any system.
"""

import os
import sqlite3
from contextlib import closing
from pathlib import Path

import pyproj

VARIABLE = "PROJ_AUX_DB"
LAYOUT = "DATABASE.LAYOUT.VERSION."


def fault_of_databases():
    """What is wrong with the databases that PROJ_AUX_DB names, and what is expected.

    None where PROJ can read them all, or the variable is not set.
    """
    for path in os.environ.get(VARIABLE, "").split(os.pathsep):
        fault = _fault(Path(path)) if path else None
        if fault is not None:
            return f"{VARIABLE} names {path}, which {fault[0]}", fault[1]
    return None


def _fault(path):
    if not path.exists():
        return "is not there", "a database of PROJ, or none"
    found, own = _layout(path), _own_layout()
    if found is None:
        return "is no database of PROJ", "a database of PROJ, or none"
    # PROJ reads what has its own tables, and more
    if own is None or (found[0] == own[0] and found[1] >= own[1]):
        return None
    is_newer = found[0] > own[0]
    age = "a newer" if is_newer else "an older"
    return (
        f"has the layout {found[0]}.{found[1]} of {age} PROJ",
        f"the layout {own[0]}.{own[1]} of PROJ {pyproj.proj_version_str}",
    )


def second_name_of(grid):
    """Name that PROJ takes for a grid as well: that of the survey; None for most."""
    path = _own_database()
    asked = "SELECT old_proj_grid_name FROM grid_alternatives WHERE proj_grid_name = ?"
    rows = [] if path is None else _rows(path, asked, (grid,))
    return next((name for (name,) in rows if name and name != grid), None)


def _own_layout():
    path = _own_database()
    return None if path is None else _layout(path)


def _own_database():
    folders = pyproj.datadir.get_data_dir().split(os.pathsep)
    paths = (Path(folder) / "proj.db" for folder in folders)
    return next((path for path in paths if path.is_file()), None)


def _rows(path, asked, values=()):
    uri = f"{path.absolute().as_uri()}?mode=ro"
    with closing(sqlite3.connect(uri, uri=True)) as database:
        return database.execute(asked, values).fetchall()


def _layout(path):
    """Major and minor version of the layout of a database; None where it has none."""
    if not path.is_file():  # a pipe would never end
        return None
    try:
        found = dict(_rows(path, "SELECT key, value FROM metadata"))
        return tuple(int(found[f"{LAYOUT}{part}"]) for part in ("MAJOR", "MINOR"))
    except (sqlite3.Error, KeyError, ValueError):
        return None
