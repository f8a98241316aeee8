"""Projects of the Open Photogrammetry Format."""

import json

import numpy as np
import pytest
from fuzz.foreign_files import OPF, OPF_FILES

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.interfaces.files.camera_toml import camera_of
from einschalt.interfaces.files.input_files import companions
from einschalt.interfaces.files.understood_tables import Said
from einschalt.interfaces.new_block.looked_at import files_below, look_at
from einschalt.interfaces.new_block.proposal import propose
from einschalt.interfaces.programs.block_tables import read_camera
from einschalt.interfaces.programs.recognised import read_foreign

POINTS, CALIBRATED = "input_control_points.json", "calibrated_cameras.json"
CAMERAS, FRAME, LIST = "input_cameras.json", "frame.json", "camera_list.json"


@pytest.fixture
def project(tmp_path):
    for name, text in ({"project.opf": OPF} | OPF_FILES).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / "project.opf"


def change(project, name, *changes):
    text = (project.parent / name).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (project.parent / name).write_text(text, encoding="utf-8")


def without(project, kind):
    """Take the items of a kind out of the project."""
    given = json.loads(project.read_text(encoding="utf-8"))
    given["items"] = [one for one in given["items"] if one["type"] != kind]
    project.write_text(json.dumps(given), encoding="utf-8")


def test_points_have_the_axes_of_their_system(project):
    """EPSG:31255 has the northing first: the project follows it."""
    found = read_foreign(project)
    assert found.crs == "EPSG:31255+5778"
    (row,) = found.tables["control_points"].to_dict("records")
    assert (row["point_id"], row["role"]) == ("P1", "control")
    place = row["easting"], row["northing"], row["height"]
    assert place == (13050.25, 322100.5, 411.5)
    errors = row["standard_error_m"], row["standard_error_height"]
    assert errors == pytest.approx((0.05, 0.02))  # TOTAL: 3 and 4 cm


def test_check_points_and_longitudes(project):
    first = '"coordinates": [322100.5, 13050.25, 411.5]'
    degrees = (first, '"coordinates": [48.25, 13.5, 411.5]')
    system, check = ("EPSG:31255+5778", "EPSG:4326"), ('point": false', 'point": true')
    change(project, POINTS, degrees, system, check)
    found = read_foreign(project)
    (row,) = found.tables["control_points"].to_dict("records")
    assert (row["longitude"], row["latitude"], row["role"]) == (13.5, 48.25, "check")
    assert any("above the ellipsoid" in note for note in found.notes)


def test_marks_are_those_of_control_and_of_tie_points(project):
    table = read_foreign(project).tables["image_points"]
    assert table.to_numpy().tolist() == [
        ["1.jpg", "P1", 562.25, 2047.5],
        ["2.jpg", "P1", 1562.25, 2040.5],
        ["2.jpg", "M1", 20.5, 30.5],
    ]


def test_images_of_no_list_are_called_by_their_numbers(project):
    without(project, "camera_list")
    found = read_foreign(project)
    images = found.tables["image_points"]["image_id"]
    assert images.tolist() == ["9843086184167632639", "12", "12"]
    assert any("2 images of no camera list" in note for note in found.notes)


def pixels_of(camera_numbers, rays):
    """What Pix4D's formulas of the perspective camera give for rays x/z, y/z."""
    f, (cx, cy), (r1, r2, r3), (t1, t2) = camera_numbers
    x, y = rays.T
    squared = x**2 + y**2
    bent = 1.0 + r1 * squared + r2 * squared**2 + r3 * squared**3
    column = x * bent + 2 * t1 * x * y + t2 * (squared + 2 * x**2)
    row = y * bent + 2 * t2 * x * y + t1 * (squared + 2 * y**2)
    return np.column_stack([f * column + cx, f * row + cy])


@pytest.mark.parametrize("is_calibrated", [True, False])
def test_cameras_are_the_calibrated_ones_where_there_are_such(project, is_calibrated):
    if not is_calibrated:
        without(project, "calibration")
    camera = camera_of(read_foreign(project).cameras["FC330"])
    rays = np.array([[0.0, 0.0], [0.3, -0.2], [-0.5, 0.4], [0.6, 0.5]])
    began = 2500.0, (2000.0, 1500.0), (0.0, 0.0, 0.0), (0.0, 0.0)
    adjusted = 2512.5, (2010.0, 1490.0), (0.05, -0.02, 0.003), (0.001, -0.002)
    pixels = pixels_of(adjusted if is_calibrated else began, rays)
    c = camera.principal_distance_mm
    assert c == pytest.approx((2512.5 if is_calibrated else 2500.0) * 1.5e-3)
    xy = camera.xy_from_measured(pixels)
    np.testing.assert_allclose(xy, rays * [c, -c], atol=1e-9)


def test_orientations_stand_on_the_ground_and_turn_as_ours(project):
    (row,) = read_foreign(project).tables["orientations"].to_dict("records")
    place = row["easting"], row["northing"], row["height"]
    assert (row["image_id"], place) == ("2.jpg", (13010.0, 322020.0, 500.0))
    angles = (row[name] for name in ("omega", "phi", "kappa"))
    matrix = rotation_from_angles(*angles)
    np.testing.assert_allclose(matrix @ [0.0, 1.0, 0.0], [1, 0, 0], atol=1e-12)
    without(project, "scene_reference_frame")
    found = read_foreign(project)
    assert found.tables["orientations"]["easting"].tolist() == [10.0]
    assert any("frame of the calibration" in note for note in found.notes)


