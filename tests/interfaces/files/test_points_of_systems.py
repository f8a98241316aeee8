"""Control in every system that surveyors have, brought into that of the block."""

from dataclasses import replace
from hashlib import sha256

import numpy as np
import pandas as pd
import pyproj
import pytest
from tests.moved_block import CONTROL, PLANE, moved_block
from tests.ntv2_grids import write_ntv2

import einschalt as es
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.projections import read_source_crs
from einschalt.interfaces.files import block_folder
from einschalt.interfaces.files.block_folder import find_problems, read_block
from einschalt.interfaces.files.block_writing import write_block
from einschalt.interfaces.files.points_of_systems import bring
from einschalt.pipeline.block.places import place_problems

SALZBURG, LUCERNE, NEW_YORK = (13.5, 47.3), (8.0, 47.0), (-73.0, 40.7)


@pytest.mark.parametrize(
    ("crs", "own", "place", "accuracy"),
    [
        # datums tied by an operation: within what PROJ states for it
        ("EPSG:31255", "EPSG:4258", SALZBURG, 1.5),
        ("EPSG:31255", "EPSG:4326", SALZBURG, 1.5),
        ("EPSG:31255", "EPSG:25833", SALZBURG, 1.5),
        ("EPSG:25832", "EPSG:2056", LUCERNE, 0.1),
        ("EPSG:25832", "EPSG:21781", LUCERNE, 1.5),
        # the same datum: exact
        ("EPSG:31255", "EPSG:31287", SALZBURG, 0.0),
        ("EPSG:31255", "EPSG:31258", SALZBURG, 0.0),
        ("EPSG:31255", "EPSG:4312", SALZBURG, 0.0),
        ("EPSG:25833", "EPSG:4258", SALZBURG, 0.0),
        ("EPSG:32118", "EPSG:2263", NEW_YORK, 0.0),  # US survey feet
        ("EPSG:27700", "EPSG:4277", (-1.5, 52.0), 0.0),
        ("EPSG:27561", "EPSG:4807", (5.0, 49.5), 0.0),  # grads from Paris
    ],
)
def test_control_of_any_system_is_where_it_was(small_block, crs, own, place, accuracy):
    accepted = "crs_accuracy_m = 2.0" if accuracy else ""
    frame = moved_block(small_block, crs, place, own, settings=accepted)
    block = read_block(small_block.path)
    found = block.control_points[PLANE].to_numpy()
    apart = np.hypot(*(found - frame[PLANE].to_numpy()).T)
    # exchanged axes or forgotten feet are off by kilometres; the same operation there
    # and back by nothing, another one by no more than both are wrong by
    assert apart.max() <= max(1e-6, 2.0 * accuracy)
    shared = {"control_points": accuracy} if accuracy else {}
    assert block.shared_errors_m == pytest.approx(shared)
    (note,) = block.notes
    for code in (own, crs):
        assert f"{pyproj.CRS(code).name} ({code})" in note
    assert f"({accuracy:g} m" in note


@pytest.mark.parametrize(
    ("own", "crs", "place", "grid"),
    [
        ("EPSG:31255", "EPSG:25833", SALZBURG, "at_bev_AT_GIS_GRID_2021_09_28.tif"),
        ("EPSG:31467", "EPSG:25832", (9.0, 50.0), "de_hvbg_hessen_HeTA2010.tif"),
        ("EPSG:21781", "EPSG:25832", LUCERNE, "ch_swisstopo_CHENyx06_ETRS.tif"),
        ("EPSG:25833", "EPSG:31256", (15.5, 47.2), "at_bev_AT_GIS_GRID_2021_09_28.tif"),
    ],
)
def test_no_block_goes_through_metres_in_silence(small_block, own, crs, place, grid):
    moved_block(small_block, crs, place, own)
    (problem,) = find_problems(small_block.path).problems
    for code in (own, crs):
        assert f"{pyproj.CRS(code).name} ({code})" in problem.found
    assert f"needs {grid}, which is missing" in problem.found
    assert problem.expected.startswith("an accuracy of 0.0075 m")
    shared = read_block(small_block.path, {"crs_accuracy_m": 2.0}).shared_errors_m
    assert shared["control_points"] in (1.0, 1.5)


