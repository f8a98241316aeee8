"""Coordinate reference systems, at the edge (pyproj).

Ground coordinates are easting, northing everywhere, whatever the axis order of the
authority: Austrian systems list the northing first.
"""

import re
from functools import lru_cache

import numpy as np
import pyproj
import pyproj.enums

from einschalt.foundations.arguments import described
from einschalt.foundations.coordinate_operations import offline, system_label
from einschalt.foundations.databases_of_proj import fault_of_databases
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import ProjectionError
from einschalt.foundations.language import mark
from einschalt.foundations.longitudes import arc_of
from einschalt.foundations.number_parsing import plain_integer
from einschalt.foundations.operation_choice import choose_operation

NAMES = str | int | pyproj.CRS  # what may name a system
CODE_BITS = 32
METRE = "metre"
AGAINST = ("south", "west")
NAMED_AGAINST = (
    mark("south"),
    mark("west"),
    mark("south and west"),
    mark("west and south"),
)
"""How they are named, for the catalogue."""
POLE = 90.0  # degrees
WGS_84 = "OGC:CRS84"
LEAST_CONFIDENCE = 70  # per cent, at which PROJ takes two systems for the same
STEP = 10.0  # metres, for directions
GRADIENT_STEP = 1000.0  # metres
EARTH_RADIUS = 6.371e6  # metres
# +init=, and grids or other files with a path: in PROJ strings, WKT and PROJJSON
OPENS_FILE = re.compile(
    r"""(^|[\s+"])init\s*=
    | (grids|file)\s*=\s*(\S*|"[^"]*)[/\\]
    | PARAMETERFILE[^]]*[/\\]
    | "value"\s*:\s*"[^"]*[/\\]""",
    re.IGNORECASE | re.VERBOSE,
)


def read_crs(text):
    """Understand the name of a plane coordinate reference system in metres.

    ``EPSG:31255``, a PROJ string or WKT; a compound system has heights as well. A
    ProjectionError where it is unknown, or not a plane system in metres.
    """
    crs = _known_crs(text)
    units = {axis.unit_name for axis in crs.axis_info}
    is_plane = crs.is_projected or crs.is_engineering
    if not is_plane or (units and units != {METRE}):
        given = {
            "expected": "a plane system in metres",
            "remedy": "Name the projected system of the coordinates",
        }
        if units == {METRE}:  # of heights alone, or geocentric
            axes = ", ".join(axis.direction for axis in crs.axis_info)
            raise ProjectionError(
                f"crs = {system_label(crs)} has the axes {axes}", **given
            )
        if crs.is_projected:  # in feet, most often
            given["remedy"] = (
                "Name one in metres for the block, such as the UTM zone of the same "
                "datum, and this one as crs of the table of its points, in block.toml"
            )
        axes = ", ".join(sorted(units))
        raise ProjectionError(f"crs = {system_label(crs)} has axes in {axes}", **given)
    return _with_usual_axes(crs)


def read_source_crs(text):
    """Understand the name of any system in which a surveyor may give points.

    Plane, geographic, compound or three-dimensional. A ProjectionError where it is
    unknown, or has no easting and northing, longitude and latitude.
    """
    crs = _known_crs(text)
    if not (crs.is_geographic or crs.is_projected or crs.is_engineering):
        axes = ", ".join(axis.direction for axis in crs.axis_info)
        raise ProjectionError(
            f"crs = {system_label(crs)} has the axes {axes}",
            expected="a plane or a geographic system, with heights or without",
            remedy="Name the system of the coordinates",
        )
    return _with_usual_axes(crs)


def _known_crs(text):
    _refuse_files(text)
    try:
        with offline():
            return pyproj.CRS.from_user_input(_utf8(plain_integer(text)))
    except (pyproj.exceptions.CRSError, UnicodeEncodeError) as error:
        _require_databases(text, error)
        raise ProjectionError(
            f"crs = {described(text)} is unknown",
            expected="an EPSG code such as 'EPSG:31255', a PROJ string or WKT",
            remedy="Look the code up, or leave crs out for a local system",
        ) from error


