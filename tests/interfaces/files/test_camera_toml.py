"""Cameras in TOML, alone and as part of a block."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.foundations.errors import BlockError, EinschaltError, SettingsError
from einschalt.interfaces.files.camera_toml import camera_of, read_camera, write_camera
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.theory.interior_orientation import Camera

OPENCV = """\
convention = "opencv"
fx = 7980.0
fy = 7990
cx = 4010.5
cy = 2985.25
k1 = -0.11
p2 = -4e-4
pixel_size_um = 4.5
"""
MORE = "centre_x = 4\npixel_size_um = 4\n"
CAMERAS = {
    "opencv": Camera.from_opencv(
        7980, 7990, 4010, 2985, (0.1, 0, 1e-4), pixel_size_um=4
    ),
    "metashape": Camera.from_metashape(
        7980.0, (8000, 6000), (10.0, -5.0), {"b1": 2.0, "k4": 0.1}, pixel_size_um=4.0
    ),
    "mm": Camera.from_mm(152.7, (0.01, -0.02), {"k1": 1e-8, "p1": 1e-7}),
    "micmac": Camera.from_micmac(
        7980.0,
        (4010.5, 2985.25),
        {"k1": -1.7e-9, "k5": 1e-41, "p1": 4e-8, "b2": 1e-4},
        (3990.0, 3001.0),
        pixel_size_um=4.5,
    ),
    "scan": Camera.from_mm(
        152.7, pixels={"pixel_size_um": 15.0, "width": 15_000, "height": 15_200}
    ),
    "oblong": Camera.from_mm(
        7.5,
        pixels={
            "pixel_size_um": 3.19,
            "pixel_height_um": 3.2,
            "width": 2_272,
            "height": 1_704,
        },
    ),
}


def written(tmp_path, text):
    path = tmp_path / "camera.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("head", ["", "[camera]\n"])
def test_camera_file(tmp_path, head):
    camera = read_camera(written(tmp_path, head + OPENCV))
    wanted = Camera.from_opencv(
        7980.0, 7990.0, 4010.5, 2985.25, (-0.11, 0, 0, -4e-4), pixel_size_um=4.5
    )
    corner = [[0.0, 0.0], [8000.0, 6000.0]]
    np.testing.assert_array_equal(
        camera.xy_from_measured(corner), wanted.xy_from_measured(corner)
    )


@pytest.mark.parametrize("name", CAMERAS)
def test_what_was_written_is_read(tmp_path, name):
    camera = CAMERAS[name]
    write_camera(tmp_path / "camera.toml", camera)
    again = read_camera(tmp_path / "camera.toml")
    assert again.given == camera.given
    np.testing.assert_array_equal(again.matrix, camera.matrix)
    assert (again.centre, again.affinity) == (camera.centre, camera.affinity)
    assert again.tangential == camera.tangential


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            OPENCV.replace("fx", "focal"),
            r"camera.toml: \[camera\] fx is missing|focal: unknown key",
        ),
        (OPENCV + "k4 = 1\n", r"\[camera\] k4: unknown key; expected .*k3, pixel_"),
        (OPENCV + "tolerance = 1\n", r"Write it below \[settings\] of block\.toml"),
        (OPENCV + "pixel_um = 4\n", r"pixel_um: unknown key; .*Write pixel_size_um"),
        (OPENCV.replace("4.5", "0"), r"pixel_size_um = 0; expected a number above 0"),
        (OPENCV.replace("4.5", "1e-3"), r"\[camera\] the camera has a principal dist"),
        (OPENCV.replace("opencv", "cv2"), r"convention is unknown: 'cv2'; expected op"),
        ("fx = 1\n", r"convention is missing; expected opencv or metashape or mm"),
        (
            "fx == 1\n",
            r"camera.toml, row 1: the file is no TOML: .*expected key = value",
        ),
        (
            'convention = "mm"\nc = 153.0\nwidth = 3\n',
            r"\[camera\] pixel_size_um, width and height are not all given",
        ),
        (
            'convention = "micmac"\nf = 8e3\ncx = 4\ncy = 3\n' + MORE,
            r"\[camera\] centre_x and centre_y are not both given",
        ),
    ],
)
def test_what_is_wrong_is_said(tmp_path, text, message):
    with pytest.raises(EinschaltError, match=message):
        read_camera(written(tmp_path, text), "camera.toml")


def test_several_faults_come_together():
    with pytest.raises(BlockError) as caught:
        camera_of({"convention": "mm", "c": "153", "f": 1.0})
    assert len(caught.value.problems) == 2


# ------------------------------------------------------------------------------ blocks


@pytest.fixture(scope="module")
def image_block():
    """A block whose low flight comes from image coordinates [mm]."""
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    return es.simulate_block("demo", seed=3, geometry=geometry)


@pytest.fixture
def pixel_block(image_block):
    """The same, as pixels of a camera with distortion."""
    flight = image_block.low_flight
    distance = flight.principal_distance_mm
    camera = Camera.from_metashape(
        distance / 0.012,
        (20_000, 20_000),
        (12.0, -7.0),
        {"k1": -0.01, "p1": 1e-4, "b1": 1.5},
        pixel_size_um=12.0,
    )
    points = flight.image_points.copy()
    points[["x", "y"]] = camera.measured_from_xy(points[["x", "y"]].to_numpy())
    pixels = replace(
        flight, image_points=points, camera=camera, principal_distance_mm=None
    )
    return replace(image_block, low_flight=pixels)


@pytest.mark.slow
def test_pixels_give_the_same_points(image_block, pixel_block):
    assert pixel_block.low_flight.principal_distance_mm == pytest.approx(
        image_block.low_flight.principal_distance_mm
    )
    names = ["easting", "northing"]
    found = es.densify(pixel_block).solution.points[names]
    wanted = es.densify(image_block).solution.points[names]
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("is_inside", [True, False])
def test_block_with_a_camera_is_read_as_written(tmp_path, pixel_block, is_inside):
    es.Block.write(pixel_block, tmp_path)
    if is_inside:
        toml = tmp_path / "block.toml"
        name = 'camera = "low_flight_camera.toml"\n'
        text = toml.read_text().replace(name, "")
        keys = (tmp_path / "low_flight_camera.toml").read_text()
        toml.write_text(f"{text}\n[low_flight.camera]\n{keys}")
    block = es.read_block(tmp_path)
    assert block.low_flight.camera.given == pixel_block.low_flight.camera.given
    one, other = (b.low_flight.image_coordinates() for b in (block, pixel_block))
    np.testing.assert_allclose(one[["x", "y"]], other[["x", "y"]], atol=1e-9)
    assert ("low_flight_camera.toml" in block.checksums) != is_inside


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("k1 = ", "q1 = ", r"\[camera\] q1: unknown key"),
        ("f = ", "fc = ", r"\[camera\] f is missing|fc: unknown key"),
        ("k1 = -0.01", "k1 = -10.0", "lies where the distortion has no inverse; so"),
    ],
)
def test_a_wrong_camera_of_a_block_is_said(tmp_path, pixel_block, old, new, message):
    es.Block.write(pixel_block, tmp_path)
    camera = tmp_path / "low_flight_camera.toml"
    camera.write_text(camera.read_text().replace(old, new))
    with pytest.raises(EinschaltError, match=message) as caught:
        es.read_block(tmp_path)
    # and nothing else that would follow from it
    assert "image_points and" not in str(caught.value)


def test_a_missing_camera_file_is_said(tmp_path, pixel_block):
    es.Block.write(pixel_block, tmp_path)
    (tmp_path / "low_flight_camera.toml").unlink()
    with pytest.raises(EinschaltError, match=r"low_flight_camera\.toml") as caught:
        es.read_block(tmp_path)
    assert not isinstance(caught.value, BlockError)


def test_two_principal_distances_are_said(pixel_block):
    flight = replace(pixel_block.low_flight, principal_distance_mm=153.5)
    with pytest.raises(
        SettingsError, match=r"principal_distance_mm = 153\.5, but that"
    ):
        replace(pixel_block, low_flight=flight)
