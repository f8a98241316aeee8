"""Every message that names a reference system names its code and what it is called."""

import json
import re

import pyproj
import pytest
from tests.moved_block import CONTROL, moved_block

import einschalt as es
from einschalt.interfaces.files.block_folder import find_problems
from einschalt.interfaces.publication.publish import publish_densification
from einschalt.interfaces.publication.published_results import publish_folder

SALZBURG, LUCERNE = (13.5, 47.3), (8.0, 47.0)
CODE = re.compile(r"EPSG:(\d+)")
# what may be written is said by example, and an address or a command is no message
EXAMPLE = re.compile(r"such as '?EPSG:\d+(\+\d+)?'?")


def unnamed(text):
    """Codes of systems that stand in a message without their names."""
    text = EXAMPLE.sub("", text)
    return [
        code
        for code in CODE.findall(text)
        if f"{pyproj.CRS.from_epsg(code).name} (EPSG:{code})" not in text
    ]


def test_what_has_no_name_is_seen():
    assert unnamed("from MGI (EPSG:4312) to EPSG:31255; such as 'EPSG:25833'") == [
        "31255"
    ]


def replaced(block, old, new):
    block.replace("block.toml", f'crs = "{old}"', f'crs = "{new}"')


# system of the block, of its control, place, and what is changed then
BLOCKS = {
    "no grid": ("EPSG:25833", "EPSG:31255", SALZBURG, None),
    "another grid": ("EPSG:31255", "EPSG:4326", SALZBURG, None),
    "used": ("EPSG:31255", "EPSG:31287", SALZBURG, None),
    "wrong zone": ("EPSG:31258", None, SALZBURG, ("EPSG:31258", "EPSG:31255")),
    "wrong zone of the points": (
        *("EPSG:31255", "EPSG:25833", SALZBURG),
        ("EPSG:25833", "EPSG:25831"),
    ),
    "another country": (
        *("EPSG:25832", "EPSG:2056", LUCERNE),
        ("EPSG:2056", "EPSG:31255"),
    ),
    "neighbouring zone": ("EPSG:25832", None, (14.2, 47.3), None),
    "distorted": ("EPSG:3857", None, SALZBURG, None),
    "degrees": ("EPSG:31255", None, SALZBURG, ("EPSG:31255", "EPSG:4258")),
    "feet": ("EPSG:31255", None, SALZBURG, ("EPSG:31255", "EPSG:2263")),
    "geocentric": (
        *("EPSG:31255", "EPSG:31287", SALZBURG),
        ("EPSG:31287", "EPSG:4978"),
    ),
    "to the south": (
        *("EPSG:31255", "EPSG:31287", SALZBURG),
        ("EPSG:31287", "EPSG:5513"),
    ),
}


@pytest.mark.parametrize("case", BLOCKS)
def test_what_is_said_of_a_block_names_its_systems(case, small_block):
    crs, own, place, change = BLOCKS[case]
    moved_block(small_block, crs, place, own)
    if change is not None:
        replaced(small_block, *change)
    found = find_problems(small_block.path)
    said = [*map(str, found.problems), *found.notes]
    assert any(CODE.search(text) for text in said), said
    assert [code for text in said for code in unnamed(text)] == []


@pytest.mark.parametrize("names", ["easting,northing", "longitude,latitude"])
def test_what_is_said_of_columns_names_their_system(names, small_block):
    moved_block(small_block, "EPSG:31255", SALZBURG, "EPSG:4312")
    one, two = names.split(",")
    other = f"{two},{one}" if one == "longitude" else names
    small_block.replace(CONTROL, "longitude,latitude", other)
    (problem, *_) = find_problems(small_block.path).problems
    assert "MGI (EPSG:4312)" in str(problem)
    assert unnamed(str(problem)) == []


def test_what_is_said_of_results_in_another_system_names_both(demo_block):
    from dataclasses import replace

    for block, output in (
        (demo_block, "EPSG:25833"),
        (demo_block, "EPSG:31254"),
        (demo_block, "EPSG:4258"),
        (replace(demo_block, crs=None), "EPSG:25833"),
    ):
        with pytest.raises(es.EinschaltError) as caught:
            es.densify(block, es.Settings(output_crs=output))
        assert CODE.search(str(caught.value))
        assert unnamed(str(caught.value)) == []


def test_what_is_said_of_publications_names_their_systems(good_result, tmp_path):
    with pytest.raises(es.EinschaltError) as caught:
        publish_densification(good_result, "DEMO", tmp_path, source_crs="EPSG:2393")
    assert "KKJ / Finland Uniform Coordinate System (EPSG:2393)" in str(caught.value)
    facts = {"block": {"crs": "EPSG:31255"}, "output": {"crs": "EPSG:25833"}}
    facts |= {"program": "einschalt", "command": "densify"}
    (tmp_path / "provenance.json").write_text(json.dumps(facts), encoding="utf-8")
    with pytest.raises(es.EinschaltError) as caught:
        publish_folder(tmp_path, "DEMO", tmp_path / "out")
    assert "ETRS89 / UTM zone 33N (EPSG:25833), and its models" in str(caught.value)
    assert unnamed(str(caught.value)) == []
