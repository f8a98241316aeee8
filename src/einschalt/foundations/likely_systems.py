"""Which system was meant, where coordinates do not fit the one that was named."""

from functools import lru_cache
from itertools import takewhile

import numpy as np
import pyproj
from pyproj.enums import PJType

from einschalt.foundations.areas_of_use import area_of, in_area, in_extent
from einschalt.foundations.coordinate_operations import offline, system_label
from einschalt.foundations.projections import degrees_of, read_source_crs

MOST_LIKELY = 3
# where nobody names a system: those of surveys in and around the Alps, by country
USUAL_SYSTEMS = (
    *(31254, 31255, 31256, 31257, 31258, 31259, 31287),  # Austria
    *(31466, 31467, 31468, 31469),  # Germany
    *(21781, 2056),  # Switzerland
    *(25831, 25832, 25833, 25834),  # ETRS89, UTM
    *(2154, 27561, 27562, 27563, 27572),  # France
    *(3003, 3004, 3794, 23700, 5514),  # Italy, Slovenia, Hungary, Czechia
)


def likely_systems(easting, northing, crs):
    """Systems of the same datum which points [m] fit that lie outside of theirs.

    Names and codes of those that hold these very numbers (another zone was meant), and
    of those in whose area the place lies if it was given rightly (the neighbouring
    zone). ``crs``: the plane system that was named, with an area of use.
    """
    crs = read_source_crs(crs)
    middle = np.median(easting), np.median(northing)
    place = degrees_of(*middle, crs)
    own = system_label(crs)
    others = [one for one in _of_same_datum(crs) if system_label(one) != own]
    fitting = [one for one in others if _is_at_home(middle, one)]
    there = [one for one in others if in_area(*place, one)]
    return _nearest(crs, fitting), _nearest(crs, there)


def likely_sources(easting, northing, crs, target):
    """Systems of the same datum in which the numbers lie in the area of another one.

    ``crs`` was named for the point, ``target`` is where it is to be brought. Names and
    codes.
    """
    middle = easting, northing
    others = [o for o in _of_same_datum(crs) if system_label(o) != system_label(crs)]
    return _nearest(
        crs,
        [
            one
            for one in others
            if _is_at_home(middle, one) and in_area(*degrees_of(*middle, one), target)
        ],
    )


def systems_that_hold(easting, northing):
    """Usual systems in whose area a point [m] lies; all that could be meant."""
    codes = [f"EPSG:{code}" for code in USUAL_SYSTEMS]
    return [c for c in codes if in_extent(easting, northing, c)]


def _of_same_datum(crs):
    """Plane systems of the same datum and unit, as EPSG lists them."""
    family = crs.name.split(" / ")[0]
    if family == crs.name:
        return []
    unit = crs.axis_info[0].unit_name
    return [
        one
        for one in _listed(family)
        if {axis.unit_name for axis in one.axis_info} == {unit}
        and {axis.direction for axis in one.axis_info} == {"east", "north"}
    ]


@lru_cache(maxsize=8)
def _listed(family):
    with offline():
        known = pyproj.database.query_crs_info("EPSG", PJType.PROJECTED_CRS)
    codes = {one.code: one.name for one in known}  # listed for each of their usages
    return [
        pyproj.CRS.from_epsg(code)
        for code, name in codes.items()
        if name.startswith(f"{family} / ")
    ]


def _is_at_home(point, crs):
    """Whether a point given in a system lies where that is used.

    The extent of a zone is a rectangle about its area, and wider in the north.
    """
    return in_extent(*point, crs) and in_area(*degrees_of(*point, crs), crs)


def _nearest(crs, systems):
    """The first few: those named alike, as zones are, then those of small countries."""

    def rank(other):
        west, south, east, north = area_of(other)
        words = zip(crs.name.split(), other.name.split(), strict=False)
        alike = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], words))
        return -alike, (east - west) % 360.0 * (north - south)

    names = {one.name for one in systems}
    plain = [one for one in systems if not _is_variant(one.name, names)]
    return [system_label(one) for one in sorted(plain, key=rank)[:MOST_LIKELY]]


def _is_variant(name, names):
    """Whether a name is that of another system, with its axes exchanged."""
    plain, parted, _ = name.partition(" (")
    return bool(parted) and plain in names
