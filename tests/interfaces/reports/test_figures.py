"""Figures: valid, true to scale, deterministic, and small for many points."""

import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from tests.changed_results import judged_before

from einschalt.interfaces.reports.figures import block_map, precision_figure
from einschalt.interfaces.reports.map_sheet import map_sheet, round_down

SVG = "{http://www.w3.org/2000/svg}"


def texts(svg):
    return ["".join(node.itertext()) for node in ET.fromstring(svg).iter(f"{SVG}text")]


def enlarged(result, n_points):
    """The result with many points, spread over the same area."""
    rng = np.random.default_rng(0)
    base = result.points
    low, high = (
        base[["easting", "northing"]].agg(side).to_numpy() for side in ("min", "max")
    )
    place = rng.uniform(low, high, (n_points, 2))
    rows = rng.integers(0, len(base), n_points)
    points = base.iloc[rows].reset_index(drop=True)
    points["point_id"] = [f"{k}" for k in range(n_points)]
    points[["easting", "northing"]] = place
    error = rng.normal(0.0, 0.03, (2 * n_points, 2))
    values = pd.concat([points.assign(coverage=name) for name in "12"])
    values[["easting", "northing"]] += error
    parts = {name: part[rows] for name, part in result.errors.parts.items()}
    errors = replace(result.errors, point_ids=points["point_id"], parts=parts)
    return judged_before(result, points=points, single_values=values, errors=errors)


@pytest.mark.parametrize("draw", [block_map, precision_figure])
def test_figures_are_valid_xml_with_a_title(draw, good_result):
    svg = draw(good_result)
    root = ET.fromstring(svg)
    assert root.tag == f"{SVG}svg"
    assert root.find(f"{SVG}title").text
    assert root.get("role") == "img"
    ids = [node.get("id") for node in root.iter() if node.get("id")]
    assert len(ids) == len(set(ids))


@pytest.mark.parametrize("draw", [block_map, precision_figure])
def test_figures_carry_no_date_and_come_out_equal(draw, good_result):
    svg = draw(good_result)
    assert svg == draw(good_result)
    assert "<metadata" not in svg
    assert not re.search(r"\b20\d\d-\d\d-\d\d", svg)


def test_references_stay_within_their_figure(good_result):
    for name, svg in (
        ("map", block_map(good_result)),
        ("precision", precision_figure(good_result)),
    ):
        ids = set(re.findall(r'\bid="([^"]+)"', svg))
        used = set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', svg))
        assert {first or second for first, second in used} <= ids
        assert all(one.startswith(f"{name}-") for one in ids)


def test_map_says_roles_scale_and_exaggeration(good_result):
    said = texts(block_map(good_result))
    assert {"new points", "control points", "check points"} <= set(said)
    assert {"Easting [km]", "Northing [km]"} <= set(said)
    assert any(re.fullmatch(r"\d+ k?m \(map\)", text) for text in said)
    assert any(re.fullmatch(r".+ cm \(vectors × \d+\)", text) for text in said)
    assert "control points: densified − given" in said
    assert "new points: coverage 1 − 2" in said


def test_both_axes_have_the_same_scale_and_north_is_up(good_result):
    sheet = map_sheet(good_result.points)
    (west, east), (south, north) = sheet.axes.get_xlim(), sheet.axes.get_ylim()
    assert west < east
    assert south < north
    width, height = sheet.axes.get_position().size * sheet.figure.get_size_inches()
    assert (east - west) / width == pytest.approx((north - south) / height, rel=1e-12)
    assert sheet.m_per_in == pytest.approx(1e3 * (east - west) / width, rel=1e-12)


@pytest.mark.parametrize("draw", [block_map, precision_figure])
def test_many_points_become_an_image(draw, good_result):
    svg = draw(enlarged(good_result, 50_000))
    assert "data:image/png;base64," in svg
    assert len(svg) < 4e6
    assert "data:image" not in draw(good_result)


def test_vectors_of_many_points_are_thinned_and_that_is_said(good_result):
    said = texts(block_map(enlarged(good_result, 20_000)))
    assert any(re.match(r"new points, 1 in \d+: coverage 1 − 2", text) for text in said)


def test_names_are_not_read_as_formulas(good_result):
    values = good_result.single_values.assign(
        coverage=lambda v: v["coverage"] + " $\\frac <b>"
    )
    said = texts(block_map(judged_before(good_result, single_values=values)))
    assert "new points: coverage 1 $\\frac <b> − 2 $\\frac <b>" in said


@pytest.mark.parametrize(
    "points",
    [
        pd.DataFrame({"easting": [1.0], "northing": [2.0]}),
        pd.DataFrame({"easting": [0.0, 9e3], "northing": [5.0, 5.0]}),
    ],
    ids=["one point", "a line"],
)
def test_blocks_without_extent_still_have_a_map(points, good_result):
    facts = good_result.points.iloc[: len(points)].reset_index(drop=True)
    changed = facts.assign(role="new", **points.to_dict("list"))
    result = judged_before(good_result, points=changed, errors=None)
    ET.fromstring(block_map(result))
    ET.fromstring(precision_figure(result))


def test_no_points_no_figure(good_result):
    empty = judged_before(good_result, points=good_result.points.iloc[:0], errors=None)
    assert block_map(empty) == ""
    assert precision_figure(empty) == ""


def test_one_coverage_has_no_vectors_at_new_points(good_result):
    values = good_result.single_values
    result = judged_before(good_result, single_values=values[values["coverage"] == "1"])
    assert not any("coverage" in text for text in texts(block_map(result)))


@pytest.mark.parametrize(
    ("value", "expected"), [(1.0, 1.0), (0.99, 0.5), (2999.0, 2000.0), (3e-5, 3e-5)]
)
def test_round_down(value, expected):
    assert round_down(value) == expected


def test_settings_of_matplotlib_play_no_part(good_result):
    """As a matplotlibrc makes them, in the folder where the program is started."""
    plain = block_map(good_result)
    with mpl.rc_context({"text.usetex": True, "lines.linewidth": 9.0}):
        assert block_map(good_result) == plain
