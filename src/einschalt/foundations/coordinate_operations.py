"""The operation that brings coordinates from one reference system into another.

PROJ knows several between most pairs of systems: grids of the national survey good to
centimetres, and seven parameters good to a metre. Where a grid is not installed, it
takes what is left without a word. Here the choice is made in the open, for the area of
the points, and only among what is good enough. The network is never asked.
"""

import os
import warnings
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import RLock

import numpy as np
import pyproj
from pyproj.aoi import AreaOfInterest
from pyproj.transformer import TransformerGroup

from einschalt.foundations.databases_of_proj import second_name_of
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import ProjectionError, name_some

AXIS_CHANGE = "axis order change"
CONVERSION = "change of map projection"
INVERSE = "Inverse of "
NAMELESS = ("unknown", "unnamed")
OF_COURSE = ("+no_defs", "+type=crs")
MOST_SHOWN = 80  # characters of a PROJ string
GRIDS = (".tif", ".gsb", ".gtx", ".ct2", ".lla")
GRID_STEPS = ("hgridshift", "vgridshift", "gridshift", "xyzgridshift")
MOST_CANDIDATES = 5
SLACK = 0.01  # degrees: areas of use are rounded to hundredths
PROJ = RLock()  # its folders and its network are those of the whole process


@contextmanager
def offline(grids=None):
    """Let PROJ ask no network, and look for grids in a folder as well."""
    with PROJ:
        folders = pyproj.datadir.get_data_dir()
        asks = pyproj.network.is_network_enabled()
        pyproj.network.set_network_enabled(active=False)
        try:
            if grids is not None:
                pyproj.datadir.append_data_dir(str(grids))
            yield
        finally:
            if grids is not None:
                pyproj.datadir.set_data_dir(folders)
            pyproj.network.set_network_enabled(active=asks)


def system_label(crs):
    """Name and code of a system, as messages say it.

    Examples
    --------
    >>> system_label(pyproj.CRS("EPSG:31255"))
    'MGI / Austria GK Central (EPSG:31255)'
    """
    # a PROJ string may resemble a known system, and is none for that
    parts = crs.sub_crs_list or [crs]
    codes = [part.to_authority(min_confidence=100) for part in parts]
    known = "+".join(":".join(code) for code in codes if code is not None)
    if known and None not in codes:
        return f"{crs.name} ({known})"
    return _proj_string(crs) if crs.name in NAMELESS else crs.name


def _proj_string(crs):
    """What a system is that came as a PROJ string, and has no name for that."""
    with warnings.catch_warnings():  # some things cannot be said so, and have a name
        warnings.simplefilter("ignore", UserWarning)
        text = crs.to_proj4() or crs.srs
    for word in OF_COURSE:
        text = text.replace(f" {word}", "")
    return shortened(text, MOST_SHOWN)


@dataclass(frozen=True, eq=False)
class Operation:
    """A way from one system into another."""

    name: str  # of its change of datum, as PROJ has it
    codes: tuple[str, ...]  # of the same: ``EPSG:1619``
    accuracy_m: float  # as PROJ states it; NaN where it states none
    grids: tuple[tuple[str, str], ...]  # name and address of each that it needs
    missing: tuple[tuple[str, str], ...]  # those of them that are not installed
    area: tuple[float, float, float, float] | None  # west, south, east, north [degrees]
    transformer: pyproj.Transformer | None  # easting, northing; None without its grid

    def __str__(self):
        stated = f"{self.accuracy_m:g} m"
        text = stated if np.isfinite(self.accuracy_m) else "PROJ states no accuracy"
        if self.missing:
            are = "is" if len(self.missing) == 1 else "are"
            text += f", needs {_names(self.missing)}, which {are} missing"
        return f"{self.name} ({text})"

    def covers(self, bounds):
        """Whether points within bounds [degrees] lie in its area of use."""
        if self.area is None:
            return True
        west, south, east, north = self.area
        west_of, south_of, east_of, north_of = bounds
        # an area over the antimeridian ends west of where it begins
        is_between = west <= west_of + SLACK and east_of <= east + SLACK
        is_between |= west > east
        return is_between and south <= south_of + SLACK and north_of <= north + SLACK

    def is_called(self, wanted):
        """Whether a user means it by a name or code."""
        wanted, names = wanted.casefold(), self.name.casefold()
        return wanted in names or wanted in (code.casefold() for code in self.codes)


def find_operations(source, target, bounds):
    """Find all operations between two systems whose area of use holds the points.

    ``bounds``: west, south, east, north of these [degrees]. The most accurate first,
    whether its grids are installed or not; where none covers all points, those that
    cover some. "Ballpark" ones, which take the datums for the same, are none.
    """
    group = _group(source, target, area_of_interest=AreaOfInterest(*bounds))
    projections = _projection_names(source, target)
    found = [_operation(one, projections, one) for one in group.transformers]
    found += [_operation(o, projections, None) for o in group.unavailable_operations]
    found = [one for one in found if one.covers(bounds)] or found
    return sorted(found, key=lambda one: np.nan_to_num(one.accuracy_m, nan=np.inf))


