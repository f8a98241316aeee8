"""Which operation between two reference systems is used, and which never in silence."""

import os
import sqlite3
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace

import numpy as np
import pyproj
import pytest
from tests.ntv2_grids import write_ntv2

from einschalt.foundations.areas_of_use import area_of, in_area, in_extent
from einschalt.foundations.coordinate_operations import (
    CONVERSION,
    Operation,
    installed_grids,
    offline,
    system_label,
)
from einschalt.foundations.errors import ProjectionError
from einschalt.foundations.likely_systems import likely_systems
from einschalt.foundations.operation_choice import Demand
from einschalt.foundations.projections import (
    read_crs,
    read_source_crs,
    reproject,
    scale_gradient,
    scale_range,
    turn,
)
from einschalt.foundations.published_systems import area_of_points

SITE = (
    'ENGCRS["site",EDATUM["site"],CS[Cartesian,2],AXIS["x",east],AXIS["y",north],'
    'LENGTHUNIT["metre",1]]'
)
STRICT, LAX = Demand(0.01, "as asked"), Demand(2.0, "as asked", is_stated=True)
SALZBURG, FRANKFURT, LUCERNE, GRAZ = (13.5, 47.3), (9, 50), (8, 47), (15.5, 47.2)
PAIRS = {
    (31255, 25833): (SALZBURG, "at_bev_AT_GIS_GRID_2021_09_28.tif"),
    (31467, 25832): (FRANKFURT, "de_hvbg_hessen_HeTA2010.tif"),
    (21781, 25832): (LUCERNE, "ch_swisstopo_CHENyx06_ETRS.tif"),
    (25833, 31256): (GRAZ, "at_bev_AT_GIS_GRID_2021_09_28.tif"),
}


def systems(source, target):
    return read_source_crs(f"EPSG:{source}"), read_crs(f"EPSG:{target}")


def points_at(place, crs):
    """Four points about a place, in a system."""
    transformer = pyproj.Transformer.from_crs("OGC:CRS84", crs, always_xy=True)
    corners = np.array([[0, 0], [0.02, 0], [0, 0.02], [0.02, 0.02]]) + place
    return np.column_stack(transformer.transform(*corners.T))


@pytest.mark.parametrize("pair", PAIRS)
def test_a_missing_grid_is_an_error_that_names_it_and_the_candidates(pair):
    source, target = systems(*pair)
    place, grid = PAIRS[pair]
    with pytest.raises(ProjectionError) as caught:
        reproject(points_at(place, source), source, target, STRICT)
    said = str(caught.value)
    assert f"{system_label(source)} to {system_label(target)}" in said
    assert f"needs {grid}, which is missing" in said
    assert f"from https://cdn.proj.org/{grid}" in said
    assert "expected an accuracy of 0.01 m, as asked" in said
    assert "Or: Set crs_accuracy_m = 1" in said


@pytest.mark.parametrize("pair", PAIRS)
def test_what_is_allowed_is_used_with_the_accuracy_that_proj_states(pair):
    source, target = systems(*pair)
    place, grid = PAIRS[pair]
    points = points_at(place, source)
    moved, operation, better = reproject(points, source, target, LAX)
    assert operation.accuracy_m in (1.0, 1.5)
    assert [name for name, _ in better.missing] == [grid]
    # PROJ's own way through the same operation
    own = operation.transformer.transform(*points.T)
    assert operation.transformer.get_last_used_operation().accuracy in (1.0, 1.5)
    np.testing.assert_array_equal(moved, np.column_stack(own))


def test_the_network_is_never_asked():
    source, target = systems(31255, 25833)
    points = points_at(SALZBURG, source)
    was = pyproj.network.is_network_enabled()
    pyproj.network.set_network_enabled(active=True)
    try:
        with offline():
            assert not pyproj.network.is_network_enabled()
        # with the network the grid would be there for PROJ
        with pytest.raises(ProjectionError, match="which is missing"):
            reproject(points, source, target, STRICT)
        assert pyproj.network.is_network_enabled()
    finally:
        pyproj.network.set_network_enabled(active=was)


