"""The coordinate system of a job in JobXML, where it is one that PROJ knows.

A job names its system as Trimble's library does, and states its projection. A name that
PROJ knows counts where nothing in the job contradicts it: PROJ takes names that are
much alike for each other. Parameters alone name no system, since they lack the datum.
"""

import math
import re
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from einschalt.foundations.column_words import folded
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import ProjectionError
from einschalt.foundations.projections import code_on_earth, label_of, read_source_crs
from einschalt.interfaces.files.plain_xml import each, local, text_of
from einschalt.interfaces.programs.foreign import is_finite

NO_FIT = {"", "NoAdjustment"}
USUAL_AXES = {"", "IncreasingNorthEast"}
UTM_ZONE = re.compile(r"(?:zone\s*)?(\d{1,2})\s*([NS])(?:orth|outh)?", re.IGNORECASE)
TRANSVERSE_MERCATOR = "TransverseMercator"
# of a parameter: its name in the job, its beginning in PROJ, and what rounding may miss
PARAMETERS = (
    ("CentralLatitude", "Latitude of", 1e-7),
    ("CentralLongitude", "Longitude of", 1e-7),
    ("Scale", "Scale factor", 1e-9),
    ("FalseEasting", "False easting", 1e-3),
    ("FalseNorthing", "False northing", 1e-3),
)
LARGEST_AWAY_M, LARGEST_FLATTENING_AWAY = 0.01, 1e-9  # of ellipsoids that are the same


@dataclass(frozen=True)
class _System:
    """What a job says of its system; elements without anything where it says none."""

    names: Element  # of the system, its zone and its datum
    projection: Element
    ellipsoid: Element
    fit: str  # kind of its horizontal adjustment

    @property
    def said(self):
        """Names as the job has them."""
        words = [text_of(self.names, f"{one}Name") for one in ("System", "Zone")]
        return shortened(", ".join(word for word in words if word), 60)

    @property
    def kind(self):
        """Kind of the projection; empty where there is none."""
        return text_of(self.projection, "Type")


def system_of(root, source):
    """Code of the system of a job's grid, None where none is known; notes."""
    system = _stated(root)
    if not (system.said or system.kind):
        return None, []
    said = system.said or system.kind
    if system.fit not in NO_FIT:
        fit = shortened(system.fit, 40)
        note = (
            f"{source}: the system of the job, {said}, is fitted to its site ({fit}): "
            "its coordinates are local ones"
        )
        return None, [note]
    found = (code for name in _names(system) if (code := _code(name, system)))
    code = next(found, None)
    if code is not None:
        label = label_of(code)
        return code, [f"{source}: the system of the job, {said}, is {label}"]
    parameters = _parameters(system)
    note = (
        f"{source}: the system of the job, {said}, is none that is known by this name: "
        f"say which one it is; its projection is {parameters}"
    )
    return None, [note]


def _stated(root):
    """What holds at the end of a job; its field book has one record after the other."""
    whole = _last(root, "CoordinateSystem")
    if len(whole):
        projection, ellipsoid = (
            _last(whole, name) for name in ("Projection", "Ellipsoid")
        )
        fit = text_of(whole, "HorizontalAdjustment", "Type")
        return _System(whole, projection, ellipsoid, fit)
    return _System(
        _last(root, "CoordinateSystemRecord"),
        _last(_last(root, "ProjectionRecord"), "Projection"),
        _last(root, "EllipsoidRecord"),
        text_of(_last(root, "HorizontalAdjustmentRecord"), "Type"),
    )


def _last(element, name):
    found = list(each(element, name))
    return found[-1] if found else Element(name)


def _names(system):
    """Names under which PROJ may know it, codes first."""
    for one in system.names.iter():
        code = (one.text or "").strip().upper().removeprefix("EPSG:")
        if "epsg" in local(one).casefold() and code.isdigit():
            yield f"EPSG:{code}"
    parts = ("SystemName", "ZoneName", "DatumName")
    whole, zone, datum = (text_of(system.names, part) for part in parts)
    utm = UTM_ZONE.fullmatch(zone)
    if utm and "UTM" in whole.upper().split():
        yield f"{datum} / UTM zone {utm[1]}{utm[2].upper()}"
    # a number alone is the code of another system
    for name in (zone, f"{whole} / {zone}", f"{datum} / {zone}", f"{whole} {zone}"):
        if any(map(str.isalpha, name)) and zone:
            yield name


def _code(name, system):
    """Code of what PROJ takes a name for, if it is a plane system and may be meant."""
    code = code_on_earth(name)
    if code is None:
        return None
    try:
        crs = read_source_crs(code)
    except ProjectionError:
        return None
    if not crs.is_projected or text_of(system.projection, "SouthAzimuth") == "true":
        return None
    axes = text_of(system.projection, "GridOrientation")
    agrees = axes in USUAL_AXES and _has_its_ellipsoid(crs, system.ellipsoid)
    if system.kind == TRANSVERSE_MERCATOR:
        agrees &= _has_its_parameters(crs, system.projection)
    else:
        is_code = name.startswith("EPSG:")
        agrees &= is_code or folded(crs.name).endswith(folded(name))
    return code if agrees else None


def _has_its_ellipsoid(crs, ellipsoid):
    words = [text_of(ellipsoid, name) for name in ("EarthRadius", "Flattening")]
    if not all(map(is_finite, words)):
        return True
    radius, flattening = map(float, words)
    inverse = crs.ellipsoid.inverse_flattening
    own = 1.0 / inverse if inverse else 0.0
    return (
        abs(radius - crs.ellipsoid.semi_major_metre) < LARGEST_AWAY_M
        and abs(flattening - own) < LARGEST_FLATTENING_AWAY
    )


def _has_its_parameters(crs, projection):
    operation = crs.coordinate_operation
    if "Transverse Mercator" not in operation.method_name:
        return False
    for name, beginning, within in PARAMETERS:
        said = text_of(projection, name)
        found = [p for p in operation.params if p.name.startswith(beginning)]
        if not (is_finite(said) and found):
            return False
        factor = found[0].unit_conversion_factor
        is_angle = name.startswith("Central")
        own = found[0].value * (math.degrees(factor) if is_angle else factor)
        if abs(float(said) - own) > within:
            return False
    return True


def _parameters(system):
    """Kind and numbers of the projection, by the names of the job."""
    texts = {local(one): (one.text or "").strip() for one in system.projection}
    numbers = [f"{n} {text}" for n, text in texts.items() if is_finite(text)]
    return shortened(", ".join([system.kind or "none", *numbers]), 200)
