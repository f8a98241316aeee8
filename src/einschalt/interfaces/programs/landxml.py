"""Points as LandXML 1.2 (CgPoints): northing, easting, height, as its schema orders.

Read from files of any version, whatever their namespace.
"""

from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd

from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import child, each, read_xml, xml_bytes
from einschalt.interfaces.programs.foreign import Foreign, is_finite

NAMESPACE = "http://www.landxml.org/schema/LandXML-1.2"
EXPECTED = "LandXML with CgPoints"
METRES = {"meter": 1.0, "millimeter": 1e-3, "centimeter": 1e-2}
METRES |= {"foot": 0.3048, "USSurveyFoot": 1200.0 / 3937.0, "kilometer": 1e3}


def write_landxml(handed, path):
    """Write the points; their kinds as codes, 0.1 mm."""
    date, _, time = handed.created.partition("T")
    root = ET.Element(
        "LandXML",
        {
            "xmlns": NAMESPACE,
            "version": "1.2",
            "date": date or "1970-01-01",
            "time": time[:8] or "00:00:00",
        },
    )
    units = ET.SubElement(root, "Units")
    ET.SubElement(
        units,
        "Metric",
        areaUnit="squareMeter",
        linearUnit="meter",
        volumeUnit="cubicMeter",
        temperatureUnit="celsius",
        pressureUnit="milliBars",
        angularUnit="grads",
        directionUnit="grads",
    )
    if handed.crs is not None:
        system = ET.SubElement(root, "CoordinateSystem", name=handed.crs)
        authority, _, code = handed.crs.partition(":")
        if authority.upper() == "EPSG" and code.isdigit():
            system.set("epsgCode", code)
    ET.SubElement(root, "Project", name=handed.name or "einschalt")
    ET.SubElement(root, "Application", name="einschalt")
    group = ET.SubElement(root, "CgPoints", name="densified points")
    points = handed.points
    xyz = np.column_stack([points[["northing", "easting"]], handed.heights])
    for name, role, place in zip(points["point_id"], points["role"], xyz, strict=True):
        one = ET.SubElement(group, "CgPoint", name=str(name), code=str(role))
        one.text = " ".join(f"{value:.4f}" for value in place if np.isfinite(value))
    path.write_bytes(xml_bytes(root))


def is_landxml(head):
    """Whether the first bytes of a file look so."""
    return b"<LandXML" in head


def read_landxml(file) -> Foreign:
    """Read the points of a file in the unit that it states.

    References to other points are left out.
    """
    root = read_xml(file.data, file.source, EXPECTED)
    units = child(root, "Units")
    units = None if units is None or not len(units) else units[0]
    unit = "" if units is None else units.get("linearUnit", "")
    if unit and unit not in METRES:
        raise damaged(file.source, f"the unit {unit!r} is unknown", EXPECTED)
    rows, n_references = [], 0
    for one in each(root, "CgPoint"):
        if one.get("pntRef") is not None:
            n_references += 1
            continue
        words = (one.text or "").split()
        name = one.get("name") or one.get("oID")
        if not name or len(words) not in (2, 3) or not all(map(is_finite, words)):
            said = f"point {name or '?'}: {' '.join(words)[:60]!r} is no place"
            raise damaged(file.source, said, "a name, northing and easting [height]")
        north, east, *height = map(float, words)
        rows.append((name, east, north, height[0] if height else np.nan))
    names = ["point_id", "easting", "northing", "height"]
    if not rows:
        raise damaged(file.source, "holds no CgPoint with coordinates", EXPECTED)
    notes = [f"{n_references} references to points left out"] if n_references else []
    table = pd.DataFrame(rows, columns=names).dropna(axis=1, how="all")
    system = child(root, "CoordinateSystem")
    code = None if system is None else system.get("epsgCode")
    crs = f"EPSG:{code}" if code and code.isdigit() else None
    stated = {"unit": unit, "unit_m": METRES[unit]} if unit else {}
    return Foreign({"control_points": table}, crs, tuple(notes), **stated)