def test_a_grid_in_a_folder_is_used_and_named_and_only_there(tmp_path):
    source, target = systems(31255, 25833)
    _, grid = PAIRS[31255, 25833]
    write_ntv2(tmp_path / grid, -1.5, -3.5)
    points = points_at(SALZBURG, source)
    demand = Demand(0.14, "as asked")
    moved, operation, better = reproject(points, source, target, demand, tmp_path)
    assert operation.name == "MGI to ETRS89 (8)"
    assert operation.accuracy_m == 0.14
    assert [name for name, _ in operation.grids] == [grid]
    assert better is None
    before, after = (
        np.column_stack(
            pyproj.Transformer.from_crs(
                crs, crs.geodetic_crs, always_xy=True
            ).transform(*xy.T)
        )
        for crs, xy in ((source, points), (target, moved))
    )
    np.testing.assert_allclose((after - before) * 3600.0, [[-3.5, -1.5]] * 4, atol=1e-6)
    # what one block is given, the next one does not find
    with pytest.raises(ProjectionError, match="which is missing"):
        reproject(points, source, target, demand)


def test_an_operation_can_be_chosen_by_name_and_by_code():
    source, target = systems(31255, 25833)
    points = points_at((15.4, 47.1), source)  # where that of Styria holds as well
    best, operation, _ = reproject(points, source, target, LAX)
    assert operation.name == "MGI to ETRS89 (4)"
    by_name = Demand(0.01, "", operation="mgi to etrs89 (1)")
    by_code = Demand(0.01, "", operation="EPSG:1619")
    for demand in (by_name, by_code):
        moved, operation, _ = reproject(points, source, target, demand)
        assert (operation.name, operation.accuracy_m) == ("MGI to ETRS89 (1)", 1.5)
        assert 0.1 < np.abs(moved - best).max() < 3.0


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        (
            "MGI to ETRS89 (99)",
            r"is none of the operations; expected MGI to ETRS89 \(8",
        ),
        ("MGI to ETRS89 (8)", r"cannot be used: .*Get at_bev_AT_GIS_GRID.* Or choose"),
        (
            "MGI to ETRS89",
            r"fits 2 operations: .*\(8\): .*\(1\): .*Write its whole name",
        ),
    ],
)
def test_an_operation_that_is_not_there_is_said(wanted, said):
    source, target = systems(31255, 25833)
    demand = Demand(0.01, "", operation=wanted)
    with pytest.raises(ProjectionError, match=said):
        reproject(points_at(SALZBURG, source), source, target, demand)


def test_the_operation_of_one_way_does_no_harm_to_another():
    two = Demand(0.01, "", operation="EPSG:1619; CH1903 to ETRS89 (1)")
    for pair, place, name in (
        ((31255, 25833), SALZBURG, "MGI to ETRS89 (1)"),
        ((21781, 25832), LUCERNE, "CH1903 to ETRS89 (1)"),
        ((31258, 31255), SALZBURG, CONVERSION),  # where no datum changes
    ):
        source, target = systems(*pair)
        found = reproject(points_at(place, source), source, target, two)
        assert found[1].name == name
    both = replace(two, operation="EPSG:1619; MGI to ETRS89 (4)")
    source, target = systems(31255, 25833)
    with pytest.raises(ProjectionError, match="fits 2 operations"):
        reproject(points_at((15.4, 47.1), source), source, target, both)


def test_an_operation_of_unknown_accuracy_is_used_only_with_one_that_is_stated():
    seven = "+towgs84=577.326,90.129,463.919,5.137,1.474,5.297,2.4232"
    source = read_crs(f"+proj=tmerc +lon_0=13.33 +ellps=bessel {seven} +units=m")
    target = read_crs("EPSG:25833")
    points = points_at(SALZBURG, source)
    with pytest.raises(ProjectionError, match="PROJ states no accuracy"):
        reproject(points, source, target, LAX)
    chosen = "Transformation from unknown to WGS84"
    with pytest.raises(ProjectionError, match="Set crs_accuracy_m to the accuracy"):
        reproject(points, source, target, Demand(2.0, "", operation=chosen))
    stated = Demand(0.7, "", operation=chosen, is_stated=True)
    _, operation, _ = reproject(points, source, target, stated)
    assert operation.accuracy_m == 0.7


@pytest.mark.parametrize(
    ("source", "said"),
    [
        (
            "+proj=utm +zone=33 +ellps=GRS80",
            r"PROJ knows no operation from \+proj=utm ",
        ),
        (
            SITE,
            "site is a system of one site, tied to no other; .*identical points",
        ),
    ],
)
def test_datums_are_never_taken_for_the_same(source, said):
    points = np.array([[387_000.0, 5_240_000.0]])
    with pytest.raises(ProjectionError, match=said):
        reproject(points, read_source_crs(source), read_crs("EPSG:25833"), LAX)


