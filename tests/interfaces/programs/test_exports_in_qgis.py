"""Exported files as QGIS opens and draws them."""

from collections import Counter

import pytest
from tests.in_qgis import said_by_qgis

import einschalt as es
from einschalt.interfaces.files.geopackage import write_geopackage

# of each layer: whether it is sound and can be drawn, its features, its system
LAYERS = """
said = []
for path in sys.argv[1:]:
    whole = QgsVectorLayer(path, "whole", "ogr")
    assert whole.isValid(), path
    for one in whole.dataProvider().subLayers():
        _, name, _, kind, *_ = one.split(QgsDataProvider.sublayerSeparator())
        uri = f"{path}|layername={name}"
        uri += f"|geometrytype={kind}" if path.endswith(".dxf") else ""
        layer = QgsVectorLayer(uri, name, "ogr")
        features = list(layer.getFeatures())
        is_drawn = layer.isValid() and layer.renderer() is not None
        levels = [f["Layer"] for f in features] if path.endswith(".dxf") else []
        said.append([
            os.path.splitext(path)[1], name, kind, is_drawn, len(features), levels,
            all(f.hasGeometry() and not f.geometry().isEmpty() for f in features),
            layer.crs().authid(),
        ])
"""
# the names that are placed on a map of a scale
NAMES = """
from qgis.PyQt.QtCore import QSize
layer = QgsVectorLayer(f"{sys.argv[1]}|layername=points", "points", "ogr")
said = []
for size in (4000, 200):
    settings = QgsMapSettings()
    settings.setLayers([layer])
    settings.setDestinationCrs(layer.crs())
    settings.setOutputSize(QSize(size, size))
    settings.setExtent(layer.extent())
    job = QgsMapRendererSequentialJob(settings)
    job.start()
    job.waitForFinished()
    assert not job.errors()
    placed = job.takeLabelingResults().labelsWithinRect(settings.extent())
    said.append([settings.scale(), [one.labelText for one in placed]])
"""


@pytest.fixture(scope="module")
def layers(tmp_path_factory, good_result):
    pytest.importorskip("ezdxf")
    folder = tmp_path_factory.mktemp("qgis")
    files = [folder / f"p{suffix}" for suffix in (".dxf", ".shp", ".kml")]
    es.export(good_result, *files)
    return said_by_qgis(LAYERS, folder, *files)


def test_every_layer_is_sound_and_drawn(layers):
    assert {suffix for suffix, *_ in layers} == {".dxf", ".shp", ".kml"}
    for suffix, name, kind, is_drawn, n_features, _, has_geometry, _ in layers:
        assert is_drawn, (suffix, name, kind)
        assert n_features > 0
        assert has_geometry, (suffix, name, kind)


def test_all_points_are_in_layers_and_map(layers, good_result):
    roles = Counter(good_result.points["role"])
    ((n_features, _, _, crs),) = [one[4:] for one in layers if one[0] == ".shp"]
    assert (n_features, crs) == (roles.total(), "EPSG:31255")
    of_kml = {name: n for suffix, name, _, _, n, *_ in layers if suffix == ".kml"}
    assert of_kml == {f"{role} points": n for role, n in roles.items()}
    assert {one[-1] for one in layers if one[0] == ".kml"} == {"EPSG:4326"}


def test_every_point_of_a_drawing_has_a_symbol(layers, good_result):
    (levels,) = [one[5] for one in layers if one[0] == ".dxf" and "Line" in one[2]]
    levels = Counter(level.split("_X")[0] for level in levels)
    for role, n in Counter(good_result.points["role"]).items():
        assert levels[f"POINTS_{role.upper()}"] == n
    assert levels["ELLIPSES"] == len(good_result.ellipses)


def test_points_are_named_on_maps_of_large_scale_only(tmp_path, good_result):
    package = tmp_path / "block.gpkg"
    write_geopackage(good_result, package)
    (near, names), (far, none) = said_by_qgis(NAMES, tmp_path, package)
    assert near < 25_000 < far
    assert not none
    assert len(names) > 10
    assert set(names) <= set(good_result.points["point_id"])
