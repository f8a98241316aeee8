"""Which system was meant, where coordinates do not fit the one that was named."""

from functools import lru_cache
from itertools import chain, takewhile

import numpy as np
import pyproj
from pyproj.enums import PJType

from einschalt.foundations.areas_of_use import area_of, in_area, in_extent
from einschalt.foundations.coordinate_operations import offline, system_label
from einschalt.foundations.projections import degrees_of, plane_of, read_source_crs

MOST_LIKELY = 3
DATUM_WORDS = 2  # of a name: ETRS89 / UTM zone 32N
DEGREES_BESIDE = 3.0  # from the area of a zone to the next ones of the country
# where nobody names a system: those of surveys in and around the Alps, by country
OF_ALL = (25831, 25832, 25833, 25834)  # ETRS89, UTM
USUAL_BY_COUNTRY = (
    (31254, 31255, 31256, 31257, 31258, 31259, 31287),  # Austria
    (31466, 31467, 31468, 31469),  # Germany
    (21781, 2056),  # Switzerland
    OF_ALL,
    (2154, 27561, 27562, 27563, 27572),  # France
    (3003, 3004),  # Italy
    (3794,),  # Slovenia
    (23700,),  # Hungary
    (5514,),  # Czechia
)
USUAL_SYSTEMS = tuple(chain.from_iterable(USUAL_BY_COUNTRY))


def likely_systems(easting, northing, crs):
    """Systems which points [m] fit that lie outside of theirs.

    Names and codes of those that hold these very numbers (another zone was meant, or
    another system of the same country), and of those of the same datum in whose area
    the place lies if it was given rightly (the neighbouring zone). ``crs``: the plane
    system that was named, with an area of use.
    """
    crs = read_source_crs(crs)
    middle = np.median(easting), np.median(northing)
    place = degrees_of(*middle, crs)
    own = system_label(crs)
    others = [one for one in _of_same_datum(crs) if system_label(one) != own]
    fitting = [one for one in others if _is_at_home(middle, one)]
    usual = [] if crs.is_geographic else _usual_beside(middle, crs)
    # beside those of the country no others of a large datum
    if usual:
        fitting = [one for one in fitting if _is_alike(crs, one)]
    fitting = dict.fromkeys([*usual, *_nearest(crs, fitting)])
    there = [one for one in others if in_area(*place, one)]
    return list(fitting)[:MOST_LIKELY], _nearest(crs, there)


def likely_sources(easting, northing, crs, target):
    """Systems in which the numbers lie in the area of another one.

    Those of the same datum, and where there is none the usual ones.

    ``crs`` was named for the point, ``target`` is where it is to be brought. Names and
    codes.
    """
    middle = easting, northing
    usual = [] if crs.is_geographic else systems_that_hold(*middle)
    for among in (_of_same_datum(crs), map(read_source_crs, usual)):
        found = [
            one
            for one in among
            if system_label(one) != system_label(crs)
            and _is_at_home(middle, one)
            and in_area(*degrees_of(*middle, one), target)
        ]
        if found:
            break
    return _nearest(crs, found)


def systems_that_hold(easting, northing):
    """Usual systems in whose area a point [m] lies; all that could be meant."""
    codes = [f"EPSG:{code}" for code in USUAL_SYSTEMS]
    return [c for c in codes if in_extent(easting, northing, c)]


def systems_over(longitude, latitude):
    """Usual systems that are used at a place [degrees]."""
    codes = [f"EPSG:{code}" for code in USUAL_SYSTEMS]
    return [c for c in codes if in_area(longitude, latitude, read_source_crs(c))]


def systems_among(point, bounds, crs):
    """Systems in which a point [m] would lie within bounds given in another one.

    Usual ones, and those of the same datum. ``bounds``: smallest and largest easting
    and northing in ``crs``, (2, 2). Names and codes.
    """
    codes = systems_that_hold(*point)
    usual = [read_source_crs(code) for code in codes]
    own = system_label(crs)
    found = []
    for one in [*usual, *_of_same_datum(crs)]:
        if system_label(one) == own or not _is_at_home(point, one):
            continue
        place = np.array(plane_of(*degrees_of(*point, one), crs))
        if ((place >= bounds[0]) & (place <= bounds[1])).all():
            found.append(system_label(one))
    return list(dict.fromkeys(found))[:MOST_LIKELY]


def _usual_beside(middle, crs):
    """Usual systems that put a point where another system is used, or just beside."""
    country = _country_of(crs)
    codes = [c for c in systems_that_hold(*middle) if not country or c in country]
    own = system_label(crs)
    usual = [one for one in map(read_source_crs, codes) if system_label(one) != own]
    return [
        system_label(one)
        for one in usual
        if _is_at_home(middle, one)
        and in_area(*degrees_of(*middle, one), crs, DEGREES_BESIDE)
    ]


def _country_of(crs):
    """Codes of the usual systems of a system's country, UTM with them; () of none."""
    for codes in USUAL_BY_COUNTRY:
        systems = [read_source_crs(f"EPSG:{code}") for code in codes]
        if codes != OF_ALL and any(_is_alike(crs, one) for one in systems):
            return tuple(f"EPSG:{code}" for code in (*codes, *OF_ALL))
    return ()


def _is_alike(one, other):
    """Whether systems are the same, or named alike beyond their datum."""
    return one.name == other.name or _n_alike(one, other) > DATUM_WORDS


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
        return -_n_alike(crs, other), (east - west) % 360.0 * (north - south)

    names = {one.name for one in systems}
    plain = [one for one in systems if not _is_variant(one.name, names)]
    return [system_label(one) for one in sorted(plain, key=rank)[:MOST_LIKELY]]


def _n_alike(one, other):
    """How many of the first words of two names are the same."""
    words = zip(one.name.split(), other.name.split(), strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], words))


def _is_variant(name, names):
    """Whether a name is that of another system, with its axes exchanged."""
    plain, parted, _ = name.partition(" (")
    return bool(parted) and plain in names
