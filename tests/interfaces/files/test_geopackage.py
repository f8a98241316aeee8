"""block.gpkg: layers, geometries, systems, styles."""

import sqlite3
import struct
import warnings
from contextlib import closing
from dataclasses import replace

import numpy as np
import pandas as pd
import pyogrio
import pytest
from scipy.spatial import ConvexHull
from tests.changed_results import changed

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.gdal_files import written
from einschalt.interfaces.files.geopackage import distinct_names, write_geopackage
from einschalt.interfaces.files.map_layers import exaggeration
from einschalt.interfaces.files.qgis_styles import LAYERS, claim_of, style_of


@pytest.fixture(scope="module")
def package(tmp_path_factory, faulty_result):
    path = tmp_path_factory.mktemp("gpkg") / "block.gpkg"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_geopackage(faulty_result, path)
    return path


def read_layer(path, name):
    _, table = pyogrio.read_arrow(path, layer=name)
    frame = table.to_pandas()
    frame["geom"] = table["geom"].to_pylist()
    return frame


def doubles(wkb, n_head):
    return np.array(struct.unpack(f"<{(len(wkb) - n_head) // 8}d", wkb[n_head:]))


def test_layers_are_in_the_system_of_the_block(package):
    layers = dict(pyogrio.list_layers(package).tolist())
    assert {name: layers[name] for name in LAYERS} == {
        "models": "Polygon",
        "residual_vectors": "LineString",
        "ellipses": "Polygon",
        "points": "Point",
    }
    for name in LAYERS:
        assert pyogrio.read_info(package, layer=name)["crs"] == "EPSG:31255"


def test_points_stand_where_they_are_with_all_that_is_known(package, faulty_result):
    layer = read_layer(package, "points")
    points = faulty_result.points
    assert set(points.columns) <= set(layer.columns)
    assert layer["point_id"].tolist() == points["point_id"].tolist()
    xy = np.array([doubles(wkb, 5) for wkb in layer["geom"]])
    np.testing.assert_array_equal(xy, points[["easting", "northing"]])


def test_residual_vectors_lead_from_given_to_transformed(package, faulty_result):
    layer = read_layer(package, "residual_vectors")
    residuals = faulty_result.residuals
    assert len(layer) == len(residuals)
    ends = np.array([doubles(wkb, 9) for wkb in layer["geom"]]).reshape(-1, 2, 2)
    factor = layer["exaggeration"].iloc[0]
    drawn = (ends[:, 1] - ends[:, 0]) / factor
    expected = residuals[["residual_easting", "residual_northing"]]
    # coordinates of 3e5 m carry 6e-11 m
    np.testing.assert_allclose(drawn, expected, atol=1e-10)
    given = faulty_result.approximations.set_index("point_id")
    low = (residuals["flight"] == "low_flight").to_numpy()
    at = given.loc[residuals.loc[low, "point_id"], ["easting", "northing"]]
    np.testing.assert_array_equal(ends[low, 0], at)


def test_description_says_the_exaggeration(package):
    factor = read_layer(package, "residual_vectors")["exaggeration"].iloc[0]
    with closing(sqlite3.connect(package)) as database:
        query = "SELECT description FROM gpkg_contents WHERE table_name = ?"
        (said,) = database.execute(query, ("residual_vectors",)).fetchone()
    assert said == (
        f"Residuals, transformed minus given, drawn {factor:g} times as long"
    )


def test_models_are_the_hulls_of_their_points(package, faulty_result):
    layer = read_layer(package, "models").set_index(["flight", "coverage", "model_id"])
    where = faulty_result.approximations.set_index("point_id")[["easting", "northing"]]
    for name, flight in faulty_result.block.flights.items():
        for key, points in flight.model_table().groupby(["coverage", "model_id"]):
            wkb = layer.loc[(name, *key), "geom"]
            known = where.reindex(points["point_id"]).dropna().to_numpy()
            if len(known) < 3:
                assert wkb is None
                continue
            ring = doubles(wkb, 13).reshape(-1, 2)
            hull = ConvexHull(known)
            np.testing.assert_array_equal(ring[0], ring[-1])
            assert set(map(tuple, ring)) == set(map(tuple, known[hull.vertices]))


def test_failed_models_are_there_with_their_reason(package, faulty_result):
    layer = read_layer(package, "models")
    failed = layer[~layer["is_usable"].astype(bool)]
    assert 0 < len(failed) == len(faulty_result.failures)
    assert (failed["reason"].str.len() > 0).all()


def test_layers_have_their_default_styles(package, faulty_result):
    with closing(sqlite3.connect(package)) as database:
        query = "SELECT f_table_name, useAsDefault, styleQML FROM layer_styles"
        styles = {name: (used, qml) for name, used, qml in database.execute(query)}
        query = "SELECT data_type FROM gpkg_contents WHERE table_name = 'layer_styles'"
        assert database.execute(query).fetchone() == ("attributes",)
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    columns = {
        name: pyogrio.read_info(package, layer=name)["fields"] for name in LAYERS
    }
    claim = claim_of(faulty_result)
    assert claim.low < claim.high
    looks = {name: (1, style_of(name, columns[name], claim)) for name in LAYERS}
    assert styles == looks


