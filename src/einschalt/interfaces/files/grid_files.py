"""Grids of PROJ by which points may come into a block: inputs of it, as its tables are.

They are those that are there of all operations between two systems, whichever is taken:
told without a look at the points, and a better grid that comes is a change as well.
"""

from functools import lru_cache
from pathlib import Path

from einschalt.foundations.coordinate_operations import files_for_grids, installed_grids
from einschalt.foundations.errors import ProjectionError, SettingsError, name_some
from einschalt.foundations.projections import read_crs, read_source_crs
from einschalt.interfaces.files.block_parts import POINT_TABLES


def grid_folder(settings, folder):
    """Folder of grids that the settings name, from that of the block, or None.

    A SettingsError where there is no such folder, or a pipe in it.
    """
    if not settings.grids:
        return None
    path = folder / settings.grids
    if not path.is_dir():
        raise SettingsError(
            f"[settings] grids = {settings.grids!r} is no folder",
            expected="a folder with grids of PROJ, such as .tif or .gsb",
            remedy="Correct the path",
            section="settings",
            key="grids",
        )
    # PROJ opens what has the name of a grid: a pipe would never end
    others = [one.name for one in path.iterdir() if not (one.is_file() or one.is_dir())]
    if others:
        raise SettingsError(
            f"[settings] grids = {settings.grids!r} holds {name_some(sorted(others))}, "
            "which is no file",
            expected="a folder with grids of PROJ, such as .tif or .gsb",
            remedy="Take it out",
            section="settings",
            key="grids",
        )
    return path


def grids_of_block(sections, settings, folder) -> dict:
    """Path of each grid that reading a block may use, by table (``grids.NAME``)."""
    block = sections.get("block")
    found = {}
    of_tables = [getattr(sections.get(name), "crs", None) for name in POINT_TABLES]
    for crs in (*of_tables, settings.output_crs or None):
        if block is None or block.crs is None or crs is None:
            continue
        try:
            systems = read_source_crs(crs), read_crs(block.crs)
            found |= grids_between(*systems, grid_folder(settings, folder))
        except (ProjectionError, SettingsError):  # the computation will say it
            continue
    return found


def grids_between(own, target, folder) -> dict:
    """Path of each grid that is there for the way between two systems, by table.

    ``folder``: of grids beside PROJ's own, or None.
    """
    if own == target:
        return {}
    folder = None if folder is None else folder.absolute()
    # grids may come, go and change while a program runs for days
    found = _grids_between(own, target, folder, files_for_grids(folder))
    return {f"grids.{name}": Path(path) for name, path in found}


@lru_cache(maxsize=256)
def _grids_between(own, target, folder, _files):
    ways = {(own.to_2d(), target.to_2d()), (own, target)}  # without heights, and with
    found = {}
    for way in ways:
        found |= installed_grids(*way, folder)
    return tuple(sorted(found.items()))
