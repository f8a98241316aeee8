"""``einschalt init``: degrees, metres and pixels under the names of others."""

import json
from pathlib import Path

import pandas as pd
import pyproj
import pytest

STRASBOURG = Path(__file__).parents[3] / "data_examples" / "sxb_strasbourg"
GIVEN = ("--principal-distance-mm", "123.9392", "--low-m-g-um", "10", "--yes")
PITCH_MM = 0.0082


@pytest.fixture(scope="module")
def control():
    dtype = {"point_id": str}
    return pd.read_csv(STRASBOURG / "control_points.csv", dtype=dtype, comment="#")


@pytest.fixture(scope="module")
def degrees(control):
    way = pyproj.Transformer.from_crs("EPSG:27561", "EPSG:4326", always_xy=True)
    return way.transform(control["easting"], control["northing"])


def write_geojson(path, control, xy, crs=None):
    features = [
        {
            "type": "Feature",
            "properties": {"name": name, "role": role},
            "geometry": {"type": "Point", "coordinates": [x, y, height]},
        }
        for name, role, x, y, height in zip(
            control["point_id"], control["role"], *xy, control["height"], strict=True
        )
    ]
    given = {"type": "FeatureCollection", "features": features}
    if crs is not None:
        given["crs"] = {"type": "name", "properties": {"name": crs}}
    path.write_text(json.dumps(given), encoding="utf-8")
    return path


def files(path):
    return ("--from", path, STRASBOURG / "image_points.csv")


def test_geojson_in_metres_without_a_system_makes_a_block(invoke, control, tmp_path):
    plane = control["easting"], control["northing"]
    path = write_geojson(tmp_path / "c.geojson", control, plane)
    shown = invoke("init", tmp_path / "b", *GIVEN, *files(path))
    assert shown.exit_code == 0, shown.output
    assert "names no system (crs)" in shown.stdout
    assert "[low_flight] scale_number = 14340" in shown.stdout


def test_degrees_need_a_plane_system_of_the_place(invoke, control, degrees, tmp_path):
    path = write_geojson(tmp_path / "c.geojson", control, degrees)
    refused = invoke("init", tmp_path / "b", *GIVEN, *files(path))
    assert refused.exit_code == 2
    said = "Plane reference system of the block, since these are degrees, such as "
    assert said in " ".join(refused.stderr.split())
    assert "EPSG:27561" in refused.stderr
    shown = invoke("init", tmp_path / "b", *GIVEN, "--crs", "EPSG:32632", *files(path))
    assert shown.exit_code == 0, shown.output


@pytest.mark.slow
@pytest.mark.parametrize("crs", ["EPSG:27561", "a local system"])
def test_degrees_of_a_plane_system_are_told(invoke, control, degrees, tmp_path, crs):
    path = write_geojson(tmp_path / "c.geojson", control, degrees, crs)
    refused = invoke("init", tmp_path / "b", *GIVEN, *files(path))
    assert refused.exit_code == 2
    told = " ".join(refused.stderr.split())
    assert "c.geojson: the models have scales of 1:0.1" in told
    assert "as if their coordinates were degrees" in told


def test_small_metres_that_are_taken_for_degrees_are_told(invoke, control, tmp_path):
    """A local system with its origin in the block: the scale alone tells."""
    plane = [control[axis] - control[axis].mean() for axis in ("easting", "northing")]
    points = pd.read_csv(STRASBOURG / "image_points.csv", dtype=str, comment="#")
    shrunk = [one / 40.0 for one in plane]  # of a model of the site, say
    assert max(one.abs().max() for one in shrunk) < 90.0
    points.to_csv(tmp_path / "i.csv", index=False)
    path = write_geojson(tmp_path / "c.geojson", control, shrunk)
    refused = invoke("init", tmp_path / "b", *GIVEN, "--from", path, tmp_path / "i.csv")
    assert refused.exit_code == 2
    told = " ".join(refused.stderr.split())
    assert "as if their longitudes and latitudes were metres" in told


def test_pixels_without_a_camera_are_told_before_anything_is_asked(invoke, tmp_path):
    points = pd.read_csv(STRASBOURG / "image_points.csv", comment="#")
    pixels = points.assign(
        x=points["x"] / PITCH_MM + 4000.0, y=4500.0 - points["y"] / PITCH_MM
    )
    pixels.to_csv(tmp_path / "image_points.csv", index=False)
    control = STRASBOURG / "control_points.csv"
    given = ("--from", control, tmp_path / "image_points.csv")
    refused = invoke("init", tmp_path / "b", *given)
    assert refused.exit_code == 2
    told = " ".join(refused.stderr.split())
    assert "image_points.csv: image points extend over 8657" in told
    assert 'convention = "mm", c = principal distance in mm, pixel_size_um' in told
    assert "--low-m-g-um" not in told
    # what the message asks for is enough
    camera = tmp_path / "camera.toml"
    camera.write_text(
        'convention = "mm"\nc = 123.9392\npixel_size_um = 8.2\n'
        "width = 8000\nheight = 9000\n"
    )
    rest = ("--low-m-g-um", "10", "--yes")
    shown = invoke("init", tmp_path / "b", *given, camera, *rest)
    assert shown.exit_code == 0, shown.output
    assert "[low_flight] scale_number = 14340" in shown.stdout
