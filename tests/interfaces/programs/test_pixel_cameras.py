"""Cameras and projects of COLMAP, OpenSfM and Pix4D, as a block takes them."""

import json

import numpy as np
import pytest
from fuzz.foreign_files import PIX4D_PARAMETERS as PARAMETERS

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.interfaces.files.camera_toml import camera_of
from einschalt.interfaces.programs.recognised import read_foreign

PITCH_UM = 2.4
IMAGES = "# Number of images: 1\n1 1 0 0 0 0 0 0 1 a.jpg\n100 200 1\n"
# a camera of OpenCV, as each of the programs states it
FX, FY, CX, CY, SIZE = 2300.0, 2310.0, 2010.0, 1490.0, (4000, 3000)
K1, K2, P1, P2, K3 = 0.05, -0.02, 0.001, -0.002, 0.003


def expected_of(points, fx, fy, cx, cy, k1=0.0, k2=0.0, p1=0.0, p2=0.0, k3=0.0):
    """Pixels of rays x / z, y / z (y down), by the formulas of OpenCV's manual."""
    x, y = points.T
    r2 = x * x + y * y
    growth = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = x * growth + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    v = y * growth + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return np.column_stack([fx * u + cx, fy * v + cy])


def seen_by(keys, points):
    """Pixels of the same rays, by the camera of these keys."""
    camera = camera_of({"pixel_size_um": PITCH_UM, **keys})
    xy = points * [1.0, -1.0] * camera.principal_distance_mm
    return camera.measured_from_xy(xy)


@pytest.fixture
def rays():
    """x / z and y / z within the image."""
    return np.random.default_rng(2026).uniform(-0.6, 0.6, (40, 2))


MODELS_OF_COLMAP = [
    ("SIMPLE_PINHOLE", (FX, CX, CY), (FX, FX, CX, CY)),
    ("PINHOLE", (FX, FY, CX, CY), (FX, FY, CX, CY)),
    ("SIMPLE_RADIAL", (FX, CX, CY, K1), (FX, FX, CX, CY, K1)),
    ("RADIAL", (FX, CX, CY, K1, K2), (FX, FX, CX, CY, K1, K2)),
    ("OPENCV", (FX, FY, CX, CY, K1, K2, P1, P2), (FX, FY, CX, CY, K1, K2, P1, P2)),
    (
        "FULL_OPENCV",
        (FX, FY, CX, CY, K1, K2, P1, P2, K3, 0, 0, 0),
        (FX, FY, CX, CY, K1, K2, P1, P2, K3),
    ),
]


def colmap_with(folder, *cameras):
    """A model of COLMAP with these cameras: model and parameters."""
    lines = [
        f"{k} {model} {SIZE[0]} {SIZE[1]} {' '.join(map(str, parameters))}"
        for k, (model, parameters) in enumerate(cameras, 1)
    ]
    (folder / "cameras.txt").write_text("\n".join(lines) + "\n")
    (folder / "images.txt").write_text(IMAGES)
    return read_foreign(folder)


@pytest.mark.parametrize(("model", "parameters", "constants"), MODELS_OF_COLMAP)
def test_cameras_of_colmap_map_rays_as_opencv(
    tmp_path, rays, model, parameters, constants
):
    found = colmap_with(tmp_path, (model, parameters))
    pixels = seen_by(found.cameras["1"], rays)
    np.testing.assert_allclose(pixels, expected_of(rays, *constants), atol=1e-9)
    assert any("add pixel_size_um" in note for note in found.notes)


@pytest.mark.parametrize("width", ["0", "-4000", "1e300"])
def test_cameras_of_colmap_without_a_size_are_refused(tmp_path, width):
    colmap_with(tmp_path, ("PINHOLE", (FX, FY, CX, CY)))
    path = tmp_path / "cameras.txt"
    path.write_text(path.read_text().replace("4000", width))
    with pytest.raises(
        EinschaltError, match=r"row 1: the size of camera 1 is \S+ x 3000"
    ):
        read_foreign(tmp_path)


