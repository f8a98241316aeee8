"""Every public dataclass describes its fields, with their units."""

import dataclasses
import inspect
import re

import pytest

import einschalt as es

KINDS = [
    kind
    for name in es.__all__
    if inspect.isclass(kind := getattr(es, name)) and dataclasses.is_dataclass(kind)
]
# of a result the solution has the tables; these are how it came about
NOT_TOLD = {es.DensificationResult: {"solution", "stopwatch", "examined", "choice"}}
NOT_TOLD[es.DensificationResult] |= {"compares_methods"}
SUFFIXES = {"_um": "[µm]", "_mm": "[mm]", "_m": "[m]"}
METRES = {
    *("spacing", "spacings", "image_format", "image_format_across", "width", "height"),
    *("principal_distance", "control_standard_error", "max_height", "extent", "target"),
    *("reached", "missed", "point_spacing", "unusable_rim", "m_0", "mean_height"),
    *("centre_easting", "centre_northing", "relief", "network_strain", "points"),
    *("values", "plans", "flight_lines", "photographs", "control", "figures", "parts"),
    *("formula", "network_strain_wavelength", "area", "heights", "layout"),
}
RADIANS = {"camera_tilt", "orientation_error"}


def told(kind):
    """What the section of fields says of each."""
    text = inspect.cleandoc(kind.__doc__)
    _, _, section = text.partition("Attributes\n----------\n")
    found, names = {}, []
    for line in section.partition("\n\n")[0].splitlines():
        if line.startswith(" "):
            for name in names:
                found[name] += f" {line.strip()}"
            continue
        head, _, type_of = line.partition(" : ")
        names = head.split(", ")
        found |= dict.fromkeys(names, type_of)
    return found


def unit_of(name):
    """Unit of a field by its name; of lengths that have none there by the table."""
    if name in METRES:
        return "[m]"
    if name in RADIANS:
        return "[rad]"
    return next((u for end, u in SUFFIXES.items() if name.endswith(end)), "")


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_field_is_described_with_its_unit(kind):
    described = told(kind)
    names = {one.name for one in dataclasses.fields(kind) if one.name[0] != "_"}
    assert names - NOT_TOLD.get(kind, set()) <= set(described)
    for name, text in described.items():
        assert hasattr(kind, name) or name in names
        # of Flight an error is said of settings of points, of Block in words
        if (unit := unit_of(name)) and "DataFrame, optional" not in text:
            assert unit in re.sub(r"\[m²\]", "[m]", text), (name, text)


def test_fields_are_told_where_they_are_computed():
    assert len(KINDS) > 15
    for name in ("Block", "PlanSearch", "ExpectedPrecision", "CheckedPlan", "AreaPlan"):
        kind = getattr(es, name)
        assert told(kind) == told(kind.__bases__[0])
    um = told(es.FlightDesign)["m_g_um"]
    assert "of the mean, where it is set several times" in um