def test_columns_are_explained_in_the_file(package, faulty_result):
    """After the schema extension of GeoPackage 1.2; GDAL gives them as other names."""
    with closing(sqlite3.connect(package)) as database:
        query = "SELECT column_name, title, description FROM gpkg_data_columns"
        query += " WHERE table_name = 'points'"
        told = {name: more for name, *more in database.execute(query)}
        query = "SELECT scope FROM gpkg_extensions WHERE extension_name = 'gpkg_schema'"
        assert database.execute(query).fetchone() == ("read-write",)
    assert set(told) == set(faulty_result.points)
    assert told["easting"][0] == "easting [m]"
    assert all(meaning for _, meaning in told.values())


def test_block_without_system_warns_of_nothing(tmp_path, good_result):
    block = replace(good_result.block, crs=None)
    path = tmp_path / "block.gpkg"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_geopackage(changed(good_result, block=block), path)
    assert (
        "Local system, not georeferenced"
        in pyogrio.read_info(path, layer="points")["crs"]
    )


def test_result_without_residuals(tmp_path, good_result):
    empty = changed(good_result, residuals=good_result.residuals.iloc[:0])
    write_geopackage(empty, tmp_path / "block.gpkg")
    assert len(read_layer(tmp_path / "block.gpkg", "residual_vectors")) == 0


def test_equal_results_are_equal_files(tmp_path, package, faulty_result):
    write_geopackage(faulty_result, tmp_path / "again.gpkg")
    assert (tmp_path / "again.gpkg").read_bytes() == package.read_bytes()


def test_options_of_gdal_are_as_before(package):
    assert pyogrio.get_gdal_config_option("OGR_CURRENT_DATE") is None
    assert pyogrio.get_gdal_config_option("OGR_SQLITE_SYNCHRONOUS") is None


def test_failure_of_gdal_is_a_file_error(tmp_path, good_result, monkeypatch):
    def refuse(*_arguments, **_options):
        raise pyogrio.errors.DataSourceError("disk I/O error")

    monkeypatch.setattr(pyogrio, "write_arrow", refuse)
    with pytest.raises(
        FileError, match=r"block\.gpkg: cannot be written: disk I/O err"
    ):
        write_geopackage(good_result, tmp_path / "block.gpkg")
    assert list(tmp_path.iterdir()) == []


def test_names_that_differ_in_case_alone_are_told_apart(tmp_path, good_result):
    points = good_result.points.assign(EASTING=1.0, fid=2.0, Geom="g")
    write_geopackage(changed(good_result, points=points), tmp_path / "block.gpkg")
    layer = read_layer(tmp_path / "block.gpkg", "points")
    assert {"easting", "EASTING_2", "fid_2", "Geom_2"} <= set(layer.columns)
    assert distinct_names(["a", "A", "a_2", "A"]) == ["a", "A_2", "a_2_2", "A_3"]


@pytest.mark.parametrize(
    ("residual", "factor"), [(0.01, 2000.0), (0.05, 200.0), (1e3, 0.02), (0.0, 1.0)]
)
def test_exaggeration_is_round(residual, factor):
    # 2 % of an extent of 1000 m is 20 m, the factor 1, 2 or 5 times a power of ten
    xy = np.array([[0.0, 0.0], [1000.0, 500.0]])
    shift = np.full((10, 2), [residual, 0.0])
    assert exaggeration(xy, shift) == pytest.approx(factor)


def test_exaggeration_of_nothing():
    nothing = np.empty((0, 2))
    assert exaggeration(nothing, nothing) == 1.0
    assert exaggeration(np.full((2, 2), np.nan), np.ones((2, 2))) == 1.0


def test_points_of_images_are_outlined(tmp_path, good_result):
    """Flights from image coordinates have no model points of their own."""
    block = good_result.block
    images = pd.DataFrame(
        {
            "image_id": np.repeat(["11", "12"], 4),
            "point_id": np.tile(good_result.points["point_id"].iloc[[0, 1, 50, 99]], 2),
            "x": np.tile([-90.0, 90.0, 90.0, -90.0], 2),
            "y": np.tile([-90.0, -90.0, 90.0, 90.0], 2),
        }
    )
    models = pd.DataFrame(
        {
            "coverage": "1",
            "model_id": ["11/12"],
            "left_image": "11",
            "right_image": "12",
        }
    )
    flight = replace(
        block.low_flight,
        model_points=None,
        image_points=images,
        models=models,
        principal_distance_mm=153.0,
    )
    result = changed(good_result, block=replace(block, low_flight=flight))
    write_geopackage(result, tmp_path / "block.gpkg")
    layer = read_layer(tmp_path / "block.gpkg", "models")
    low = layer[layer["flight"] == "low_flight"]
    assert low["model_id"].tolist() == ["11/12"]
    assert low["geom"].iloc[0] is not None


def test_of_a_statement_in_sql_only_what_is_wrong_is_said(tmp_path):
    statement = f"sqlite3_exec(CREATE TABLE ({'x ' * 3000}) failed: "
    said = r"a\.gpkg: cannot be written: database or disk is full\. See that the disk"
    with (
        pytest.raises(FileError, match=said),
        written(tmp_path / "a.gpkg"),
    ):
        raise RuntimeError(statement + "database or disk is full")
