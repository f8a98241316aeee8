"""What is published does, run by PROJ, what the result does: there and back."""

import json
import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pyproj
import pytest

import einschalt as es
from einschalt.interfaces.publication import return_check
from einschalt.interfaces.publication.publish import _names_of_files, publish_block

FINLAND = Path(__file__).parents[3] / "data_examples" / "fi_ykj_tm35fin"
SCHEMA = {  # of PROJ's data/triangulation.schema.json
    "file_type",
    "format_version",
    "name",
    "description",
    "input_crs",
    "output_crs",
    "transformed_components",
    "vertices_columns",
    "triangles_columns",
    "vertices",
    "triangles",
}
CLOSE = {"atol": 1e-4, "rtol": 0.0}


@pytest.fixture(scope="module")
def finland():
    """The 767 points, Finland's own triangles, and the transformation over them."""
    old, new, triangles = (
        pd.read_csv(FINLAND / f"{name}.csv")
        for name in ("model_points", "ground_points", "triangles_model_points")
    )
    fit = es.transform_models(old, new, kind="helmert")
    return old, new, triangles, fit.distributed(triangles)


@pytest.fixture(scope="module")
def published(finland, tmp_path_factory):
    folder = tmp_path_factory.mktemp("a folder") / "ykj"
    systems = {"crs": "EPSG:3067", "source_crs": "EPSG:2393"}
    return finland[-1].publish("YKJ", folder, **systems)


@pytest.fixture(scope="module")
def within(finland):
    """10 000 points within Finland's triangles, and where these take them."""
    old, new, triangles, _ = finland
    both = old.merge(new, on="point_id").set_index("point_id")
    corners = triangles["point_id"].to_numpy().reshape(-1, 3)
    rng = np.random.default_rng(2)
    shares = rng.dirichlet(np.ones(3), 10_000)[..., None]
    chosen = corners[rng.integers(0, len(corners), 10_000)]
    of = [
        both.loc[chosen.ravel(), names].to_numpy().reshape(-1, 3, 2)
        for names in (["x", "y"], ["easting", "northing"])
    ]
    return [(shares * part).sum(axis=1) for part in of]


def with_database(path, work):
    """Call in a thread of its own, which opens PROJ's database anew."""
    os.environ["PROJ_AUX_DB"] = str(path)
    try:
        with ThreadPoolExecutor(1) as alone:
            return alone.submit(work).result()
    finally:
        del os.environ["PROJ_AUX_DB"]


@pytest.mark.slow
def test_finlands_own_transformation_is_reproduced(published, within):
    """PROJ's documentation: (3210000, 6700000) → (209948.3217, 6697187.0009)."""
    for text in published.operations[["proj", "wkt"]].iloc[0]:
        way = pyproj.Transformer.from_pipeline(text)
        found = way.transform(3_210_000.0, 6_700_000.0)
        np.testing.assert_allclose(found, (209948.3217, 6697187.0009), **CLOSE)
        moved = np.column_stack(way.transform(*within[0].T))
        np.testing.assert_allclose(moved, within[1], **CLOSE)
        back = np.column_stack(way.transform(*within[1].T, direction="INVERSE"))
        np.testing.assert_allclose(back, within[0], **CLOSE)


@pytest.mark.slow
def test_proj_finds_it_by_name_without_a_network(published, finland, within):
    code, target = "EINSCHALT:YKJ", "EPSG:3067"

    def run():
        pyproj.network.set_network_enabled(active=False)
        group = pyproj.transformer.TransformerGroup(code, target, always_xy=True)
        way = pyproj.Transformer.from_crs(code, target, always_xy=True, only_best=True)
        moved = np.column_stack(way.transform(*within[0].T))
        back = np.column_stack(way.transform(*moved.T, direction="INVERSE"))
        return group.transformers[0], moved, back, pyproj.CRS(code).name

    chosen, moved, back, frame = with_database(published.database, run)
    points = pd.DataFrame({"model_id": "all", "point_id": range(len(within[0]))})
    points[["x", "y"]] = within[0]
    expected = finland[-1].transform(points)[["easting", "northing"]]
    np.testing.assert_allclose(moved, expected, **CLOSE)
    np.testing.assert_allclose(back, within[0], **CLOSE)
    error = published.operations["accuracy"].iloc[0]
    assert chosen.accuracy == pytest.approx(error) == pytest.approx(0.1056, abs=1e-3)
    assert chosen.area_of_use.west < 20.0
    assert chosen.area_of_use.east > 31.0
    assert "KKJ / Finland Uniform Coordinate System" in frame