def installed_grids(source, target, grids=None) -> dict:
    """Path of each grid that is there, by name, of all operations between two systems.

    Wherever points lie; ``grids``: a folder with some, beside PROJ's own.
    """
    with offline(grids):
        group = _group(source, target)
        found = [*group.transformers, *group.unavailable_operations]
        listed = [grid for one in found for grid in _grids_of(one)]
    return {g.short_name: g.full_name for g in listed if g.available and g.full_name}


def _group(source, target, **more):
    with warnings.catch_warnings():  # what is not available is said by our own errors
        warnings.simplefilter("ignore", UserWarning)
        try:
            return TransformerGroup(
                source, target, always_xy=True, allow_ballpark=False, **more
            )
        except pyproj.exceptions.ProjError as error:  # of a grid that is none
            _refuse_broken_grids(error)
            raise


def _refuse_broken_grids(error):
    """Name the files that have the name of a grid, and are none that PROJ can read."""
    folders = pyproj.datadir.get_data_dir().split(os.pathsep)
    folders.append(pyproj.datadir.get_user_data_dir())
    files = [path for folder in folders for path in sorted(Path(folder).glob("*"))]
    named = [one for one in files if one.suffix.lower() in GRIDS and one.is_file()]
    broken = [path for path in named if not _is_grid(path)]
    if broken:
        sizes = [f"{path.name} ({path.stat().st_size} bytes)" for path in broken]
        raise ProjectionError(
            f"PROJ cannot read as a grid: {name_some(sizes)}; half a download, or a "
            "page of the web in its place",
            expected="grids as they are published",
            remedy=f"Get them again, or take them out of {broken[0].parent}",
        ) from error


def _is_grid(path):
    """Whether PROJ opens a file as a grid of one kind or another."""
    for step in GRID_STEPS:
        try:
            pyproj.Transformer.from_pipeline(f"+proj={step} +grids={path.name}")
        except pyproj.exceptions.ProjError:
            continue
        return True
    return False


def _grids_of(found):
    of_steps = [grid for step in found.operations or () for grid in step.grids]
    return of_steps or list(getattr(found, "grids", ()))


def _projection_names(*systems):
    parts = [part for crs in systems for part in crs.sub_crs_list or [crs]]
    # of a system with seven parameters of its own the operation is a change of datum
    plane = [part.source_crs if part.is_bound else part for part in parts]
    names = {c.coordinate_operation.name for c in plane if c.coordinate_operation}
    return names | {f"{INVERSE}{name}" for name in names}


def _operation(found, projections, transformer):
    whole = found.name if transformer is None else found.description
    parts = [
        part
        for part in whole.split(" + ")
        if part not in projections and not part.startswith(AXIS_CHANGE)
    ]
    steps = found.operations or ()
    ids = [s.to_json_dict().get("id") for s in steps if s.type_name != "Conversion"]
    codes = [f"EPSG:{i['code']}" for i in ids if i and "EPSG" in i["authority"]]
    # of an operation that can be used all grids are there
    listed = {grid.short_name: grid for grid in _grids_of(found)}.values()
    area = found.area_of_use
    stated = found.accuracy
    return Operation(
        " + ".join(parts) or CONVERSION,
        tuple(codes),
        stated if stated is not None and stated >= 0.0 else np.nan,
        tuple((grid.short_name, grid.url) for grid in listed),
        tuple((g.short_name, g.url) for g in listed if not g.available)
        if transformer is None
        else (),
        None if area is None else (area.west, area.south, area.east, area.north),
        transformer,
    )


@dataclass(frozen=True)
class Demand:
    """What is asked of an operation."""

    accuracy_m: float  # worst that may be used
    reason: str  # where that comes from, as messages say it
    operation: str = ""  # (part of a) name or code of it, whatever its accuracy
    is_stated: bool = False  # by a user: then it holds where PROJ states none


def choose_operation(source, target, bounds, demand):
    """Choose the operation between two systems for points within bounds [degrees].

    The most accurate one that is available, or the one that was asked for; and a better
    one whose grid is missing, or None. A ProjectionError names the candidates where
    none is good enough, or the one asked for is none of them.
    """
    candidates = find_operations(source, target, bounds)
    way = f"{system_label(source)} to {system_label(target)}"
    if not candidates:
        raise _no_operation(source, target, bounds, way)
    if demand.operation:
        return _chosen(candidates, way, demand), None
    usable = [one for one in candidates if one.transformer is not None]
    good = [one for one in usable if one.accuracy_m <= demand.accuracy_m]
    if not good:
        raise ProjectionError(
            f"{way}: no operation is good enough; {_listed(candidates)}",
            expected=f"an accuracy of {demand.accuracy_m:g} m, {demand.reason}",
            remedy=_remedy(candidates, demand),
        )
    best = candidates[0]
    is_better = best.missing and best.accuracy_m < good[0].accuracy_m
    return good[0], best if is_better else None


