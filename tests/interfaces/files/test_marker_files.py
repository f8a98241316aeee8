"""Control that other programs measured in images."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from fuzz.foreign_files import MARKERS as XML

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.files.marker_files import read_opensfm
from einschalt.interfaces.files.metashape_markers import read_metashape
from einschalt.interfaces.files.odm_lists import read_odm, write_odm


def written(tmp_path, name, text):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / name


def test_two_images_of_one_name_remain_two(tmp_path):
    """Cameras begin to count again on every card: DJI_0001 of two flights."""
    text = XML.replace('label="B.JPG"', 'label="A.JPG"')
    text = text.replace('<marker id="22" label="tie"/>', '<marker id="22" label="P1"/>')
    markers = read_metashape(written(tmp_path, "m.xml", text))
    images = markers.measurements["image_id"].tolist()
    assert images == ["A.JPG (0)", "A.JPG (7)", "A.JPG (7)"]
    assert any("2 images named like another" in note for note in markers.notes)


def test_the_system_of_markers_is_theirs_and_not_that_of_the_cameras(tmp_path):
    """Since 2.0 each has its own: GNSS of the drone in WGS 84, control in UTM."""
    old = "<reference>EPSG:4326</reference>"
    text = XML.replace(old, f"{old}<marker_reference>EPSG:25833</marker_reference>")
    markers = read_metashape(written(tmp_path, "m.xml", text))
    assert markers.crs == "EPSG:25833"
    assert {"easting", "northing"} <= set(markers.control_points())


def test_markers_without_coordinates_state_no_accuracies(tmp_path):
    text = re.sub("<reference x=[^>]*/>", "", XML)
    markers = read_metashape(written(tmp_path, "m.xml", text))
    assert len(markers.points) == 0
    assert not any("accuracies" in note for note in markers.notes)


def test_metashape_markers_are_read_and_said(tmp_path):
    markers = read_metashape(written(tmp_path, "m.xml", XML))
    assert markers.control_points().to_dict("list") == {
        "point_id": ["P1", "P2"],
        "longitude": [13.5, 13.6],
        "latitude": [48.25, 48.26],
        "height": [411.5, 412.0],
        "role": ["control", "check"],
    }
    assert markers.measurements.to_numpy().tolist() == [
        ["A.JPG", "P1", 1.5, 2.25],
        ["B.JPG", "P2", 3.0, 4.0],
        ["B.JPG", "tie", 5.0, 6.0],
    ]
    assert markers.notes == (
        "m.xml: 1 position predicted and not measured, left out",
        "m.xml: 1 marker not enabled, taken for check points",
    )


def test_switches_of_older_versions_are_known(tmp_path):
    old = XML.replace('"true"', '"1"').replace('"false"', '"0"')
    here, there = (
        read_metashape(written(tmp_path, "m.xml", text)) for text in (XML, old)
    )
    pd.testing.assert_frame_equal(here.points, there.points)
    pd.testing.assert_frame_equal(here.measurements, there.measurements)
    assert here.notes == there.notes


@pytest.mark.parametrize(
    ("first", "second", "usual", "plan", "height"),
    [
        ('sx="0.03" sy="0.04" sz="0.1"', 'sxy="0.02" sz="0.05"', "", 2**0.5 * 0.02, 1),
        ('sx="0.03" sy="0.04"', 'sxy="0.02" sz="0.05"', "", 2**0.5 * 0.02, 0),
        ('sx="0.03" sy="0.04" sz="0.1"', "", "0.01", 2**0.5 * 0.01, 1),
        ('sx="0.03" sy="0.04" sz="0.1"', 'sxyz="0.02"', "0.01", 2**0.5 * 0.02, 1),
        ('sx="0.03" sy="0.04" sz="0.1"', 'sxyz="0"', "", None, 0),
        ("", "", "0.005", None, 0),  # set by the program, stated by nobody
    ],
)
def test_accuracies_of_markers_are_standard_errors(
    tmp_path, first, second, usual, plan, height
):
    text = XML.replace('z="411.5"', f'z="411.5" {first}')
    text = text.replace('z="412"', f'z="412" {second}')
    stated = f'<settings><property name="accuracy_markers" value="{usual}"/></settings>'
    text = text.replace("<frames>", f"{stated if usual else ''}<frames>")
    markers = read_metashape(written(tmp_path, "m.xml", text))
    table, notes = markers.control_points(), " ".join(markers.notes)
    if plan is None:
        assert "standard_error_m" not in table
        assert ("left out, since some points have no accuracy" in notes) == bool(first)
    else:
        np.testing.assert_allclose(table["standard_error_m"], [0.05, plan])
        assert "its accuracies are standard errors of these points" in notes
    assert ("standard_error_height" in table) == bool(height)


def test_a_list_of_odm_comes_back(tmp_path):
    markers = read_metashape(written(tmp_path, "m.xml", XML))
    write_odm(tmp_path / "gcp_list.txt", markers)
    back = read_odm(tmp_path / "gcp_list.txt")
    assert back.crs == "EPSG:4326"
    pd.testing.assert_frame_equal(back.points, markers.points)
    known = markers.measurements[markers.measurements["point_id"] != "tie"]
    pd.testing.assert_frame_equal(back.measurements, known)


def test_points_of_odm_without_names_are_told_apart_by_their_places(tmp_path):
    text = (
        "WGS84 UTM 33N\n# by hand\n5e5 5.3e6 400 1 2 a.jpg\n6e5 5.3e6 NaN 3 4 a.jpg\n"
    )
    text += "5e5 5.3e6 400 5 6 b.jpg\n"
    markers = read_odm(written(tmp_path, "gcp_list.txt", text))
    assert markers.crs == "EPSG:32633"
    assert markers.measurements["point_id"].tolist() == ["1", "2", "1"]
    assert list(markers.control_points())[:3] == ["point_id", "easting", "northing"]


def test_tabs_leave_blanks_in_names(tmp_path):
    rows = [
        ["5e5", "5.3e6", "400", "1", "2", "my image.jpg", "P 1"],
        ["5e5", "5.3e6", "400", "3", "4", "b.jpg", "P 1", "", "0.02"],
        ["6e5", "5.3e6", "400", "3", "4", "b.jpg", ""],
    ]
    rows = map("\t".join, rows)
    text = "\n".join(["EPSG:32633", *rows, ""])
    markers = read_odm(written(tmp_path, "gcp_list.txt", text))
    assert markers.measurements.to_numpy().tolist() == [
        ["my image.jpg", "P 1", 1.0, 2.0],
        ["b.jpg", "P 1", 3.0, 4.0],
        ["b.jpg", "1", 3.0, 4.0],
    ]
    said = "gcp_list.txt: columns behind the name of the point are left out"
    assert markers.notes == (said,)
    text = text.partition("\tP 1\t\t")[0] + "\n"
    assert not read_odm(written(tmp_path, "gcp_list.txt", text)).notes


def test_numbers_of_unnamed_points_are_free(tmp_path):
    text = "WGS84\n1 2 3 4 5 a.jpg\n2 2 3 4 5 b.jpg 1\n3 2 3 4 5 c.jpg\n"
    markers = read_odm(written(tmp_path, "gcp_list.txt", text))
    assert markers.points["point_id"].tolist() == ["2", "1", "3"]


def test_a_measurement_that_stands_twice_counts_once(tmp_path):
    text = "WGS84\n1 2 3 4 5 a.jpg P\n1 2 3 4 5 a.jpg P\n1 2 3 4 5 b.jpg P\n"
    markers = read_odm(written(tmp_path, "gcp_list.txt", text))
    assert markers.measurements["image_id"].tolist() == ["a.jpg", "b.jpg"]
    assert "gcp_list.txt: 1 repeated measurement left out" in markers.notes


def test_control_of_opensfm_is_turned_into_pixels(tmp_path):
    seen = {"shot_id": "a.jpg", "projection": [-0.25, 0.125]}
    point = {"id": "7", "observations": [seen]}
    point["position"] = {"latitude": 52.5, "longitude": 13.4}
    file = tmp_path / "ground_control_points.json"
    written(tmp_path, file.name, json.dumps({"points": [point]}))
    with pytest.raises(EinschaltError, match=r"size of image a\.jpg is unknown"):
        read_opensfm(file)
    cameras = {"c": {"width": 4000, "height": 3000}}
    part = {"cameras": cameras, "shots": {"a.jpg": {"camera": "c"}}}
    written(tmp_path, "reconstruction.json", json.dumps([part]))
    markers = read_opensfm(file)
    # from the middle, in units of the longer side; pixel centres are whole
    xy = markers.measurements[["x", "y"]].to_numpy(float)
    np.testing.assert_allclose(xy, [[1999.5 - 1000.0, 1499.5 + 500.0]])
    assert "height" not in markers.control_points()
    # OpenSfM could not orient b.jpg, where the point was measured as well
    point["observations"].append({**seen, "shot_id": "b.jpg"})
    written(tmp_path, file.name, json.dumps({"points": [point]}))
    found = read_opensfm(file)
    pd.testing.assert_frame_equal(found.measurements, markers.measurements)
    said = "1 image that no reconstruction has, left out: b.jpg"
    assert found.notes == (f"ground_control_points.json: {said}",)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("m.xml", XML[:300], r"m\.xml, row 8: is no whole XML"),
        ("m.xml", XML.replace('camera_id="0"', 'camera_id="5"'), "camera 5 or marker"),
        ("m.xml", XML.replace('x="1.5"', 'x="l.5"'), "'l.5' is not a number"),
        (
            "m.xml",
            XML.replace("<document", "<!DOCTYPE d []><document"),
            "document type",
        ),
        ("m.xml", XML.replace('label="B.JPG"', ""), r"'\? P2 3\.0 4\.0' lacks a name"),
        ("m.xml", "<document/>", "holds nothing that is known"),
        ("gcp_list.txt", "# of March\n", "holds no line but comments.*Export"),
        ("gcp_list.txt", "EPSG:4326\n1 2 3 4 a.jpg\n", "row 2: '1 2 3 4 a.jpg' is no"),
        ("gcp_list.txt", "Gauß\n1 2 3 4 5 a.jpg\n", "row 1: 'Gauß' is no reference"),
        (
            "gcp_list.txt",
            "WGS84\n1 2 3 4 5 a.jpg P\n1 2 4 4 5 b.jpg P\n",
            "row 3: point P has other coordinates",
        ),
        (
            "gcp_list.txt",
            "WGS84\n1 2 3 4 5 a.jpg P\n1 2 3 4 6 a.jpg P\n",
            "row 3: point P is measured in image a.jpg twice",
        ),
        *(
            (
                "gcp_list.txt",
                f"WGS84\n1 2 3 4 5 {names}\n",
                r"row 2: '1 2 3 4 5 .*' may have a name with blanks.*by tabs",
            )
            for names in (
                "a.jpg P 1",
                "my image.jpg P1",
                "my image.jpg",
                "a.jpg P1 0.02",
                "a.jpg\tP 1",
            )
        ),
        ("gcp_list.txt", "WGS84\n1\t2\t3\t4\t5\t\tP\n", "row 2: .* is no measurement"),
        (
            "gcp_list.txt",
            "WGS84\n1 2 3 4 5 a.jpg CHK-P\n1 2 3 4 5 b.jpg Q\n2 2 3 4 6 b.jpg P\n",
            "row 4: point P is marked CHK- in some lines, in others not",
        ),
        ("g.json", '{"points": [', r"g\.json, row 1: is no whole JSON"),
        ("g.json", '{"points": [{"id": 1}]}', "holds no measurement"),
        ("g.json", '{"points": [{}]}', "holds no points as OpenSfM writes them"),
    ],
)
def test_damaged_files_are_refused_with_line_and_remedy(tmp_path, name, text, said):
    readers = {
        "m.xml": read_metashape,
        "gcp_list.txt": read_odm,
        "g.json": read_opensfm,
    }
    with pytest.raises(EinschaltError, match=said):
        readers[name](written(tmp_path, name, text))


def test_a_list_names_the_names_with_blanks_alone(tmp_path):
    text = XML.replace('label="P1"', 'label="P 1"').replace('"B.JPG"', '"B 2.JPG"')
    markers = read_metashape(written(tmp_path, "m.xml", text))
    with pytest.raises(EinschaltError) as refused:
        write_odm(tmp_path / "gcp_list.txt", markers)
    assert refused.value.found == "names with blanks: 'B 2.JPG', 'P 1'"