@pytest.mark.slow
@pytest.mark.parametrize("third", ["EPSG:4258", "EPSG:25835", "EPSG:3857"])
def test_proj_goes_on_to_other_systems_than_the_target(third, published, within):
    def run():
        ways = [
            pyproj.Transformer.from_crs(*ends, always_xy=True, only_best=True)
            for ends in (("EINSCHALT:YKJ", third), ("EPSG:3067", third))
        ]
        at_once = ways[0].transform(*within[0].T)
        there_and_on = ways[1].transform(*within[1].T)
        back = np.column_stack(ways[0].transform(*at_once, direction="INVERSE"))
        return at_once, there_and_on, back

    at_once, there_and_on, back = with_database(published.database, run)
    close = {"atol": 1e-9} if third == "EPSG:4258" else {"atol": 1e-4}
    np.testing.assert_allclose(at_once, there_and_on, **close, rtol=0.0)
    np.testing.assert_allclose(back, within[0], **CLOSE)


def test_the_operation_says_how_good_it_is_and_where(published):
    operation = published.operations.iloc[0]
    way = pyproj.Transformer.from_pipeline(operation["wkt"])
    assert way.accuracy == pytest.approx(operation["accuracy"], abs=1e-4)
    assert "BBOX[" in operation["wkt"]
    assert operation["wkt"].startswith("COORDINATEOPERATION[")


def test_the_file_of_triangles_keeps_to_the_format(published):
    content = json.loads((published.folder / "YKJ.json").read_text(encoding="utf-8"))
    assert set(content) == SCHEMA
    assert content["output_crs"] == "EPSG:3067"
    assert len(content["vertices"]) == 767
    assert np.shape(content["triangles"]) == (1450, 3)


def test_the_page_says_how_to_use_it_and_how_good_it_is(published):
    page = (published.folder / "README.md").read_text(encoding="utf-8")
    for words in ("EINSCHALT:YKJ", "EPSG:3067", "PROJ_AUX_DB", "0.1056", "cs2cs"):
        assert words in page
    assert "KKJ / Finland Uniform Coordinate System (EPSG:2393)" in page


SYSTEM_DATABASE = Path("/usr/share/proj/proj.db")
PAIR = {"crs": "EPSG:3067", "source_crs": "EPSG:2393"}


def needs(program):
    is_there = shutil.which(program)
    return pytest.mark.skipif(not is_there, reason=f"{program} is not installed")


@pytest.fixture(scope="module")
def for_the_system(finland, tmp_path_factory):
    """A database for the PROJ of the system's own programs, and what names it."""
    if not SYSTEM_DATABASE.exists():
        pytest.skip(f"the system has no PROJ of its own ({SYSTEM_DATABASE})")
    folder = tmp_path_factory.mktemp("system")
    done = es.publish(finland[-1], "YKJ", folder, **PAIR, proj_db=SYSTEM_DATABASE)
    return done, {**os.environ, "PROJ_AUX_DB": str(done.database)}


@pytest.fixture(scope="module")
def asked(within):
    """All identical points and 10 000 others, and where Finland takes them."""
    old, new = (
        pd.read_csv(FINLAND / f"{name}.csv").set_index("point_id")
        for name in ("model_points", "ground_points")
    )
    both = old.join(new, how="inner")
    known = both[["x", "y"]].to_numpy(), both[["easting", "northing"]].to_numpy()
    return [np.concatenate(parts) for parts in zip(known, within, strict=True)]


