"""Results for other programs: written, read, equal."""

import gc
import json
import re
import resource
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pyogrio
import pyproj
import pytest
import shapely
from scipy.linalg import block_diag
from tests.interfaces.programs import gama_covariance

import einschalt as es
from einschalt.foundations.errors import EinschaltError, FileError
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.programs import export as exporting
from einschalt.interfaces.programs import gama, kml, sinex
from einschalt.interfaces.programs.handed_over import HandedOver, of_result
from einschalt.interfaces.programs.recognised import read_foreign

SUFFIXES = list(exporting.WRITERS)
READ_BACK = (".dxf", ".xml", ".csv", ".con", ".gkf")
PLANE = ["easting", "northing"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory, good_result):
    """The demo result in every format but SINEX, which has heights."""
    place = tmp_path_factory.mktemp("export")
    files = [place / f"p{suffix}" for suffix in SUFFIXES if suffix != ".snx"]
    for written in es.export(good_result, *files):
        (place / f"{written.path.name}.notes").write_text("\n".join(written.notes))
    return place


@pytest.fixture(scope="module")
def spatial():
    """Three points with heights and a full covariance."""
    root = np.random.default_rng(3).normal(size=(9, 9)) * 0.01
    covariance = root @ root.T + 1e-4 * np.eye(9)
    own = covariance.reshape(3, 3, 3, 3)[range(3), :, range(3), :]
    error = np.sqrt(own[:, [0, 1, 2], [0, 1, 2]])
    points = pd.DataFrame(
        {
            "point_id": ["7/8", "Ötz & Söhne", "0012"],
            "easting": [400_000.0, 400_500.25, 401_000.5],
            "northing": [5_300_000.0, 5_300_400.125, 5_299_900.0],
            "height": [411.5, 0.0, 1250.125],
            "role": ["control", "new", "check"],
            "standard_error_easting": error[:, 0],
            "standard_error_northing": error[:, 1],
            "standard_error_height": error[:, 2],
            "covariance_en": own[:, 0, 1],
            "covariance_eh": own[:, 0, 2],
            "covariance_nh": own[:, 1, 2],
            "standard_error_total": np.hypot(error[:, 0], error[:, 1]),
        }
    )
    tables, full = {"points": points}, lambda _: covariance
    return HandedOver("three", "EPSG:25833", "2026-03-01T12:00:00", tables, full)


def of_file(path, reader):
    return reader(read_once(path, path.name))


@pytest.mark.parametrize("suffix", READ_BACK)
def test_points_come_back_as_they_were(folder, good_result, suffix):
    back = read_foreign(folder / f"p{suffix}").tables["control_points"]
    points = good_result.points
    assert back["point_id"].tolist() == points["point_id"].tolist()
    np.testing.assert_allclose(back[PLANE], points[PLANE], rtol=0, atol=5.1e-5)
    assert es.read_points(folder / f"p{suffix}").equals(back)
    if "role" in back:
        is_check = points["role"] == "check"
        assert (back["role"].eq("check") == is_check).all()


def places(table):
    shapes = shapely.from_wkb(np.array(table["wkb"].to_pylist(), dtype=object))
    xyz = shapely.get_coordinates(shapes, include_z=True)
    return xyz if np.isfinite(xyz).all() else xyz[:, :2]


def opened(path):
    """Columns and geometries of a file, by pyogrio or, of Parquet, by pyarrow."""
    if path.suffix == ".parquet":
        return pq.read_table(path).rename_columns({"geometry": "wkb"})
    meta, table = pyogrio.read_arrow(path)
    return table.rename_columns({meta["geometry_name"] or "wkb_geometry": "wkb"})


def test_maps_open_with_every_value_and_the_system(folder, good_result):
    points = good_result.points
    for name, total in (("p.shp", "se_total"), ("p.parquet", "standard_error_total")):
        table = opened(folder / name)
        np.testing.assert_allclose(places(table), points[PLANE], rtol=0, atol=1e-9)
        assert table["point_id"].to_pylist() == points["point_id"].tolist()
        np.testing.assert_allclose(
            np.array(table[total], float), points["standard_error_total"], rtol=1e-9
        )
    assert pyogrio.read_info(folder / "p.shp")["crs"] == "EPSG:31255"
    geo = json.loads(pq.read_schema(folder / "p.parquet").metadata[b"geo"])
    assert geo["columns"]["geometry"]["geometry_types"] == ["Point"]
    assert pyproj.CRS(geo["columns"]["geometry"]["crs"]) == pyproj.CRS("EPSG:31255")
    assert "standard_error_total = se_total" in (folder / "p.shp.notes").read_text()


