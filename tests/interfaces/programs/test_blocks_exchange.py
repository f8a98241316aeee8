"""BlocksExchange: points with roles, marks from the corner of the image, cameras."""

import numpy as np
import pytest
from fuzz.foreign_files import READ

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.files.camera_toml import camera_of
from einschalt.interfaces.programs.recognised import read_foreign

TEXT = READ["blocks.xml"][0]
OTHER_SYSTEM = (
    "</ControlPoint><ControlPoint><Name>Q</Name><SRSId>1</SRSId></ControlPoint></C"
)


def read(folder, text):
    (folder / "blocks.xml").write_text(text, encoding="utf-8")
    return read_foreign(folder / "blocks.xml")


def test_points_marks_and_camera(tmp_path):
    found = read(tmp_path, TEXT)
    control = found.tables["control_points"].iloc[0]
    assert found.crs == "EPSG:2154"
    assert control["point_id"] == "P 1"
    assert control["role"] == "check"
    place = control[["easting", "northing", "height"]].tolist()
    assert place == [652788.5, 6863015.25, 78.5]
    # of each coordinate: TOTAL is of both
    assert control["standard_error_m"] == pytest.approx(0.01 * np.sqrt(2.0))
    assert control["standard_error_height"] == 0.02
    marks = found.tables["image_points"].to_numpy().tolist()
    assert marks == [["b.jpg", "P 1", 100.5, 200.75], ["a.jpg", "P 1", 900.5, 210.75]]
    keys = found.cameras["cam"]
    # 24 mm over 6000 pixels are 4 um, 20 mm are 5000 pixels
    wanted = {"f": 5000.0, "cx": 10.0, "cy": 0.0, "pixel_size_um": 4.0, "k1": 0.01}
    assert {key: pytest.approx(keys[key]) for key in wanted} == wanted
    assert camera_of(keys) is not None


def test_marks_of_people_are_points_and_those_of_the_program_are_not(tmp_path):
    tie = (
        "<TiePoint>{}<Measurement>{}<PhotoId>4</PhotoId><x>1</x><y>2</y></Measurement>"
        "</TiePoint>"
    )
    ties = tie.format("<Name>T1</Name>", "<Type>User</Type>") + tie.format("", "")
    text = TEXT.replace(
        "</ControlPoints>", f"</ControlPoints><TiePoints>{ties}</TiePoints>"
    )
    marks = read(tmp_path, text).tables["image_points"]
    assert marks["point_id"].tolist() == ["P 1", "P 1", "T1"]


def test_points_of_heights_or_places_alone(tmp_path):
    found = read(tmp_path, TEXT.replace("Full<", "Vertical<"))
    assert "control_points" not in found.tables
    assert any("1 point of heights alone left out" in note for note in found.notes)
    found = read(tmp_path, TEXT.replace("Full<", "Horizontal<"))
    assert "height" not in found.tables["control_points"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<P1>0</P1>", "<P1>0.001</P1>", "cam has P1: its calibration"),
        ("Perspective<", "Fisheye<", "cam is a Fisheye camera"),
        ("<SensorSize>24</SensorSize>", "", "cam states no focal length with the size"),
    ],
)
def test_calibrations_that_are_not_described_are_left_out(tmp_path, old, new, said):
    found = read(tmp_path, TEXT.replace(old, new))
    assert not found.cameras
    assert any(said in note for note in found.notes)
    assert len(found.tables["image_points"]) == 2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("EPSG:2154", "EPSG:4978", "has geocentric control points"),
        ("<PhotoId>5<", "<PhotoId>6<", "point P 1 has a mark in photograph 6, unknown"),
        ("<y>200.25<", "<y>2OO<", "a coordinate of point P 1 is no number: '2OO'"),
        ("<Width>6000<", "<Width>0<", "camera cam has pixels of no size"),
        ("</BlocksExchange>", "", "is damaged|XML"),
        (
            "</ControlPoint>\n    </C",
            OTHER_SYSTEM,
            "has control points of 2 systems",
        ),
    ],
)
def test_what_is_damaged_or_of_several_systems_is_refused(tmp_path, old, new, said):
    assert old in TEXT
    with pytest.raises(EinschaltError, match=said):
        read(tmp_path, TEXT.replace(old, new, 1))