def test_zones_of_one_datum_are_exact():
    source, target = systems(31258, 31255)
    demand = Demand(1e-6, "as asked")
    _, operation, _ = reproject(points_at(SALZBURG, source), source, target, demand)
    assert (operation.name, operation.accuracy_m) == (CONVERSION, 0.0)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("EPSG:31255", "MGI / Austria GK Central (EPSG:31255)"),
        (
            "EPSG:31255+5778",
            "MGI / Austria GK Central + GHA height (EPSG:31255+EPSG:5778)",
        ),
        # resembles 25833, and is not
        (
            "+proj=utm +zone=33 +ellps=GRS80",
            "+proj=utm +zone=33 +ellps=GRS80 +units=m",
        ),
    ],
)
def test_systems_are_said_with_name_and_code(code, said):
    assert system_label(pyproj.CRS(code)) == said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("EPSG:4978", "WGS 84.* has the axes geocentricX"),
        ("EPSG:5773", "EGM96 height.* has the axes up"),
        ("EPSG:5513", "axes to the south and west.*EPSG:5514"),
        ("EPSG:2048", "axes to the west and south.*UTM zone 34S .EPSG:32734"),
    ],
)
def test_systems_without_easting_and_northing_are_refused(text, said):
    with pytest.raises(ProjectionError, match=said):
        read_source_crs(text)


@pytest.mark.parametrize("text", ["EPSG:4258", "EPSG:2263", "EPSG:31255+6360"])
def test_the_system_of_a_block_is_plane_and_in_metres(text):
    with pytest.raises(ProjectionError, match="expected a plane system in metres"):
        read_crs(text)
    assert read_source_crs(text).name


def test_compound_systems_have_the_area_of_their_plane_part():
    east, north = np.meshgrid(*2 * [np.arange(-5e5, 6e5, 1e4)])
    plane = in_extent(east, north, "EPSG:31255")
    assert 0.0 < plane.mean() < 1.0
    np.testing.assert_array_equal(in_extent(east, north, "EPSG:31255+5778"), plane)


def test_scale_of_web_mercator_is_one_over_the_cosine_of_latitude():
    points = points_at(SALZBURG, pyproj.CRS("EPSG:3857"))
    low, high = scale_range(*points.T, "EPSG:3857")
    # along the meridian and across it: the ellipsoid makes a third of a per cent
    assert low == pytest.approx(1.0 / np.cos(np.radians(47.3)), rel=4e-3)
    assert high == pytest.approx(1.0 / np.cos(np.radians(47.32)), rel=4e-3)


def test_axes_turn_by_the_difference_of_the_convergences():
    source, target = systems(25832, 25833)
    points = points_at((12.0, 47.3), source)
    _, operation, _ = reproject(points, source, target, STRICT)
    degrees = points_at((12.0, 47.3), pyproj.CRS("OGC:CRS84")).T
    east, west = (
        pyproj.Proj(crs).get_factors(*degrees).meridian_convergence
        for crs in (target, source)
    )
    angle = np.degrees(turn(points, source, operation))
    np.testing.assert_allclose(angle, east - west, atol=1e-5)
    assert angle.max() < -4.0


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of POSIX")
@pytest.mark.parametrize(
    "crs",
    [
        "+init={pipe}:1",
        "init={pipe}:1",
        "  +INIT = {pipe}:1",
        "+proj=pipeline +step +init={pipe}:1",
        "+proj=tmerc +ellps=bessel +nadgrids={pipe} +units=m +type=crs",
        "+proj=tmerc +ellps=bessel +nadgrids=a+b,./pipe +units=m",
        '+proj=tmerc +ellps=bessel +geoidgrids="a b/{pipe}" +units=m',
        '{{"name": "file", "value": "{pipe}"}}',
        'PARAMETERFILE["Latitude and longitude difference file","{pipe}"]',
    ],
)
def test_no_name_of_a_system_opens_a_file(crs, tmp_path):
    """PROJ would wait for ever for what comes out of a pipe."""
    os.mkfifo(pipe := tmp_path / "pipe")
    for read in (read_crs, read_source_crs):
        with pytest.raises(ProjectionError, match="names a file; expected an EPSG"):
            read(crs.format(pipe=pipe))