def test_a_drawing_is_sound_and_has_its_layers(folder, good_result):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.readfile(folder / "p.dxf")
    assert drawing.audit().errors == []
    by_layer = {}
    for entity in drawing.modelspace():
        by_layer.setdefault(entity.dxf.layer.split("_X")[0], []).append(entity)
    points, residuals = good_result.points, good_result.residuals
    for role, held in points.groupby("role"):
        assert len(by_layer[f"POINTS_{role.upper()}"]) == len(held)
    assert len(by_layer["ELLIPSES"]) == len(good_result.ellipses)
    for flight, held in residuals.groupby("flight"):
        assert len(by_layer[f"RESIDUALS_{flight.upper()}"]) == len(held)
    assert drawing.units == ezdxf.units.M
    ellipse = by_layer["ELLIPSES"][0]
    said = good_result.ellipses.iloc[0]
    factor = float(ellipse.dxf.layer.rpartition("_X")[2])
    assert ellipse.dxf.major_axis.magnitude == pytest.approx(factor * said.semi_major)
    assert f"{factor:g} times" in (folder / "p.dxf.notes").read_text()


def sheet(path, name):
    return pyogrio.read_arrow(path, layer=name)[1].to_pandas()


def test_a_workbook_has_a_sheet_for_each_table_with_units(folder, good_result):
    sheets = dict.fromkeys(pyogrio.list_layers(folder / "p.xlsx")[:, 0])
    tables = of_result(good_result).tables
    assert list(sheets) == ["about", *tables, "columns"]
    read = sheet(folder / "p.xlsx", "points")
    points = good_result.points
    assert read["point_id"].tolist() == points["point_id"].tolist()
    found = read[[f"{name} [m]" for name in PLANE]]
    np.testing.assert_allclose(found, points[PLANE], rtol=0, atol=1e-9)
    head = sheet(folder / "p.xlsx", "residuals").columns
    assert "residual_easting [m]" in head
    meanings = sheet(folder / "p.xlsx", "columns")
    # the first row has the names: all is text, so that GDAL knows no header
    assert len(meanings) == 1 + sum(table.shape[1] for table in tables.values())
    assert meanings.iloc[:, 3].ne("").all()


def test_kml_is_where_pyproj_puts_it(folder, good_result):
    root = ET.parse(folder / "p.kml").getroot()
    marks = list(root.iter(f"{{{kml.NAMESPACE}}}Placemark"))
    names = [one[0].text for one in marks]
    at = good_result.points.set_index("point_id").loc[names, PLANE].to_numpy().T
    way = pyproj.Transformer.from_crs("EPSG:31255", "OGC:CRS84", always_xy=True)
    expected = np.column_stack(way.transform(*at))
    said = [one.find(".//{*}coordinates").text.split(",") for one in marks]
    assert len(said) == len(good_result.points)
    # PROJ may choose another of its operations; they are within their accuracies
    assert np.abs(np.array(said, float) - expected).max() < 5e-5
    assert "MGI to WGS 84" in (folder / "p.kml.notes").read_text()


def test_the_full_covariance_comes_back_from_memory(folder, good_result):
    table, covariance = gama_covariance.read_covariance(folder / "p.gkf")
    pairs = [(table.point_id[0], table.point_id[k]) for k in (0, 1, 7)]
    expected = np.concatenate(good_result.covariance_between(pairs), axis=1)
    found = np.concatenate([covariance[:2, 2 * k : 2 * k + 2] for k in (0, 1, 7)], 1)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-15)
    assert np.abs(expected[:, 2:]).max() > 0
    assert "full covariance" in (folder / "p.gkf.notes").read_text()


