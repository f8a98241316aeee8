"""The summary in German: complete, and with the same figures."""

import re

import pytest

from einschalt.foundations.language import written_in
from einschalt.pipeline.summary.summary import summarize

ENGLISH = re.compile(r"\b(the|of|is|are|and|with|by|from|points?|models?)\b")
RESULTS = ("good", "faulty", "given_approximations", "unchecked")
# names of columns and settings, and what users have named
DATA = re.compile(r"\w*_\w+|\[\w+\]|Demo \(simulated\)|Given approximations")


@pytest.mark.parametrize("name", RESULTS)
def test_no_english_is_left_in_a_german_summary(name, request):
    result = request.getfixturevalue(f"{name}_result")
    text = result.summary(language="de")
    assert ENGLISH.findall(DATA.sub("", text)) == []


def test_figures_are_the_same_in_both_languages(faulty_result):
    english = re.findall(r"\d+(?:\.\d+)?", summarize(faulty_result))
    german = faulty_result.summary(language="de").replace("\u202f", "")
    german = [text.replace(",", ".") for text in re.findall(r"\d+(?:,\d+)?", german)]
    # words order them otherwise
    assert sorted(german) == sorted(english)


def test_the_summary_is_in_the_active_language(good_result):
    with written_in("de"):
        assert good_result.summary() == good_result.summary(language="de")
        assert good_result.summary(language="en") == summarize_in_english(good_result)
    assert good_result.summary() == summarize_in_english(good_result)


def summarize_in_english(result):
    with written_in("en"):
        return summarize(result)
