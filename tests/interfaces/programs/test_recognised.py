"""Files of other programs: what stands in them, and damaged ones."""

import re

import numpy as np
import pytest
from fuzz.foreign_files import (
    CAMERAS,
    DICO,
    GAMA,
    IMAGES,
    LANDXML,
    MARKS,
    MMVII,
    MORE,
    OPK,
    ORIENTATION,
    POINTS_3D,
    PRJ,
    PROJECT,
    QGIS,
    READ,
    REFERENCE,
    VRT,
)
from fuzz.sound_files import as_geotiff
from PIL import Image

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.interfaces.files.block_toml import write_keys
from einschalt.interfaces.files.camera_toml import camera_of, read_camera
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.programs import block_tables, recognised, sinex
from einschalt.interfaces.programs.recognised import read_foreign

PLACE = ["easting", "northing", "height"]
SYSTEMS = {"a.vrt": 31467, "a.tif.aux.xml": 31467, "a.tif.points": 31255}
SYSTEMS |= {"blocks.xml": 2154, "a.OPK": 2154, "ref.csv": 4326, "a.kml": 4326}
AFTER_MANUAL = {
    "a.sim",
    "blocks.xml",
    "a.con",
    "a.im",
    "geoin.dat",
    "image.dat",
    "itera.dat",
    "a.ori",
    "a.prj",
}


@pytest.mark.parametrize("name", READ)
def test_what_stands_in_a_file_is_read(tmp_path, name):
    text, table, first = READ[name]
    (tmp_path / name).write_bytes(text.encode())
    found = read_foreign(tmp_path / name)
    assert found.tables[table].iloc[0, : len(first)].tolist() == first
    known = SYSTEMS.get(name)
    assert found.crs == (known and f"EPSG:{known}")
    assert (name in AFTER_MANUAL) == any("after the manual" in n for n in found.notes)


def turned(found):
    """Matrix, from the ground to the camera, of the first image."""
    table = found.tables["orientations"]
    return rotation_from_angles(*table.loc[0, ["omega", "phi", "kappa"]])


@pytest.mark.parametrize(
    "name", ["a.OPK", "itera.dat", "a.ori", "a.prj", "project.txt"]
)
def test_a_camera_turned_to_the_north_sees_east_below(tmp_path, name):
    (tmp_path / name).write_bytes(READ[name][0].encode())
    # kappa is a right angle in all of these: x of the image points to the north
    matrix = turned(read_foreign(tmp_path / name))
    np.testing.assert_allclose(matrix @ [0.0, 1.0, 0.0], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(matrix @ [1.0, 0.0, 0.0], [0, -1, 0], atol=1e-12)


def test_a_camera_of_micmac_that_looks_down_is_upright(tmp_path):
    file = tmp_path / "Orientation-a.tif.xml"
    file.write_text(ORIENTATION)
    found = read_foreign(file)
    assert found.tables["orientations"].iloc[0, :4].tolist() == ["a.tif", 10, 20, 100]
    np.testing.assert_allclose(turned(found), np.eye(3), atol=1e-12)


@pytest.fixture
def colmap(tmp_path):
    (tmp_path / "cameras.txt").write_text(CAMERAS)
    (tmp_path / "images.txt").write_text(IMAGES)
    (tmp_path / "points3D.txt").write_text(POINTS_3D)
    return tmp_path


def test_a_model_of_colmap_is_read_as_it_looks(colmap):
    found = read_foreign(colmap)
    oriented = found.tables["orientations"]
    assert oriented["image_id"].tolist() == ["a b.jpg", "c.jpg"]
    np.testing.assert_allclose(oriented[PLACE], [[10, 20, 100]] * 2, atol=1e-12)
    np.testing.assert_allclose(turned(found), np.eye(3), atol=1e-12)
    assert found.tables["image_points"].to_numpy().tolist() == [
        ["a b.jpg", "7", 2000.0, 1500.0],
        ["a b.jpg", "8", 2250.0, 1500.0],
    ]
    # 10 to the east of the nadir, 100 below: a tenth of 2500 pixels to the right
    assert found.tables["object_points"]["x"].tolist() == [10.0, 20.0]
    assert "1 image points without a point left out" in found.notes


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        (
            "cameras.txt",
            "1 PINHOLE 4000",
            "1 PINHOLE 4OOO",
            "cameras.txt, row 2: '1 P",
        ),
        (
            "images.txt",
            "c.jpg\n\n",
            "c.jpg\n2000\n",
            "row 5: the points of image c",
        ),
        ("images.txt", IMAGES[-34:], "", "holds 1 images, and announces 2: it is cut"),
        ("images.txt", "100 1 c", "100 9 c", "row 4.*names no camera"),
        ("points3D.txt", POINTS_3D[-30:], "", "holds 1 points, and announces 2"),
    ],
)
def test_a_damaged_model_of_colmap_is_refused(colmap, file, old, new, said):
    text = (colmap / file).read_text()
    assert old in text
    (colmap / file).write_text(text.replace(old, new))
    with pytest.raises(EinschaltError, match=said):
        read_foreign(colmap)