@pytest.mark.parametrize("module", [gama, sinex])
@pytest.mark.parametrize("is_full", [True, False])
def test_spatial_covariances_come_back(tmp_path, spatial, module, is_full):
    handed = spatial if is_full else replace(spatial, covariances=None)
    known = handed.covariance()
    own = block_diag(*known.own)
    covariance = known.full if is_full else own
    assert (known.full is None) != is_full
    path = tmp_path / "p.x"
    is_gama = module is gama
    notes = (gama.write_gama if is_gama else sinex.write_sinex)(handed, path)
    assert any(("full" in note) == is_full for note in notes)
    if is_gama:
        table, found = gama_covariance.read_covariance(path)
    else:
        table, found = of_file(path, sinex.read_covariance)
    assert table["point_id"].tolist() == spatial.points["point_id"].tolist()
    if is_gama:
        np.testing.assert_allclose(found, covariance, rtol=1e-7, atol=1e-15)
        return
    system = pyproj.CRS("EPSG:25833").to_3d()  # of ETRS89, as EPSG:4936
    back = pyproj.Transformer.from_crs("EPSG:4936", system, always_xy=True)
    xyz = table[["x", "y", "z"]].to_numpy()
    np.testing.assert_allclose(
        np.column_stack(back.transform(*xyz.T)), handed.coordinates, rtol=0, atol=1e-6
    )
    # errors of the geocentric coordinates, brought back by pyproj's own differences
    step = np.eye(3)
    turn = np.stack(
        [
            [np.array(back.transform(*(one + d))) - back.transform(*one) for d in step]
            for one in xyz
        ]
    )
    turned = np.einsum("iab,iajc,jcd->ibjd", turn, found.reshape(3, 3, 3, 3), turn)
    np.testing.assert_allclose(turned.reshape(9, 9), covariance, rtol=2e-3, atol=1e-8)


@pytest.fixture
def contradicted(spatial):
    """Points whose stated precision the measurements exceed, each by its own factor."""
    points, times = spatial.points, np.array([3.0, 1.0, 2.0])
    believed = {
        "standard_error_checked": times * points["standard_error_total"],
        "standard_error_height_checked": 5.0 * points["standard_error_height"],
    }
    return replace(spatial, tables={"points": points.assign(**believed)})


@pytest.mark.parametrize("is_full", [True, False])
def test_covariances_are_those_to_believe(tmp_path, spatial, contradicted, is_full):
    without = {} if is_full else {"covariances": None}
    known = replace(spatial, **without).covariance()
    times = np.array([3.0, 3.0, 5.0, 1.0, 1.0, 5.0, 2.0, 2.0, 5.0])
    covariance = known.full if is_full else block_diag(*known.own)
    path, handed = tmp_path / "p.gkf", replace(contradicted, **without)
    notes = gama.write_gama(handed, path)
    found = gama_covariance.read_covariance(path)[1]
    expected = covariance * np.outer(times, times)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-15)
    assert "enlarged, by up to 5 times" in " ".join(notes)
    assert "enlarged, by up to 5 times" in path.read_text()
    assert "enlarged" not in " ".join(gama.write_gama(spatial, tmp_path / "q.gkf"))
    sinex.write_sinex(handed, tmp_path / "p.snx")
    lines = (tmp_path / "p.snx").read_text().splitlines()
    comments = lines[: lines.index("-FILE/COMMENT")]
    assert any("enlarged, by up to 5 times" in line for line in comments)
    assert max(map(len, comments)) <= 80
    sizes = of_file(tmp_path / "p.snx", sinex.read_covariance)[1]
    # a turn from the plane to geocentric axes leaves the sum of the variances
    point = np.trace(sizes[:3, :3]) / np.trace(expected[:3, :3])
    assert point == pytest.approx(1.0, rel=2e-3)


def test_classes_and_accuracies_are_those_to_believe(tmp_path, contradicted):
    points = contradicted.points
    notes = "; ".join(exporting.WRITERS[".con"](contradicted, tmp_path / "p.con"))
    plan = np.sqrt(np.mean(points["standard_error_checked"] ** 2) / 2.0)
    height = np.sqrt(np.mean(points["standard_error_height_checked"] ** 2))
    assert f"class 1: {plan:.3f} m for each coordinate in plan" in notes
    assert f"class 1 of the list of heights: {height:.3f} m" in notes
    assert "enlarged, by up to 5 times" in notes
    notes = "; ".join(exporting.WRITERS[".csv"](contradicted, tmp_path / "p.csv"))
    assert "enlarged, by up to 5 times" in notes
    rows = pd.read_csv(tmp_path / "p.csv", skiprows=1)
    found = rows[["Accuracy_X/Y_(m)", "Accuracy_Z_(m)"]]
    believed = points[["standard_error_checked", "standard_error_height_checked"]]
    np.testing.assert_allclose(found, believed / [np.sqrt(2.0), 1.0], atol=5.1e-6)


