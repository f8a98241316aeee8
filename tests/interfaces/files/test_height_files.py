"""Heights of the terrain, as they may come."""

import numpy as np
import pytest
import shapely
from PIL import Image, TiffImagePlugin

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.files.height_files import read_heights
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights

UTM = "EPSG:32633"
EAST, NORTH, CELL = 500_000.0, 5_300_000.0, 100.0
AREA = FlightArea(
    shapely.box(EAST + 1000, NORTH + 1000, EAST + 4000, NORTH + 3000), UTM
)
PLANE = (1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633)
ROWS, COLUMNS = np.mgrid[0:40, 0:50]
GROUND = (500.0 + 2.0 * COLUMNS + 3.0 * ROWS).astype("float32")


def write(path, cells=GROUND, *, nodata=None, keys=PLANE, east=EAST, of_gdal=None):
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    given = {
        33550: (12, (CELL, CELL, 0.0)),
        33922: (12, (0.0, 0.0, 0.0, east, NORTH + 40 * CELL, 0.0)),
        34735: (3, keys),
    }
    if nodata is not None:
        given[42113] = (2, nodata)
    if of_gdal is not None:
        given[42112] = (2, f"<GDALMetadata>\n{of_gdal}\n</GDALMetadata>")
    for tag, (kind, value) in given.items():
        tags.tagtype[tag] = kind
        tags[tag] = value
    Image.fromarray(cells).save(path, tiffinfo=tags)
    return path


def with_gap(value, rows=slice(12, 14)):
    cells = GROUND.copy()
    cells[rows, 20:24] = value
    return cells


def test_cells_lie_where_the_tags_say(tmp_path):
    heights = read_heights(write(tmp_path / "a.tif"), UTM).over(AREA)
    place = np.array([[EAST + 2050.0, NORTH + 2050.0]])
    # column 20, row 19 from the north
    assert heights.mean_around(place, 10.0) == pytest.approx([500 + 40 + 57])
    assert heights.spacing == pytest.approx(100.0)
    as_points = (1, 1, 0, 2, 1024, 0, 1, 1, 1025, 0, 1, 2)
    points = read_heights(write(tmp_path / "a.tif", keys=as_points), UTM)
    assert points.plane[0] == pytest.approx([EAST, NORTH + 4000])


IN_FEET = (*PLANE[:3], PLANE[3] + 1, *PLANE[4:])
ITEM = '<Item name="{0}" sample="0" role="{0}">{1}</Item>'


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"keys": (*IN_FEET, 4099, 0, 1, 9002)}, "unit foot \\(EPSG:9002"),
        ({"keys": (*IN_FEET, 4096, 0, 1, 6360)}, "unit US survey foot, that of NAVD"),
        (
            {"keys": (*IN_FEET, 3076, 0, 1, 9003)},
            "cells are in the unit US survey",
        ),
        ({"of_gdal": ITEM.format("scale", "0.1")}, "heights have the scale 0.1"),
        ({"of_gdal": ITEM.format("offset", "none")}, "heights have the offset none"),
        ({"of_gdal": ITEM.format("unittype", "ft")}, "heights have the unittype ft"),
    ],
)
def test_other_units_are_not_taken_for_metres(tmp_path, given, said):
    with pytest.raises(EinschaltError, match=said):
        read_heights(write(tmp_path / "a.tif", **given), UTM)


@pytest.mark.parametrize("code", [5778, 4979, 5013, 32767, 1])  # metres, or not known
def test_systems_of_heights_in_metres_are_read(tmp_path, code):
    heights = read_heights(
        write(tmp_path / "a.tif", keys=(*IN_FEET, 4096, 0, 1, code)), UTM
    )
    assert heights.height.max() == GROUND.max()


def test_units_that_are_metres_are_read(tmp_path):
    keys = (
        *IN_FEET[:3],
        PLANE[3] + 2,
        *IN_FEET[4:],
        3076,
        0,
        1,
        9001,
        4099,
        0,
        1,
        9001,
    )
    given = {"scale": "1.000", "offset": "-0.0", "unittype": "Metre"}
    items = "".join(ITEM.format(*item) for item in given.items())
    found = read_heights(write(tmp_path / "a.tif", keys=keys, of_gdal=items), UTM)
    usual = read_heights(write(tmp_path / "b.tif"), UTM)
    np.testing.assert_array_equal(found.height, usual.height)


