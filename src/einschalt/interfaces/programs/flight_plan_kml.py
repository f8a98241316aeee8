"""A flight plan as KML: area, flight lines, photographs, control, on the globe."""

from functools import partial
from xml.etree import ElementTree as ET

import numpy as np

from einschalt.foundations.language import in_english, mark
from einschalt.foundations.operation_choice import Demand
from einschalt.foundations.projections import (
    WGS_84,
    read_crs,
    read_source_crs,
    reproject,
)
from einschalt.interfaces.files.atomic import write_bytes
from einschalt.interfaces.files.plain_xml import xml_bytes
from einschalt.interfaces.programs.kml import (
    GOOD_ENOUGH,
    NAMESPACE,
    add_folder,
    add_mark,
    add_style,
)

FILE = "flight_plan.kml"
HIGH, LOW, CONTROL, BORDER = "ffb27200", "ff009ee6", "ff005ed5", "ffffffff"
FLIGHTS = {"high_flight": HIGH, "low_flight": LOW}


@in_english
def _of_plan(plan):
    """What the plan comes to, as it is told on the command line."""
    return plan.checked.outcome()


def write_flight_plan_kml(plan, path):
    """Write an AreaPlan; cameras at their altitudes where heights are known."""
    import shapely  # noqa: PLC0415 - loaded when a file is written

    flown, area = plan.flown, plan.area
    # all by one operation: near the border of its use each may have another one
    places = np.concatenate([shapely.get_coordinates(area.shape), *_places(flown)])
    operation = _way_to_wgs_84(places, area.crs)
    to_degrees = partial(_degrees, operation=operation)
    root = ET.Element("kml", xmlns=NAMESPACE)
    document = ET.SubElement(root, "Document")
    ET.SubElement(document, "name").text = "Flight plan"
    said = f"{_of_plan(plan)} Brought to WGS 84 by {operation}."
    ET.SubElement(document, "description").text = said
    for flight, colour in FLIGHTS.items():
        _style(document, flight, colour, "placemark_circle", 0.4)
    _style(document, "control", CONTROL, "triangle", 0.9)
    _style(document, "area", BORDER, "shaded_dot", 0.4)
    border = add_folder(document, "Area")
    for part in shapely.get_parts(area.shape):
        _area(add_mark(border, "Area", "area"), part, to_degrees)
    lines = add_folder(document, "Flight lines")
    for row in flown.flight_lines.itertuples():
        ends = [row.start_easting, row.start_northing, row.altitude]
        ends = np.array([ends, [row.end_easting, row.end_northing, row.altitude]])
        placemark = add_mark(lines, row.line_id, row.flight)
        _shape(placemark, "LineString", to_degrees(ends))
    table = flown.photographs
    places = to_degrees(table[["easting", "northing", "altitude"]].to_numpy(float))
    for name in FLIGHTS:
        of_flight = add_folder(document, f"Photographs, {name.replace('_', ' ')}")
        for k in np.flatnonzero(table["flight"] == name):
            placemark = add_mark(of_flight, table["photo_id"].iat[k], name)
            _shape(placemark, "Point", places[k : k + 1])
    control = add_folder(document, "Control")
    places = to_degrees(
        flown.control[["easting", "northing", "height"]].to_numpy(float)
    )
    for name, place in zip(flown.control["point_id"], places, strict=True):
        # on the ground, whatever its height
        _shape(add_mark(control, name, "control"), "Point", place[None, :2])
    write_bytes(path, xml_bytes(root))


def _places(flown):
    """Where lines, photographs and control lie, arrays (n, 2) [m]."""
    lines, plan = flown.flight_lines, ["easting", "northing"]
    for end in ("start", "end"):
        yield lines[[f"{end}_{axis}" for axis in plan]].to_numpy(float)
    for table in (flown.photographs, flown.control):
        yield table[plan].to_numpy(float)


def _degrees(xyz, operation):
    """Longitude and latitude of places, with heights if they have them."""
    return np.column_stack([operation.apply(xyz[:, :2])[:, :2], xyz[:, 2:]])


def _way_to_wgs_84(xy, crs):
    flat, target = read_crs(crs).to_2d(), read_source_crs(WGS_84)
    reason = mark("since KML is for a look at the plan")
    demand = Demand(GOOD_ENOUGH, reason, is_fixed=True)
    _, operation, _ = reproject(xy, flat, target, demand)
    return operation


def _shape(mark, kind, places):
    """Write places (n, 2) on the ground, or (n, 3) at their altitudes."""
    shape = ET.SubElement(mark, kind)
    has_altitude = places.shape[1] == 3 and np.isfinite(places[:, 2]).all()
    if has_altitude:
        ET.SubElement(shape, "altitudeMode").text = "absolute"
    ET.SubElement(shape, "coordinates").text = _text(places, has_altitude)


def _text(places, has_altitude=False):
    return " ".join(
        f"{p[0]:.9f},{p[1]:.9f}" + (f",{p[2]:.1f}" if has_altitude else "")
        for p in places
    )


def _area(mark, polygon, to_degrees):
    import shapely  # noqa: PLC0415 - loaded when a file is written

    shape = ET.SubElement(mark, "Polygon")
    for name, ring in [
        ("outerBoundaryIs", polygon.exterior),
        *(("innerBoundaryIs", hole) for hole in polygon.interiors),
    ]:
        border = ET.SubElement(ET.SubElement(shape, name), "LinearRing")
        places = to_degrees(shapely.get_coordinates(ring))
        ET.SubElement(border, "coordinates").text = _text(places)


def _style(document, name, colour, icon, scale):
    style = add_style(document, name, colour, icon, (scale, 0.5))
    line = ET.SubElement(style, "LineStyle")
    ET.SubElement(line, "color").text = colour
    ET.SubElement(line, "width").text = "2"
    ET.SubElement(ET.SubElement(style, "PolyStyle"), "fill").text = "0"
