"""What a notebook shows of results and blocks without being asked for a figure."""

import html
import re
import sys
from dataclasses import replace

import numpy as np
import pytest
import shapely
from tests.changed_results import changed, judged_before
from tests.pipeline.summary.test_german_summary import DATA, ENGLISH

import einschalt as es
from einschalt.foundations.language import written_in
from einschalt.interfaces.files.result_folder import render, write_report
from einschalt.interfaces.notebook.cards import block_card, result_card
from einschalt.interfaces.notebook.geodataframe import points_with_geometry
from einschalt.pipeline.summary.suggestions.catalogue import suggestions_of
from einschalt.pipeline.summary.verdict import verdict

MARKUP = "<script>alert(1)</script> & sons"


def test_headline_comes_first_then_problems_then_figures(faulty_result):
    card = result_card(faulty_result)
    text = re.sub(r"<[^>]+>", "\n", card).split("\n")
    words = [line for line in text if line]
    assert words[0] == verdict(faulty_result.assessment)
    assert words[1].startswith("Exchanged names: ")
    n_problems = min(len(suggestions_of(faulty_result.assessment.findings)), 3)
    assert words[1 + n_problems] == "Precision of the new points (total, RMS)"
    assert len(card) < 6000


@pytest.mark.slow
def test_names_are_text_and_nothing_comes_from_elsewhere(good_result):
    block = replace(
        good_result.block, name=MARKUP, notes=tuple(f"{MARKUP} {k}" for k in "12345")
    )
    result = changed(good_result, block=block)
    for card in (result_card(result), block_card(block)):
        assert "&lt;script&gt;" in card
        assert not re.search(r"<script|src=|href=|http", card)
    assert "and 2 more notes" in block_card(block)


def test_the_card_of_a_block_counts_what_was_measured(demo_block):
    card = block_card(demo_block)
    known = demo_block.control_points["role"].value_counts()
    said = f"{known['control']} control points; {known['check']} check points"
    assert f"Demo (simulated): {said}</p>" in card
    low = demo_block.low_flight
    assert f">{low.n_models}</td>" in card
    assert ">1:8000</td>" in card
    assert "EPSG:31255" in card


def test_plans_that_were_laid_out_show_what_they_come_to_first():
    choices = es.PlanChoices(
        scale_number=(9000, 11000), spacing=(300,), m_g_um=(5,), n_coverages=(2,)
    )
    with written_in("de"):
        plan = es.plan_area(0.06, shapely.box(0, 0, 7000, 6000), choices)
        for one in (plan, plan.checked):
            card = one._repr_html_()
            head, rest = card.split("</p>")
            assert head.endswith(f">{html.escape(plan.checked.outcome())}")
            assert plan.checked.outcome()[:30] not in rest
            assert ("11 Flugstreifen" in rest) == (one is plan)
            assert ENGLISH.findall(DATA.sub("", re.sub(r"<[^>]+>", " ", card))) == []


@pytest.mark.slow
def test_cards_and_the_report_alone_are_german_where_it_is_asked_for(
    faulty_result, demo_block, tmp_path
):
    design = es.FlightDesign(scale_number=8000, spacing=300, m_g_um=5)
    expected = es.expect_precision(design)
    with written_in("de"):
        cards = (
            result_card(faulty_result),
            block_card(demo_block),
            expected._repr_html_(),
        )
    for card in cards:
        text = DATA.sub("", re.sub(r"<[^>]+>", " ", card))
        assert ENGLISH.findall(text) == []
        assert not re.search(r"\d\.\d", text)
    result = es.densify(demo_block)
    for language in ("en", "de"):
        path = tmp_path / f"{language}.html"
        result.report(path, language=language)
        assert f'<html lang="{language}">' in path.read_text(encoding="utf-8")
    with pytest.raises(es.EinschaltError, match="language = 'fr'; expected en or de"):
        result.report(tmp_path / "fr.html", language="fr")
    assert not (tmp_path / "fr.html").exists()


def test_representations_are_a_line(good_result, demo_block):
    assert repr(good_result) == (
        f"<DensificationResult {verdict(good_result.assessment)}>"
    )
    assert repr(demo_block) == (
        "<SimulatedBlock 'Demo (simulated)': 23 known points, 7 models of the high "
        "flight, 23 models of the low flight, EPSG:31255>"
    )
    assert repr(demo_block.low_flight) == (
        "<Flight 1:8000, affine, m_g 5.0 µm, "
        f"{len(demo_block.low_flight.model_points)} model points>"
    )
    # before anything is checked it may be anything
    assert "Flight 8000, affine, m_g None" in repr(
        es.Flight(scale_number="8000", m_g_um=None)
    )


def test_points_have_geometry_height_and_system(good_result):
    pytest.importorskip("geopandas", reason="geopandas is not installed")
    flat = points_with_geometry(good_result)
    assert flat.crs == "EPSG:31255"
    points = good_result.points
    np.testing.assert_array_equal(flat.geometry.x, points["easting"])
    np.testing.assert_array_equal(flat.geometry.y, points["northing"])
    assert not flat.geometry.has_z.any()
    assert list(flat.columns) == [*points.columns, "geometry"]
    known = np.arange(len(points)) > 1
    raised = points.assign(height=np.where(known, 700.0, np.nan))
    raised.loc[raised.index[0], "easting"] = np.nan
    spatial = judged_before(good_result)
    vars(spatial)["points"] = raised
    geometry = points_with_geometry(spatial).geometry
    np.testing.assert_array_equal(geometry.has_z, known)
    assert geometry.iloc[0] is None
    assert (geometry[known].z == 700.0).all()


def test_without_geopandas_it_is_said_how_it_is_had(good_result, monkeypatch):
    monkeypatch.setitem(sys.modules, "geopandas", None)
    with pytest.raises(es.EinschaltError, match=r"pip install '\.\[notebook\]'"):
        points_with_geometry(good_result)


def test_a_report_is_named_as_the_page_that_it_is(good_result, tmp_path):
    """rep.txt held HTML, without a word."""
    said = r"'\.txt' is no suffix of a report.* Name it rep\.html\.$"
    with pytest.raises(es.EinschaltError, match=said):
        write_report(good_result, tmp_path / "rep.txt")
    assert list(tmp_path.iterdir()) == []


def test_the_report_alone_is_a_page_that_loses_nothing(good_result, tmp_path):
    path = tmp_path / "report.html"
    write_report(good_result, path)
    assert path.read_text(encoding="utf-8") == render(good_result)
    path.write_text("mine", encoding="utf-8")
    said = r"there is a file of this name.*\(in Python overwrite=True\)"
    with pytest.raises(es.EinschaltError, match=said):
        write_report(good_result, path)
    write_report(good_result, path, overwrite=True)
    assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
