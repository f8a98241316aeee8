"""Points of drawings: numbers and heights in attributes, and the unit."""

import math

import ezdxf
import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.programs.recognised import read_foreign


@pytest.fixture
def read(tmp_path):
    """Function of block references (place, attributes), points, and the unit."""

    def drawn(references=(), points=(), unit=6):
        drawing = ezdxf.new("R2010", units=unit)
        space = drawing.modelspace()
        drawing.blocks.new("PT")
        for place, attributes in references:
            one = space.add_blockref("PT", place)
            for tag, text in attributes.items():
                one.add_attrib(tag, text)
        for place in points:
            space.add_point(place)
        drawing.saveas(tmp_path / "a.dxf")
        return read_foreign(tmp_path / "a.dxf")

    return drawn


def heights_of(found):
    return found.tables["control_points"]["height"].tolist()


@pytest.mark.parametrize("tag", ["H", "Z", "HOEHE", "Höhe", "HEIGHT", "quota"])
@pytest.mark.parametrize("z", [0.0, 513.0999])
def test_heights_stand_in_attributes(read, tag, z):
    found = read([((1, 2, z), {"NR": "A", tag: "513.1"})])
    assert heights_of(found) == [513.1]
    assert found.notes == ()


def test_a_decimal_comma_is_told(read):
    found = read([((1, 2, 0), {"NR": "A", "HEIGHT": "513,1"})])
    assert heights_of(found) == [513.1]
    assert found.notes == ("a.dxf: 1 height with a decimal comma, such as '513,1'",)


@pytest.mark.parametrize("text", ["n/a", "1.234,5", "513.1 m"])
def test_a_height_that_is_no_number_is_told(read, text):
    found = read(
        [((1, 2, 0), {"NR": "A", "H": text}), ((1, 3, 7), {"NR": "B", "H": ""})]
    )
    assert math.isnan(heights_of(found)[0])
    assert heights_of(found)[1] == 7.0
    assert found.notes == (f"a.dxf: heights that are no number left out: '{text}'",)


@pytest.mark.parametrize(
    ("z", "attributes", "said"),
    [
        (500, {"H": "512.3"}, "height 512.3 in H and 500 in z"),
        (500, {"HEIGHT": "512.3"}, "height 512.3 in HEIGHT and 500 in z"),
        (0, {"H": "512.3", "Z": "2.0"}, "height 512.3 in H and 2 in Z"),
        (512.34, {"H": "512.3", "Z": "512.36"}, "height 512.3 in H and 512.36 in Z"),
    ],
)
def test_heights_that_contradict_each_other_are_refused(read, z, attributes, said):
    is_rounding = attributes.get("Z") == "512.36"
    references = [((1, 2, z), {"NR": "A", **attributes})]
    if is_rounding:
        assert heights_of(read(references)) == [512.3]
        return
    with pytest.raises(EinschaltError, match=f"point A has the {said}.*Correct"):
        read(references)


def test_numbers_of_unnamed_points_are_free(read):
    references = [((1, 2, 3), {"NR": "1"}), ((2, 2, 3), {"NR": " "})]
    references += [((9, 9, 9), {"CODE": "tree"})]
    found = read(references, points=[(3, 2, 3), (4, 2, 3)])
    table = found.tables["control_points"]
    assert table["point_id"].tolist() == ["1", "2", "3", "4"]
    assert table["easting"].tolist() == [1.0, 2.0, 3.0, 4.0]
    assert found.notes == ("a.dxf: 3 points without a number, numbered",)


@pytest.mark.parametrize(
    ("unit", "said"), [(0, None), (6, None), (2, "feet"), (4, "millimetres"), (9, "9")]
)
def test_a_unit_other_than_metres_is_told(read, unit, said):
    found = read([((1, 2, 3), {"NR": "A"})], unit=unit)
    assert heights_of(found) == [3.0]
    assert len(found.notes) == (said is not None)
    assert all(f"{said} ($INSUNITS)" in note for note in found.notes)


def test_points_of_a_vrt_have_free_numbers_and_heights_of_their_own(tmp_path):
    gcp = '<GCP Id="{}" Pixel="{}" Line="0" X="10" Y="20" {}/>'
    gcps = gcp.format("2", 0, 'Z="5"') + gcp.format("", 1, "")
    text = f'<VRTDataset><GCPList Projection="EPSG:31255">{gcps}</GCPList></VRTDataset>'
    (tmp_path / "a.vrt").write_text(text)
    found = read_foreign(tmp_path / "a.vrt")
    assert found.tables["control_points"]["point_id"].tolist() == ["2", "1"]
    assert found.tables["image_points"]["point_id"].tolist() == ["2", "1"]
    assert heights_of(found)[0] == 5.0
    assert math.isnan(heights_of(found)[1])
    assert found.notes == ("a.vrt: 1 point without a number, numbered",)
    (tmp_path / "a.vrt").write_text(text.replace('Z="5"', 'Z="n/a"'))
    with pytest.raises(EinschaltError, match="a GCP has the height 'n/a'"):
        read_foreign(tmp_path / "a.vrt")