def _require_databases(text, error):
    """Say that PROJ, which is to read a database that it cannot, knows no system."""
    fault = fault_of_databases()
    if fault is not None:
        raise ProjectionError(
            f"crs = {described(text)} is unknown, since {fault[0]}",
            expected=fault[1],
            remedy="Correct the environment variable PROJ_AUX_DB, or unset it",
        ) from error


def _refuse_files(text):
    """Refuse what lets PROJ open a file by its path: a pipe or a device never ends."""
    if not isinstance(text, str) or not OPENS_FILE.search(text):
        return
    raise ProjectionError(
        f"crs = {described(text)} names a file",
        expected="an EPSG code such as 'EPSG:31255', WKT or PROJJSON, or a PROJ string "
        "without init and without paths",
        remedy="Write the code; put grids into a folder, and name that under grids in "
        "[settings]",
    )


def _with_usual_axes(crs):
    """Refuse axes to the south and west: nobody knows what their easting would be."""
    against = [a.direction for a in crs.axis_info[:2] if a.direction in AGAINST]
    if not against:
        return crs
    twin = _east_north(crs)
    raise ProjectionError(
        f"crs = {system_label(crs)} has axes to the {' and '.join(against)}",
        expected="axes to the east and north",
        remedy=f"Give the coordinates in a system with these, such as {_usual(crs)}"
        if twin is None
        else f"Name {system_label(twin)} in its place: lists whose Y and X count to "
        "the west and south are read as they are",
    )


def _east_north(crs):
    """The same system with axes to the east and north; None where PROJ has none."""
    try:
        return pyproj.CRS.from_user_input(f"{crs.name} East North")
    except pyproj.exceptions.CRSError:
        return None