def test_whole_numbers_and_missing_values_outside_the_area(tmp_path):
    whole = write(tmp_path / "a.tif", GROUND.astype("int16"))
    # of the corners of the area, between four cells each: columns 9.5 and 39.5, rows
    # 9.5 and 29.5; what lies beside it counts no more
    assert read_heights(whole, UTM).over(AREA).range == (547.5, 667.5)
    outside = write(tmp_path / "b.tif", with_gap(-9999, slice(0, 3)), nodata="-9999")
    assert np.isfinite(read_heights(outside, UTM).over(AREA).height).all()


@pytest.mark.parametrize(
    ("cells", "options", "says"),
    [
        (with_gap(-9999), {"nodata": "-9999"}, "8 of 600 places .* without a height"),
        (with_gap(np.nan), {}, "8 of 600 places .* without a height"),
        (with_gap(-9999), {}, "height of -9999 m .* declare it as nodata"),
        (with_gap(3.4e38), {}, "Does it stand for a missing one"),
        (GROUND, {"nodata": "none"}, "nodata is no number"),
        (
            GROUND,
            {"east": 100_000.0},
            r"none of 2000 heights .* eastings of 100.*\(EPSG:32633\)\. .*--crs",
        ),
        (GROUND, {"keys": (1, 1, 0, 1, 1024, 0, 1, 2)}, "cells are in degrees"),
        (GROUND, {"keys": (*PLANE[:-1], 31255)}, r"in MGI .*--crs EPSG:31255"),
        (
            GROUND,
            {"keys": (*PLANE[:-1], 14641)},
            "a.tif: .* EPSG:14641, which is no",
        ),
        (GROUND, {"east": np.nan}, "a.tif: its tags are damaged"),
        (GROUND[:, :25], {}, "nearest height to 504000, .* away"),
    ],
)
def test_rasters_that_do_not_do_are_refused(cells, options, says, tmp_path):
    path = write(tmp_path / "a.tif", np.ascontiguousarray(cells), **options)
    with pytest.raises(EinschaltError, match=says):
        read_heights(path, UTM).over(AREA).require_cover(AREA)


