"""Messages and figures of each language, and the catalogue that holds them."""

import ast
import io
import string
from gettext import GNUTranslations
from pathlib import Path

import pytest

from einschalt.foundations import language
from einschalt.foundations import typesetting as ts
from einschalt.foundations.language import figure, language_of_locale, written_in

SOURCE = Path(language.__file__).parents[1]


def messages_of_sources():
    """Every message that is written out in a call; of plurals the English singular."""
    return {
        node.args[0].value
        for path in SOURCE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in {"translated", "plural", "mark"}
        and isinstance(node.args[0], ast.Constant)
    }


def in_po(name):
    """Forms of each message in the language, by the English text or singular."""
    pofile = pytest.importorskip("babel.messages.pofile", reason="needs Babel")
    text = (language.CATALOGUES / f"{name}.po").read_text(encoding="utf-8")
    read = pofile.read_po(text.splitlines(keepends=True), abort_invalid=True)
    return {
        forms(message.id)[0]: (forms(message.id), forms(message.string))
        for message in read
        if message.id
    }


def forms(texts):
    return (texts,) if isinstance(texts, str) else tuple(texts)


def places(message):
    return {field for _, field, _, _ in string.Formatter().parse(message) if field}


def test_every_message_has_a_german_entry_and_no_entry_is_unused():
    assert set(in_po("de")) == messages_of_sources()


def test_translations_keep_the_places_of_their_message():
    wrong = [
        (english, german)
        for english, german in in_po("de").values()
        if not all(german)
        or set().union(*map(places, english)) != set().union(*map(places, german))
    ]
    assert not wrong


def test_the_compiled_catalogue_is_that_of_the_po_file():
    mofile = pytest.importorskip("babel.messages.mofile", reason="needs Babel")
    with (language.CATALOGUES / "de.mo").open("rb") as compiled:
        read = {
            forms(message.id)[0]: (forms(message.id), forms(message.string))
            for message in mofile.read_mo(compiled)
            if message.id
        }
    assert read == in_po("de")


def test_a_number_chooses_the_form_of_its_noun(monkeypatch):
    mofile = pytest.importorskip("babel.messages.mofile", reason="needs Babel")
    babel_catalogue = pytest.importorskip("babel.messages.catalog")
    catalogue = babel_catalogue.Catalog(locale="de")
    catalogue.add(("{n} point", "{n} points"), ("{n} Punkt", "{n} Punkte"))
    compiled = io.BytesIO()
    mofile.write_mo(compiled, catalogue)
    compiled.seek(0)
    german = GNUTranslations(compiled)
    monkeypatch.setattr(language, "_catalogue", lambda _name: german)
    for n, english, in_german in (
        (0, "0 points", "0 Punkte"),
        (1, "1 point", "1 Punkt"),
        (26912, "26912 points", "26\u202f912 Punkte"),
    ):
        assert language.plural("{n} point", "{n} points", n) == english
        with written_in("de"):
            assert language.plural("{n} point", "{n} points", n) == in_german


def test_figures_have_a_decimal_comma_and_groups_in_german():
    with written_in("de"):
        assert ts.length(0.0371) == "3,7 cm"
        assert ts.scale(8000.0) == "1:8000"  # four digits need no groups
        assert ts.fixed(5326127.48213, 3) == "5\u202f326\u202f127,482"
        assert ts.fixed(-0.25, 2) == "-0,25"
        assert figure(1.5e-7) == "1,5e-07"
    assert ts.length(0.0371) == "3.7 cm"


def test_messages_are_looked_up_when_they_are_written():
    with written_in("de"):
        assert ts.names(["7/8", "8/9", "9/10"], most=2) == "7/8, 8/9 und noch 1"
        with written_in("en"):
            assert ts.number_word(2) == "two"
        assert ts.number_word(2) == "zwei"
    assert ts.number_word(2) == "two"


def test_the_first_variable_that_is_set_decides_on_the_language():
    assert language_of_locale({"LC_MESSAGES": "de", "LANG": "en_GB.UTF-8"}) == "de"
    assert language_of_locale({"LC_ALL": "", "LANG": "de_DE@euro"}) == "de"
    assert language_of_locale({"LANG": "fr_FR.UTF-8"}) == "en"
    assert language_of_locale({}) == "en"


def test_an_unknown_language_is_refused():
    with pytest.raises(ValueError, match="'fr' is none of en, de"), written_in("fr"):
        pass
