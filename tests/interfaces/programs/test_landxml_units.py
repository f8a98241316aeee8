"""Points of LandXML in the unit of their system."""

import pytest

import einschalt as es
from einschalt.interfaces.programs.recognised import read_foreign

US_FOOT = 1200.0 / 3937.0
IN_FEET = "EPSG:2263"  # New York, US survey feet
PLACE = ["easting", "northing", "height"]


@pytest.fixture
def land(tmp_path):
    """Function of the unit and the code of a file: its path."""

    def written(unit, code=None, point="212522.519 989791.457 10"):
        system = "" if code is None else f'<CoordinateSystem epsgCode="{code}"/>'
        (tmp_path / "a.xml").write_text(
            f'<LandXML><Units><Imperial linearUnit="{unit}"/></Units>{system}<CgPoints>'
            f'<CgPoint name="A">{point}</CgPoint></CgPoints></LandXML>'
        )
        return tmp_path / "a.xml"

    return written


def place_of(table):
    return table.loc[0, PLACE].tolist()


def test_points_stay_in_the_unit_of_their_system(land):
    found = read_foreign(land("USSurveyFoot", 2263))
    assert found.crs == IN_FEET
    place = place_of(found.tables["control_points"])
    assert place[:2] == [989791.457, 212522.519]
    assert place[2] == pytest.approx(10 * US_FOOT, rel=1e-12)  # heights of no system
    assert found.notes == ("a.xml: height converted from USSurveyFoot to metres",)


def test_a_system_that_is_said_has_its_unit_as_well(land):
    table = es.read_points(land("USSurveyFoot"), crs=IN_FEET)
    assert place_of(table)[:2] == [989791.457, 212522.519]
    assert table.attrs["crs"] == IN_FEET


@pytest.mark.parametrize(
    ("unit", "code", "crs", "times", "said"),
    [
        ("USSurveyFoot", None, None, US_FOOT, "USSurveyFoot to metres"),
        ("foot", 32618, None, 0.3048, "foot to metres"),
        ("millimeter", None, "EPSG:32618", 1e-3, "millimeter to metres"),
        ("foot", 2263, None, 0.3048 / US_FOOT, "foot to US survey foot"),
        ("meter", 2263, None, 1.0 / US_FOOT, "meter to US survey foot"),
        ("meter", 32618, None, 1.0, None),
        ("meter", None, None, 1.0, None),
        ("", 2263, None, 1.0, None),
    ],
)
def test_what_is_converted_is_told(land, unit, code, crs, times, said):
    table = es.read_points(land(unit, code, "2000 1000"), crs=crs)
    place = table.loc[0, PLACE[:2]].tolist()
    assert place == pytest.approx([1000 * times, 2000 * times], rel=1e-12)
    note = f"a.xml: easting, northing converted from {said}"
    told = () if said is None else (note,)
    assert table.attrs["notes"] == told