def test_wkt_and_json_of_systems_are_no_files():
    for system in (read_source_crs("EPSG:31255"), read_source_crs("EPSG:31255+5778")):
        for text in (system.to_wkt(), system.to_json(), system.to_wkt("WKT1_GDAL")):
            assert read_source_crs(text).name == system.name
    assert read_crs("+proj=tmerc +ellps=bessel +nadgrids=BETA2007.gsb +units=m")


@pytest.mark.parametrize(
    ("code", "inside", "outside"),
    [
        ("EPSG:4269", (-74.0, 40.7), (13.4, 48.2)),
        ("EPSG:4167", (174.8, -41.3), (13.4, -41.3)),
        ("EPSG:4258", (13.4, 48.2), (-74.0, 48.2)),
        ("EPSG:4807", (5.0, 54.0), (-74.0, 54.0)),  # grads from Paris
        ("EPSG:4326", (-179.9, 0.0), (379787.0, 0.0)),  # metres are no longitudes
    ],
)
def test_an_area_may_lie_over_the_antimeridian(code, inside, outside):
    assert in_extent(*inside, code)
    assert not in_extent(*outside, code)


def test_zones_are_used_beyond_their_area():
    # Bavaria keeps zone 32 as far as Passau and the Bavarian Forest
    assert in_extent(857_000.0, 5_392_000.0, "EPSG:25832")
    assert not in_extent(905_000.0, 5_392_000.0, "EPSG:25832")


def test_an_operation_over_the_antimeridian_covers_what_lies_there_alone():
    of_new_zealand = Operation(
        "", (), 1.0, (), (), (160.6, -55.95, -171.2, -25.8), None
    )
    assert of_new_zealand.covers((178.0, -40.0, -178.0, -39.0))
    assert of_new_zealand.covers((-176.0, -44.0, -175.0, -43.0))
    assert not of_new_zealand.covers((10.0, -40.0, 20.0, -39.0))
    assert not of_new_zealand.covers((150.0, -40.0, 165.0, -39.0))
    assert replace(of_new_zealand, area=(-180.0, -90.0, 180.0, 90.0)).covers(
        (178.0, -40.0, -178.0, -39.0)
    )


def test_points_on_both_sides_of_the_antimeridian_lie_close_together():
    fiji = read_crs("EPSG:3460")
    to_map = pyproj.Transformer.from_crs("OGC:CRS84", fiji, always_xy=True)
    points = np.column_stack(to_map.transform([179.9, -179.9], [-16.5, -16.6]))
    area = area_of_points(points, fiji)
    np.testing.assert_allclose(area, (179.9, -16.6, -179.9, -16.5), atol=2e-3)
    _, operation, _ = reproject(points, fiji, read_crs("EPSG:32701"), LAX)
    assert operation.area[0] > operation.area[2]
    assert operation.covers(area)


def test_both_sides_of_the_antimeridian_belong_to_one_area():
    fiji = read_source_crs("EPSG:3460")
    longitudes = np.array([176.0, 178.0, -179.0, -178.0])
    np.testing.assert_array_equal(
        in_area(longitudes, -18.0, fiji), [False, True, True, False]
    )


@pytest.mark.parametrize(
    ("layout", "said"),
    [
        (None, "which is no database of PROJ"),
        ("1", "which has the layout 0.1 of an older PROJ; expected the layout 1."),
        ("999", None),  # PROJ reads it
    ],
)
def test_a_database_that_proj_cannot_read_is_named(layout, said, tmp_path, monkeypatch):
    path = tmp_path / "own.db"
    if layout is None:
        path.write_text("no database")
    else:
        major = "0" if said else "1"
        keys = zip(("MAJOR", "MINOR"), (major, layout), strict=True)
        with closing(sqlite3.connect(path)) as database, database:
            database.execute("CREATE TABLE metadata (key TEXT, value TEXT)")
            rows = [(f"DATABASE.LAYOUT.VERSION.{key}", value) for key, value in keys]
            database.executemany("INSERT INTO metadata VALUES (?, ?)", rows)
    monkeypatch.setenv("PROJ_AUX_DB", str(path))
    with pytest.raises(ProjectionError, match="is unknown") as caught:
        read_crs("EPSG:999999")
    assert ("PROJ_AUX_DB names" in str(caught.value)) == (said is not None)
    assert (said or "expected an EPSG code") in str(caught.value)