def test_homologous_points_are_named_by_their_files(tmp_path):
    folder = tmp_path / "Homol" / "Pastisa.tif"
    folder.mkdir(parents=True)
    (folder / "b.tif.txt").write_text("1.5 2.5 3.5 4.5 1\n5 6 7 8 1\n")
    for path in (folder / "b.tif.txt", tmp_path / "Homol"):
        pairs = read_foreign(path).tables["image_pairs"]
        assert pairs.iloc[0].tolist() == ["a.tif/b.tif", "1", 1.5, 2.5, 3.5, 4.5]
        assert len(pairs) == 2
    (folder / "b.tif.txt").write_text("1.5 2.5 3.5 4.5 1\n5 6 7\n")
    with pytest.raises(EinschaltError, match=r"b\.tif\.txt, row 2: '5 6 7' cannot"):
        read_foreign(tmp_path / "Homol")


def geotiff(ties, keys=(1, 1, 0, 1, 3072, 0, 1, 31467)):
    return as_geotiff(Image.new("L", (4, 4)), {33922: ties}, keys)


def test_tie_points_of_a_geotiff_are_read_from_its_tags(tmp_path):
    ties = [1, 2, 0, 3.5e6, 5.3e6, 0, 3, 4, 0, 3.6e6, 5.4e6, 0]
    (tmp_path / "a.tif").write_bytes(geotiff(ties))
    found = read_foreign(tmp_path / "a.tif")
    assert found.crs == "EPSG:31467"
    assert found.tables["image_points"][["x", "y"]].to_numpy().tolist() == [
        [1, 2],
        [3, 4],
    ]
    assert found.tables["control_points"]["easting"].tolist() == [3.5e6, 3.6e6]
    at_points = (1, 1, 0, 2, 3072, 0, 1, 31467, 1025, 0, 1, 2)
    (tmp_path / "a.tif").write_bytes(geotiff(ties, at_points))
    found = read_foreign(tmp_path / "a.tif").tables["image_points"]
    assert found.loc[0, ["x", "y"]].tolist() == [1.5, 2.5]
    for wrong in (np.nan, np.inf):
        (tmp_path / "a.tif").write_bytes(geotiff([wrong, *ties[1:]]))
        with pytest.raises(EinschaltError, match=r"a\.tif: its tags are damaged"):
            read_foreign(tmp_path / "a.tif")
    (tmp_path / "a.tif").write_bytes(geotiff(ties)[:60])
    with pytest.raises(EinschaltError, match=r"a\.tif: (is no|its tags|has)"):
        read_foreign(tmp_path / "a.tif")


OLDEST = """<?xml version="1.0" encoding="UTF-8"?>
<collection><cameras><camera label="IMG_1.jpg"><resolution width="972" height="648"/>
<calibration><width>972</width><height>648</height><fx>1.87e+003</fx><fy>1.87e+003</fy>
</calibration></camera></cameras></collection>
"""
DAMAGED = [
    (
        "cameras.xml",
        OLDEST,
        "the first versions of PhotoScan .* export its cameras and",
    ),
    ("a.xml", LANDXML[:150], "is no whole XML"),
    ("a.xml", LANDXML.replace("2000 1000", "2000 l000"), "point A: '2000 l000 3000'"),
    ("a.xml", LANDXML.replace("millimeter", "ell"), "the unit 'ell' is unknown"),
    ("a.gkf", GAMA.replace("4 1 9", "4 1"), "has 2 covariances of 2 coordinates"),
    ("dico.xml", DICO.replace("1 2 3", "1 2"), "point P1: '1 2' is not 3 numbers"),
    ("mmvii.xml", MMVII.replace("<Nb>1", "<Nb>2"), "holds 1 of 2 members"),
    ("Ori.xml", ORIENTATION.replace("1 0 0", "1 1 0"), "its matrix is no rotation"),
    ("a.vrt", "<!DOCTYPE a []>" + VRT, "row 1: the XML defines a document type"),
    ("a.vrt", VRT.replace('Pixel="3"', 'Pixel="x"'), "a GCP says 'x 4"),
    ("a.points", QGIS.replace(".", ","), "row 3: '13000,5,322000,25,10,5"),
    ("a.points", QGIS.replace("-40", ""), "row 4: '13100,322100,30,,0"),
    ("marks.txt", MARKS[:-12], "row 4: has 4 of 6 columns"),
    (
        "project.txt",
        PROJECT[: PROJECT.index("   0      317")],
        "ends before its points and marks",
    ),
    ("project.txt", PROJECT[:-10], "lists 0 of its 1 marks at its end"),
    ("ref.csv", REFERENCE.replace(",0.01,False", ""), "row 3: .* has 4 of 6 columns"),
    ("a.opk", OPK.replace("grade", "ell"), "row 3: the unit of angles 'ell'"),
    ("a.opk", OPK[:-40], "row 5: 'im1 1029229.25 6334683.5"),
    ("a.con", "7 1.5 2 1\n", "has no -99: it is cut off"),
    ("a.con", "7 1.5 2 1\n7 1.5 2 1\n-99\n", "row 2: point 7 stands twice"),
    ("a.im", "12\n7 1500 -2500\n", "row 2: photo 12 has no end -99"),
    ("image.dat", "12\n7 1,5 2\n-99\n", "row 2: '7 1,5 2' cannot be read"),
    ("geoin.dat", "CONT P1 1 2\n", "row 1: 'CONT P1 1 2' cannot be read"),
    ("a.ori", "12 1 2 3\n0 -1 0 1 0\n0 0 0\n", "has 12 numbers, which is not 13"),
    ("a.ori", "12 1 2 3\n0 -1 0 2 0\n0 0 0 1\n", "row 1: the nine elements"),
    ("a.ori", "12 1 2 3\n0 -1 0 1 1e308\n0 0 0 1\n", "row 1: the nine elements"),
    ("a.ori", "12 1 2 3\n0 1 0 1 0\n0 0 0 1\n", "row 1: the nine elements"),
    ("a.prj", PRJ[: PRJ.index("$END\n")], "photo 12 has no .END: the file is cut off"),
    ("a.snx", "%=SNX 2.02\n", "does not end with %ENDSNX"),
    ("a.dxf", "  0\nSECTION\n  2\nHEADER\n", "is no whole DXF|holds no points"),
    ("ref.csv", REFERENCE.replace("48.25", "48,25x"), "row 3: .* is no point"),
    ("a.doc", "x", "is of no program that is known"),
]