def test_default_is_a_quarter_of_the_standard_error(small_block):
    moved_block(small_block, "EPSG:25832", LUCERNE, "EPSG:2056")
    (problem,) = find_problems(small_block.path).problems
    assert "CH1903+ to ETRS89 (1): 0.1 m" in problem.found
    assert problem.expected.startswith("an accuracy of 0.0075 m, a quarter of the 0.03")
    assert problem.remedy == "Set crs_accuracy_m = 0.1 to use CH1903+ to ETRS89 (1)"
    small_block.replace("block.toml", "standard_error_m = 0.03", "standard_error_m = 1")
    assert read_block(small_block.path).shared_errors_m == {"control_points": 0.1}


def test_without_standard_errors_a_centimetre_is_allowed(small_block):
    moved_block(small_block, "EPSG:25832", LUCERNE, "EPSG:2056")
    small_block.replace("block.toml", "standard_error_m = 0.03\n", "")
    (problem,) = find_problems(small_block.path).problems
    assert "an accuracy of 0.01 m, since the points have no st" in problem.expected


def test_settings_that_are_given_go_before_those_of_the_file(small_block):
    moved_block(small_block, "EPSG:25832", LUCERNE, "EPSG:2056")
    block = read_block(small_block.path, {"crs_accuracy_m": 0.1})
    assert block.settings.crs_accuracy_m == 0.1
    with pytest.raises(EinschaltError, match="none of the operations"):
        read_block(small_block.path, {"crs_operation": "by hand"})


def test_grids_are_looked_for_from_the_folder_of_the_block(small_block):
    settings = 'grids = "grids"'
    moved_block(small_block, "EPSG:25832", LUCERNE, "EPSG:2056", settings=settings)
    with pytest.raises(EinschaltError, match=r"grids = 'grids' is no folder"):
        read_block(small_block.path)
    (small_block.path / "grids").mkdir()
    with pytest.raises(EinschaltError, match="no operation is good enough"):
        read_block(small_block.path)


def test_a_grid_in_the_folder_is_used_and_named(small_block):
    settings = 'grids = "grids"\ncrs_accuracy_m = 0.25'
    moved_block(small_block, "EPSG:25832", LUCERNE, "EPSG:21781", settings=settings)
    grids, grid = small_block.path / "grids", "ch_swisstopo_CHENyx06_ETRS.tif"
    grids.mkdir()
    with pytest.raises(EinschaltError, match=f"needs {grid}, which is missing"):
        read_block(small_block.path)
    write_ntv2(grids / grid, -1.5, -3.5)
    block = read_block(small_block.path)
    (note,) = block.notes
    assert note.endswith(f"by CH1903 to ETRS89 (2) (0.25 m) with {grid}")
    assert block.shared_errors_m == {"control_points": 0.25}
    assert grids / grid in block.files
    assert block.checksums[grid] == sha256((grids / grid).read_bytes()).hexdigest()


def test_a_grid_that_changes_while_it_is_used_is_said(small_block, monkeypatch):
    settings = 'grids = "grids"\ncrs_accuracy_m = 0.25'
    moved_block(small_block, "EPSG:25832", LUCERNE, "EPSG:21781", settings=settings)
    grid = small_block.path / "grids" / "ch_swisstopo_CHENyx06_ETRS.tif"
    grid.parent.mkdir()
    write_ntv2(grid, -1.5, -3.5)

    def written_meanwhile(*args, **options):
        write_ntv2(grid, -1.5, -3.6)
        return bring(*args, **options)

    monkeypatch.setattr(block_folder, "bring", written_meanwhile)
    (problem,) = find_problems(small_block.path).problems
    assert problem.found == "the file changed while it was read"
    assert problem.file == grid.name


def test_degrees_in_columns_that_say_metres_are_refused(small_block):
    moved_block(small_block, "EPSG:31255", SALZBURG, "EPSG:4312")
    small_block.replace(CONTROL, "longitude,latitude", "easting,northing")
    (problem,) = find_problems(small_block.path).problems
    assert "MGI (EPSG:4312) is geographic, but the columns are easting" in problem.found
    assert problem.expected == "columns longitude and latitude, in degrees"


@pytest.mark.slow
def test_metres_of_a_system_in_feet_lie_outside_of_it(small_block):
    moved_block(small_block, "EPSG:32118", NEW_YORK)
    small_block.replace("block.toml", f'"{CONTROL}"', f'"{CONTROL}"\ncrs = "EPSG:2263"')
    (problem,) = find_problems(small_block.path).problems
    assert "New York Long Island (ftUS) (EPSG:2263)" in problem.found