@pytest.mark.parametrize("kind", ["fisheye", "spherical"])
def test_cameras_of_other_kinds_are_told_and_cost_no_measurement(project, kind):
    for name in (CAMERAS, CALIBRATED):
        change(project, name, ("perspective", kind))
    said = f"FC330 is a {kind} camera: its calibration is left out"
    found = read_foreign(project)
    assert len(found.tables["image_points"]) == 3
    assert any(said in note for note in found.notes)
    with pytest.raises(EinschaltError, match=said):
        read_camera(project)
    with pytest.raises(EinschaltError, match=said):  # before pixels are told
        propose(look_at(project, Said()), {})


def test_init_sees_points_marks_and_the_camera(project):
    found = {one.kind: one for one in look_at(project, Said())}
    assert set(found) == {"ground", "image_points", "camera"}
    assert not found["camera"].lacks_pitch
    assert found["ground"].crs == "EPSG:31255+5778"


def test_a_folder_is_looked_through_without_the_parts_of_its_project(project):
    project.with_name("other.json").write_text("{}", encoding="utf-8")
    names = [path.name for path in files_below(project.parent)]
    assert names == ["other.json", "project.opf"]


def test_a_part_of_a_project_is_told_from_the_project(project):
    said = "is no project, but application/opf-input-control-points.json"
    with pytest.raises(EinschaltError, match=rf"{said}.*Name the project\.opf"):
        read_foreign(project.with_name(POINTS))


def test_files_of_a_project_are_signed_for(project):
    assert {one.name for one in companions(project)} == set(OPF_FILES)
    for name in (LIST, POINTS):
        (project.parent / name).unlink()
    assert {one.name for one in companions(project)} == {CAMERAS, CALIBRATED, FRAME}
    with pytest.raises(EinschaltError, match=r"camera_list\.json: the file does not"):
        read_foreign(project)
    project.write_text("{", encoding="utf-8")
    assert companions(project) == []


@pytest.mark.parametrize(
    ("uri", "said"),
    [
        ("../frame.json", "lies outside of its folder"),
        ("a/../../frame.json", "lies outside of its folder"),
        ("/etc/passwd", "is no file of its folder"),
        ("file:///etc/passwd", "is no file of its folder"),
        ("//host/frame.json", "is no file of its folder"),
        ("https://host/frame.json", "is no file of its folder"),
        ("frame%00.json", "is no file of its folder"),
        ("", "is no file of its folder"),
    ],
)
def test_nothing_outside_of_the_folder_is_opened(project, uri, said):
    change(project, "project.opf", ('"frame.json"', json.dumps(uri)))
    with pytest.raises(EinschaltError, match=rf"project\.opf: .*{said}"):
        read_foreign(project)
    assert companions(project) == []


@pytest.mark.parametrize("name", ["project.opf", *OPF_FILES])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_files_that_are_cut_off_are_refused_with_their_line(project, name, share):
    file = project.parent / name
    data = file.read_bytes()
    file.write_bytes(data[: int(share * len(data))])
    with pytest.raises(EinschaltError, match=rf"{name}, row \d+: is no whole JSON"):
        read_foreign(project)


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        (POINTS, "[562.25", '["x"', "position_px of P1 is no number: 'x'"),
        (POINTS, "[562.25", "[true", "position_px of P1 is no number: 'True'"),
        (POINTS, "[562.25, ", "[", "position_px of P1 has 1 numbers instead of 2"),
        (POINTS, "411.5", "1e999", "coordinates of P1 is no number: 'inf'"),
        (POINTS, '"marks"', '"mark"', "a control point lacks something"),
        (POINTS, '"definition"', '"wkt"', "a control point lacks something"),
        (
            CAMERAS,
            '"pixel_size_um": 1.5',
            '"pixel_size_um": 0',
            "a length that is none",
        ),
        (CALIBRATED, "2512.5", "-1", "camera FC330 has a length that is none"),
        (
            CALIBRATED,
            "[0, 0, 90]",
            "[0, 90]",
            "orientation_deg of 2.jpg has 2 numbers instead of 3",
        ),
        (CALIBRATED, '"position"', '"place"', "an image lacks its orientation"),
        (FRAME, "[1, 1, 1]", "[1, 0, 1]", "its scale is 0"),
        (FRAME, '"shift"', '"move"', "base_to_canonical lacks something"),
        (LIST, '"uri"', '"name"', "has no id or uri"),
        (LIST, "opf-camera-list", "opf-gps-bias", "is not of the format"),
        ("project.opf", '"items"', '"item"', "has an item without files"),
    ],
)
def test_damage_is_told_with_the_file_in_which_it_is(project, name, old, new, said):
    change(project, name, (old, new))
    with pytest.raises(EinschaltError, match=rf"{name}.*{said}"):
        read_foreign(project)


def test_points_in_two_systems_are_refused(project):
    given = json.loads((project.parent / POINTS).read_text(encoding="utf-8"))
    second = given["gcps"][0] | {"id": "P2"}
    place = second["geolocation"] | {"crs": {"definition": "EPSG:4326"}}
    given["gcps"].append(second | {"geolocation": place})
    (project.parent / POINTS).write_text(json.dumps(given), encoding="utf-8")
    said = "has points in several systems: EPSG:31255.5778, EPSG:4326"
    with pytest.raises(EinschaltError, match=said):
        read_foreign(project)