def lines_of(points):
    return "".join(f"{x!r} {y!r}\n" for x, y in points.tolist())


@needs("cs2cs")
@pytest.mark.parametrize("way", [[], ["-I"]], ids=["there", "back"])
def test_cs2cs_leads_there_and_back(way, for_the_system, asked):
    source, target = asked[::-1] if way else asked
    shown = subprocess.run(
        ["cs2cs", *way, "-f", "%.6f", "EINSCHALT:YKJ", "EPSG:3067"],
        input=lines_of(source),
        env=for_the_system[1],
        capture_output=True,
        text=True,
        check=True,
    )
    found = [line.split()[:2] for line in shown.stdout.splitlines()]
    np.testing.assert_allclose(np.array(found, dtype=float), target, **CLOSE)


@needs("ogr2ogr")
@pytest.mark.parametrize("way", ["there", "back"])
def test_ogr2ogr_leads_there_and_back(way, for_the_system, asked, tmp_path):
    source, target = asked if way == "there" else asked[::-1]
    systems = ["EINSCHALT:YKJ", "EPSG:3067"][:: 1 if way == "there" else -1]
    pd.DataFrame(source, columns=["x", "y"]).to_csv(tmp_path / "old.csv", index=False)
    columns = ["-oo", "X_POSSIBLE_NAMES=x", "-oo", "Y_POSSIBLE_NAMES=y"]
    written = ["-f", "CSV", "-lco", "GEOMETRY=AS_XY", "new.csv", "old.csv"]
    # the first one names the system of what is read
    asked_for = ["-s_srs", systems[0], "-t_srs", systems[1]]
    subprocess.run(
        ["ogr2ogr", *columns, *asked_for, *written],
        cwd=tmp_path,
        env=for_the_system[1],
        check=True,
    )
    found = pd.read_csv(tmp_path / "new.csv")[["X", "Y"]]
    np.testing.assert_allclose(found, target, **CLOSE)


QGIS_PYTHON = Path("/usr/bin/python3")  # Debian's, which its python3-qgis is for
IN_QGIS = """
import json, sys
from qgis.core import *
application = QgsApplication([], False)
application.initQgis()
frame = QgsCoordinateReferenceSystem.fromWkt(open(sys.argv[1]).read())
system = QgsCoordinateReferenceSystem("EPSG:3067")
way = QgsCoordinateTransform(frame, system, QgsCoordinateTransformContext())
found = []
for x, y in json.load(sys.stdin):
    there = way.transform(QgsPointXY(x, y))
    back = way.transform(there, QgsCoordinateTransform.ReverseTransform)
    found.append([there.x(), there.y(), back.x(), back.y()])
used = way.instantiatedCoordinateOperationDetails()
print(json.dumps([frame.authid(), used.name, used.accuracy, found]))
application.exitQgis()
"""


def has_qgis():
    if not QGIS_PYTHON.exists():
        return False
    known = [QGIS_PYTHON, "-c", "import qgis.core"]
    return subprocess.run(known, capture_output=True, check=False).returncode == 0


