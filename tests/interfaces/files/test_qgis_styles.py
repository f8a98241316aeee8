"""Styles are well-formed, complete, and go with the package."""

import re
import tomllib
from pathlib import Path
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
import pyogrio
import pytest
from tests.in_qgis import said_by_qgis

import einschalt
import einschalt as es
from einschalt.interfaces.files.geopackage import write_geopackage
from einschalt.interfaces.files.qgis_styles import (
    LAYERS,
    Claim,
    claim_of,
    expression_of,
    style_of,
)
from einschalt.interfaces.reports.precision_colours import STEPS

PROJECT = Path(__file__).parents[3] / "pyproject.toml"


def root_of(layer, *more):
    return ET.fromstring(style_of(layer, *more).split(">", 1)[1])


@pytest.fixture(scope="module")
def package_columns(tmp_path_factory, good_result):
    package = tmp_path_factory.mktemp("gpkg") / "block.gpkg"
    write_geopackage(good_result, package)
    return {n: pyogrio.read_info(package, layer=n)["fields"].tolist() for n in LAYERS}


@pytest.mark.parametrize("layer", LAYERS)
def test_every_category_has_its_symbol(layer):
    root = root_of(layer)
    categories = root.findall("renderer-v2/categories/category")
    symbols = root.findall("renderer-v2/symbols/symbol")
    assert len(categories) >= 2
    assert [c.get("symbol") for c in categories] == [s.get("name") for s in symbols]
    for symbol in symbols:
        options = symbol.findall("layer/Option/Option")
        older = symbol.findall("layer/prop")
        assert {o.get("name"): o.get("value") for o in options} == {
            p.get("k"): p.get("v") for p in older
        }
        assert options


@pytest.mark.parametrize("layer", LAYERS)
def test_every_value_that_the_layer_may_have_is_drawn(layer):
    values = [c.get("value") for c in root_of(layer).iter("category")]
    columns = set(re.findall(r"\w+", root_of(layer).find("renderer-v2").get("attr")))
    if "role" in columns:
        assert sorted(values) == ["check", "control", "new"]
    else:
        assert "flight" in columns
        assert {"high_flight", "low_flight"} <= set(values)


def test_files_that_are_no_python_are_declared_for_the_wheel():
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))
    patterns = project["tool"]["setuptools"]["package-data"]["einschalt"]
    package = Path(einschalt.__file__).parent
    others = {
        path
        for path in package.rglob("*")
        if path.is_file() and path.suffix not in {".py", ".pyc", ".nbi", ".nbc", ".po"}
    }
    declared = {path for pattern in patterns for path in package.glob(pattern)}
    assert others == declared


CLAIM = Claim("standard_error_total", 0.03, 0.075)


def test_colours_of_errors_are_those_of_the_report():
    steps = mpl.colormaps["viridis_r"](np.linspace(0.0, 1.0, len(STEPS)))
    np.testing.assert_allclose(np.array(STEPS), 255 * steps[:, :3], atol=1)
    root = root_of("points", ["point_id"], CLAIM)
    new, *others = root.findall("renderer-v2/symbols/symbol")
    options = {o.get("name"): o.get("value") for o in new.iter("Option")}
    assert options["expression"] == expression_of(CLAIM)
    assert all("expression" not in ET.tostring(one, "unicode") for one in others)
    label = root.find("renderer-v2/categories/category").get("label")
    assert label == "new point, total error 3.0 cm (yellow) to 7.5 cm (violet)"


@pytest.mark.parametrize("layer", LAYERS)
def test_map_tips_name_columns_that_the_layer_has(layer, package_columns):
    tip = root_of(layer, package_columns[layer], CLAIM).findtext("mapTip")
    assert set(re.findall(r'"(\w+)"', tip)) <= set(package_columns[layer])
    root = root_of(layer, package_columns[layer])
    aliases = {one.get("field"): one.get("name") for one in root.iter("alias")}
    assert list(aliases) == list(package_columns[layer])


QGIS = """
said = {}
drawing = QgsVectorLayer(f"{sys.argv[2]}|layername=entities", "dxf", "ogr")
texts = {feature["Text"] for feature in drawing.getFeatures()}
for name in sys.argv[3:]:
    layer = QgsVectorLayer(f"{sys.argv[1]}|layername={name}", name, "ogr")
    assert layer.isValid(), name
    feature = next(layer.getFeatures())
    context = QgsExpressionContext(
        QgsExpressionContextUtils.globalProjectLayerScopes(layer)
    )
    context.setFeature(feature)
    tip = QgsExpression.replaceExpressionText(layer.mapTipTemplate(), context)
    said[name] = {
        "crs": layer.crs().authid(), "n": layer.featureCount(), "tip": tip,
        "renderer": layer.renderer().type(), "labels": layer.labelsEnabled(),
        "aliases": {f.name(): layer.attributeAlias(k)
                    for k, f in enumerate(layer.fields())},
        "colours": [],
    }
    if name == "points":
        settings = layer.labeling().settings()
        said[name]["named"] = [settings.fieldName, settings.minimumScale]
        category = layer.renderer().categories()[0]  # which owns its symbol
        symbol = category.symbol().symbolLayer(0)
        colour = symbol.dataDefinedProperties().property(3)
        for feature in layer.getFeatures():
            context.setFeature(feature)
            said[name]["colours"].append(colour.valueAsString(context)[0])
said = [said, sorted(map(str, texts))]
"""


def test_qgis_opens_the_layers_with_all_that_was_said(tmp_path, good_result):
    package = tmp_path / "block.gpkg"
    write_geopackage(good_result, package)
    drawing = tmp_path / "points.dxf"
    es.export(good_result, drawing)
    said, texts = said_by_qgis(QGIS, tmp_path, package, drawing, *LAYERS)
    points = good_result.points
    assert set(points["point_id"]) <= set(texts)  # of the drawing
    for layer in LAYERS:
        assert said[layer]["crs"] == "EPSG:31255"
        assert said[layer]["n"] > 0
        assert said[layer]["renderer"] == "categorizedSymbol"
        assert "[%" not in said[layer]["tip"]
    assert said["points"]["labels"]
    assert said["points"]["named"] == ["point_id", 25000.0]
    assert said["points"]["n"] == len(points)
    assert said["points"]["aliases"]["easting"] == "easting [m]"
    assert points["point_id"].iloc[0] in said["points"]["tip"]
    colours = said["points"]["colours"]
    claim = claim_of(good_result)
    is_best = (points["role"] == "new") & (points[claim.column] == claim.low)
    assert colours[int(np.argmax(is_best))] == "253,231,37"
    assert len(set(colours)) > 5