@pytest.mark.parametrize(("name", "text", "said"), DAMAGED)
def test_damaged_files_are_refused_with_a_sentence(tmp_path, name, text, said):
    (tmp_path / name).write_bytes(text.encode())
    with pytest.raises(EinschaltError, match=said):
        read_foreign(tmp_path / name)


def test_cameras_of_metashape_become_camera_toml(tmp_path):
    file = tmp_path / "cameras.xml"
    file.write_text(MORE["cameras.xml"])
    found = read_foreign(file)
    camera = found.cameras["FC6310"]
    write_keys(tmp_path / "camera.toml", camera)
    read = read_camera(tmp_path / "camera.toml", "camera.toml")
    assert (read.given["f"], read.given["cy"]) == (3239.25, 51.75)
    assert (camera["cx"], camera["k1"], camera["width"]) == (-17.5, -0.0625, 5472)
    assert camera["pixel_size_um"] == pytest.approx(2.41)
    oriented = found.tables["orientations"]
    assert oriented.iloc[0, :4].tolist() == ["A.JPG", 10.0, 20.0, 100.0]
    np.testing.assert_allclose(turned(found), np.eye(3), atol=1e-12)
    for old, new, said in (
        ("3239.25", "x", "the f of sensor FC6310 is no number"),
        ("100 0 0 0 1", "100 0 0 1", "camera A.JPG is not 16 numbers"),
        ("1 0 0 10", "2 0 0 10", "is no rotation"),
    ):
        file.write_text(MORE["cameras.xml"].replace(old, new))
        with pytest.raises(EinschaltError, match=said):
            read_foreign(file)


def test_sensors_of_one_name_are_cameras_of_their_own(tmp_path):
    """Each flight with the same camera may have a sensor, and all have its name."""
    text = MORE["cameras.xml"]
    sensor = text[text.index("<sensor ") : text.index("</sensors>")]
    other = sensor.replace('id="0"', 'id="4"').replace("3239.25", "3240.5")
    file = tmp_path / "cameras.xml"
    file.write_text(text.replace("</sensors>", f"{other}</sensors>"))
    found = read_foreign(file).cameras
    lengths = {name: camera["f"] for name, camera in found.items()}
    assert lengths == {"FC6310 (0)": 3239.25, "FC6310 (4)": 3240.5}


PHOTOSCAN = """<fx>3241.25</fx><fy>3239.25</fy><cx>2718.5</cx><cy>1875.75</cy>
<skew>-0.5</skew><k1>-0.0625</k1><p1>0.001</p1><p2>-0.002</p2></calibration>
"""