def _usual(crs):
    """Another system of the same place with axes to the east and north."""
    area = crs.area_of_use
    if area is None or max(area.north, -area.south) >= POLE:
        return "the UTM zone of the place"
    zone = int((area.west + area.east + 360.0) // 12.0) + 1
    first = 32600 if area.south + area.north > 0.0 else 32700
    return system_label(pyproj.CRS.from_epsg(first + zone))


def _utf8(name):
    """Pass on what names a system, and nothing that PROJ would choke on."""
    if not isinstance(name, NAMES) or isinstance(name, bool):
        raise pyproj.exceptions.CRSError(f"{type(name).__name__} names no system")
    if isinstance(name, int) and name.bit_length() > CODE_BITS:
        raise pyproj.exceptions.CRSError("no authority has so long a code")
    # the library ends at a NUL, and takes what stands before it
    if isinstance(name, str) and "\0" in name:
        raise pyproj.exceptions.CRSError("NUL in the name")
    return name.strip() if isinstance(name, str) else name


def code_of(crs):
    """Shortest name of a system: its EPSG code where it is known, otherwise WKT.

    ``crs`` may be WKT or a PROJ string of a program that leaves the code out. One of a
    plane and heights without a code of its own has those of both: ``EPSG:25830+5782``.
    """
    system = read_source_crs(crs)
    system = system.source_crs if system.is_bound else system
    codes = [_epsg(system)]
    if codes == [None] and system.is_compound:
        codes = [_epsg(part) for part in system.sub_crs_list]
    return system.to_string() if None in codes else f"EPSG:{'+'.join(codes)}"


def _epsg(system):
    """Code of a system as text, or None."""
    system = system.source_crs if system.is_bound else system
    with offline():
        code = system.to_epsg(min_confidence=LEAST_CONFIDENCE)
    return None if code is None else str(code)


def code_on_earth(text):
    """Code of a system as a file states it; None where it states none that has a place.

    None as well of a local one, as of laboratories, and of one that PROJ does not know.
    """
    try:
        is_local = not text or read_source_crs(text).is_engineering
        return None if is_local else code_of(text)
    except ProjectionError:
        return None


def axis_letters(crs):
    """What X and Y mean in a system that calls its axes so.

    ``{"X": "northing", "Y": "easting"}`` for EPSG:31255; None for systems that have
    other names, or none, for their axes.
    """
    axes = read_source_crs(crs).axis_info[:2]
    meant = {
        axis.abbrev.upper(): "easting" if axis.direction == "east" else "northing"
        for axis in axes
    }
    is_plane = {"north", "east"} == {axis.direction for axis in axes}
    return meant if is_plane and set(meant) == {"X", "Y"} else None


def is_of_krovak(crs):
    """Whether a system is one of Krovak's projection, of Czechia and Slovakia.

    Land surveyors count its coordinates to the west and south.

    >>> is_of_krovak("EPSG:5514"), is_of_krovak("EPSG:31255"), is_of_krovak(None)
    (True, False, False)
    """
    if crs is None:
        return False
    system = read_source_crs(crs)
    plane = (system.sub_crs_list or [system])[0]
    way = plane.coordinate_operation
    return way is not None and "Krovak" in way.method_name


def is_northing_first(crs):
    """Whether the northing or latitude is the first axis of a system.

    At the poles both axes point to the same direction, and their names tell.

    >>> is_northing_first("EPSG:31467"), is_northing_first("EPSG:3031")
    (True, False)
    """
    first, second = read_source_crs(crs).axis_info[:2]
    if first.direction == second.direction:
        return first.abbrev.upper() == "N" or "north" in first.name.casefold()
    return first.direction == "north"


def label_of(crs):
    """Name and code of a system by any name of it; that itself where it is unknown.

    >>> label_of("EPSG:31255")
    'MGI / Austria GK Central (EPSG:31255)'
    """
    try:
        return system_label(_known_crs(crs))
    except ProjectionError:
        return shortened(crs)


def crs_name(crs):
    """Name of a system as text: as given where it is text, else code or WKT."""
    return crs if isinstance(crs, str) else read_crs(crs).to_string()


def degrees_of(easting, northing, crs):
    """Longitude and latitude of points, for areas and not for coordinates.

    [degrees] in WGS 84, to some hundred metres; infinite where a point has none.
    """
    with offline():
        return to_degrees(crs).transform(easting, northing)


def plane_of(longitude, latitude, crs):
    """Easting and northing of places, as :func:`degrees_of` has them."""
    with offline():
        return to_degrees(crs).transform(
            longitude, latitude, direction=pyproj.enums.TransformDirection.INVERSE
        )


@lru_cache(maxsize=1024)
def to_degrees(crs):
    """Transformer from a system to degrees in WGS 84, longitude first."""
    return pyproj.Transformer.from_crs(crs.to_2d(), WGS_84, always_xy=True)


def reproject(points, source_crs, target_crs, demand, grids=None):
    """Bring points from one system into another.

    ``points``, shape (n_points, 2) or (n_points, 3): easting, northing [, height] or
    longitude, latitude [, height] in the units of the source, in this order whatever
    its authority says. ``grids``: a folder with grids, beside PROJ's own.

    Returns them in the target system, the Operation used, and the better one that would
    have been used if its grid were there, or None. A ProjectionError where none meets
    the ``demand``, or a point has no image in the target system.
    """
    points = np.asarray(points, dtype=float)
    bounds = _bounds(points, source_crs)
    try:
        with offline(grids):
            operation, better = choose_operation(source_crs, target_crs, bounds, demand)
            moved = operation.apply(points, errcheck=True)
    except pyproj.exceptions.ProjError as error:
        way = f"{system_label(source_crs)} to {system_label(target_crs)}"
        raise ProjectionError(
            f"{way}: a point has no image: {error}",
            expected="points within the area of both systems, and of their grids",
            remedy="Check crs and the coordinates",
        ) from error
    return moved, operation, better


def _bounds(points, crs):
    if crs.is_engineering:
        raise ProjectionError(
            f"{system_label(crs)} is a system of one site, tied to no other",
            expected="a system that PROJ knows how to leave",
            remedy="Fit a transformation to identical points (einschalt transform), or "
            "give the coordinates in the system of the block",
        )
    longitude, latitude = degrees_of(points[:, 0], points[:, 1], crs)
    if not np.all(np.isfinite([longitude, latitude])):
        raise ProjectionError(
            f"a point has no place on the Earth in {system_label(crs)}",
            expected="coordinates of this system",
            remedy="Check crs, and the unit of the coordinates",
        )
    west, east = arc_of(longitude)
    return west, np.min(latitude), east, np.max(latitude)


def turn(points, source_crs, operation):
    """Angle by which axes turn on their way through an operation.

    From the source's east to the target's, counterclockwise [rad], shape (n_points,).
    """
    step = np.zeros(points.shape[1])
    step[0] = STEP / source_crs.axis_info[0].unit_conversion_factor
    if source_crs.is_geographic:
        step[0] /= EARTH_RADIUS
    ahead = operation.apply(points + step)
    behind = operation.apply(points - step)
    east, north = (ahead - behind)[:, :2].T
    return np.arctan2(north, east)


def plane_jacobian(points, operation):
    """What a step of a metre in a plane system is in the one it is brought to.

    ``points``, shape (n_points, 2) or (n_points, 3); heights do not change. The
    derivatives of easting and northing (rows) by easting and northing (columns), shape
    (n_points, 2, 2).
    """
    jacobian = np.empty((len(points), 2, 2))
    for axis in range(2):
        step = np.zeros(points.shape[1])
        step[axis] = STEP
        ahead = operation.apply(points + step)
        behind = operation.apply(points - step)
        jacobian[:, :, axis] = (ahead - behind)[:, :2] / (2.0 * STEP)
    return jacobian


def to_geocentric(points, crs):
    """Geocentric coordinates of points, in the datum of their own plane system.

    X points to Greenwich, whatever meridian the longitudes of the datum count from.
    ``points`` (n, 3): easting, northing, height above the ellipsoid. Gives X, Y, Z
    (n, 3) and their derivatives by easting, northing and height (n, 3, 3).
    """
    with offline():
        way, _ = _geocentric_ways(crs)
        jacobian = np.empty((len(points), 3, 3))
        for axis in range(3):
            step = np.zeros(3)
            step[axis] = STEP
            ahead = np.column_stack(way.transform(*(points + step).T))
            behind = np.column_stack(way.transform(*(points - step).T))
            jacobian[:, :, axis] = (ahead - behind) / (2.0 * STEP)
        xyz = np.column_stack(way.transform(*points.T))
    turned = _to_greenwich(crs)
    return (xyz, jacobian) if turned is None else (xyz @ turned.T, turned @ jacobian)


def from_geocentric(xyz, crs):
    """Easting, northing, height above the ellipsoid of geocentric coordinates (n, 3).

    In a plane system of the same datum; infinite where a point has no place in it.
    """
    xyz, turned = np.asarray(xyz), _to_greenwich(crs)
    xyz = xyz if turned is None else xyz @ turned
    with offline():
        _, way = _geocentric_ways(crs)
        return np.column_stack(way.transform(*xyz.T))


def _to_greenwich(crs):
    """Rotation from X to the prime meridian of a datum to X to Greenwich, (3, 3).

    None where they are one. PROJ counts X from the meridian of the datum: Paris, Ferro.
    """
    east = np.radians(_prime_meridian(crs))
    if east == 0.0:
        return None
    cos, sin = np.cos(east), np.sin(east)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _prime_meridian(crs):
    """Longitude of the meridian that a system counts from, from Greenwich [degrees]."""
    meridian = crs.prime_meridian
    return meridian.longitude * np.degrees(meridian.unit_conversion_factor)


@lru_cache(maxsize=64)  # PROJ takes 50 ms, and each flight of a block asks for it
def _geocentric_ways(crs):
    """Transformers of a plane system to the geocentric one of its datum, and back."""
    plane, geocentric = crs.to_3d(), _geocentric(crs)
    there = pyproj.Transformer.from_crs(plane, geocentric, always_xy=True)
    back = pyproj.Transformer.from_crs(geocentric, plane, always_xy=True)
    return _by_its_steps(there), _by_its_steps(back)


def _by_its_steps(transformer):
    """The same transformer: every thread makes its own, in 1 ms instead of 50.

    As it is, where PROJ has several ways and takes one by the place of a point.
    """
    try:
        return pyproj.Transformer.from_pipeline(transformer.definition)
    except pyproj.exceptions.ProjError:
        return transformer


def _geocentric(crs):
    """Geocentric system of the datum, or of the ensemble of datums, of another one."""
    own = crs.geodetic_crs.to_json_dict()
    axes = pyproj.crs.GeocentricCRS().to_json_dict()["coordinate_system"]
    datum = {key: own[key] for key in ("datum", "datum_ensemble") if key in own}
    system = {"type": "GeodeticCRS", "name": f"{own['name']}, geocentric", **datum}
    return pyproj.CRS.from_json_dict({**system, "coordinate_system": axes})


def beyond_use(easting, northing, crs):
    """How far a place lies outside of where a system is used, and where it is.

    [degrees], longitude and latitude; 0.0 where the system does not say where that is,
    infinite where the place is none on the Earth.
    """
    longitude, latitude = degrees_of(easting, northing, read_source_crs(crs))
    return degrees_beyond_use(longitude, latitude, crs), longitude, latitude


def degrees_beyond_use(longitude, latitude, crs):
    """How far a place in degrees lies outside of where a system is used [degrees].

    As :func:`beyond_use` has it.
    """
    if not np.isfinite([longitude, latitude]).all():
        return np.inf
    area = read_source_crs(crs).area_of_use
    if area is None or area.west > area.east:  # or over the antimeridian
        return 0.0
    beyond = (
        *(area.west - longitude, longitude - area.east),
        *(area.south - latitude, latitude - area.north),
    )
    return max(0.0, *beyond)


def scale_range(easting, northing, crs):
    """Smallest and largest scale of a plane system in the middle of some points.

    Length in the plane over length on the ellipsoid; None where that is not known.
    """
    crs = read_source_crs(crs)
    if not crs.is_projected:
        return None
    factors = _factors(np.median(easting), np.median(northing), crs)
    scales = factors.tissot_semiminor, factors.tissot_semimajor
    return scales if np.all(np.isfinite(scales)) else None


def scale_gradient(points, crs):
    """Change of the scale of a plane system in plan, relative, per metre, (n,).

    ``points`` (n, 2): easting, northing [m]; ``crs``: a pyproj.CRS that is projected.
    """
    steps = GRADIENT_STEP * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    asked = (points[:, None] + steps).reshape(-1, 2)
    factors = _factors(*asked.T, crs)
    scale = np.log(factors.areal_scale).reshape(-1, 2, 2) / 2.0  # per length
    return np.hypot(*(scale[:, :, 0] - scale[:, :, 1]).T) / (2.0 * GRADIENT_STEP)


def _factors(easting, northing, crs):
    """Factors of PROJ of a system that is projected, at points in it."""
    plane = (crs.sub_crs_list or [crs])[0]
    longitude, latitude = degrees_of(easting, northing, crs)
    # PROJ counts from the system's own: from Ferro, 17 2/3 degrees west of Greenwich
    meridian = _prime_meridian(plane)
    with offline():
        return pyproj.Proj(plane).get_factors(longitude - meridian, latitude)