def test_files_that_are_damaged_are_told(tmp_path):
    whole = write(tmp_path / "a.tif").read_bytes()
    for name, data, says in [
        ("cut.tif", whole[: len(whole) // 2], "cannot be read|no TIFF"),
        ("no.tif", b"hello", "is no TIFF of one band"),
        ("two.xyz", b"1 2\n3 4\n", "row 1: the line has 2 numbers"),
        ("late.xyz", b"1 2 3\n1 2\n", "row 2: the line has 2 numbers"),
        ("word.xyz", b"1 2 3\n1 2 x\n", "word.xyz, row 2: 'x' is no number"),
        ("gap.xyz", b"1 2 3\n\n \n1 2 x\n", "gap.xyz, row 4: 'x' is no number"),
        ("short.xyz", b"\n1 2 3\n\n1 2\n", "row 4: the line has 2 numbers"),
        ("empty.xyz", b"", "is empty"),
        ("a.jpg", b"", "suffix '.jpg'"),
    ]:
        (tmp_path / name).write_bytes(data)
        with pytest.raises(EinschaltError, match=says):
            read_heights(tmp_path / name, UTM)


@pytest.mark.parametrize(
    ("name", "header", "line"),
    [
        ("a.xyz", "", "{e} {n} {h}"),
        ("a.csv", "northing,easting,height\n", "{n},{e},{h}"),
        ("b.csv", "easting;northing;height\n", "{e};{n};{c}"),
        ("c.csv", "Rechtswert;Hochwert;Höhe\n", "{e};{n};{c}"),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_lists_and_tables(name, header, line, encoding, tmp_path):
    places = [(EAST + e, NORTH + n) for e in (1500, 3500) for n in (1500, 2500)]
    lines = [
        line.format(e=e, n=n, h=f"{k}.5", c=f"{k},5") for k, (e, n) in enumerate(places)
    ]
    (tmp_path / name).write_text(header + "\n".join(lines) + "\n", "utf-8")
    heights = read_heights(tmp_path / name).over(AREA)
    assert heights.range == (0.5, 3.5)
    assert heights.plane[1].tolist() == [EAST + 1500, NORTH + 2500]
    (tmp_path / name).write_text(header + "\n".join(lines[:2]) + "\n", "utf-8")
    with pytest.raises(EinschaltError, match="2 of 2 heights in the area"):
        read_heights(tmp_path / name).over(AREA)


@pytest.mark.parametrize(
    "head",
    [
        "x y z\n",
        '"X","Y","Z"\n',
        "# of a survey\n",
        "# of a survey\n\nX Y Z\n# in metres\n",
        "easting,northing,height\n",
        "Rechtswert Hochwert Höhe\n",
    ],
)
def test_xyz_may_have_a_header_and_comments(head, tmp_path):
    sign = "," if "," in head else " "
    lines = [sign.join(row) + "\n" for row in (["1.5", "2", "3"], ["2", "3", "4"])]
    path = tmp_path / "a.xyz"
    path.write_text(head + "".join(lines), "utf-8")
    heights = read_heights(path)
    assert heights.plane.tolist() == [[1.5, 2.0], [2.0, 3.0]]
    assert heights.height.tolist() == [3.0, 4.0]


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("a.txt", "x y z\n1 2 3\n", "'y' and 'x'.*Call the columns easting"),
        ("a.csv", "X,Y,H\n1,2,3\n", "Call the columns easting, northing and height"),
        ("a.xyz", "y x z\n1 2 3\n", "Call the columns easting, northing and height"),
        ("a.csv", "easting;northing;height\n1,500;2;3\n", "with decimal points"),
        ("a.csv", "easting,northing,Höhe,Hoehe\n1,2,3,4\n", "both be height.*Call the"),
        ("a.xyz", "# nothing else\n", "a.xyz"),
        ("a.xyz", "x y z\n", "a.xyz"),
        ("a.xyz", "x y z\n1 2\n", "row 2: the line has 2 numbers"),
        ("a.asc", "ncols 2\nnrows 1\n1 2\n", "ASCII grid .*not read.*to GeoTIFF"),
    ],
)
def test_advice_on_heights_is_of_heights(name, text, says, tmp_path):
    """A plan has no block.toml to say columns in."""
    (tmp_path / name).write_text(text, "utf-8")
    with pytest.raises(EinschaltError, match=says) as caught:
        read_heights(tmp_path / name)
    assert "block.toml" not in str(caught.value)


def test_zeros_far_below_all_others_are_said():
    """A hole of 0 m in ground of 500 m was planned as ground."""
    plane = np.stack(np.meshgrid(*[np.arange(10.0) * 100.0] * 2), -1).reshape(-1, 2)
    height = 500.0 + 0.1 * plane[:, 0]
    area = FlightArea(shapely.box(0.0, 0.0, 900.0, 900.0).buffer(1.0))
    assert GroundHeights(plane, height, "a.xyz").over(area).said_of_zeros() == ""
    height[[44, 45, 54]] = 0.0
    said = GroundHeights(plane, height, "a.xyz").over(area).said_of_zeros()
    assert said.startswith("3 heights of the terrain are exactly 0 m, the others 500 m")
    # land that comes down to the sea
    by_the_sea = np.maximum(0.1 * plane[:, 0] - 30.0, 0.0)
    assert GroundHeights(plane, by_the_sea, "a.xyz").over(area).said_of_zeros() == ""


def test_cells_have_the_ground_of_their_mean():
    """Of cells the lowest counts where a limit of height is held, not for control."""
    plane = np.stack(np.meshgrid(*[np.arange(200.0) * 5.0] * 2), -1).reshape(-1, 2)
    fine = GroundHeights(plane, 500.0 + 0.3 * plane[:, 0], "a.xyz")
    places = np.array([[300.0, 400.0], [512.0, 77.0]])
    expected = 500.0 + 0.3 * places[:, 0]
    np.testing.assert_allclose(fine.at(places), expected, atol=1e-9)
    coarse = fine.in_cells(40.0)
    np.testing.assert_allclose(coarse.at(places), expected, atol=1e-6)
    assert (coarse.straight_below(places) < expected - 3.0).all()
