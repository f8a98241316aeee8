"""Points as KML, for a look at them on the globe: longitude and latitude of WGS 84."""

from xml.etree import ElementTree as ET

import numpy as np

from einschalt.foundations.errors import FileError
from einschalt.foundations.language import mark
from einschalt.foundations.operation_choice import Demand
from einschalt.foundations.projections import (
    WGS_84,
    read_crs,
    read_source_crs,
    reproject,
)
from einschalt.interfaces.files.plain_xml import xml_bytes

NAMESPACE = "http://www.opengis.net/kml/2.2"
GOOD_ENOUGH = 30.0  # metres: the imagery below is not everywhere better
ICON = "http://maps.google.com/mapfiles/kml/shapes/{}.png"
STYLES = {  # icon, colour as alpha, blue, green, red
    "new": ("shaded_dot", "ffffffff"),
    "control": ("triangle", "ff005ed5"),
    "check": ("square", "ffb27200"),
}
SHOWN = ("easting", "northing", "height", "standard_error_checked", "n_models", "role")


def write_kml(handed, path):
    """Write the points; gives a note of the operation by which they came there."""
    if handed.crs is None:
        raise FileError(
            "the result has no reference system, and KML has longitude and latitude",
            expected="crs in [block] of block.toml",
            remedy="Name the system and compute the block again",
            file=path.name,
        )
    xy = handed.coordinates[:, :2]
    reason = mark("since KML is for a look at the points")
    demand = Demand(GOOD_ENOUGH, reason, is_fixed=True)
    flat, target = read_crs(handed.crs).to_2d(), read_source_crs(WGS_84)
    degrees, operation, _ = reproject(xy, flat, target, demand)
    root = ET.Element("kml", xmlns=NAMESPACE)
    document = ET.SubElement(root, "Document")
    ET.SubElement(document, "name").text = handed.name or "einschalt"
    for role, (icon, colour) in STYLES.items():
        size = 0.6 if role == "new" else 0.9
        add_style(document, role, colour, icon, (size, 0.6))
    for role in STYLES:
        is_in = (handed.points["role"] == role).to_numpy()
        if is_in.any():
            _add_points(document, role, handed.points[is_in], degrees[is_in])
    path.write_bytes(xml_bytes(root))
    return [f"brought to WGS 84 by {operation}; heights as data, not as altitudes"]


def add_style(document, name, colour, icon, sizes):
    """Add the style of that name; ``sizes`` of icon and label. Gives its element."""
    style = ET.SubElement(document, "Style", id=name)
    shown = ET.SubElement(style, "IconStyle")
    ET.SubElement(shown, "color").text = colour
    of_icon, of_label = map(str, sizes)
    ET.SubElement(shown, "scale").text = of_icon
    ET.SubElement(ET.SubElement(shown, "Icon"), "href").text = ICON.format(icon)
    ET.SubElement(ET.SubElement(style, "LabelStyle"), "scale").text = of_label
    return style


def add_folder(document, name):
    """Add an empty folder; gives its element."""
    folder = ET.SubElement(document, "Folder")
    ET.SubElement(folder, "name").text = name
    return folder


def add_mark(folder, name, style):
    """Add a placemark without a place; gives its element."""
    mark = ET.SubElement(folder, "Placemark")
    ET.SubElement(mark, "name").text = str(name)
    ET.SubElement(mark, "styleUrl").text = f"#{style}"
    return mark


def _add_points(document, role, points, degrees):
    folder = add_folder(document, f"{role} points")
    columns = [name for name in SHOWN if name in points]
    rows = points[columns].to_numpy(dtype=object)
    for name, place, row in zip(points["point_id"], degrees, rows, strict=True):
        mark = add_mark(folder, name, role)
        data = ET.SubElement(mark, "ExtendedData")
        for column, value in zip(columns, row, strict=True):
            if isinstance(value, float) and not np.isfinite(value):
                continue
            one = ET.SubElement(data, "Data", name=column)
            said = f"{value:.4f}" if isinstance(value, float) else str(value)
            ET.SubElement(one, "value").text = said
        point = ET.SubElement(ET.SubElement(mark, "Point"), "coordinates")
        point.text = f"{place[0]:.9f},{place[1]:.9f}"