def _no_operation(source, target, bounds, way):
    """Tell datums that are not known to each other from heights that are not."""
    flat = source.to_2d(), target.to_2d()
    if flat != (source, target) and find_operations(*flat, bounds):
        return ProjectionError(
            f"PROJ knows no operation from {way} for heights, such as by a geoid, and "
            "one for the plan alone",
            expected="heights of a system that PROJ can bring into the other",
            remedy="Give the heights in the vertical system of the block, or take the "
            "vertical systems out of crs where the heights are in one already",
        )
    return ProjectionError(
        f"PROJ knows no operation from {way}",
        expected="systems whose datums are known, and known to each other there",
        remedy="Correct crs, or give the coordinates in the system of the block",
    )


def _chosen(candidates, way, demand):
    called = [one for one in candidates if one.is_called(demand.operation)]
    exact = [
        one for one in called if one.name.casefold() == demand.operation.casefold()
    ]
    called = exact or called
    usable = [one for one in called if one.transformer is not None]
    asked = f"{way}: crs_operation = {demand.operation!r}"
    if not called:
        raise ProjectionError(
            f"{asked} is none of the operations",
            expected=_listed(candidates),
            remedy="Write one of these names, or its EPSG code",
        )
    if not usable:
        raise ProjectionError(
            f"{asked} cannot be used: {_listed(called)}",
            expected="a grid that is there",
            remedy=f"{_where(called[0].missing)} or choose another operation",
        )
    one = usable[0]
    by_code = demand.operation.casefold() in (code.casefold() for code in one.codes)
    if not by_code and len({other.name for other in called}) > 1:
        raise ProjectionError(
            f"{asked} fits {len(called)} operations: {_listed(called)}",
            expected="one of them",
            remedy="Write its whole name, or its EPSG code",
        )
    if np.isfinite(one.accuracy_m):
        return one
    if not demand.is_stated:
        raise ProjectionError(
            f"{asked}: PROJ states no accuracy for it",
            expected="an accuracy, since it is a source of error",
            remedy="Set crs_accuracy_m to the accuracy that it has",
        )
    return Operation(**{**vars(one), "accuracy_m": demand.accuracy_m})


def _listed(candidates):
    rest = len(candidates) - MOST_CANDIDATES
    said = ", ".join(str(one) for one in candidates[:MOST_CANDIDATES])
    return f"{said} and {rest} more" if rest > 0 else said


def _names(grids):
    return " and ".join(name for name, _ in grids)


def _where(grids):
    """Say where grids are to be had."""
    first = f"Get {_names(grids)}"
    addresses = " and ".join(address for _, address in grids if address)
    from_there = f" from {addresses}" if addresses else ""
    seconds = [second_name_of(name) for name, _ in grids]
    seconds = [name for name in seconds if name is not None]
    known = f" (or as {' and '.join(seconds)})" if seconds else ""
    return (
        f"{first}{from_there}, or under that name{known} from the national survey, "
        f"name its folder with --grids, or grids in [settings]{_held()},"
    )


def _held():
    """What the folders of grids hold that were named, beside PROJ's own."""
    folders = pyproj.datadir.get_data_dir().split(os.pathsep)[1:]
    files = [path for folder in folders for path in sorted(Path(folder).glob("*"))]
    names = [path.name for path in files if path.suffix.lower() in GRIDS]
    said = f" (the folder that is named holds {name_some(names) or 'none'})"
    return said if folders else ""


def _remedy(candidates, demand):
    """Tell every way out: the grid, the accuracy, another operation."""
    stated = [one for one in candidates if np.isfinite(one.accuracy_m)]
    usable = [one for one in stated if one.transformer is not None]
    ways = []
    if stated and stated[0].missing:
        best = stated[0]
        where, stated_m = _where(best.missing), f"{best.accuracy_m:g}"
        is_enough = best.accuracy_m <= demand.accuracy_m
        ways = [
            where[:-1] if is_enough else f"{where} and set crs_accuracy_m = {stated_m}"
        ]
    if usable:
        accuracy = usable[0].accuracy_m
        ways.append(f"set crs_accuracy_m = {accuracy:g} to use {usable[0].name}")
    else:
        ways.append("choose an operation with crs_operation and crs_accuracy_m")
    text = "; or ".join(ways)
    return f"{text[0].upper()}{text[1:]}"