def test_cameras_of_colmap_that_are_no_frames_are_left_out(tmp_path):
    rational = ("FULL_OPENCV", (FX, FY, CX, CY, K1, K2, P1, P2, K3, 0.1, 0, 0))
    fisheye = ("OPENCV_FISHEYE", (FX, FY, CX, CY, 0, 0, 0, 0))
    found = colmap_with(tmp_path, rational, fisheye, ("PINHOLE", (FX, FY, CX, CY)))
    assert list(found.cameras) == ["3"]
    assert list(found.unusable) == ["1", "2"]
    assert any("the model OPENCV_FISHEYE, its" in note for note in found.notes)


BROWN = {
    "projection_type": "brown",
    "width": SIZE[0],
    "height": SIZE[1],
    "focal_x": FX / 4000,
    "focal_y": FY / 4000,
    "c_x": 0.0025,
    "c_y": -0.001,
    "k1": K1,
    "k2": K2,
    "k3": K3,
    "p1": P1,
    "p2": P2,
}
SHOT = {"camera": "c", "rotation": [0.1, -0.2, 0.3], "translation": [1.0, 2.0, 3.0]}


def opensfm_with(folder, cameras, shots=None):
    """Cameras of OpenSfM; a reconstruction where there are shots."""
    part = {"cameras": cameras, "shots": shots}
    name = "camera_models.json" if shots is None else "reconstruction.json"
    path = folder / name
    path.write_text(json.dumps(cameras if shots is None else [part]))
    return read_foreign(path)


def test_cameras_of_opensfm_count_from_the_middle_of_the_image(tmp_path, rays):
    plain = {"projection_type": "perspective", "width": 3000, "height": 4000}
    plain |= {"focal": 0.9, "k1": K1, "k2": K2}
    found = opensfm_with(tmp_path, {"b": BROWN, "p": plain})
    # as OpenSfM's denormalized_image_coordinates has it
    middle = 4000 * 0.0025 + 1999.5, 4000 * -0.001 + 1499.5
    expected = expected_of(rays, FX, FY, *middle, K1, K2, P1, P2, K3)
    np.testing.assert_allclose(seen_by(found.cameras["b"], rays), expected, atol=1e-9)
    expected = expected_of(rays, 3600.0, 3600.0, 1499.5, 1999.5, K1, K2)
    np.testing.assert_allclose(seen_by(found.cameras["p"], rays), expected, atol=1e-9)


def test_a_reconstruction_of_opensfm_has_orientations(tmp_path):
    found = opensfm_with(tmp_path, {"c": BROWN}, {"a.jpg": SHOT})
    row = found.tables["orientations"].iloc[0]
    # Rodrigues' formula, as OpenSfM turns: X_camera = R X + t
    axis = np.array(SHOT["rotation"])
    angle = np.linalg.norm(axis)
    x, y, z = axis / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    centre = -turn.T @ SHOT["translation"]
    place = row[["easting", "northing", "height"]].to_numpy(float)
    np.testing.assert_allclose(place, centre, atol=1e-12)
    own = rotation_from_angles(*row[["omega", "phi", "kappa"]].to_numpy(float))
    np.testing.assert_allclose(own, np.diag([1.0, -1.0, -1.0]) @ turn, atol=1e-12)
    assert any("own frame" in note for note in found.notes)


WRONG_CAMERAS = [
    (BROWN | {"focal_x": "wide"}, "the focal_x of camera c is no number"),
    (BROWN | {"focal_x": True}, "the focal_x of camera c is no number"),
    (BROWN | {"width": 0}, "the size of camera c is 0 x 3000"),
    ({"width": 1, "of": "projection_type"}, "is no reconstruction"),
    (BROWN | {"projection_type": "fisheye"}, "of the kind fisheye: its calibration"),
    (BROWN | {"k4": 0.1, "k6": 1}, "camera c of the kind brown has a term k4 and k6"),
]


