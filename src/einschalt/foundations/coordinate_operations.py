"""The operation that brings coordinates from one reference system into another.

PROJ knows several between most pairs of systems: grids of the national survey good to
centimetres, and seven parameters good to a metre. Where a grid is not installed, it
takes what is left without a word. Here the choice is made in the open, for the area of
the points, and only among what is good enough. The network is never asked.
"""

import os
import warnings
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from threading import RLock, local

import numpy as np
import pyproj
from pyproj.aoi import AreaOfInterest
from pyproj.transformer import TransformerGroup

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import ProjectionError, name_some
from einschalt.foundations.language import mark
from einschalt.foundations.longitudes import lies_within

# steps that change no datum
AXIS_CHANGE, TO_GEOCENTRIC = "axis order change", ("Conversion from ", "(geocentric)")
CONVERSION = "change of map projection"
BETTER = mark("better would be {0}")
INVERSE = "Inverse of "
NAMELESS = ("unknown", "unnamed")
OF_COURSE = ("+no_defs", "+type=crs")
MOST_SHOWN = 80  # characters of a PROJ string
TIME_IN_PROJ, TIME_IN_METHOD = ("t_epoch=", "proj=defmodel"), "Time-"
GRIDS = (".tif", ".gsb", ".gtx", ".ct2", ".lla")
GRID_STEPS = ("hgridshift", "vgridshift", "gridshift", "xyzgridshift")
SLACK = 0.01  # degrees: areas of use are rounded to hundredths
PROJ = RLock()  # its folders and its network are those of the whole process
THREAD = local()  # folders in which the PROJ of each thread was told to look


@contextmanager
def offline(grids=None):
    """Let PROJ ask no network, and look for grids in a folder as well."""
    with PROJ:
        folders = pyproj.datadir.get_data_dir()
        asks = pyproj.network.is_network_enabled()
        pyproj.network.set_network_enabled(active=False)
        try:
            _look_in(folders if grids is None else f"{folders}{os.pathsep}{grids}")
            yield
        finally:
            _look_in(folders)
            pyproj.network.set_network_enabled(active=asks)


def _look_in(folders):
    """Tell the PROJ of this thread its folders.

    Each thread has a PROJ of its own, which was told those of the process when it was
    first used: perhaps while another thread had a folder of grids.
    """
    told = getattr(THREAD, "folders", None)
    if told != folders or pyproj.datadir.get_data_dir() != folders:
        pyproj.datadir.set_data_dir(folders)
        THREAD.folders = folders


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
    depends_on_time: bool = False  # frames that move against each other
    epoch: float | None = None  # of the coordinates, a decimal year

    def __str__(self):
        return f"{self.name} ({self.worth})"

    def as_better(self) -> str:
        """Write, behind a note, that it would have been better."""
        return f"; {BETTER.format(self)}"

    @property
    def worth(self):
        """How accurate it is, and what it needs."""
        stated = f"{self.accuracy_m:g} m"
        text = stated if np.isfinite(self.accuracy_m) else "PROJ states no accuracy"
        if len(self.missing) == 1:
            text = f"{text}, needs {names_of(self.missing)}, which is missing"
        elif self.missing:
            text = f"{text}, needs {names_of(self.missing)}, which are missing"
        if self.epoch is not None:
            return f"{text}, at epoch {self.epoch:.10g}"
        if self.depends_on_time:
            return f"{text}, needs the epoch of the coordinates"
        return text

    @property
    def can_run(self):
        """Whether its grids are there, and the epoch where it depends on time."""
        is_timeless = not self.depends_on_time or self.epoch is not None
        return self.transformer is not None and is_timeless

    def apply(self, points, *, errcheck=False):
        """Bring points (n, 2) or (n, 3) over; infinite where one has no image.

        With ``errcheck`` a ProjError of pyproj there.
        """
        axes = [*points.T]
        if self.epoch is not None:
            rest = (np.zeros(len(points)), np.full(len(points), self.epoch))
            axes += rest[len(axes) - 2 :]
        moved = self.transformer.transform(*axes, errcheck=errcheck)
        return np.column_stack(moved[: points.shape[1]])

    def at(self, epoch):
        """The operation for coordinates of an epoch, or None where it is not known."""
        return replace(self, epoch=epoch if self.depends_on_time else None)

    def covers(self, bounds):
        """Whether points within bounds [degrees] lie in its area of use.

        West, south, east, north of both; east is less than west over 180°.
        """
        if self.area is None:
            return True
        west, south, east, north = self.area
        west_of, south_of, east_of, north_of = bounds
        is_between = lies_within((west_of, east_of), (west, east), SLACK)
        return is_between and south <= south_of + SLACK and north_of <= north + SLACK

    def is_called(self, wanted):
        """Whether a user means it by a part of its name, or by its code."""
        return wanted.casefold() in self.name.casefold() or self.has_code(wanted)

    def is_exactly(self, wanted):
        """Whether a user means it by its whole name, or by its code."""
        return wanted.casefold() == self.name.casefold() or self.has_code(wanted)

    def has_code(self, wanted):
        """Whether a user names it by its code."""
        return wanted.casefold() in (code.casefold() for code in self.codes)


