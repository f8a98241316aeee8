"""Blocks that name files of other programs, as these programs wrote them."""

import pandas as pd
import pytest
from fuzz.foreign_files import MORE, READ

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.tables import CONTROL_POINTS, IMAGE_POINTS
from einschalt.interfaces.files.understood_tables import Said
from einschalt.interfaces.new_block.looked_at import files_below, look_at
from einschalt.interfaces.programs import block_tables, recognised
from einschalt.interfaces.programs.block_tables import find_problems

SYSTEM = "EPSG:31255"
LAND = """\
<LandXML xmlns="http://www.landxml.org/schema/LandXML-1.2"><Units>
<Metric linearUnit="meter"/></Units><CgPoints>{}</CgPoints></LandXML>
"""
MARKERS = """\
<document><chunk><cameras><camera id="0" label="a.tif"/></cameras><markers>{}</markers>
<reference>{}</reference><frames><frame><markers><marker marker_id="0">
<location camera_id="0" pinned="1" x="5.5" y="6"/></marker></markers></frame></frames>
</chunk></document>
"""
ONE = (
    '<marker id="{}" label="{}"><reference x="{}" y="{}" z="{}" enabled="{}"/></marker>'
)


def rows(block):
    """Name, easting, northing of the control of the folder."""
    lines = block.read("control_points.csv").splitlines()[1:]
    return [line.split(",") for line in lines]


def land_xml(found):
    points = (f'<CgPoint name="{n}">{t} {e} 411.5</CgPoint>' for n, e, t in found)
    return LAND.format("".join(points))


def markers(found):
    shown = (
        ONE.format(k, n, e, t, 411.5, "true" if k else "false")
        for k, (n, e, t) in enumerate(found)
    )
    return MARKERS.format("".join(shown), SYSTEM).replace('pinned="1"', 'pinned="true"')


def pat_b(found):
    return "".join(f"{n} {e} {t} 1\n" for n, e, t in found) + "-99\n"


def odm(found):
    lines = [f"{e} {t} 411.5 5 6 a.tif {n}" for n, e, t in found]
    return "\n".join([SYSTEM, *lines, ""])


def reference(found):
    head = "#Label,X/Easting,Y/Northing,Z/Altitude,Enable\n"
    return head + "".join(f"{n},{e},{t},411.5,1\n" for n, e, t in found)


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("c.xml", land_xml),
        ("markers.xml", markers),
        ("c.con", pat_b),
        ("gcp_list.txt", odm),
        ("marks_of_webodm.txt", odm),
        ("ref.csv", reference),
    ],
)
def test_control_may_stand_in_a_file_of_another_program(small_block, name, written):
    before = find_problems(small_block.path).block.control_points
    small_block.write(name, written(rows(small_block)))
    small_block.replace("block.toml", "control_points.csv", name)
    found = find_problems(small_block.path)
    assert not found.problems, found.problems
    control = found.block.control_points
    plane = ["point_id", "easting", "northing"]
    assert control[plane].to_numpy().tolist() == before[plane].to_numpy().tolist()
    is_check = control.get("role", before["point_id"]).eq("check").to_numpy()
    assert is_check.tolist() == [name == "markers.xml", *[False] * 7]
    assert name in found.block.checksums
    assert any("after the manual" in n for n in found.notes) == (name == "c.con")


def test_a_note_on_a_file_that_two_tables_name_stands_once(small_block):
    """Also where the block has a problem: a high flight and approximate points."""
    small_block.write("markers.xml", markers(rows(small_block)))
    small_block.replace("block.toml", "control_points.csv", "markers.xml")
    more = '[approximate_points]\nfile = "markers.xml"\nm_0_m = 5.0\n'
    small_block.replace("block.toml", "[low_flight]", f"{more}\n[low_flight]")
    found = find_problems(small_block.path)
    assert found.problems
    told = [note for note in found.notes if "not enabled" in note]
    assert told == ["markers.xml: 1 marker not enabled, taken for check points"]


def test_what_is_no_control_is_refused_by_its_name(small_block):
    def said(name, text):
        small_block.write(name, text)
        small_block.write("block.toml", toml.replace("control_points.csv", name))
        (problem, *_) = find_problems(small_block.path).problems
        return str(problem)

    toml = small_block.read("block.toml")
    text, *_ = READ["a.OPK"]
    assert "a.opk: holds orientations, and no control points" in said("a.opk", text)
    cut = land_xml(rows(small_block))[:300]
    assert "cut.xml, row 2: is no whole XML" in said("cut.xml", cut)
    other = odm(rows(small_block)).replace(SYSTEM, "EPSG:31254", 1)
    small_block.write("gcp_list.txt", other)
    stated = f'gcp_list.txt"\ncrs = "{SYSTEM}'
    small_block.write("block.toml", toml.replace("control_points.csv", stated))
    (problem, *_) = find_problems(small_block.path).problems
    assert (
        "(EPSG:31255), but gcp_list.txt says MGI / Austria GK West (EPSG:31254)"
        in str(problem)
    )