@pytest.mark.parametrize("own", ["EPSG:4312", "EPSG:25833"])
def test_exchanged_axes_are_told_by_the_system_of_the_points(small_block, own):
    settings = "crs_accuracy_m = 2.0"
    moved_block(small_block, "EPSG:31255", SALZBURG, own, settings=settings)
    names = "longitude,latitude" if own == "EPSG:4312" else "easting,northing"
    one, two = names.split(",")
    small_block.replace(CONTROL, names, f"{two},{one}")
    problems = find_problems(small_block.path).problems
    assert "and inside with the two exchanged" in problems[0].found
    assert problems[0].expected == f"{one}, {two} in this order"


def test_points_of_another_country_are_refused_with_both_systems(small_block):
    settings = "crs_accuracy_m = 2.0"
    moved_block(small_block, "EPSG:31255", SALZBURG, settings=settings)
    swiss = small_block.read(CONTROL).splitlines()
    rows = [
        f"{row.split(',')[0]},{2_660_000 + k},1200000" for k, row in enumerate(swiss)
    ]
    small_block.write(CONTROL, "\n".join([swiss[0], *rows[1:]]) + "\n")
    small_block.replace("block.toml", f'"{CONTROL}"', f'"{CONTROL}"\ncrs = "EPSG:2056"')
    (problem,) = find_problems(small_block.path).problems
    assert "CH1903+ / LV95 (EPSG:2056) puts the points at longitude 8." in problem.found
    assert "outside the area of MGI / Austria GK Central (EPSG:31255)" in problem.found


@pytest.mark.parametrize("is_exchanged", [False, True])
def test_longitudes_and_latitudes_that_are_exchanged_are_told(
    small_block, is_exchanged
):
    settings = "crs_accuracy_m = 2.0"
    moved_block(small_block, "EPSG:31255", SALZBURG, "EPSG:4326", settings=settings)
    if not is_exchanged:
        assert find_problems(small_block.path).problems == ()
        return
    head, rest = small_block.read(CONTROL).split("\n", 1)
    names = {"longitude": "latitude", "latitude": "longitude"}
    head = ",".join(names.get(name, name) for name in head.split(","))
    small_block.write(CONTROL, f"{head}\n{rest}")
    (problem,) = find_problems(small_block.path).problems
    assert "WGS 84 (EPSG:4326) puts the points at longitude 47." in problem.found
    assert problem.remedy.startswith("Exchanged they lie in it: call the columns")


def test_degrees_without_a_system_are_told_as_such(small_block):
    moved_block(small_block, "EPSG:31255", SALZBURG, "EPSG:4326")
    small_block.replace("block.toml", 'crs = "EPSG:4326"', "")
    (problem,) = find_problems(small_block.path).problems
    said = "column 'easting' is missing, found longitudes and latitudes"
    assert problem.found == said
    remedy = 'Say crs = "EPSG:4326", or the system of the receiver'
    assert problem.remedy.startswith(remedy)


def test_degrees_in_python_are_told_what_python_can_do(small_block, tmp_path):
    """Their remedy was to write into block.toml."""
    points = pd.DataFrame({"point_id": ["A"], "lon": [13.5], "lat": [47.3]})
    points.to_csv(tmp_path / "ll.csv", index=False)
    with pytest.raises(EinschaltError) as caught:
        es.read_points(tmp_path / "ll.csv")
    assert caught.value.remedy.startswith('Give crs="EPSG:4326", or the system')
    table = es.read_points(tmp_path / "ll.csv", crs="EPSG:4326")
    assert table.loc[0, ["longitude", "latitude"]].tolist() == [13.5, 47.3]
    block = read_block(small_block.path)
    with pytest.raises(EinschaltError) as caught:
        replace(block, control_points=points.assign(role="control"))
    said = "Transform them into the system of the block first, with pyproj"
    assert caught.value.remedy.startswith(said)


def test_the_wrong_zone_of_the_points_is_named_with_the_likely_one(small_block):
    moved_block(small_block, "EPSG:31255", SALZBURG, "EPSG:25833")
    small_block.replace("block.toml", '"EPSG:25833"', '"EPSG:25831"')
    (problem,) = find_problems(small_block.path).problems
    assert "ETRS89 / UTM zone 31N (EPSG:25831) puts the points at" in problem.found
    assert "ETRS89 / UTM zone 33N (EPSG:25833)" in problem.remedy


