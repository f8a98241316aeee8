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