def test_calibrations_before_photoscan_1_2_see_the_same(tmp_path):
    """The formula of that time, written out: Agisoft's forum, topic 6437."""
    text = MORE["cameras.xml"]
    start = text.index("<f>3239.25</f>")
    end = text.index("</calibration>", start) + len("</calibration>")
    file = tmp_path / "cameras.xml"
    file.write_text(text[:start] + PHOTOSCAN + text[end:])
    camera = camera_of(read_foreign(file).cameras["FC6310"])
    x, y = np.array([[0.2, -0.3], [0.1, 0.25]])
    squared = x**2 + y**2
    radial = 1.0 - 0.0625 * squared
    bent_x = x * radial - 0.002 * (squared + 2 * x**2) + 2 * 0.001 * x * y
    bent_y = y * radial + 0.001 * (squared + 2 * y**2) - 2 * 0.002 * x * y
    column = 2718.5 + 3241.25 * bent_x - 0.5 * bent_y
    row = 1875.75 + 3239.25 * bent_y
    reduced = camera.xy_from_measured(np.column_stack([column, row]))
    expected = np.column_stack([x, -y]) * camera.principal_distance_mm
    np.testing.assert_allclose(reduced, expected, atol=1e-9)


def test_a_calibration_saved_alone_is_a_camera(tmp_path):
    file = tmp_path / "35mm.xml"
    file.write_text(
        """<?xml version="1.0" encoding="UTF-8"?>
<calibration>
  <projection>frame</projection><width>6012</width><height>4008</height>
  <f>9263.5</f><cx>51.5</cx><cy>-44.25</cy><k1>-0.08</k1><p1>0.0005</p1>
  <date>2023-02-17T16:46:52Z</date>
</calibration>
"""
    )
    found = read_foreign(file)
    assert not found.tables
    expected = {"f": 9263.5, "cx": 51.5, "cy": -44.25, "k1": -0.08, "p1": 0.0005}
    expected |= {"convention": "metashape", "width": 6012, "height": 4008}
    assert found.cameras == {"35mm": expected}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("frame", "fisheye", "sensor FC6310 is a fisheye camera"),
        ("<k1>", "<p3>0.5</p3><k1>", "sensor FC6310 has a term p3:"),
        ("<k1>", "<k5>1</k5><p4>1</p4><k1>", "sensor FC6310 has a term k5 and p4:"),
    ],
)
def test_a_camera_that_none_here_is_costs_no_measurement(tmp_path, old, new, said):
    text = MORE["cameras.xml"]
    calibration = text[text.index('<calibration type="frame" class="adjusted"') :]
    text = text.replace(calibration, calibration.replace(old, new, 1))
    file = tmp_path / "cameras.xml"
    file.write_text(text)
    found = read_foreign(file)
    assert len(found.tables["orientations"]) == 1
    assert not found.cameras
    assert any(said in note for note in found.notes)
    with pytest.raises(EinschaltError, match=f"{said}.*export undistorted images"):
        block_tables.read_camera(file)
    file.write_text(re.sub("<transform>.*</transform>", "", text))
    with pytest.raises(EinschaltError, match=f"{said}.*export undistorted images"):
        read_foreign(file)


def test_cameras_of_a_rig_that_stand_with_their_master_are_said(tmp_path):
    text = MORE["cameras.xml"]
    slave = '<camera id="7" sensor_id="0" master_id="0" label="DJI_0001_2.TIF"/>'
    (tmp_path / "cameras.xml").write_text(
        text.replace("</cameras>", f"{slave}</cameras>")
    )
    found = read_foreign(tmp_path / "cameras.xml")
    said = "none of their own; left out: DJI_0001_2.TIF"
    assert any(said in note for note in found.notes)
    assert "DJI_0001_2.TIF" not in found.tables["orientations"]["image_id"].tolist()


def test_orientations_of_several_components_are_said(tmp_path):
    text = MORE["cameras.xml"]
    start = text.index('<camera id="0"')
    end = text.index('<camera id="1"')
    one = text[start:end].replace("<camera ", '<camera component_id="0" ')
    two = one.replace('"0"', '"1"').replace("A.JPG", "B.JPG")
    file = tmp_path / "cameras.xml"
    last = '<camera id="1" label="B.JPG" sensor_id="0"/>'
    file.write_text(text.replace(text[start:end], one).replace(last, two))
    found = read_foreign(file)
    assert len(found.tables["orientations"]) == 2
    assert any("2 components, each with a frame" in note for note in found.notes)


def test_markers_exported_with_calibrated_sensors_keep_their_measurements(tmp_path):
    """Metashape writes the sensors, and so calibrations, in front of the markers."""
    marked = """<markers><marker id="0" label="P 1"><reference x="5" y="6" z="7"/>
    </marker><marker id="1" label="P2"/></markers><frames><frame id="0"><markers>
    <marker marker_id="0"><location camera_id="0" pinned="true" x="10.5" y="20.5"/>
    </marker><marker marker_id="1"><location camera_id="0" x="1" y="2"/></marker>
    </markers></frame></frames></chunk>"""
    text = MORE["cameras.xml"]
    file = tmp_path / "markers.xml"
    file.write_text(text.replace("</chunk>", marked))
    found = read_foreign(file)
    assert list(found.cameras) == ["FC6310"]
    measured = found.tables["image_points"].to_numpy().tolist()
    image = measured[0][0]
    assert measured == [[image, "P 1", 10.5, 20.5], [image, "P2", 1.0, 2.0]]
    control = found.tables["control_points"].iloc[0]
    assert control[["point_id", *PLACE]].tolist() == ["P 1", 5.0, 6.0, 7.0]
    file.write_text(text)
    assert "image_points" not in read_foreign(file).tables


