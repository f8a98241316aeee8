"""Systems and operations of our own, described for others: WKT, PROJ strings.

What is published is in the order easting, northing on both sides, as everywhere here;
where an authority lists the northing first, the description says which axis is which.
"""

import math

import numpy as np
import pyproj
from pyproj.crs import CoordinateOperation

from einschalt.foundations.coordinate_operations import offline
from einschalt.foundations.longitudes import arc_of
from einschalt.foundations.projections import degrees_of, read_crs

PROJJSON = "https://proj.org/schemas/v0.7/projjson.schema.json"
METHOD = {
    "name": "Affine parametric transformation",
    "id": {"authority": "EPSG", "code": 9624},
}
# parameters of EPSG:9624, row by row: shift, factor of x, factor of y
PARAMETERS = {
    "A0": 8623,
    "A1": 8624,
    "A2": 8625,
    "B0": 8639,
    "B1": 8640,
    "B2": 8641,
}
OF_AUTHORITY = ("id", "usages", "scope", "area", "bbox", "remarks")
FINEST = 1e6  # parts of a degree to which areas are rounded, outwards


def published_target(name):
    """Plane system into which a published transformation leads, or None of a site.

    As :func:`plane_part` has it.
    """
    crs = None if name is None else read_crs(name)
    return None if crs is None or crs.is_engineering else plane_part(crs)


def plane_part(crs):
    """What a system says of easting and northing.

    Of a compound one its plane part; of one that says how to leave its datum (by
    ``+towgs84``) the system without that.
    """
    plane = (crs.sub_crs_list or [crs])[0]
    return plane.source_crs if plane.is_bound else plane


def east_north(crs):
    """Easting and northing of a plane system, in this order.

    The system itself where that is its order.
    """
    if [axis.direction for axis in crs.axis_info[:2]] == ["east", "north"]:
        return crs
    content = crs.to_json_dict()
    for key in OF_AUTHORITY:
        content.pop(key, None)
    axes = content["coordinate_system"]["axis"]
    content["coordinate_system"]["axis"] = sorted(axes, key=lambda a: a["direction"])
    return pyproj.CRS.from_json_dict(content)


def own_frame(name, like, unit_m=1.0):
    """A plane system on a datum of its own, easting before northing.

    Projected as the system ``like`` is, on its ellipsoid: only what is published leads
    from it to others. ``unit_m``: what its unit is on the ground [m].
    """
    content = like.to_json_dict()
    for key in OF_AUTHORITY:
        content.pop(key, None)
    base = content["base_crs"]
    known = base.pop("datum_ensemble", None) or base.pop("datum")
    kept = {k: known[k] for k in ("ellipsoid", "prime_meridian") if k in known}
    datum = {"type": "GeodeticReferenceFrame", "name": f"Datum of {name}", **kept}
    base.pop("id", None)
    content["base_crs"] = {**base, "name": f"{name}, geographic", "datum": datum}
    content["name"] = name
    content["coordinate_system"] = _plane_axes(unit_m)
    return pyproj.CRS.from_json_dict(content)


def site_frame(name, unit_m=1.0):
    """A plane system of one site, tied to no other."""
    return pyproj.CRS.from_json_dict(
        {
            "$schema": PROJJSON,
            "type": "EngineeringCRS",
            "name": name,
            "datum": {"name": f"Datum of {name}"},
            "coordinate_system": _plane_axes(unit_m),
        }
    )


def _plane_axes(unit_m):
    unit = "metre"
    if unit_m != 1.0:
        name = f"unit of {unit_m:g} metres"
        unit = {"type": "LinearUnit", "name": name, "conversion_factor": unit_m}
    axes = [
        {"name": long, "abbreviation": short, "direction": way, "unit": unit}
        for long, short, way in (("Easting", "E", "east"), ("Northing", "N", "north"))
    ]
    return {"subtype": "Cartesian", "axis": axes}


def affine_step(matrix, shift):
    """PROJ's step for ground = matrix · xyz + shift, exact to the last digit."""
    named = zip("xyz", shift, strict=False)
    shifts = [f"+{axis}off={float(value)!r}" for axis, value in named]
    factors = [
        f"+s{i + 1}{j + 1}={float(value)!r}" for (i, j), value in np.ndenumerate(matrix)
    ]
    return " ".join(["+proj=affine", *shifts, *factors])


def affine_method(matrix, shift):
    """Method and parameters of an affine transformation, as WKT has them."""
    rows = np.column_stack([shift, matrix]).ravel()
    return METHOD, [
        {
            "name": name,
            "value": float(value),
            "unit": "metre"
            if name.endswith("0")
            else {"type": "ScaleUnit", "name": "coefficient", "conversion_factor": 1.0},
            "id": {"authority": "EPSG", "code": code},
        }
        for (name, code), value in zip(PARAMETERS.items(), rows, strict=True)
    ]


def pipeline_method(pipeline):
    """Method of a PROJ string, as WKT has it; it has no parameters."""
    return {"name": f"PROJ-based operation method: {pipeline}"}, []


def operation_wkt(name, systems, method, accuracy_m, area):
    """Describe an operation between two systems as WKT (CoordinateOperation).

    ``method``: what :func:`affine_method` or :func:`pipeline_method` gives; ``area``:
    west, south, east, north [degrees], or None.
    """
    source, target = systems
    content = {
        "$schema": PROJJSON,
        "type": "Transformation",
        "name": name,
        "source_crs": source.to_json_dict(),
        "target_crs": target.to_json_dict(),
        "method": method[0],
        "parameters": method[1],
    }
    if math.isfinite(accuracy_m):
        content["accuracy"] = f"{accuracy_m:.4g}"
    if area is not None:
        names = ["west_longitude", "south_latitude", "east_longitude", "north_latitude"]
        content["scope"] = "As its publication says"
        content["area"] = f"Identical points of {name}"
        content["bbox"] = dict(zip(names, area, strict=True))
    return CoordinateOperation.from_json_dict(content).to_wkt()


def area_of_points(points, crs):
    """West, south, east, north [degrees], rounded outwards, of points (n, 2) of a crs.

    East is less than west over 180°; None where they have no place on the Earth.
    """
    longitude, latitude = degrees_of(points[:, 0], points[:, 1], crs)
    if not np.all(np.isfinite([longitude, latitude])):
        return None
    west, east = arc_of(longitude)
    low = np.floor(np.array([west, latitude.min()]) * FINEST) / FINEST
    high = np.ceil(np.array([east, latitude.max()]) * FINEST) / FINEST
    return tuple(float(value) for value in (*low, *high))


def run_pipeline(text, points, *, inverse=False):
    """Points (n, 2) through a PROJ string or WKT, without network; infinite outside."""
    with offline():
        way = pyproj.Transformer.from_pipeline(text)
        direction = "INVERSE" if inverse else "FORWARD"
        return np.column_stack(way.transform(*points.T, direction=direction))