@pytest.mark.parametrize(("camera", "said"), WRONG_CAMERAS, ids=range(6))
def test_wrong_cameras_of_opensfm_are_refused(tmp_path, camera, said):
    with pytest.raises(EinschaltError, match=said):
        opensfm_with(tmp_path, {"c": camera})
    with pytest.raises(EinschaltError, match=r"reconstruction\.json: "):
        opensfm_with(tmp_path, {"c": camera}, {"a": SHOT | {"rotation": [1, 2]}})


def test_optimised_cameras_of_pix4d_map_rays_as_opencv(tmp_path, rays):
    path = tmp_path / "p_calibrated_camera_parameters.txt"
    path.write_text(PARAMETERS)
    (tmp_path / "p_offset.xyz").write_text("500000 200000 400\n")
    found = read_foreign(path)
    assert list(found.cameras) == ["1"]
    expected = expected_of(rays, FX, FY, CX, CY, K1, K2, P1, P2, K3)
    np.testing.assert_allclose(seen_by(found.cameras["1"], rays), expected, atol=1e-9)
    oriented = found.tables["orientations"]
    assert oriented["image_id"].tolist() == ["image 1.jpg", "b.jpg"]
    assert oriented["easting"].tolist() == [500010.0, 500030.0]
    angles = oriented[["omega", "phi", "kappa"]].to_numpy()
    np.testing.assert_allclose(angles[1], 0.0, atol=1e-12)
    # a point at (12, 24, 0) of the first image, by m = K R (X - t)
    own = rotation_from_angles(*angles[0]) @ [2.0, 4.0, -100.0]
    np.testing.assert_allclose(own[:2] / -own[2], [0.04, -0.02], atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0 0 -1\nb.jpg", "b.jpg", "holds 19 lines after its headings: it is cut off"),
        ("10 20 100", "10 2O 100", "row 16: '10 2O 100' cannot be read"),
        ("30 20 100", "30 20", "'30 20' cannot be read"),
        ("0 1 0\n", "1 1 0\n", "the R of an image is no rotation"),
        ("b.jpg 4000", "4000", "'4000 3000' is no name and size of an image"),
        (
            "3000\n\n2300 0",
            "3000\n\n2300 0.4",
            "row 11: K has a skew of 0.4; expected 0",
        ),
    ],
)
def test_damaged_parameters_of_pix4d_are_refused(tmp_path, old, new, said):
    path = tmp_path / "p_calibrated_camera_parameters.txt"
    assert PARAMETERS.count(old) == 1
    path.write_text(PARAMETERS.replace(old, new))
    with pytest.raises(EinschaltError, match=said):
        read_foreign(path)


PROJECT = """\
<?xml version="1.0"?>
<pix4dmapper><inputs>
 <cameras><camera name="X5_15.0_4608x3456">
  <imageWidth>4608</imageWidth><imageHeight>3456</imageHeight>
  <pixelSize>3.75</pixelSize><lensType>perspective</lensType>
  <focalLengthmm>15</focalLengthmm>
  <principalPointXmm>8.64</principalPointXmm>
  <principalPointYmm>6.48</principalPointYmm>
  <radialK1>0.01</radialK1><tangentialT1>0.001</tangentialT1>
 </camera></cameras>
 <coordinateSystems><gcp><WKT>{wkt}</WKT></gcp></coordinateSystems>
 <gcps>
  <GCP label="A 1" id="0" type="3DGCP" x="532575.071" y="151907.401" z="396.462"
       lat="46.5" lon="6.6" alt="396.4" accuracyXY="0.03" accuracyZ="0.05"/>
  <GCP label="B" id="1" type="CheckPoint" x="532634" y="152250" z="401"
       lat="46.6" lon="6.7" alt="401.4" accuracyXY="0.03" accuracyZ="0.05"/>
  <GCP label="M" id="2" type="MTP" x="0" y="0" z="0"/>
 </gcps>
 <images>
  <image path="C:\\flight\\1.jpg" enabled="true">
   <imageGCP x="562.3" y="2047.5" id="0"/><imageGCP x="10" y="20" id="2"/></image>
  <image path="/data/2.jpg"><imageGCP x="30" y="40" id="1"/></image>
  <image path="/data/3.jpg" enabled="false"><imageGCP x="3" y="4" id="1"/></image>
 </images>
</inputs></pix4dmapper>
"""