def test_the_wrong_zone_of_a_block_is_named_with_the_likely_one(small_block):
    moved_block(small_block, "EPSG:31258", SALZBURG)
    small_block.replace("block.toml", '"EPSG:31258"', '"EPSG:31255"')
    (problem,) = find_problems(small_block.path).problems
    assert "lie outside the area of use of MGI / Austria GK Central" in problem.found
    assert "fit MGI / Austria GK M31 (EPSG:31258)" in problem.remedy


def test_a_block_in_the_neighbouring_zone_is_told_where_it_belongs(small_block):
    moved_block(small_block, "EPSG:25832", (14.2, 47.3))
    (problem,) = find_problems(small_block.path).problems
    assert "outside the area of use of ETRS89 / UTM zone 32N" in problem.found
    assert "he place belongs to ETRS89 / UTM zone 33N (EPSG:25833)" in problem.remedy


def test_systems_that_distort_are_refused_with_the_reason(small_block):
    moved_block(small_block, "EPSG:3857", SALZBURG)
    (problem,) = find_problems(small_block.path).problems
    assert "Pseudo-Mercator (EPSG:3857) shows lengths there 1.47 times" in problem.found
    assert problem.expected == "a system true to scale within 1%"


HEIGHTS = [
    # both plane parts of one datum, heights of one system: left as they are
    ("EPSG:31255+5778", "EPSG:31258+5778", None),
    # ellipsoidal heights cannot become heights of nothing
    ("EPSG:31255", "EPSG:9267", "heights of the points are ellipsoidal"),
    ("EPSG:31255+5778", "EPSG:31258", "heights of the points have no system"),
    # and not those over the sea without a geoid
    (
        "EPSG:25833+5778",
        "EPSG:4937",
        "and at_bev_GV_Hoehengrid_V1.tif, which are missing",
    ),
]


@pytest.mark.parametrize(("crs", "own", "said"), HEIGHTS)
def test_heights_change_their_system_or_are_refused(small_block, crs, own, said):
    settings = "crs_accuracy_m = 0.05"
    way = {"settings": settings, "height": 500.0}
    if said is None:
        moved_block(small_block, crs, SALZBURG, own, **way)
        block = read_block(small_block.path)
        np.testing.assert_allclose(block.control_points["height"], 500.0, atol=1e-6)
        return
    moved_block(small_block, crs, SALZBURG, pyproj.CRS(own).to_2d().to_string(), **way)
    text = small_block.read("block.toml")
    flat = pyproj.CRS(own).to_2d().to_string()
    small_block.write("block.toml", text.replace(f'crs = "{flat}"', f'crs = "{own}"'))
    (problem,) = find_problems(small_block.path).problems
    assert said in problem.found


def test_heights_in_feet_become_metres(small_block):
    crs, own = "EPSG:32118+5703", "EPSG:2263+6360"  # NAVD88, in metres and in US feet
    moved_block(small_block, crs, NEW_YORK, own, height=120.0)
    raw = pd.read_csv(small_block.path / CONTROL)
    assert raw["height"].iloc[0] == pytest.approx(120.0 * 3937.0 / 1200.0)
    block = read_block(small_block.path)
    np.testing.assert_allclose(block.control_points["height"], 120.0, atol=1e-6)


def test_errors_by_axis_turn_with_the_axes(small_block):
    moved_block(small_block, "EPSG:25833", (12.0, 47.3), "EPSG:25832")
    frame = pd.read_csv(small_block.path / CONTROL, dtype={"point_id": str})
    errors = {"standard_error_easting": 0.04, "standard_error_northing": 0.01}
    frame.assign(**errors, covariance_en=0.0).to_csv(
        small_block.path / CONTROL, index=False
    )
    found = read_block(small_block.path).control_points
    angle = np.radians(-4.41)  # of the convergences of both zones there
    spread = 0.04**2 - 0.01**2
    size = 0.01**2 + spread * np.cos(angle) ** 2
    np.testing.assert_allclose(found["standard_error_easting"] ** 2, size, rtol=1e-3)
    covariance = spread * np.sin(angle) * np.cos(angle)
    np.testing.assert_allclose(found["covariance_en"], covariance, rtol=1e-2)
    total = found["standard_error_easting"] ** 2 + found["standard_error_northing"] ** 2
    np.testing.assert_allclose(total, 0.04**2 + 0.01**2, rtol=1e-12)