def test_orientations_of_mmvii_are_those_of_micmac(tmp_path):
    """One image, written by both: axes of the camera are columns of the older matrix.

    IMGP4167.JPG of the tests of MMVII, with its figures shortened to nine digits.
    """
    axes = np.array(
        [
            [-0.162381355, 0.038317790, 0.985983794],
            [0.097033570, 0.995022468, -0.022688628],
            [-0.981945407, 0.091989318, -0.165291209],
        ]
    )
    older = tmp_path / "Orientation-IMGP4167.JPG.xml"
    text = ORIENTATION
    for name, row in zip(("L1", "L2", "L3"), axes.T, strict=True):
        said = " ".join(map(str, row))
        text = re.sub(f"<{name}>.*?</{name}>", f"<{name}>{said}</{name}>", text)
    older.write_text(re.sub("<Centre>.*?</", "<Centre>5.25 1.5 2.125</", text))
    named = zip("IJK", axes.tolist(), strict=True)
    matrix = "".join(f"<Axe{n}>{a} {b} {c}</Axe{n}>" for n, (a, b, c) in named)
    newer = tmp_path / "Ori-PerspCentral-IMGP4167.JPG.xml"
    newer.write_text(
        f"""<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>
<Root><Type>"MMVII_Serialization"</Type><Version>"0.0.0"</Version><Data><CameraPose>
<NameImage>"IMGP4167.JPG"</NameImage><Center>5.25 1.5 2.125</Center>
<RotMatrix>{matrix}</RotMatrix></CameraPose></Data></Root>"""
    )
    one, two = (read_foreign(file).tables["orientations"] for file in (older, newer))
    assert one["image_id"].tolist() == two["image_id"].tolist() == ["IMGP4167.JPG"]
    columns = [*PLACE, "omega", "phi", "kappa"]
    np.testing.assert_allclose(one[columns], two[columns], atol=1e-12)


def test_control_of_a_project_stands_before_all_of_its_points(tmp_path):
    """As DBAT reads it; a tie point is no control, whatever precision it has."""
    control = "     317 1.5 2.5 3.5 0.01 0.02 0.03\n"
    points = f"{control}\n{control}     318 4.5 5.5 6.5 0.01 0.02 0.03\n"
    file = tmp_path / "project.txt"
    file.write_text(PROJECT.replace(control, points))
    found = read_foreign(file)
    table = found.tables["control_points"]
    roles = dict(zip(table["point_id"], table["role"], strict=True))
    assert roles == {"317": "control", "318": "new"}
    assert any("those of its adjustment" in note for note in found.notes)
    file.write_text(PROJECT)
    assert read_foreign(file).tables["control_points"]["role"].tolist() == ["new"]


CALIBRATION = "7.5 3.6 2.6 7.25 5.44 0.005 -1e-4 0 -6e-5 -4e-5"


def test_the_camera_of_a_project(tmp_path):
    """Brown as DBAT has it: pixels to millimetres, y up, corrected as measured."""
    file = tmp_path / "project.txt"
    text = PROJECT.replace("   0 1 1 1 1 1 1 1 1 1 1\n", f"   0 {CALIBRATION}\n", 1)
    file.write_text(text.replace(" 20 100 100\n", " 20 2272 1704\n"))
    ((name, keys),) = read_foreign(file).cameras.items()
    assert name == "camera"
    column, row = 300.0, 200.0
    x, y = column * 7.25 / 2272 - 3.6, 2.6 - row * 5.44 / 1704
    r2 = x * x + y * y
    radial, (p1, p2) = 0.005 * r2 - 1e-4 * r2**2, (-6e-5, -4e-5)
    x_is = x + radial * x + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y
    y_is = y + radial * y + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y
    found = camera_of(keys).xy_from_measured([column, row])
    np.testing.assert_allclose(found, [x_is, y_is], rtol=0, atol=1e-12)


def test_a_project_without_numbers_of_pixels_has_no_camera(tmp_path):
    file = tmp_path / "project.txt"
    file.write_text(PROJECT.replace(" 20 100 100\n", " 20\n"))
    found = read_foreign(file)
    assert not found.cameras
    said = "no camera, as it has not the number of pixels: c = 1 mm, 1 mm by 1 mm"
    assert any(said in note for note in found.notes)