def test_a_broken_download_is_named_among_whole_grids(tmp_path):
    # of a pair of its own: PROJ remembers the grids that it has read
    source, target = systems(27700, 25830)
    grid = "uk_os_OSTN15_NTv2_OSGBtoETRS.tif"
    (tmp_path / grid).write_text("<html>")
    write_ntv2(tmp_path / "BETA2007.gsb", -1.5, -3.5)
    said = f"PROJ cannot read as a grid: {grid} \\(6 bytes\\);"
    with pytest.raises(ProjectionError, match=said):
        installed_grids(source, target, tmp_path)
    with pytest.raises(ProjectionError, match=said):
        reproject(points_at((-1.5, 52.0), source), source, target, LAX, tmp_path)


def test_an_area_of_use_is_that_of_all_usages():
    # in its zone on large maps, in the whole country on small ones
    assert area_of(read_crs("EPSG:2393")) == (19.24, 59.75, 31.59, 70.09)
    assert area_of(read_source_crs("EPSG:4167")) == (160.6, -55.95, -171.2, -25.88)
    assert area_of(read_source_crs(SITE)) is None


@pytest.mark.parametrize(
    ("crs", "place", "codes"),
    [
        ("EPSG:21781", (2_600_000.0, 1_200_000.0), ["2056"]),
        ("EPSG:2056", (600_000.0, 200_000.0), ["21781"]),
        ("EPSG:31258", (400_000.0, 5_300_000.0), ["25833", "31285"]),
        ("EPSG:31255", (462_660.0, 240_134.0), ["31258"]),  # no place in Hungary
        ("EPSG:31468", (691_000.0, 5_334_000.0), ["25832"]),
        ("EPSG:25833", (12_000.0, 340_000.0), ["31255", "31256"]),
        ("EPSG:25833", (6_600_000.0, 200_000.0), []),
    ],
)
def test_likely_systems_are_those_of_the_country(crs, place, codes):
    fitting, _ = likely_systems(*place, crs)
    assert [one.rpartition(":")[2].rstrip(")") for one in fitting] == codes


def test_likely_systems_lie_at_the_place_and_stand_there_once():
    # numbers of UTM 32 east of its zone: those of 29 to 31 would lie east of theirs
    fitting, there = likely_systems(827095.0, 5347762.0, "EPSG:25832")
    assert fitting == []
    assert there[0] == "ETRS89 / UTM zone 33N (EPSG:25833)"
    assert len(set(there)) == len(there) == 3
    assert not any("zE-N" in name for name in there)


def test_spaces_about_a_code_are_none_of_it():
    assert read_crs(" EPSG:25833 ") == read_crs("EPSG:25833")


def test_heights_without_a_geoid_are_told_from_datums_that_are_not_known():
    source, target = read_source_crs("EPSG:4937"), read_crs("EPSG:25833+5783")
    points = np.array([[13.4, 48.2, 450.0]])
    with pytest.raises(ProjectionError, match="for heights, such as by a geoid"):
        reproject(points, source, target, LAX)


def test_a_missing_grid_is_told_with_its_second_name_and_what_is_there(tmp_path):
    source, target = systems(21781, 25832)
    write_ntv2(tmp_path / "CHENYX06_etrs.gsb", -1.5, -3.5)
    with pytest.raises(ProjectionError) as caught:
        reproject(points_at(LUCERNE, source), source, target, STRICT, tmp_path)
    said = caught.value.remedy
    assert "The national survey may call it CHENyx06_ETRS.gsb. Name its fo" in said
    assert "The folder that is named holds CHENYX06_etrs.gsb" in said


SYDNEY = (151.2, -33.9)
MOVING = Demand(0.05, "as asked")


