"""The report in German: complete, in its text and in its scripts."""

import base64
import json
import re
import zlib

import pytest
from tests.changed_results import judged_before
from tests.pipeline.summary.test_german_summary import DATA, ENGLISH

from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import written_in
from einschalt.interfaces.reports.html_report import render
from einschalt.interfaces.reports.page_templates import messages_of_scripts
from einschalt.stages.relative_orientation.image_orientation import EXCHANGED


def german_page(result):
    with written_in("de"):
        return render(result)


def head_of(html):
    """The JSON head of the data of a page."""
    packed = re.search(r'id="data">([^<]*)<', html)[1]
    data = zlib.decompress(base64.b64decode(packed))
    return json.loads(data[4 : 4 + int.from_bytes(data[:4], "little")])


def test_no_english_is_left_in_the_text_of_a_german_report(faulty_result):
    html = german_page(faulty_result)
    assert '<html lang="de">' in html
    text = re.sub(r"<(style|script).*?</\1>|<[^>]*>", " ", html, flags=re.DOTALL)
    labels = re.findall(r'aria-label="([^"]*)"', html)
    assert ENGLISH.findall(DATA.sub("", " ".join([text, *labels]))) == []


def test_why_an_orientation_is_doubted_is_german():
    """The reason is kept in English with the result, and shown in German."""
    with written_in("de"):
        assert retold(EXCHANGED).startswith("die Basis zeigt gegen x: linkes und")


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("affine", "affin"),
        ("helmert", "Helmert"),
        ("rigid", "maßstabstreu"),
        ("helmert_3d", "räumlich (Helmert)"),
    ],
)
def test_transformations_have_german_names(good_result, kind, name):
    models = good_result.models.assign(transformation=kind)
    html = german_page(judged_before(good_result, models=models))
    assert head_of(html)["models"]["fit"]["texts"] == [name]
    assert f"<td>{name}</td>" in html


def test_no_english_is_left_in_the_data_of_a_german_page(faulty_result):
    """But for words by which scripts know what a point is."""
    head = head_of(german_page(faulty_result))
    models = [head["models"][name]["texts"] for name in ("fit", "reason")]
    texts = [*models[0], *models[1], *head["plots"]["sources"]["names"]]
    assert any(models[1])
    assert [text for text in texts if ENGLISH.search(DATA.sub("", text))] == []
    assert "affine" not in texts


def test_scripts_find_every_message_in_the_data_of_the_page(faulty_result):
    head = head_of(german_page(faulty_result))
    assert head["language"] == "de"
    assert set(head["words"]) == set(messages_of_scripts())
    german = [re.sub(r"\{\w+", "", text) for text in head["words"].values()]
    assert [text for text in german if ENGLISH.search(text)] == []
    assert head_of(render(faulty_result))["words"] == {}
