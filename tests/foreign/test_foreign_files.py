"""Real files of other programs: counted against what is known of them, and damaged."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.programs.block_tables import found_in

HERE = Path(__file__).parent
# rows of control points and of image points, images, system
COUNTS = {
    "pafs.xml": (19, 133, 44, "EPSG:4326"),
    "gcp_list_crear.txt": (12, 133, 44, "EPSG:4326"),
    "gcps.vrt": (4, 4, 1, "EPSG:26711"),
    "byte_gcp.tif": (2, 2, 1, "EPSG:4326"),
    "arcgis93_geodataxform_gcp.tif.aux.xml": (16, 16, 1, "EPSG:26712"),
    "opensfm/ground_control_points.json": (2, 5, 3, "EPSG:4326"),
}


def tables_of(path):
    found = found_in(path)
    return found, found.tables["control_points"], found.tables["image_points"]


@pytest.mark.parametrize("name", COUNTS)
def test_files_hold_what_their_programs_say(name):
    found, control, measured = tables_of(HERE / name)
    images = measured["image_id"].nunique()
    assert (len(control), len(measured), images, found.crs) == COUNTS[name]


def test_tracks_of_opensfm_lie_in_their_images():
    points = found_in(HERE / "opensfm" / "tracks.csv").tables["image_points"]
    assert points.groupby("image_id").size().to_dict() == {
        f"0{k}.jpg": 40 for k in (1, 2, 3)
    }
    assert points[["x", "y"]].min().min() > 0.0
    assert (points[["x", "y"]].max() < [3264, 2448]).all()


def test_the_list_made_of_markers_has_each_of_their_measurements():
    """133 measurements of Metashape are the 133 rows of OpenDroneMap."""
    names = ("pafs.xml", "gcp_list_crear.txt")
    markers, rows = (tables_of(HERE / name)[2] for name in names)
    keys = ["image_id", "point_id"]
    one, other = (t.sort_values(keys).reset_index(drop=True) for t in (markers, rows))
    assert one[keys].equals(other[keys])
    np.testing.assert_allclose(one[["x", "y"]], other[["x", "y"]], rtol=0, atol=1e-2)


@pytest.mark.parametrize("name", COUNTS)
@pytest.mark.parametrize("share", [0.2, 0.5, 0.8, 0.97])
def test_files_that_are_cut_off_are_refused_or_doubted(tmp_path, name, share):
    file = copy(tmp_path, name)
    data = file.read_bytes()
    file.write_bytes(data[: int(share * len(data))])
    try:
        found = found_in(file)
    except EinschaltError as error:
        said = str(error)
    else:
        # a list of lines may end anywhere
        assert any("is its last line whole?" in note for note in found.notes)
        return
    assert file.name in said
    assert "again" in said or "Correct" in said
    assert "row " in said or file.suffix == ".tif", said


@pytest.mark.parametrize("name", [n for n in COUNTS if not n.endswith(".tif")])
def test_numbers_that_are_none_are_refused(tmp_path, name):
    file = copy(tmp_path, name)
    text = file.read_text(encoding="utf-8")
    decimals = list(re.finditer(r"\d\d\.\d+", text))
    place = decimals[len(decimals) // 2]
    for wrong in ("1O.5", "nan", "1e999", "1,5"):
        file.write_text(text[: place.start()] + wrong + text[place.end() :])
        with pytest.raises(EinschaltError, match=re.escape(file.name)) as refused:
            found_in(file)
        assert "again" in str(refused.value) or "Correct" in str(refused.value)


def copy(tmp_path, name):
    """A copy, with what lies beside it."""
    source = HERE / name
    if source.parent != HERE:
        shutil.copytree(source.parent, tmp_path, dirs_exist_ok=True)
    return Path(shutil.copy(source, tmp_path / source.name))


def test_drawings_without_points_are_refused_by_their_line_or_their_kind():
    pytest.importorskip("ezdxf")
    with pytest.raises(EinschaltError, match=r"assorted\.dxf, row 1646: is no whole"):
        found_in(HERE / "assorted.dxf")
    with pytest.raises(EinschaltError, match="holds no points with a place"):
        found_in(HERE / "cc_dxflib.dxf")


def test_other_files_of_opensfm_are_told_from_its_control(tmp_path):
    path = tmp_path / "control.json"
    for text in ('[{"cameras": {}}]', '{"points": 3}', "7"):
        path.write_text(text)
        with pytest.raises(EinschaltError, match="holds no points as OpenSfM"):
            found_in(path)


OPF = "opf/project.opf"
OPF_PARTS = [
    "project.opf",
    "camera-list.json",
    "input-cameras.json",
    "calibrated-cameras.json",
    "arbitrary-scene-reference-frame.json",
    "control_points/input-control-points.json",
]


def test_a_project_of_the_open_photogrammetry_format_is_read():
    found, control, measured = tables_of(HERE / OPF)
    row = control.iloc[0]
    assert (len(control), row["point_id"], row["role"]) == (1, "gcp0", "check")
    # EPSG:4265 has the latitude first
    assert (row["longitude"], row["latitude"], row["height"]) == (2.0, 1.0, 3.0)
    assert found.crs == "EPSG:4265+5214"
    assert measured.groupby("point_id").size().to_dict() == {"gcp0": 3, "mtp0": 3}
    kinds = [len(found.cameras), len(found.unusable)]
    assert kinds == [2, 3]
    camera = found.cameras["DJI_FC6540_24.0_6016x4008"]  # as it was calibrated
    assert (camera["f"], camera["width"], camera["height"]) == (5312.353, 6016, 4008)
    assert camera["cx"] == pytest.approx(3001.23 - 3008.0)
    images = found.tables["orientations"]["image_id"].tolist()
    assert images == ["IMG_160929_114101_0001_GRE.tif", "57282923", "Image_09573.jpg"]


@pytest.mark.parametrize("name", OPF_PARTS)
@pytest.mark.parametrize("share", [0.2, 0.5, 0.8, 0.97])
def test_parts_of_a_project_that_are_cut_off_are_refused(tmp_path, name, share):
    file = copy(tmp_path, OPF)
    part = tmp_path / name
    data = part.read_bytes()
    part.write_bytes(data[: int(share * len(data))])
    with pytest.raises(EinschaltError, match=rf"{name}, row \d+: is no whole JSON"):
        found_in(file)


@pytest.mark.parametrize("name", OPF_PARTS[2:])
def test_numbers_of_a_project_that_are_none_are_refused(tmp_path, name):
    file = copy(tmp_path, OPF)
    part = tmp_path / name
    text = part.read_text(encoding="utf-8")
    key = {
        "input-cameras.json": '"pixel_size_um": 1.6',
        "calibrated-cameras.json": '"focal_length_px": 5312.353',
        "arbitrary-scene-reference-frame.json": '"shift": [\n            0',
        "control_points/input-control-points.json": "                        458",
    }[name]
    assert key in text
    number = re.search(r"[\d.]+$", key).group()
    for wrong in ('"1O.5"', "NaN", "1e999", "null", "[]"):
        changed = f"{key.removesuffix(number)}{wrong}"
        part.write_text(text.replace(key, changed), encoding="utf-8")
        with pytest.raises(EinschaltError, match=rf"{name}: .*Export it again"):
            found_in(file)
