"""Figure of residual parallaxes: valid, to scale, deterministic, never too tall."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pytest
from tests.pipeline.summary.test_german_summary import DATA, ENGLISH

from einschalt.foundations.language import written_in
from einschalt.interfaces.reports import parallax_figure as module
from einschalt.interfaces.reports.parallax_figure import parallax_figure

SVG = "{http://www.w3.org/2000/svg}"
BASE = 92.0


def residuals(n_models, n_points=15, seed=0):
    """Points and models as the figure takes them; model 1 holds a blunder."""
    rng = np.random.default_rng(seed)
    names = [f"{k}/{k + 1}" for k in range(n_models)]
    points = pd.DataFrame(
        {
            "model": np.repeat(names, n_points),
            "point_id": np.tile(np.arange(n_points).astype(str), n_models),
            "x": rng.uniform(0, BASE, n_models * n_points),
            "y": rng.uniform(-95, 95, n_models * n_points),
            "residual": rng.normal(scale=0.004, size=n_models * n_points),
            "standard_error": 0.005,
        }
    )
    verdicts = np.resize(["safe", "weak", "critical"], n_models)
    models = {"model": names, "base": BASE, "sigma_0": 0.0043, "verdict": verdicts}
    return points, pd.DataFrame(models)


def texts(svg):
    return ["".join(node.itertext()) for node in ET.fromstring(svg).iter(f"{SVG}text")]


def sheet_of(points, models, monkeypatch):
    kept, make = [], module._sheet
    monkeypatch.setattr(module, "_sheet", lambda *a: kept.append(make(*a)) or kept[0])
    parallax_figure(points, models)
    return kept[0]


@pytest.mark.parametrize("n_models", [1, 2, 5, 12, 40])
def test_valid_xml_that_comes_out_equal(n_models):
    given = residuals(n_models)
    svg = parallax_figure(*given)
    root = ET.fromstring(svg)
    assert root.tag == f"{SVG}svg"
    assert root.find(f"{SVG}title").text == "Residual parallaxes of the models"
    assert svg == parallax_figure(*given)
    assert "<metadata" not in svg
    assert not re.search(r"\b20\d\d-\d\d-\d\d", svg)


@pytest.mark.parametrize("n_models", [1, 2, 3, 5, 7, 12])
@pytest.mark.parametrize("shape", ["narrow", "wide", "line"])
def test_panels_fit_on_the_sheet_and_do_not_overlap(n_models, shape, monkeypatch):
    points, models = residuals(n_models)
    points["y"] *= {"narrow": 1.0, "wide": 0.2, "line": 0.0}[shape]
    sheet = sheet_of(points, models, monkeypatch)
    width, height = sheet.figure.get_size_inches()
    assert height < 8.0
    boxes = [axes.get_position() for axes in sheet.figure.axes]
    assert len(boxes) == n_models + 1
    for place, box in enumerate(boxes):
        assert box.x0 >= 0.0
        assert box.x1 <= 1.0 + 1e-9
        assert box.y0 >= -1e-9
        assert box.y1 <= 1.0
        for other in boxes[:place]:
            assert not box.shrunk(0.99, 0.99).overlaps(other.shrunk(0.99, 0.99))
    panel = sheet.figure.axes[0]
    (west, east), (south, north) = panel.get_xlim(), panel.get_ylim()
    box = boxes[0]
    scale = (box.width * width / (east - west), box.height * height / (north - south))
    assert scale[0] == pytest.approx(scale[1])


def test_strokes_have_the_length_and_the_side_of_the_residuals(monkeypatch):
    points, models = residuals(2)
    sheet = sheet_of(points, models, monkeypatch)
    for axes, name in zip(sheet.figure.axes, models["model"], strict=False):
        own = points[points["model"] == name]
        strokes = np.array(axes.collections[0].get_segments())
        np.testing.assert_allclose(strokes[:, 0], own[["x", "y"]])
        np.testing.assert_allclose(strokes[:, 1, 0], own["x"])
        np.testing.assert_allclose(
            strokes[:, 1, 1] - own["y"], own["residual"] * sheet.exaggeration
        )


def test_models_scales_and_verdicts_are_said():
    said = texts(parallax_figure(*residuals(3)))
    assert {"0/1", "1/2", "2/3"} <= set(said)
    assert "σ₀ 4.3 µm" in said
    assert "σ₀ 4.3 µm, weak" in said
    assert "σ₀ 4.3 µm, critical" in said
    assert any(re.fullmatch(r"\d+ mm in plan", text) for text in said)
    assert any(re.fullmatch(r"\d+ µm \(parallax × \d+\)", text) for text in said)
    assert not any("standard error" in text for text in said)


def test_large_residuals_are_told_apart():
    points, models = residuals(2)
    points.loc[20, "residual"] = -0.02
    assert "more than 3.29 times its standard error" in texts(
        parallax_figure(points, models)
    )


def test_of_many_models_those_with_the_largest_residuals_are_shown():
    points, models = residuals(40)
    points.loc[points["model"] == "33/34", "residual"] *= 5.0
    said = texts(parallax_figure(points, models))
    assert "33/34" in said
    assert sum(bool(re.fullmatch(r"\d+/\d+", text)) for text in said) == 12
    assert any("12 of 40 models" in text for text in said)


def test_few_points_of_few_models_are_named():
    said = texts(parallax_figure(*residuals(1, n_points=6)))
    assert {"0", "1", "2", "3", "4", "5"} <= set(said)


def test_nothing_to_draw_gives_nothing():
    points, models = residuals(2)
    assert parallax_figure(points.head(0), models) == ""
    assert parallax_figure(points.assign(residual=np.nan), models) == ""


def test_without_residuals_and_without_redundancy():
    # five points: the parallaxes vanish, and nothing is known of their errors
    points, models = residuals(1, n_points=5)
    svg = parallax_figure(
        points.assign(residual=0.0, standard_error=np.nan),
        models.assign(sigma_0=np.nan),
    )
    assert "σ₀" not in svg


def test_names_with_signs_of_formulas_are_text():
    points, models = residuals(1)
    for table in (points, models):
        table["model"] = "a$b^2$ <&>"
    assert "a$b^2$ <&>" in texts(parallax_figure(points, models))


def test_the_figure_is_german_where_german_is_asked_for():
    with written_in("de"):
        svg = parallax_figure(*residuals(14))
    said = " ".join(texts(svg))
    assert not ENGLISH.search(DATA.sub("", said))
    assert not re.search(r"\d\.\d", said)
    assert "kritisch" in said