def test_cameras_of_photos_that_were_calibrated_one_by_one(tmp_path):
    """Each is named after the first photo that it has."""
    file = tmp_path / "project.txt"
    photo = PROJECT[PROJECT.index("   0 c:") : PROJECT.index("     317")]
    second = photo.replace("   0 ", "   1 ").replace("8811", "8812")
    third = photo.replace("   0 ", "   2 ").replace("8811", "8813")
    third = third.replace("   2 1 1 1 1", "   2 2 1 1 1", 1)
    photos = photo.rstrip("\n") + "\n" + second.rstrip("\n") + "\n" + third
    file.write_text(PROJECT.replace(photo, photos))
    cameras = read_foreign(file).cameras
    assert {name: keys["c"] for name, keys in cameras.items()} == {
        "8811.jpg": 1.0,
        "8813.jpg": 2.0,
    }


def test_a_project_may_list_marks_of_points_that_it_leaves_out(tmp_path):
    """DBAT's own camcal-pmexport.txt lists 2081 marks after its 2074."""
    file = tmp_path / "project.txt"
    file.write_text(PROJECT + "   0    2\n")
    found = read_foreign(file)
    assert len(found.tables["image_points"]) == 1
    assert "project.txt: lists 1 mark more than it has" in found.notes


def test_blanks_before_the_declaration_of_xml_are_passed(tmp_path):
    file = tmp_path / "GCP.xml"
    file.write_text(f"\n   {DICO}")
    assert len(read_foreign(file).tables["control_points"])
    file.write_text(f"\n   {DICO}".replace("</Pt>", "</Pr>", 1))
    row = DICO[: DICO.index("</Pt>")].count("\n") + 2
    with pytest.raises(EinschaltError, match=f"row {row}: is no whole XML"):
        read_foreign(file)


CHOSEN = """id  NOM   CAMERA\tP\tO\tK\tX\tY\tZ
1   im1   UCE-M3  -0.07  -0.25  0.84  814975.925  6283986.148  1771.28
"""
USUAL = "NOM X Y Z O P K CAMERA\nim1 814975.925 6283986.148 1771.28 -0.25 -0.07 0.84 "


def test_columns_of_ign_stand_where_the_header_has_them(tmp_path):
    """Borea writes the columns that are chosen, in the order that is chosen."""
    tables = []
    for name, text in (("a.opk", CHOSEN), ("b.opk", f"{USUAL}UCE-M3\n")):
        (tmp_path / name).write_text(text)
        tables.append(read_foreign(tmp_path / name).tables["orientations"])
    assert tables[0].to_dict() == tables[1].to_dict()
    file = tmp_path / "a.opk"
    file.write_text(CHOSEN.replace("K", "X"))
    with pytest.raises(EinschaltError, match="row 1: the header names no K"):
        read_foreign(file)
    file = tmp_path / "a.xyz"
    file.write_text("ID Y X Z\nP1 2 1 3\n")
    found = read_foreign(file).tables["control_points"]
    assert found.to_numpy().tolist() == [["P1", 1.0, 2.0, 3.0]]
    file.write_text("X Y Z R\n1.5 2.5 3.5 120\n")
    found = read_foreign(file).tables["control_points"]
    assert found.to_numpy().tolist() == [["1", 1.5, 2.5, 3.5]]


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.mes", "T1 832595.544 6282587.814 52.639\n", "row 1: .* names no image"),
        ("a.xyz", "832595.544 6282587.814 52.6 9\n", "row 1: .* and no name"),
    ],
)
def test_coordinates_are_no_names_of_ign(tmp_path, name, text, said):
    (tmp_path / name).write_text(text)
    with pytest.raises(EinschaltError, match=said):
        read_foreign(tmp_path / name)


def test_quotes_around_names_of_ign_are_no_part_of_them(tmp_path):
    """Control and its image points may come from two programs."""
    (tmp_path / "a.app").write_text('"1003" 13 815601.51 6283629.28 54.96\n')
    (tmp_path / "a.mes").write_text('"1003" im1 24042.25 14781.17\n')
    control = read_foreign(tmp_path / "a.app").tables["control_points"]
    measured = read_foreign(tmp_path / "a.mes").tables["image_points"]
    assert control["point_id"].tolist() == measured["point_id"].tolist() == ["1003"]


LOCAL = 'LOCAL_CS["Local Coordinates (m)",LOCAL_DATUM["Local Datum",0],UNIT["metre",1]]'


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", f"# CoordinateSystem: {LOCAL}\n#Label,X,Y,Z\ntarget 10,4.5,0,0.25\n"),
        ("a.points", f"#CRS: {LOCAL}\n{{points}}"),
    ],
)
def test_a_system_of_a_laboratory_is_none(tmp_path, name, text):
    """It would stand in block.toml otherwise, which has no use for it."""
    points = READ["a.tif.points"][0]
    points = points[points.index("mapX") :]
    (tmp_path / name).write_text(text.format(points=points))
    assert read_foreign(tmp_path / name).crs is None


