"""Styles are well-formed, complete, and go with the package."""

import re
import tomllib
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

import einschalt
from einschalt.interfaces.files.qgis_styles import LAYERS, style_of

PROJECT = Path(__file__).parents[3] / "pyproject.toml"


def root_of(layer):
    return ET.fromstring(style_of(layer).split(">", 1)[1])


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
        if path.is_file() and path.suffix not in {".py", ".pyc", ".nbi", ".nbc"}
    }
    declared = {path for pattern in patterns for path in package.glob(pattern)}
    assert others == declared
