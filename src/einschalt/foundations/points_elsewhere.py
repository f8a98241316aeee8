"""Points that were given in another system than the others, or lie beyond any survey.

Points form islands, parted by more than the known points of a survey leave empty. An
island that lies among the others once a known difference of systems is taken off - the
number of a zone, LV03 and LV95, a false northing, kilometres - was given in another
system. Points that take no part are no fault.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from einschalt.foundations import tables
from einschalt.foundations.areas_of_use import in_extent
from einschalt.foundations.errors import ConsistencyError
from einschalt.foundations.frame_columns import PLAN, values_of
from einschalt.foundations.language import mark
from einschalt.foundations.likely_systems import systems_among
from einschalt.foundations.names import is_among
from einschalt.foundations.units import METRES_PER_KM

# islands are parted by one and a half to three times that [m]
CELL = 50_000.0
# around the others, where points may lie that belong to them: half of their extent
LEAST_AROUND, LARGEST_AROUND, OF_EXTENT = 5_000.0, 50_000.0, 0.5  # [m]
# times that a way must move a point at least: another island may lie there by chance
SURELY_MOVED = 4.0
MOST_ISLANDS = 10  # that are looked at
# no block leaves as much without a known point [m]
BEYOND_ANY_BLOCK = 1_000_000.0
NO_COORDINATE = 1e9
LEAST_SHARE = 0.4  # of the points, in the island that counts
MILLION = 1e6
ZONES = range(1, 61)
# of zones and UTM, and of Austria's M28, M31 and M34
FALSE_EASTINGS, AUSTRIAN = (500_000.0,), (150_000.0, 450_000.0, 750_000.0)
FALSE_NORTHINGS = (5 * MILLION, 10 * MILLION)
EXCHANGED = mark("with easting and northing exchanged it lies among them")
LV95_MISSING = mark("it lies among them as LV95, and is given as LV03")
LV03_MISSING = mark("it lies among them as LV03, and is given as LV95")
KILOMETRES = mark("as kilometres it lies among them")
MILLIMETRES = mark("as millimetres it lies among them")


@dataclass(frozen=True, eq=False)
class Islands:
    """Points by islands, and where those lie that count."""

    plan: np.ndarray  # (n, 2) [m]
    number: np.ndarray  # of each point's island, (n,)
    main: int

    @property
    def bounds(self):
        """Smallest and largest coordinates of the main island, (2, 2)."""
        plan = self.plan[self.number == self.main]
        return np.stack([plan.min(axis=0), plan.max(axis=0)])

    @property
    def around(self):
        """Distance from them where points may belong to them as well [m]."""
        extent = np.hypot(*(self.bounds[1] - self.bounds[0]))
        return float(np.clip(OF_EXTENT * extent, LEAST_AROUND, LARGEST_AROUND))

    def others(self):
        """Number and middle of other islands, the first of them."""
        for number in np.setdiff1d(self.number, [self.main])[:MOST_ISLANDS]:
            yield number, np.median(self.plan[self.number == number], axis=0)

    def distance(self, points):
        """Distance of points from the main island [m]."""
        low, high = self.bounds
        return np.hypot(*np.maximum(np.maximum(low - points, points - high), 0.0).T)


def other_system_problems(frame, system, file, measured) -> list[ConsistencyError]:
    """Points that lie among the others in another system: errors.

    Parameters
    ----------
    frame : DataFrame
        point_id, easting, northing [m].
    system : pyproj.CRS or None
        Plane system of the points.
    file : str
        Name of the file.
    measured : callable
        Gives the names that take part.
    """
    return _problems(frame, system, file, measured, _explained)


def lost_point_problems(frame, system, file, measured):
    """Points with axes exchanged, or farther off than any block reaches: errors.

    Arguments as for :func:`other_system_problems`.
    """
    return _problems(frame, system, file, measured, _left)


def _problems(frame, system, file, measured, judge):
    plan = values_of(frame, PLAN)
    if islands_of(plan, system) is None:
        return []
    # points that take no part may be more, and lie anywhere
    rows = np.flatnonzero(is_among(frame["point_id"], measured()))
    found = islands_of(plan[rows], system)
    problems = []
    for number, middle in found.others() if found is not None else ():
        verdict = judge(middle, found, system)
        if verdict is not None:
            places = np.flatnonzero(found.number == number)
            problems += _listed(frame.iloc[rows], file, places, found, verdict)
    return problems


def islands_of(plan, system):
    """Islands of points, shape (n, 2), or None where they are one, or all apart.

    The main one has most of the points that lie where the system is used, or most.
    """
    if not len(plan) or np.abs(plan).max() > NO_COORDINATE:  # said elsewhere
        return None
    places = np.floor(plan / CELL).astype(np.int64)
    places -= places.min(axis=0)
    width = places[:, 1].max() + 1
    keys, cell = np.unique(places[:, 0] * width + places[:, 1], return_inverse=True)
    if len(keys) == 1:
        return None
    cells = np.column_stack([keys // width, keys % width])
    pairs = cKDTree(cells).query_pairs(1.0, p=np.inf, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(cells),) * 2)
    n_islands, of_cell = connected_components(links, directed=False)
    if n_islands == 1:
        return None
    number = of_cell[cell]
    is_inside = None if system is None else in_extent(*plan.T, system)
    counted = number if is_inside is None or not is_inside.any() else number[is_inside]
    main = int(np.argmax(np.bincount(counted)))
    # points that lie all apart are in another unit, which is said elsewhere
    n_of_main = np.sum(number == main)
    return Islands(plan, number, main) if n_of_main >= LEAST_SHARE * len(plan) else None


def _explained(middle, islands, system):
    """What an island is in, and what to do; None where nothing known explains it."""
    if (why := _first(_notations(middle, islands), middle, islands)) is not None:
        return why
    low, high = islands.bounds
    bounds = low - islands.around, high + islands.around
    if system is not None and (names := systems_among(middle, bounds, system)):
        return f"it lies among them if it is in {', '.join(names)}"
    return _first(_false_origins(middle, system), middle, islands)


def _first(ways, point, islands):
    """Words of the first way that brings an island among the others, or None."""
    return next((w for to, w in ways if _is_among_them(to, point, islands)), None)


def _left(middle, islands, _):
    if _is_among_them(middle[::-1], middle, islands):
        return EXCHANGED
    if islands.distance(middle[None])[0] > BEYOND_ANY_BLOCK:
        return f"no block reaches over {BEYOND_ANY_BLOCK / METRES_PER_KM:.0f} km"
    return None


def _is_among_them(moved, point, islands):
    """Whether a point, moved by much, lies among the others."""
    if np.hypot(*(moved - point)) < SURELY_MOVED * islands.around:
        return False
    return _is_within(moved, islands)


def _is_within(point, islands):
    (low, high), around = islands.bounds, islands.around
    return bool(((point >= low - around) & (point <= high + around)).all())


def _notations(point, islands):
    """Where a point would lie in each other way to write it, and its words."""
    swiss = np.array([2 * MILLION, MILLION])
    yield point + swiss, LV95_MISSING
    yield point - swiss, LV03_MISSING
    if not _is_within(np.zeros(2), islands):  # where all numbers lie as millimetres
        yield point * METRES_PER_KM, KILOMETRES
        yield point / METRES_PER_KM, MILLIMETRES
    for zone in ZONES:
        east, number = np.array([zone * MILLION, 0.0]), f"{zone}000000"
        why = f"with {number} for the zone in front of its easting it lies among them"
        yield point + east, why
        why = f"without {number} for a zone in its easting it lies among them"
        yield point - east, why


def _false_origins(point, system):
    """Where a point would lie by each usual false origin, and its words."""
    if not point.any():  # no place at all
        return
    is_austrian = system is None or "MGI" in system.name
    eastings = FALSE_EASTINGS + (AUSTRIAN if is_austrian else ())
    easts = [0.0, *(sign * e for e in eastings for sign in (1.0, -1.0))]
    norths = [0.0, *(sign * n for n in FALSE_NORTHINGS for sign in (1.0, -1.0))]
    for north, east in product(norths, easts):
        if east or north:
            yield point + np.array([east, north]), _told_shift(east, north)


def _told_shift(east, north):
    if not north:
        why = f"with {east:+.0f} in easting it lies among them"
    elif not east:
        why = f"with {north:+.0f} in northing it lies among them"
    else:
        why = (
            f"with {east:+.0f} in easting and {north:+.0f} in northing it lies among "
            "them"
        )
    return why


def _listed(frame, file, places, islands, why):
    plan, away = islands.plan, islands.distance(islands.plan) / METRES_PER_KM

    def problem(place):
        east, north = plan[place]
        return ConsistencyError(
            f"easting {east:.3f}, northing {north:.3f} lies {away[place]:.0f} km from "
            f"the other points; {why}",
            expected="all points in the same system",
            remedy="Transform it into the system of the others, correct its "
            "coordinates, or take the row out",
            file=file,
            **tables.row_location(frame, place),
        )

    return tables.listed(places, problem, "other points lie there")