@pytest.mark.parametrize("name", ["SetMesIm", "SetMesPtOf1Im"])
def test_image_points_of_mmvii_under_either_name(tmp_path, name):
    file = tmp_path / "MesIm-A.JPG.xml"
    file.write_text(
        f"""<Root><Type>"MMVII_Serialization"</Type><Data><{name}>
    <NameIm>"A.JPG"</NameIm><Measures>
    <el><Name>"Stone-6"</Name><Pt>644.25 232.5</Pt><Sigma2>1 0 1</Sigma2></el>
    <el><Name>"Grille"</Name><Pt>322 766.75</Pt><Sigma2>1 0 1</Sigma2></el>
    </Measures></{name}></Data></Root>"""
    )
    measured = read_foreign(file).tables["image_points"].to_numpy().tolist()
    expected = [["A.JPG", "Stone-6", 644.25, 232.5], ["A.JPG", "Grille", 322.0, 766.75]]
    assert measured == expected


@pytest.mark.parametrize("head", ["X,Y,Z,Yaw", "X/Easting,Y/Northing,Z/Altitude,Yaw"])
def test_axes_of_a_reference_may_stand_alone(tmp_path, head):
    file = tmp_path / "ref.csv"
    file.write_text(f"#Label,{head},Enabled\nA 1,999660.44, 112368.17,1916.55,90,0\n")
    found = read_foreign(file).tables["control_points"].iloc[0]
    assert found[PLACE].tolist() == [999660.44, 112368.17, 1916.55]
    assert (found["point_id"], found["role"]) == ("A 1", "check")


def test_degrees_of_a_reference_without_a_system_are_no_metres(tmp_path):
    """They became eastings and northings in silence."""
    head = "#Label,X/Longitude,Y/Latitude,Z/Altitude\n"
    (tmp_path / "ref.csv").write_text(f"{head}point 1,172.575336,-43.52148,24.13\n")
    found = read_foreign(tmp_path / "ref.csv")
    assert found.tables["control_points"].to_dict("records") == [
        {
            "point_id": "point 1",
            "longitude": 172.575336,
            "latitude": -43.52148,
            "height": 24.13,
            "role": "control",
        }
    ]
    assert found.crs is None
    # the same line stands above metres in files of scripts
    (tmp_path / "ref.csv").write_text(f"{head}A,512345.5,5312345.25,24.13\n")
    table = read_foreign(tmp_path / "ref.csv").tables["control_points"]
    assert table[["easting", "northing"]].iloc[0].tolist() == [512345.5, 5312345.25]


def test_places_of_images_in_a_reference_are_no_control(tmp_path):
    """Of cameras and markers in one file, as Metashape exports them."""
    head = "#Label\tX/Easting\tY/Northing\tZ/Altitude\tYaw\n"
    images = "A_1.JPG\t512345.5\t5312345.25\t124.13\t90\nA_2.tif\t1\t2\t3\t\n"
    (tmp_path / "ref.txt").write_text(f"{head}{images}P1\t4\t5\t6\t\n")
    found = read_foreign(tmp_path / "ref.txt")
    assert found.tables["control_points"]["point_id"].tolist() == ["P1"]
    assert found.notes == ("ref.txt: places of 2 images left out: they are no points",)
    (tmp_path / "ref.txt").write_text(f"{head}{images}")
    with pytest.raises(EinschaltError, match=r"places of images, such as 'A_1\.JPG'"):
        read_foreign(tmp_path / "ref.txt")


def test_images_without_places_in_a_reference_are_left_out_as_well(tmp_path):
    """Cameras that have no reference; they were points without coordinates."""
    head, images = "#Label,X/Easting,Y/Northing,Z/Altitude\n", "A.JPG,,,\nB.JPG,,,\n"
    (tmp_path / "ref.txt").write_text(f"{head}{images}P1,4,5,6\n")
    found = read_foreign(tmp_path / "ref.txt")
    assert found.tables["control_points"]["point_id"].tolist() == ["P1"]
    assert found.notes == ("ref.txt: places of 2 images left out: they are no points",)
    (tmp_path / "ref.txt").write_text(f"{head}{images}")
    with pytest.raises(EinschaltError, match="Export the markers, not the cameras"):
        read_foreign(tmp_path / "ref.txt")
    (tmp_path / "ref.txt").write_text(f"{head}{images}P1,,,\n")
    with pytest.raises(EinschaltError, match="row 4: 'P1,,,' is no point"):
        read_foreign(tmp_path / "ref.txt")


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("mark", ["#", "# ", ""])
def test_a_reference_has_the_separator_that_was_chosen(tmp_path, separator, mark):
    rows = [
        ["Label", "X/Easting", "Y/Northing", "Z/Altitude", "Accuracy_X/Y_(m)"],
        ['"A 1"', "999660.44", "112368.17", "1916.55", "0.5"],
        ["B", "999661.44", "112369.17", "1917.55", "0.5"],
    ]
    text = "".join(f"{separator.join(row)}\n" for row in rows)
    (tmp_path / "ref.txt").write_text(mark + text)
    found = read_foreign(tmp_path / "ref.txt").tables["control_points"]
    assert found["point_id"].tolist() == ["A 1", "B"]
    assert found[PLACE].to_numpy()[0].tolist() == [999660.44, 112368.17, 1916.55]
    np.testing.assert_allclose(found["standard_error_m"], 0.5 * np.sqrt(2.0))