def names_of(grids):
    """Names of grids in a sentence."""
    return " and ".join(name for name, _ in grids)


def find_operations(source, target, bounds):
    """Find all operations between two systems whose area of use holds the points.

    ``bounds``: west, south, east, north of these [degrees]. The most accurate first,
    whether its grids are installed or not; where none covers all points, those that
    cover some. "Ballpark" ones, which take the datums for the same, are none.
    """
    ready, lacking = _listed(source, target, area_of_interest=AreaOfInterest(*bounds))
    projections = _projection_names(source, target)
    found = [_operation(one, projections, one) for one in ready]
    found += [_operation(one, projections, None) for one in lacking]
    found = [one for one in found if one.covers(bounds)] or found
    return sorted(found, key=lambda one: np.nan_to_num(one.accuracy_m, nan=np.inf))


def installed_grids(source, target, grids=None) -> dict:
    """Path of each grid that is there, by name, of all operations between two systems.

    Wherever points lie; ``grids``: a folder with some, beside PROJ's own.
    """
    with offline(grids):
        ready, lacking = _listed(source, target)
        listed = [grid for one in (*ready, *lacking) for grid in _grids_of(one)]
    return {g.short_name: g.full_name for g in listed if g.available and g.full_name}


def files_for_grids(grids=None) -> tuple:
    """Files in all folders where PROJ looks for grids, but its own, as they are now.

    Path, size and time of change of each: another file is another grid. ``grids``: a
    folder with some.
    """
    with offline(grids):
        states = [(path, path.stat()) for path in _files(_more_folders())]
    return tuple((str(p), state.st_size, state.st_mtime_ns) for p, state in states)


def held_grids():
    """Names of the grids in folders that users named; None where they named none."""
    folders = _more_folders()[:-1]
    return [path.name for path in _grid_files(folders)] if folders else None


def _more_folders():
    """Folders in which PROJ looks for grids, beside its own."""
    named = pyproj.datadir.get_data_dir().split(os.pathsep)[1:]
    return [*named, pyproj.datadir.get_user_data_dir()]


def _files(folders):
    paths = [path for folder in folders for path in sorted(Path(folder).glob("*"))]
    return [path for path in paths if path.is_file()]


def _grid_files(folders):
    return [path for path in _files(folders) if path.suffix.lower() in GRIDS]


def _listed(source, target, **more):
    """Operations that PROJ can run, and those whose grids it lacks."""
    with warnings.catch_warnings():  # what is not available is said by our own errors
        warnings.simplefilter("ignore", UserWarning)
        try:
            group = TransformerGroup(
                source, target, always_xy=True, allow_ballpark=False, **more
            )
        except IndexError:  # pyproj names the missing grid of one that has none:
            return [], []  # its method is nothing that PROJ computes
        except pyproj.exceptions.ProjError as error:  # of a grid that is none
            raise _unreadable_grids(source, target, error) from error
    return group.transformers, group.unavailable_operations


def _unreadable_grids(source, target, error):
    """Name the files that have the name of a grid, and are none that PROJ can read."""
    own = pyproj.datadir.get_data_dir().split(os.pathsep)[:1]
    files = _grid_files([*own, *_more_folders()])
    broken = [path for path in files if not _is_grid(path)]
    if broken:
        sizes = [f"{path.name} ({path.stat().st_size} bytes)" for path in broken]
        return ProjectionError(
            f"PROJ cannot read as a grid: {name_some(sizes)}; half a download, or a "
            "page of the web in its place",
            expected="grids as they are published",
            remedy=f"Get them again, or take them out of {broken[0].parent}",
        )
    return ProjectionError(
        f"{system_label(source)} to {system_label(target)}: PROJ cannot use a grid of "
        f"an operation: {error}",
        expected="under the name of a grid that grid, and none of another kind",
        remedy=f"Get it again: of {name_some([path.name for path in files])}",
    )


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
        if part not in projections
        and not part.startswith(AXIS_CHANGE)
        and not all(word in part for word in TO_GEOCENTRIC)
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
        _depends_on_time(steps, transformer),
    )


def _depends_on_time(steps, transformer):
    if transformer is None:
        return any(TIME_IN_METHOD in step.method_name for step in steps)
    return any(word in transformer.definition for word in TIME_IN_PROJ)