def test_qgis_leads_there_and_back(for_the_system, asked, tmp_path):
    if not has_qgis():
        pytest.skip("QGIS (Debian's python3-qgis) is not installed")
    done, environment = for_the_system
    homes = dict.fromkeys(("HOME", "XDG_RUNTIME_DIR"), str(tmp_path))
    environment = {**environment, **homes, "QT_QPA_PLATFORM": "offscreen"}
    environment.pop("PYTHONPATH", None)
    shown = subprocess.run(
        [QGIS_PYTHON, "-c", IN_QGIS, done.folder / "YKJ.wkt"],
        input=json.dumps(asked[0].tolist()),
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    name, operation, accuracy, found = json.loads(shown.stdout.splitlines()[-1])
    assert (name, operation) == ("EINSCHALT:YKJ", "YKJ")
    assert accuracy == pytest.approx(done.operations["accuracy"].iloc[0])
    np.testing.assert_allclose(np.array(found)[:, :2], asked[1], **CLOSE)
    np.testing.assert_allclose(np.array(found)[:, 2:], asked[0], **CLOSE)


def test_what_is_no_database_of_proj_is_refused(finland, tmp_path):
    (tmp_path / "proj.db").write_text("no database")
    with pytest.raises(es.EinschaltError, match="is no database of PROJ"):
        es.publish(finland[-1], "YKJ", tmp_path / "o", proj_db=tmp_path / "proj.db")


@pytest.mark.slow
def test_a_target_that_lists_the_northing_first_gets_it_first(tmp_path):
    rng = np.random.default_rng(4)
    names = [f"P{k}" for k in range(20)]
    model = pd.DataFrame({"model_id": "1", "point_id": names})
    model[["x", "y"]] = rng.uniform(0.0, 100.0, (20, 2))
    ground = pd.DataFrame({"point_id": names})
    ground["easting"] = 10_000.0 + 8.0 * model["x"] - model["y"]
    ground["northing"] = 325_000.0 + model["x"] + 8.0 * model["y"]
    fit = es.transform_models(model, ground, kind="helmert")
    done = es.publish(fit, "OLD", tmp_path / "out", crs="EPSG:31255")

    def run():
        way = pyproj.Transformer.from_crs("EINSCHALT:OLD", "EPSG:31255")
        return way.transform(*model[["x", "y"]].to_numpy().T)

    northing, easting = with_database(done.database, run)
    np.testing.assert_allclose(easting, ground["easting"], **CLOSE)
    np.testing.assert_allclose(northing, ground["northing"], **CLOSE)


def test_the_database_is_told_by_a_path_without_detours(finland, tmp_path):
    """PROJ_AUX_DB had .. in it where the folder was given so."""
    (tmp_path / "beside").mkdir()
    systems = {"crs": "EPSG:3067", "source_crs": "EPSG:2393"}
    folder = tmp_path / "beside" / ".." / "ykj"
    told = finland[-1].publish("YKJ", folder, **systems)
    assert told.database == tmp_path.resolve() / "ykj" / "YKJ.db"
    assert told.database.is_file()


@pytest.mark.slow
def test_models_of_a_block_lead_from_the_machine_to_the_ground(good_result, tmp_path):
    few = good_result.models.iloc[[0, -1]]
    done = es.publish(with_models(good_result, few), "DEMO", tmp_path / "out")
    assert len(done.operations) == 2
    low = good_result.solution.low
    last = few.iloc[-1]
    points = low.observed.rows.reset_index(drop=True)
    is_of_it = (points[["coverage", "model_id"]] == last[["coverage", "model_id"]]).all(
        axis=1
    )
    points = points[is_of_it].assign(
        **dict(zip("xy", low.observed.source[is_of_it].T, strict=True))
    )
    expected = low.transform(points)[["easting", "northing"]]
    way = pyproj.Transformer.from_pipeline(done.operations["wkt"].iloc[-1])
    moved = np.column_stack(way.transform(*points[["x", "y"]].to_numpy().T))
    np.testing.assert_allclose(moved, expected, **CLOSE)


@pytest.fixture(scope="module")
def block_in_a_folder(good_result, tmp_path_factory):
    """What publication reads of a block's results."""
    folder = tmp_path_factory.mktemp("results")
    for name in ("models", "residuals", "points"):
        getattr(good_result, name).to_parquet(folder / f"{name}.parquet")
    facts = {"program": "einschalt", "block": {"name": "DEMO", "crs": "EPSG:31255"}}
    (folder / "provenance.json").write_text(json.dumps(facts))
    return folder


@pytest.mark.parametrize("of", ["result", "folder"])
@pytest.mark.parametrize(
    ("systems", "said"),
    [
        (
            {"crs": "EPSG:25833"},
            r"\(EPSG:25833\) for the models of a block in MGI / .* \(EPSG:31255\)",
        ),
        ({"crs": "EPSG:4258"}, "has axes in degree"),
        ({"source_crs": "EPSG:31258"}, "source_crs = .* expected none: they have mach"),
    ],
)
def test_models_of_a_block_lead_to_its_own_system_alone(
    of, systems, said, good_result, block_in_a_folder, tmp_path
):
    of_block = with_models(good_result, good_result.models)
    result = of_block if of == "result" else block_in_a_folder
    with pytest.raises(es.EinschaltError, match=said):
        es.publish(result, "DEMO", tmp_path / "out", **systems)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_block_without_a_system_gets_none_that_its_points_cannot_have(
    good_result, block_in_a_folder, tmp_path
):
    tables = {n: getattr(good_result, n) for n in ("models", "residuals", "points")}
    options = {"own_crs": None, "crs": "EPSG:25833", "title": "the block"}
    with pytest.raises(es.EinschaltError, match="outside the area of use of ETRS89"):
        publish_block(tables, "DEMO", tmp_path / "out", **options)
    # heights of a system say nothing in plan
    crs = "EPSG:31255+5778"
    done = es.publish(block_in_a_folder, "DEMO", tmp_path / "out", crs=crs)
    assert done.operations["west"].between(13.0, 14.0).all()


@pytest.mark.slow
def test_spatial_models_over_a_curved_earth_are_not_published(good_result, tmp_path):
    spatial = good_result.models.assign(transformation="helmert_3d")
    with pytest.raises(es.EinschaltError, match="curvature is in no affine"):
        es.publish(with_models(good_result, spatial), "DEMO", tmp_path / "out")


def with_models(result, models):
    """The result with some of its models."""
    from dataclasses import replace

    from einschalt.interfaces.python_api import DensificationResult

    return DensificationResult(replace(result.solution, models=models))


def test_without_a_system_there_are_strings_and_triangles(finland, tmp_path):
    done = finland[-1].publish("LOCAL", tmp_path / "out")
    assert done.database is None
    assert not list(done.folder.glob("*.db"))
    way = pyproj.Transformer.from_pipeline(done.operations["proj"].iloc[0])
    found = way.transform(3_210_000.0, 6_700_000.0)
    np.testing.assert_allclose(found, (209948.3217, 6697187.0009), **CLOSE)


def test_what_does_not_return_is_not_published(finland, tmp_path, monkeypatch):
    def bent(text, points, *, inverse=False):
        return points + (0.001 if inverse else 0.0)

    monkeypatch.setattr(return_check, "run_pipeline", bent)
    with pytest.raises(es.EinschaltError, match="nothing is published"):
        finland[-1].publish("YKJ", tmp_path / "out", crs="EPSG:3067")
    assert not (tmp_path / "out" / "YKJ.json").exists()


@pytest.mark.parametrize(
    "name", ["", "a b", "7", "Y", "Ü", "x" * 41, None, "Provenance", "failure", "Com1"]
)
def test_names_that_proj_would_not_take_are_refused(name, finland, tmp_path):
    with pytest.raises(es.EinschaltError, match="name of a publication"):
        finland[-1].publish(name, tmp_path)


def test_spatial_transformations_are_published_as_strings(tmp_path):
    rng = np.random.default_rng(1)
    names = [f"P{k}" for k in range(6)]
    xyz = rng.uniform(0.0, 100.0, (6, 3))
    model = pd.DataFrame(xyz, columns=list("xyz")).assign(model_id="1", point_id=names)
    enh = 8.0 * xyz + np.array([1e4, 3.25e5, 400.0])
    ground = pd.DataFrame(enh, columns=["easting", "northing", "height"])
    fit = es.transform_models(model, ground.assign(point_id=names), "helmert_3d")
    done = fit.publish("SPACE", tmp_path / "out", crs="EPSG:31255")
    assert done.database is None
    for text in done.operations[["proj", "wkt"]].iloc[0]:
        moved = pyproj.Transformer.from_pipeline(text).transform(*xyz.T)
        np.testing.assert_allclose(np.column_stack(moved), enh, **CLOSE)


@pytest.mark.parametrize(
    ("systems", "said"),
    [
        ({"crs": "EPSG:4258"}, r"crs = ETRS89 \(EPSG:4258\) has axes in degree"),
        (
            {"crs": "EPSG:3067", "source_crs": "EPSG:2263"},
            r"source_crs = .* \(EPSG:2263\) has axes in US survey foot",
        ),
        (
            {"crs": "EPSG:31255"},
            r"outside the area of use of MGI / Austria GK Central \(EPSG:31255\)",
        ),
        (
            {"source_crs": "EPSG:2393"},
            r"source_crs = KKJ .* \(EPSG:2393\), and no crs",
        ),
        (
            {"crs": "EPSG:3067", "source_crs": "EPSG:2056"},
            r"source_crs CH1903\+ / LV95 \(EPSG:2056\) puts the points at",
        ),
    ],
)
def test_systems_that_the_points_cannot_have_are_refused(
    systems, said, finland, tmp_path
):
    with pytest.raises(es.EinschaltError, match=said):
        es.publish(finland[-1], "YKJ", tmp_path / "out", **systems)
    assert not (tmp_path / "out").exists()


def test_one_file_is_not_written_over_another():
    operations = [SimpleNamespace(code="OLD"), SimpleNamespace(code="old")]
    with pytest.raises(es.EinschaltError, match=r"would write OLD\.json, "):
        _names_of_files(operations, "OTHER")


@pytest.mark.parametrize("crs", ["EPSG:31255", None])
def test_points_in_a_line_have_no_triangles_and_are_published(crs, tmp_path):
    names = ["A", "B", "C"]
    model = pd.DataFrame({"model_id": "1", "point_id": names, "x": [0.0, 50.0, 100.0]})
    model["y"] = 2.0 * model["x"]
    ground = pd.DataFrame({"point_id": names})
    ground["easting"] = 10_000.0 + 8.0 * model["x"] - model["y"]
    ground["northing"] = 325_000.0 + model["x"] + 8.0 * model["y"]
    fit = es.transform_models(model, ground, kind="helmert")
    done = fit.publish("LINE", tmp_path / "out", crs=crs)
    assert done.operations["triangles"].tolist() == [""]
    assert not (done.folder / "LINE.json").exists()
    assert "By its triangles" not in (done.folder / "README.md").read_text("utf-8")
    assert ("EINSCHALT:LINE" in done.summary()) == (crs is not None)
    for text in done.operations[["proj", "wkt"]].iloc[0]:
        moved = pyproj.Transformer.from_pipeline(text).transform(100.0, 0.0)
        np.testing.assert_allclose(moved, (10_800.0, 325_100.0), **CLOSE)


@pytest.mark.slow
def test_systems_with_a_way_out_of_their_datum_are_systems(finland, tmp_path):
    crs = "+proj=utm +zone=35 +ellps=GRS80 +towgs84=0,0,0"
    old = "+proj=tmerc +lon_0=27 +x_0=3500000 +ellps=intl +towgs84=-96,-103,-116"
    done = finland[-1].publish("YKJ", tmp_path / "out", crs=crs, source_crs=old)

    def run():
        way = pyproj.Transformer.from_crs("EINSCHALT:YKJ", "EINSCHALT:YKJ_TARGET")
        return way.transform(3_210_000.0, 6_700_000.0)

    found = with_database(done.database, run)
    np.testing.assert_allclose(found, (209948.3217, 6697187.0009), **CLOSE)