@pytest.mark.parametrize(
    ("system", "mapping", "is_exchanged"),
    [
        ("EPSG:31467", "2,1", False),
        ("EPSG:31467", "1,2", True),  # whose first axis is the northing
        ("EPSG:32633", "1,2", False),
        ("EPSG:32633", "2,1", True),
        ("EPSG:4326", "2,1", False),
        ("EPSG:4326", "1,2", True),
        ("EPSG:3031", "1,2", False),  # whose axes both point to the north
        ("EPSG:3031", "2,1", True),
    ],
)
def test_gcps_have_their_axes_in_the_order_that_a_vrt_maps(
    tmp_path, system, mapping, is_exchanged
):
    """X was taken for the easting, whatever the mapping says."""
    text = (
        f'<VRTDataset><GCPList Projection="{system}" '
        f'dataAxisToSRSAxisMapping="{mapping}"><GCP Id="A" Pixel="1" Line="2" '
        'X="13.5" Y="48.25" Z="7"/></GCPList></VRTDataset>'
    )
    (tmp_path / "a.vrt").write_text(text)
    table = read_foreign(tmp_path / "a.vrt").tables["control_points"]
    place = [48.25, 13.5] if is_exchanged else [13.5, 48.25]
    assert table.iloc[0, 1:4].tolist() == [*place, 7.0]
    (tmp_path / "a.vrt").write_text(text.replace(mapping, "x,1"))
    with pytest.raises(EinschaltError, match="dataAxisToSRSAxisMapping is 'x,1'"):
        read_foreign(tmp_path / "a.vrt")


def gauss_krueger(axes=""):
    """WKT 1 of EPSG:31467, whose axes PROJ takes for those of EPSG:5677 without any."""
    return f"""PROJCS["DHDN / 3-degree Gauss-Kruger zone 3",GEOGCS["DHDN",
    DATUM["Deutsches_Hauptdreiecksnetz",SPHEROID["Bessel 1841",6377397.155,
    299.1528128]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],
    PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],
    PARAMETER["central_meridian",9],PARAMETER["scale_factor",1],
    PARAMETER["false_easting",3500000],PARAMETER["false_northing",0],
    UNIT["metre",1]{axes},AUTHORITY["EPSG","31467"]]"""


AXES = ',AXIS["{}",{}],AXIS["{}",{}]'
NORTHING_FIRST = AXES.format("Northing", "NORTH", "Easting", "EAST")
EASTING_FIRST = AXES.format("Easting", "EAST", "Northing", "NORTH")


@pytest.mark.parametrize(
    ("axes", "mapping", "is_exchanged"),
    [
        ("", "2,1", False),  # the area tells
        ("", "1,2", False),
        (NORTHING_FIRST, "2,1", False),
        (NORTHING_FIRST, "1,2", True),
        (EASTING_FIRST, "1,2", False),
        (EASTING_FIRST, "2,1", True),
    ],
)
def test_axes_of_a_vrt_are_those_that_it_writes(tmp_path, axes, mapping, is_exchanged):
    """They were those of the code that PROJ guesses, which has them exchanged."""
    place = [5400000.0, 3500000.0] if is_exchanged else [3500000.0, 5400000.0]
    system = gauss_krueger(axes).replace('"', "&quot;")
    (tmp_path / "a.vrt").write_text(
        f'<VRTDataset><GCPList Projection="{system}" '
        f'dataAxisToSRSAxisMapping="{mapping}"><GCP Id="A" Pixel="1" Line="2" '
        f'X="{place[0]}" Y="{place[1]}"/></GCPList></VRTDataset>'
    )
    found = read_foreign(tmp_path / "a.vrt")
    table = found.tables["control_points"]
    assert table.iloc[0, 1:3].tolist() == [3500000.0, 5400000.0]
    assert found.notes == ()


@pytest.mark.parametrize("system", ["EPSG:5513", "LOCAL_CS[&quot;a&quot;]"])
def test_a_mapping_of_axes_that_is_not_used_is_told(tmp_path, system):
    (tmp_path / "a.vrt").write_text(
        f'<VRTDataset><GCPList Projection="{system}" dataAxisToSRSAxisMapping="2,1">'
        '<GCP Pixel="1" Line="2" X="3" Y="4"/></GCPList></VRTDataset>'
    )
    found = read_foreign(tmp_path / "a.vrt")
    said = "not used: X is taken for the easting, Y for the northing"
    assert found.notes == (f"a.vrt: dataAxisToSRSAxisMapping {said}",)
    assert found.tables["control_points"].iloc[0, 1:3].tolist() == [3.0, 4.0]
