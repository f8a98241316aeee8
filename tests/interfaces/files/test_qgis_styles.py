"""Styles are well-formed, and speak of columns and values that the layers have."""

from xml.etree import ElementTree as ET

import pytest

from einschalt.interfaces.files.qgis_styles import STYLES, Category, Style


@pytest.mark.parametrize("layer", STYLES)
def test_every_category_has_its_symbol(layer):
    root = ET.fromstring(STYLES[layer].as_qml().split(">", 1)[1])
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


def test_special_characters_are_escaped():
    style = Style(
        "line", "SimpleLine", "\"a\" < 'b'", (Category("<&>", '"x"', {"k": "<"}),)
    )
    root = ET.fromstring(style.as_qml().split(">", 1)[1])
    assert root.find("renderer-v2").get("attr") == "\"a\" < 'b'"
    assert root.find(".//category").get("value") == "<&>"