def test_empty_columns_of_a_reference_stay_columns(tmp_path):
    """Points that are measured in no image have no estimate; one has lost its label."""
    head = "#Label\tX\tY\tZ\tX_est\tY_est\n"
    (tmp_path / "ref.txt").write_text(f"{head}A\t1.5\t2.5\t3.5\t\t\n")
    found = read_foreign(tmp_path / "ref.txt").tables["control_points"]
    assert found[PLACE].to_numpy().tolist() == [[1.5, 2.5, 3.5]]
    (tmp_path / "ref.txt").write_text(f"{head}\t1.5\t2.5\t3.5\t4.5\t5.5\n")
    with pytest.raises(EinschaltError, match=r"row 2: .* is no point"):
        read_foreign(tmp_path / "ref.txt")


def test_points_of_a_referenced_raster_are_no_pixels(tmp_path):
    """QGIS writes coordinates of a raster that has a system; rows below 0 are none."""
    file = tmp_path / "a.tif.points"
    file.write_text(QGIS.replace(",-", ","))
    with pytest.raises(EinschaltError, match="sourceY is above 0 in every line"):
        read_foreign(file)
    file.write_text(QGIS.replace("-20.25", "0.25"))  # a click above the first row
    assert read_foreign(file).tables["image_points"]["y"].tolist() == [-0.25, 40.0]


def test_stations_of_others_are_named_by_code_and_solution(tmp_path):
    text = MORE["a.snx"].replace(" EIN", " IGN").replace("+SITE", "*\n+SITE")
    two = text.replace("STAX", "VELX").partition("+SOLUTION/MATRIX")[0] + "%ENDSNX\n"
    file = tmp_path / "a.snx"
    for data, name, size in ((text, "0000", 1e-2), (two, "0000", 1e-2)):
        file.write_text(data)
        if "VELX" in data:
            with pytest.raises(EinschaltError, match="lacks coordinates of a station"):
                read_foreign(file)
            file.write_text(data.replace("VELX", "STAX"))
        found = read_foreign(file).tables["stations"].iloc[0]
        assert (found["point_id"], found["standard_error_y"]) == (name, size)
    file.write_text(text.replace("1.0E-04", "0.0E+00", 1))
    with pytest.raises(EinschaltError, match="a coordinate has no variance"):
        read_foreign(file)
    corr = text.replace("COVA", "CORR").replace("1.0E-04", "1.0E-02")
    file.write_text(corr.replace("0.0E+00", "5.0E-01", 1))
    covariance = sinex.read_covariance(read_once(file, file.name))[1]
    assert covariance[0, 1] == pytest.approx(0.5e-4)


def test_a_list_without_a_last_line_break_is_doubted(tmp_path):
    for text, is_whole in (("P1 1 2 3.5\n", True), ("P1 1 2 3.5", False)):
        (tmp_path / "a.xyz").write_bytes(text.encode())
        notes = read_foreign(tmp_path / "a.xyz").notes
        assert any("is its last line whole?" in note for note in notes) != is_whole


def test_tables_are_left_to_their_own_reader(tmp_path):
    (tmp_path / "t.csv").write_text("point_id,easting,northing\n7,1,2\n")
    assert recognised.reader_of(tmp_path / "t.csv") is None


def test_formats_of_ones_own_are_read_by_suffix_or_name(tmp_path, monkeypatch):
    import pandas as pd

    class Point:
        name = ".abc"

        def load(self):
            return lambda _: {"control_points": pd.DataFrame({"point_id": ["1"]})}

    monkeypatch.setattr(recognised, "installed_readers", lambda: [Point()])
    (tmp_path / "a.abc").write_text("")
    (tmp_path / "a.txt").write_text("")
    for path, name in ((tmp_path / "a.abc", None), (tmp_path / "a.txt", ".abc")):
        assert len(read_foreign(path, name).tables["control_points"]) == 1
    with pytest.raises(EinschaltError, match="format 'abd' is unknown"):
        read_foreign(tmp_path / "a.abc", "abd")


def test_two_tables_of_photomodeler_in_one_file_are_to_be_parted(tmp_path):
    marks = "Object Point ID,Photo #,X (pixels),Y (pixels)\n1,1,10.5,20.5\n"
    file = tmp_path / "marks.txt"
    file.write_text(marks)
    assert len(read_foreign(file).tables["image_points"]) == 1
    file.write_text(f"{marks}\n{marks}")
    with pytest.raises(EinschaltError, match=r"row 4: .* another table begins") as told:
        read_foreign(file)
    assert "into a file of their own" in str(told.value)