CAMERAS = {
    "cameras.xml",
    "camera_models.json",
    "p_calibrated_camera_parameters.txt",
}


@pytest.mark.parametrize("name", [*READ, *MORE])
def test_init_sees_what_a_file_holds(tmp_path, name):
    """As tables of a block, with the rows that convert would write."""
    text = READ[name][0] if name in READ else MORE[name]
    file = tmp_path / name
    file.write_bytes(text.encode())
    if name in {"a.OPK", "a.ori", "itera.dat", "Orientation-a.tif.xml", "a.snx"}:
        with pytest.raises(EinschaltError, match="of which no block is made"):
            look_at(file, Said())
        return
    found = {one.kind: one for one in look_at(file, Said())}
    expected = {"control_points": "ground", "image_points": "image_points"}
    kind = "camera" if name in CAMERAS else "ground"
    kind = expected[READ[name][1]] if name in READ else kind
    assert kind in found
    if name in READ:
        first = READ[name][2]
        keys = CONTROL_POINTS.key if kind == "ground" else IMAGE_POINTS.key
        shown = found[kind].frame.iloc[0]
        assert [shown[key] for key in keys] == first[: len(keys)]


def test_markers_and_cameras_of_metashape_are_tables_and_camera(small_block):
    """One file is control and image points; the calibration is the camera."""
    small_block.write("markers.xml", markers(rows(small_block)))
    small_block.write("cameras.xml", MORE["cameras.xml"])
    small_block.write("models.csv", "model_id,left_image,right_image\n1,a.tif,b.tif\n")
    toml = small_block.read("block.toml")
    low = '"markers.xml"\nmodels = "models.csv"\ncamera = "cameras.xml"'
    toml = toml.replace("control_points.csv", "markers.xml")
    toml = toml.replace('model_points = "low_flight.csv"', f"image_points = {low}")
    small_block.write("block.toml", toml)
    found = find_problems(small_block.path)
    (problem,) = found.problems
    assert "right_image 'b.tif' has no image points" in str(problem)
    assert "an image_id of markers.xml" in str(problem)


def test_formats_of_ones_own_stand_for_tables(small_block, monkeypatch):
    """Their readers are given the path, as in convert."""

    class Point:
        name = ".abc"

        def load(self):
            def read(path):
                lines = path.read_text().splitlines()
                cells = [line.split() for line in lines]
                table = pd.DataFrame(cells, columns=["point_id", "easting", "northing"])
                return {"control_points": table}

            return read

    monkeypatch.setattr(recognised, "installed_readers", lambda: [Point()])
    small_block.write("c.abc", "".join(" ".join(r) + "\n" for r in rows(small_block)))
    small_block.replace("block.toml", "control_points.csv", "c.abc")
    found = find_problems(small_block.path)
    assert not found.problems, found.problems
    assert len(found.block.control_points) == len(rows(small_block))


def test_images_of_a_folder_are_not_looked_at(small_block):
    for name in ("a.tif", "b.TIFF", "c.xml"):
        small_block.write(name, "x")
    names = {path.name for path in files_below(small_block.path)}
    assert {"c.xml", "control_points.csv"} <= names
    assert not {"a.tif", "b.TIFF"} & names


@pytest.mark.parametrize(
    ("names", "cells", "plan", "upright"),
    [
        ("Accuracy_X/Y_(m),Accuracy_Z_(m)", "0.03,0.05", 0.03 * 2**0.5, 0.05),
        ("Accuracy_X_(m),Accuracy_Y_(m)", "0.03,0.04", 0.05, None),
        ("Accuracy_Z_(m)", "0.05", None, 0.05),
        ("Accuracy_X/Y_(m)", "0", None, None),
    ],
)
def test_accuracies_of_a_reference_are_standard_errors(
    tmp_path, names, cells, plan, upright
):
    file = tmp_path / "reference.csv"
    head = f"#Label,X/Easting,Y/Northing,Z/Altitude,{names},Enable\n"
    rows = [f"{name},602130.5,231470.2,451.3,{cells},1\n" for name in "AB"]
    file.write_text(head + "".join(rows))
    found = block_tables.found_in(file)
    table = found.tables["control_points"]
    for name, error in (("standard_error_m", plan), ("standard_error_height", upright)):
        assert (name in table) == (error is not None)
        if error is not None:
            assert table[name].tolist() == pytest.approx([error, error])
    assert any("accuracies" in note for note in found.notes) == ("0." in cells)


def test_accuracies_that_some_points_have_not_are_left_out(tmp_path):
    file = tmp_path / "reference.csv"
    head = "#Label,X/Easting,Y/Northing,Z/Altitude,Accuracy_X/Y_(m),Enable\n"
    file.write_text(f"{head}A,602130.5,231470.2,451.3,0.03,1\nB,1,2,3,,1\n")
    found = block_tables.found_in(file)
    assert "standard_error_m" not in found.tables["control_points"]
    note = "reference.csv: standard_error_m left out, since some points have no"
    assert found.notes[0].startswith(note)
