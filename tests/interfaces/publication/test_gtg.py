"""Grids of shifts, read and run by PROJ."""

import sys

import numpy as np
import pandas as pd
import pyproj
import pytest
from tests.interfaces.publication.test_publish import FINLAND, with_database

import einschalt as es
from einschalt.interfaces.publication.proj_database import own_database

SYSTEMS = {"crs": "EPSG:3067", "source_crs": "EPSG:2393"}
CLOSE = {"atol": 1e-4, "rtol": 0.0}
ERRORS = ["standard_error_easting", "standard_error_northing"]


@pytest.fixture(scope="module")
def finland():
    old, new = (
        pd.read_csv(FINLAND / f"{name}.csv")
        for name in ("model_points", "ground_points")
    )
    fit = es.transform_models(old, new, kind="helmert")
    return fit.distributed(method="collocation")


@pytest.fixture(scope="module")
def published(finland, tmp_path_factory):
    folder = tmp_path_factory.mktemp("a folder") / "smooth"
    return finland.publish("SMOOTH", folder, **SYSTEMS)


@pytest.fixture(scope="module")
def within(finland):
    """All identical points and 10 000 others among them, and where they go."""
    known = finland.observed.source
    rng = np.random.default_rng(3)
    shares = rng.dirichlet(np.ones(3), 10_000)[..., None]
    others = (shares * known[rng.integers(0, len(known), (10_000, 3))]).sum(axis=1)
    points = pd.DataFrame(np.concatenate([known, others]), columns=["x", "y"])
    points = points.assign(model_id="all", point_id=range(len(points)))
    return points[["x", "y"]].to_numpy(), finland.transform(points)


def there_and_back(way, xy):
    moved = np.column_stack(way.transform(*xy.T))
    return moved, np.column_stack(way.transform(*moved.T, direction="INVERSE"))


@pytest.mark.slow
@pytest.mark.parametrize("form", ["proj", "wkt"])
def test_proj_gives_what_the_result_gives_there_and_back(form, published, within):
    way = pyproj.Transformer.from_pipeline(published.operations[form].iloc[0])
    moved, back = there_and_back(way, within[0])
    np.testing.assert_allclose(moved, within[1][["easting", "northing"]], **CLOSE)
    np.testing.assert_allclose(back, within[0], **CLOSE)


@pytest.mark.slow
def test_proj_finds_the_grid_by_name(published, within):
    def run():
        systems = "EINSCHALT:SMOOTH", "EPSG:3067"
        way = pyproj.Transformer.from_crs(*systems, always_xy=True, only_best=True)
        found = there_and_back(way, within[0])
        used = way.get_last_used_operation()
        return found, used.accuracy, used.description

    (moved, back), accuracy, name = with_database(published.database, run)
    np.testing.assert_allclose(moved, within[1][["easting", "northing"]], **CLOSE)
    np.testing.assert_allclose(back, within[0], **CLOSE)
    assert name == "SMOOTH"
    assert accuracy == pytest.approx(published.operations["accuracy"].iloc[0])
    assert accuracy < 0.09  # triangles: 0.106


def test_bands_and_tags_are_those_of_the_format(published, finland, within):
    tifffile = pytest.importorskip("tifffile")
    with tifffile.TiffFile(published.folder / "SMOOTH.tif") as file:
        bands, tags = file.asarray(), file.pages[0].tags
        said = file.gdal_metadata
        keys = np.reshape(tags["GeoKeyDirectoryTag"].value, (-1, 4))[1:]
        west, north = tags["ModelTiepointTag"].value[3:5]
        cell = tags["ModelPixelScaleTag"].value[0]
    assert {key: value for key, _, _, value in keys.tolist()} == {
        1024: 1,  # projected
        1025: 2,  # nodes are the middles of pixels
        3072: 3067,
        3076: 9001,
    }
    for item in ('"TYPE">HORIZONTAL_OFFSET<', '"interpolation_method">bilinear<'):
        assert item in said
    grid = finland.grids[0].grid
    np.testing.assert_array_equal(bands[:2], np.moveaxis(grid.shifts, 2, 0))
    # the accuracies are the standard errors of points at the nodes
    row, column = 40, 50
    node = np.array([west + column * cell, north - row * cell])
    xy = np.linalg.solve(grid.matrix, node - grid.shift)
    point = pd.DataFrame({"model_id": ["all"], "point_id": "P", "x": xy[0], "y": xy[1]})
    found = finland.transform(point)[ERRORS].to_numpy()[0]
    np.testing.assert_allclose(bands[2:, row, column], found, rtol=1e-6)


@pytest.mark.slow
def test_names_in_other_letters_do_no_harm(finland, tmp_path):
    own = pyproj.CRS("EPSG:3067").to_json_dict() | {"name": "Järjestelmä"}
    own.pop("id")
    crs = pyproj.CRS.from_json_dict(own).to_wkt()
    done = finland.publish("UMLAUT", tmp_path, crs=crs, source_crs="EPSG:2393")
    assert b"J&#228;rjestelm&#228;" in (done.folder / "UMLAUT.tif").read_bytes()


def test_outside_the_grid_there_is_nothing(published, finland):
    way = pyproj.Transformer.from_pipeline(published.operations["proj"].iloc[0])
    assert way.transform(0.0, 0.0) == (np.inf, np.inf)
    point = pd.DataFrame({"model_id": ["all"], "point_id": "P", "x": 0.0, "y": 0.0})
    assert finland.transform(point)[["easting", "m_t"]].isna().all(axis=None)


def test_the_page_and_the_frame_say_how_to_use_it(published):
    page = (published.folder / "README.md").read_text(encoding="utf-8")
    for words in ("SMOOTH.tif", "+proj=gridshift", "PROJ 9.4", "SMOOTH.wkt"):
        assert words in page
    assert "triangle" not in page
    frame = pyproj.CRS((published.folder / "SMOOTH.wkt").read_text(encoding="utf-8"))
    known = {"authority": "EINSCHALT", "code": "SMOOTH"}
    assert frame.to_json_dict()["id"] == known


def test_what_proj_could_not_read_is_refused(finland, tmp_path, monkeypatch):
    with pytest.raises(es.EinschaltError, match="without commas"):
        finland.publish("SMOOTH", tmp_path / "a, b", **SYSTEMS)
    old = tmp_path / "proj.db"
    old.write_bytes(own_database().read_bytes())
    import sqlite3

    with sqlite3.connect(old) as database:
        database.execute("update metadata set value='9.1.1' where key='PROJ.VERSION'")
    database.close()
    with pytest.raises(es.EinschaltError, match=r"of PROJ 9\.1\.1, which reads no"):
        es.publish(finland, "SMOOTH", tmp_path / "old", **SYSTEMS, proj_db=old)
    monkeypatch.setitem(sys.modules, "tifffile", None)
    with pytest.raises(es.EinschaltError, match=r"pip install '\.\[export\]'"):
        finland.publish("SMOOTH", tmp_path / "new", **SYSTEMS)
    assert not (tmp_path / "new" / "SMOOTH.db").exists()