def test_the_shared_error_of_a_written_block_comes_back(small_block, tmp_path):
    settings = "crs_accuracy_m = 2.0"
    moved_block(small_block, "EPSG:25832", LUCERNE, "EPSG:21781", settings=settings)
    write_block(read_block(small_block.path), tmp_path / "written")
    back = read_block(tmp_path / "written")
    assert back.shared_errors_m == {"control_points": 1.5}
    assert back.notes == ()


def test_a_shared_error_that_is_given_adds_to_that_of_the_operation(small_block):
    settings = "crs_accuracy_m = 2.0"
    moved_block(small_block, "EPSG:25832", LUCERNE, "EPSG:21781", settings=settings)
    small_block.replace(
        "block.toml", f'"{CONTROL}"', f'"{CONTROL}"\nshared_error_m = 2.0'
    )
    assert read_block(small_block.path).shared_errors_m == {"control_points": 2.5}


@pytest.mark.parametrize(
    ("own", "size", "said", "mend"),
    [
        (None, 1.0, "longitude and latitude in degrees", "Call the columns"),
        (None, np.pi / 180.0, "longitude and latitude in radians", "Multiply them by"),
        ("EPSG:4312", np.pi / 180.0, "in radians", "Multiply them by 57.29577951 for"),
    ],
)
def test_angles_are_told_by_their_unit(own, size, said, mend):
    crs = read_source_crs(own or "EPSG:31255")
    longitude, latitude = np.full((2, 3), [[13.5], [47.3]]) * size
    (problem,) = place_problems(longitude, latitude, crs, "points.csv")
    assert said in problem.found
    assert problem.expected == ("degrees" if own else "metres")
    assert problem.remedy.startswith(mend)
    is_plane = own is None
    assert ("WGS 84 (EPSG:4326) of many rec" in problem.remedy) == is_plane
    assert problem.remedy.endswith("or MGI (EPSG:4312)") == is_plane
    (exchanged,) = place_problems(latitude, longitude, crs, "points.csv")
    assert "are latitude and longitude in" in exchanged.found


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("EPSG:4258", "EPSG:4936"),  # geocentric
        ("EPSG:4258", "EPSG:25833x"),
        ('crs = "EPSG:4258"', "crs = 4258"),
        ('crs = "EPSG:31255"', ""),
        ("EPSG:31255", "EPSG:31255x"),
    ],
)
def test_what_follows_from_a_fault_of_the_system_is_no_fault(small_block, old, new):
    moved_block(small_block, "EPSG:31255", SALZBURG, "EPSG:4258")
    small_block.replace("block.toml", old, new)
    (problem,) = find_problems(small_block.path).problems
    assert problem.key == "crs"


def test_control_of_a_frame_that_moves_needs_its_epoch(small_block):
    settings = "crs_accuracy_m = 0.05"
    place = ("EPSG:7856", (151.2, -33.9), "EPSG:9000")
    frame = moved_block(small_block, *place, settings=settings)
    with pytest.raises(EinschaltError, match=r"Set crs_epoch, such as"):
        read_block(small_block.path)
    # it was moved without one: as at 2020
    block = read_block(small_block.path, {"crs_epoch": 2020.0})
    found = block.control_points[PLANE].to_numpy()
    np.testing.assert_allclose(found, frame[PLANE], rtol=0, atol=1e-4)
    assert "at epoch 2020)" in " ".join(block.notes)


def test_degrees_with_five_decimals_are_noted(small_block):
    """A digit is a metre of latitude, far more than is stated of control."""
    moved_block(small_block, "EPSG:31255", SALZBURG, "EPSG:4312")
    assert len(read_block(small_block.path).notes) == 1
    path = small_block.path / CONTROL
    given = pd.read_csv(path, dtype={"point_id": str})
    given.round({"longitude": 5, "latitude": 5}).to_csv(path, index=False)
    transformed, note = read_block(small_block.path).notes
    assert "points transformed from" in transformed
    assert f"{CONTROL}: coordinates have no digits below 0.00001 degrees" in note
    assert "rounding makes 0.39 m (total), beside a standard error of 0.03 m" in note
