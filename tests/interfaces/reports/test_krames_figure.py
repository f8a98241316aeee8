"""The figure of Krames' construction: valid, deterministic, and true to its numbers."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pytest
from tests.pipeline.summary.test_german_summary import DATA, ENGLISH

from einschalt.foundations.errors import GeometryError, TableError
from einschalt.foundations.language import written_in
from einschalt.interfaces.reports.krames_figure import krames_figure
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)
from einschalt.theory.relative_orientation.hallert import flat_six_points
from einschalt.theory.relative_orientation.parallax_equations import (
    INDEPENDENT,
    design_matrix,
)

SVG = "{http://www.w3.org/2000/svg}"
BASE = 92.0
TRUTH = np.array([1.2e-3, -4e-4, 6e-4, -1.1e-3, -1.4e-3])


def six_points(model_id="7/8", seed=3, sigma=0.008, elements=TRUTH):
    rng = np.random.default_rng(seed)
    xyz = flat_six_points(95.0, BASE, 152.0)
    xyz[:, 1:] += rng.uniform(-15.0, 15.0, (6, 2))
    table = pd.DataFrame(xyz, columns=["x", "y", "z"])
    parallax = design_matrix(xyz, BASE, INDEPENDENT) @ elements
    parallax = parallax + rng.normal(scale=sigma, size=6) if sigma else parallax
    return table.assign(model_id=model_id, point_id=list("135246"), y_parallax=parallax)


def drawn(table, model_id="7/8", **options):
    oriented = orient_from_parallaxes(table, BASE)
    return oriented, krames_figure(oriented, table, model_id, **options)


def texts(svg):
    return ["".join(node.itertext()) for node in ET.fromstring(svg).iter(f"{SVG}text")]


def test_figure_is_valid_xml_with_a_title_and_comes_out_equal():
    table = six_points("7/8 <&>")
    _, svg = drawn(table, "7/8 <&>")
    root = ET.fromstring(svg)
    assert root.tag == f"{SVG}svg"
    assert root.find(f"{SVG}title").text == "Krames' construction for model 7/8 <&>"
    ids = [node.get("id") for node in root.iter() if node.get("id")]
    assert len(ids) == len(set(ids))
    assert all(name.startswith("krames-") for name in ids)
    assert svg == drawn(table, "7/8 <&>")[1]
    assert "<metadata" not in svg
    assert len(svg) < 60_000


def test_figure_says_what_was_found():
    table = six_points()
    oriented, svg = drawn(table.sample(frac=1.0, random_state=1))
    said = texts(svg)
    assert [text for text in said if text in list("135246")] == list("135246")
    assert {"G⁰", "Gᵇ"} <= set(said)
    for parallax in table["y_parallax"]:
        sign = "+" if parallax > 0.0 else "−"
        assert any(
            re.fullmatch(rf"{re.escape(sign)}[\d.]+", text)
            and float(text[1:]) == pytest.approx(abs(parallax), rel=0.005)
            for text in said
        )
    foot = next(text for text in said if text.startswith("Contradiction"))
    w, sigma_0 = oriented.contradiction.loc["7/8", "w"], oriented.sigma_0["7/8"]
    found = re.search(r"w = ([+−])([\d.]+),  σ₀ = \|w\|/√12 = ([\d.]+)", foot)
    assert float(found[2]) == pytest.approx(abs(w), rel=0.005)
    assert (found[1] == "+") == (w > 0.0)
    assert float(found[3]) == pytest.approx(sigma_0, rel=0.05)


def test_fundamental_points_off_the_sheet_are_said():
    nearly = six_points(sigma=0.0, elements=TRUTH * [0.02, 1, 1, 1, 1])
    said = " ".join(texts(drawn(nearly)[1]))
    assert re.search(r"G⁰ lies off the sheet, at y = [+−]\d+, z = [+−]\d+", said)
    without = six_points(sigma=0.0, elements=TRUTH * [0, 1, 1, 1, 1])
    said = " ".join(texts(drawn(without)[1]))
    assert "G⁰ lies at infinity: the plane shows no tilt" in said
    assert "Gᵇ lies at infinity" in said
    assert "dω⁰ = 0 gon" in said


def test_figure_of_one_of_two_coverages():
    one, other = six_points(seed=4), six_points(seed=5)
    both = pd.concat([one.assign(coverage="A"), other.assign(coverage="B")])
    oriented, svg = drawn(both, coverage="B")
    assert svg == drawn(other)[1]
    with pytest.raises(TableError, match="coverages A, B each have this model"):
        krames_figure(oriented, both, "7/8")


def test_models_without_the_construction_are_said():
    table = pd.concat(
        [six_points(), six_points("aside").assign(x=lambda t: t["x"] + 1)]
    )
    oriented = orient_from_parallaxes(table, BASE)
    with pytest.raises(
        GeometryError,
        match="model aside: it has no three points in each of the planes x = 0 and x =",
    ):
        krames_figure(oriented, table, "aside")
    with pytest.raises(TableError, match="model 9/9: there is no such model"):
        krames_figure(oriented, table, "9/9")


def test_the_figure_is_german_where_german_is_asked_for():
    with written_in("de"):
        _, svg = drawn(six_points())
    said = " ".join(texts(svg))
    assert not ENGLISH.search(DATA.sub("", said))
    assert not re.search(r"\d\.\d", said)
    assert "Widerspruch dω⁰ − dωᵇ = " in said