@pytest.mark.parametrize("height", [(), (80.0,)])
def test_frames_that_move_against_each_other_meet_at_an_epoch(height):
    source, target = systems(9000, 7856)  # ITRF2014, and what is fixed to Australia
    if height:
        source, target = read_source_crs("EPSG:7912"), target.to_3d()
    points = np.array([[*SYDNEY, *height]])
    demand = replace(MOVING, epoch=2024.5)
    moved, operation, _ = reproject(points, source, target, demand)
    own = pyproj.Transformer.from_crs(source, target, always_xy=True)
    expected = own.transform(*SYDNEY, *(height or (0.0,)), 2024.5)[: len(moved[0])]
    np.testing.assert_allclose(moved[0], expected, rtol=0, atol=1e-9)
    # 6 cm a year since 2020, of which PROJ says nothing
    still = own.transform(*SYDNEY, *height)
    assert 0.2 < np.hypot(*(moved[0] - still)[:2]) < 0.3
    assert str(operation) == "ITRF2014 to GDA2020 (1) (0.03 m, at epoch 2024.5)"


@pytest.mark.parametrize("name", ["", "ITRF2014 to GDA2020 (1)"])
def test_without_an_epoch_they_do_not_meet(name):
    demand = replace(MOVING, operation=name)
    with pytest.raises(ProjectionError, match=r"needs the epoch .* = 2020\.5"):
        reproject(np.array([SYDNEY]), *systems(9000, 7856), demand)
    with pytest.raises(ProjectionError, match=r"Set crs_epoch and .* = 0\.03 to"):
        reproject(np.array([SYDNEY]), *systems(9000, 7856), STRICT)


def test_an_epoch_is_nothing_to_frames_that_stand_still():
    source, target = systems(31255, 25833)
    points = points_at(SALZBURG, source)
    at_rest, operation, _ = reproject(points, source, target, LAX)
    moved, same, _ = reproject(points, source, target, replace(LAX, epoch=1990.0))
    np.testing.assert_array_equal(moved, at_rest)
    assert str(same) == str(operation)


def test_a_grid_of_one_block_is_not_in_the_threads_of_others(tmp_path):
    source, target = systems(31255, 25833)
    write_ntv2(tmp_path / PAIRS[31255, 25833][1], -1.5, -3.5)
    points = points_at(SALZBURG, source)
    with ThreadPoolExecutor(1) as other:
        with offline(tmp_path):  # while PROJ wakes up in the other thread
            other.submit(pyproj.CRS, "EPSG:31255").result()
        with pytest.raises(ProjectionError, match="which is missing"):
            other.submit(reproject, points, source, target, STRICT).result()


def test_a_grid_of_another_kind_under_the_name_of_one_is_said(tmp_path):
    geoid = "de_bkg_gcg2016.tif"
    write_ntv2(tmp_path / geoid, -1.5, -3.5)
    source, target = read_source_crs("EPSG:4937"), read_crs("EPSG:25832+7837")
    for work in (
        lambda: installed_grids(source, target, tmp_path),
        lambda: reproject(np.array([[9, 50, 80]]), source, target, LAX, tmp_path),
    ):
        with pytest.raises(ProjectionError, match=f"cannot use a grid .*of {geoid}"):
            work()


def test_operations_that_proj_lists_and_cannot_compute_are_none():
    source, target = systems(9000, 31983)  # by parameters of one epoch alone
    assert installed_grids(source, target) == {}
    with pytest.raises(ProjectionError, match=r"no operation .* that it can compute"):
        reproject(np.array([[-43.0, -22.0]]), source, target, LAX)


@pytest.mark.parametrize(
    ("code", "place"), [(31282, SALZBURG), (27572, (2.4, 47.5)), (5221, (15.3, 49.7))]
)
def test_scales_are_those_of_the_place_wherever_longitudes_are_counted_from(
    code, place
):
    crs = read_crs(f"EPSG:{code}")  # from Ferro or Paris
    at = points_at(place, crs)[0]
    to_degrees = pyproj.Transformer.from_crs(crs, crs.geodetic_crs, always_xy=True)

    def scale(east, north):
        ends = np.array([[east - 100.0, north], [east + 100.0, north]])
        angles = np.array(to_degrees.transform(*ends.T))
        per_degree = np.degrees(crs.geodetic_crs.axis_info[0].unit_conversion_factor)
        return 200.0 / crs.get_geod().line_length(*(angles * per_degree))

    np.testing.assert_allclose(scale_range(*at, crs), scale(*at), rtol=1e-7)
    steps = 1000.0 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    east, west, north, south = (np.log(scale(*(at + step))) for step in steps)
    slope = np.hypot(east - west, north - south) / 2000.0
    found = scale_gradient(at[None], crs)
    np.testing.assert_allclose(found, slope, rtol=0.01, atol=5e-12)