def project(folder, text=PROJECT, wkt="EPSG:21781"):
    path = folder / "p.p4d"
    path.write_text(text.replace("{wkt}", wkt))
    return read_foreign(path)


def test_a_project_of_pix4d_has_points_marks_and_its_first_camera(tmp_path, rays):
    found = project(tmp_path)
    assert found.crs == "EPSG:21781"
    control = found.tables["control_points"]
    assert control["point_id"].tolist() == ["A 1", "B"]
    assert control["role"].tolist() == ["control", "check"]
    assert control.loc[0, ["easting", "northing"]].tolist() == [532575.071, 151907.401]
    # of one coordinate in the project, of both together in a block
    np.testing.assert_allclose(control["standard_error_m"], 0.03 * np.sqrt(2.0))
    assert found.tables["image_points"].to_numpy().tolist() == [
        ["1.jpg", "A 1", 562.3, 2047.5],
        ["1.jpg", "M", 10.0, 20.0],
        ["2.jpg", "B", 30.0, 40.0],
    ]
    keys = found.cameras["X5_15.0_4608x3456"]
    assert keys["pixel_size_um"] == 3.75
    expected = expected_of(rays, 4000, 4000, 2304, 1728, k1=0.01, p1=0.001)
    np.testing.assert_allclose(seen_by(keys, rays), expected, atol=1e-9)
    said = " ".join(map(str, found.notes))
    assert "1 image not enabled, left out" in said
    assert "1 point of the type 'MTP'" in said


def test_degrees_of_a_project_of_pix4d_are_its_longitudes_and_latitudes(tmp_path):
    control = project(tmp_path, wkt="EPSG:4326").tables["control_points"]
    assert control.loc[0, ["longitude", "latitude"]].tolist() == [6.6, 46.5]


def test_images_of_one_name_keep_their_folders(tmp_path):
    text = PROJECT.replace("/data/2.jpg", "/data/1.jpg")
    images = project(tmp_path, text).tables["image_points"]["image_id"]
    assert images.tolist() == ["flight/1.jpg"] * 2 + ["data/1.jpg"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('id="2"/></image>', 'id="7"/></image>', "a mark of point 7, unknown"),
        ('x="562.3"', 'x="562,3"', "of point A 1 is no number: '562,3'"),
        ('z="401"', "", "a coordinate of point B is no number"),
        ("<pixelSize>3.75", "<pixelSize>0", "has pixels of no size"),
        ("<pixelSize>3.75", "<pixelSize>", "the pixelSize of camera X5_15.0_4608x3456"),
        ("/data/2.jpg", "C:\\flight\\1.jpg", "images that are listed twice"),
    ],
)
def test_damaged_projects_of_pix4d_are_refused(tmp_path, old, new, said):
    assert PROJECT.count(old) == 1
    with pytest.raises(EinschaltError, match=said):
        project(tmp_path, PROJECT.replace(old, new))


def test_a_fisheye_of_pix4d_is_left_out(tmp_path):
    text = PROJECT.replace("perspective", "fisheye")
    found = project(tmp_path, text)
    assert not found.cameras
    assert any("is a fisheye camera" in note for note in found.notes)
    only = text[: text.index(" <coordinateSystems>")] + "</inputs></pix4dmapper>"
    with pytest.raises(EinschaltError, match="is a fisheye camera: its calibration"):
        project(tmp_path, only)