def test_heights_are_written(tmp_path, spatial, monkeypatch):
    monkeypatch.setattr(exporting, "_handed_over", lambda _: (spatial, []))
    files = [tmp_path / f"p{s}" for s in (".dxf", ".xml", ".csv", ".con", ".parquet")]
    es.export("any", *files)
    for path in files[:3]:
        back = read_foreign(path).tables["control_points"]
        heights = back["height"].to_numpy()
        np.testing.assert_allclose(heights, spatial.points["height"], atol=5e-5)
        assert back["point_id"].tolist() == spatial.points["point_id"].tolist()
    assert places(opened(files[4]))[:, 2].tolist() == [411.5, 0.0, 1250.125]
    names = pd.read_csv(tmp_path / "p_names.csv", dtype=str)
    assert names["point_id"].tolist() == ["7/8", "Ötz & Söhne", "0012"]
    listed = read_foreign(files[3]).tables["control_points"]
    assert listed["point_id"].tolist() == names["number"].tolist()
    assert listed["height"].tolist() == [411.5, 0.0, 1250.125]


def test_what_a_format_cannot_hold_is_refused_in_words(tmp_path, spatial, monkeypatch):
    def exported(handed, name):
        monkeypatch.setattr(exporting, "_handed_over", lambda _: (handed, []))
        with pytest.raises(EinschaltError) as refused:
            es.export("any", tmp_path / name)
        assert not (tmp_path / name).exists()
        return str(refused.value)

    local = replace(spatial, crs=None)
    assert "no reference system, and KML" in exported(local, "p.kml")
    assert ".gkf" in exported(local, "p.snx")
    sea = replace(spatial, crs="EPSG:25833+5783")
    assert "heights are those of" in exported(sea, "p.snx")
    plain = spatial.points.drop(columns=["standard_error_easting"])
    bare = replace(spatial, tables={"points": plain}, covariances=None)
    assert "no standard errors" in exported(bare, "p.gkf")
    assert "suffix '.doc' is unknown; expected .dxf" in exported(spatial, "p.doc")
    named = spatial.points.assign(point_id=["a\x01", "b", "c"])
    odd = replace(spatial, tables={"points": named})
    assert "XML cannot hold" in exported(odd, "p.xml")


def test_names_in_a_workbook_stay_text(tmp_path, spatial):
    named = spatial.points.assign(point_id=["=1+1", "http://a.b", "1e5"])
    handed = replace(spatial, tables={"points": named.assign(role="control")})
    exporting.WRITERS[".xlsx"](handed, tmp_path / "p.xlsx")
    read = es.read_points(tmp_path / "p.xlsx", sheet="points")
    assert read["point_id"].tolist() == ["=1+1", "http://a.b", "1e5"]


def test_formats_of_ones_own_are_found(tmp_path, spatial, monkeypatch):
    class Point:
        name = ".abc"

        def load(self):
            return lambda handed, path: path.write_text(handed.name) and ["mine"]

    monkeypatch.setattr(exporting, "entry_points", lambda **_: [Point()])
    monkeypatch.setattr(exporting, "_handed_over", lambda _: (spatial, []))
    (written,) = es.export("any", tmp_path / "p.abc")
    assert (written.notes, written.path.read_text()) == (("mine",), "three")


@pytest.fixture
def files_are_small():
    """Let no file of this process grow beyond 1 kB, as a full disk would."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    gc.collect()  # temporary files of a workbook: here, and in no other test


@pytest.mark.filterwarnings("ignore:.*unclosed file:ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("suffix", [s for s in SUFFIXES if s != ".snx"])
def test_what_finds_no_room_is_said_and_leaves_nothing(
    tmp_path, good_result, suffix, files_are_small
):
    with pytest.raises(FileError, match=f"p\\{suffix}: cannot be written: ") as caught:
        es.export(good_result, tmp_path / f"p{suffix}")
    assert re.search("limit on the size of files, or choose", caught.value.remedy)
    assert list(tmp_path.iterdir()) == []
