"""Messages and figures of each language, and the catalogue that holds them."""

import ast
import inspect
import re
import string
from functools import cache
from itertools import count
from pathlib import Path

import pytest

from einschalt.foundations import language
from einschalt.foundations import typesetting as ts
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import (
    figure,
    language_of_locale,
    numbers_set,
    translated,
    written_in,
)
from einschalt.foundations.meanings_with_units import unit_and_meaning
from einschalt.interfaces.cli.main import COMMANDS

SOURCE = Path(language.__file__).parents[1]


# messages of templates and scripts of pages
WRITTEN_OUT = re.compile(r'\btranslated\("([^"\\]*)"')
MARKS = {"translated", "kept", "mark", "mark_each"}


@cache
def texts_of_sources():
    """Messages that are marked, and every other text, f-strings with numbered places.

    Errors and what results keep are told by such texts, where they are read.
    """
    marked, others = set(), set()
    for path in SOURCE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in MARKS:
                marked |= set(_constants(node.args[0]))
            elif isinstance(node, ast.JoinedStr):
                others.add(_with_numbered_places(node))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                # as it stands, as explain and help write a docstring, and a meaning
                # without its unit
                in_a_line = " ".join(node.value.split())
                others |= {node.value, in_a_line, unit_and_meaning(in_a_line)[1]}
                others.add(inspect.cleandoc(node.value))
    for path in (*SOURCE.rglob("*.j2"), *SOURCE.rglob("*.js")):
        marked |= set(WRITTEN_OUT.findall(path.read_text(encoding="utf-8")))
    return marked, others


def _constants(argument):
    """The message of a call, or those of a table."""
    texts = argument.values if isinstance(argument, ast.Dict) else [argument]
    return [text.value for text in texts if isinstance(text, ast.Constant)]


def _with_numbered_places(node):
    numbers = count()
    return "".join(
        _escaped(part.value)
        if isinstance(part, ast.Constant)
        else f"{{{next(numbers)}}}"
        for part in node.values
    )


def _escaped(text):
    return text.replace("{", "{{").replace("}", "}}")


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


@pytest.mark.slow
def test_every_message_has_a_german_entry_and_no_entry_is_unused():
    marked, others = texts_of_sources()
    german = set(in_po("de"))
    assert not sorted(marked - german)
    assert not sorted(german - marked - others)


def test_translations_keep_the_places_of_their_message():
    wrong = [
        (english, german)
        for english, german in in_po("de").values()
        if not all(german)
        or set().union(*map(places, english)) != set().union(*map(places, german))
    ]
    assert not wrong


def test_translations_write_places_as_their_message_does():
    for english, german in in_po("de").values():
        ways = {field: spec for _, field, spec, _ in parsed(english[0])}
        for _, field, spec, _ in parsed(german[0]):
            if "count" in spec or "|" in ways[field]:
                assert spec.count("|") == 1, german  # forms of the noun
            else:
                assert spec == ways[field], german


def parsed(message):
    return [part for part in string.Formatter().parse(message) if part[1]]


def test_the_compiled_catalogue_is_that_of_the_po_file():
    mofile = pytest.importorskip("babel.messages.mofile", reason="needs Babel")
    with (language.CATALOGUES / "de.mo").open("rb") as compiled:
        read = {
            forms(message.id)[0]: (forms(message.id), forms(message.string))
            for message in mofile.read_mo(compiled)
            if message.id
        }
    assert read == in_po("de")


def test_a_number_chooses_the_form_of_its_noun():
    message = "{n:new point|new points}"
    for n, english, german in (
        (0, "0 new points", "0 Neupunkte"),
        (1, "1 new point", "1 Neupunkt"),
        (26912, "26912 new points", "26\u202f912 Neupunkte"),
    ):
        assert translated(message, n=n) == english
        with written_in("de"):
            assert translated(message, n=n) == german


def test_texts_that_results_keep_are_recognised():
    kept = "1 common point, but affine needs 3"
    assert retold(kept) == kept
    with written_in("de"):
        assert retold(kept) == "1 gemeinsamer Punkt, affine braucht aber 3"
        assert retold("points P 1.5") == "points P 1.5"  # no message
        told = retold("Plan with --crs EPSG:31255, or reproject the raster")
        assert told.startswith("Mit --crs EPSG:31255 planen")
        asked = "low flight 1:8000, high flight 1:17000, 2 coverages, 250.5 m, 1"
        told = retold(f"{asked} pointing of 5 µm, 5 control points per model")
        assert told.startswith("Tiefflug 1:8000, Hochflug 1:17\u202f000, 2 Überd")
        assert "250,5 m" in told


def test_amounts_have_groups_and_names_of_digits_have_none():
    many = (
        "3 of 40 plans were not tried: their low flights would take more than 20000 "
        "models over this area. Split it into parts of at most 12.5 km² to have all of "
        "them tried."
    )
    with written_in("de"):
        assert "mehr als 20\u202f000 Modelle" in retold(many)
        assert retold("at most 20000, which cover 380 km²").startswith(
            "höchstens 20\u202f000, "
        )
        assert retold("point 20000") == "Punkt 20000"


def test_choices_and_lists_are_told_word_by_word():
    with written_in("de"):
        assert retold("two_step, simultaneous or auto").endswith(
            "simultaneous oder auto"
        )
        told = retold("holds control points, image points, and no model points")
        assert told == "enthält Passpunkte, Bildpunkte, aber keine Modellpunkte"
        # what has no entry is not told in two languages
        assert retold("the sky or the sea") == "the sky or the sea"
        # what a setting may be is typed as it is, also where it is a word of messages
        choice = "propagated or practice_1968 or off"
        assert retold(choice) == "propagated oder practice_1968 oder off"


def test_texts_put_together_are_read_so_that_least_english_is_left():
    """A message whose places are wide fits them as well, and leaves most of it."""
    told = {
        "a.csv, row 1: column 'y' is missing, found x, z; expected x, y, z": (
            "a.csv, Zeile 1: Spalte „y“ fehlt, gefunden x, z; erwartet: x, y, z"
        ),
        "The national survey may call it BETA.gsb. Name its folder with --grids, or "
        "grids in [settings]": (
            "Bei der Landesvermessung kann es BETA.gsb heißen. Seinen Ordner mit "
            "--grids oder unter grids in [settings] nennen"
        ),
        "A (EPSG:1) to B (EPSG:2): no operation is good enough; A to B (8): 0.14 m, "
        "needs b.tif, which is missing": (
            "A (EPSG:1) nach B (EPSG:2): keine Operation ist gut genug; A to B (8): "
            "0,14 m, braucht b.tif, das fehlt"
        ),
        "is no whole JSON: Expecting value: line 1 column 13 (char 12)": (
            "ist kein vollständiges JSON: ein Wert fehlt: Zeile 1, Spalte 13 "
            "(Zeichen 12)"
        ),
        "the worker has PROJ-data, version 1.20": (
            "der Prozess hat PROJ-data, Version 1.20"
        ),
        "m_0 = 7; expected 0.0001 to 100 (metres)": (
            "m_0 = 7; erwartet: 0,0001 bis 100 (Meter)"
        ),
    }
    with written_in("de"):
        assert {text: retold(text) for text in told} == told


def test_what_is_to_be_typed_stays_as_the_program_reads_it():
    """A German who is told to write 10 009,370 has written that already."""
    with written_in("de"):
        assert retold("'10009,370' has a decimal comma") == (
            "'10009,370' hat ein Dezimalkomma"
        )
        assert retold("Write 10009.370") == "10009.370 schreiben"
        # nor does what stands in a file look otherwise
        asked = (
            "y '13.000': is it 13.000 or 13000? The table has decimal commas, and its "
            "points may separate thousands"
        )
        assert retold(asked).startswith("y „13.000“: ist das ")


def test_figures_have_a_decimal_comma_and_groups_in_german():
    with written_in("de"):
        assert ts.length(0.0371) == "3,7 cm"
        assert ts.scale(8000.0) == "1:8000"  # four digits need no groups
        assert ts.fixed(5326127.48213, 3) == "5\u202f326\u202f127,482"
        assert ts.fixed(-0.25, 2) == "\N{MINUS SIGN}0,25"
        assert figure(1.5e-7) == "1,5e-07"
        assert numbers_set("models 8811-8936") == "models 8811-8936"
    assert ts.fixed(-0.25, 2) == "-0.25"
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
    with pytest.raises(SettingsError, match="'fr'; expected en or"), written_in("fr"):
        pass


FLOORS = ("foundations", "theory", "stages", "pipeline", "interfaces")
A_WORD = re.compile(r"[a-z] [a-z']|^[a-z]{4,}$")
PRINTS = {"print_out", "print_error"}


def modules_of(place):
    """A module, or all modules of a folder."""
    path = SOURCE / place
    return [path] if place.endswith(".py") else sorted(path.rglob("*.py"))


def nodes_of(place):
    for path in modules_of(place):
        yield from ast.walk(ast.parse(path.read_text(encoding="utf-8")))


def text_of(node):
    if isinstance(node, ast.JoinedStr):
        return _with_numbered_places(node)
    is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
    return node.value if is_text else ""


# what makes an error of a damaged file; its first argument is the file
REFUSALS = {"damaged", "_damaged"}


def texts_of_errors(place):
    for path in modules_of(place):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        named = assigned(tree)
        for call in ast.walk(tree):
            name = getattr(call.func, "id", "") if isinstance(call, ast.Call) else ""
            if name in REFUSALS:
                said = call.args[1:]
            elif name.endswith("Error"):
                said = call.args[:1]
            else:
                continue
            said += [k.value for k in call.keywords if k.arg in ("expected", "remedy")]
            texts = [text for node in said for text in texts_in(node, named)]
            yield from (text for text in texts if A_WORD.search(text))


def assigned(tree):
    """Values of each name of a module."""
    values = {}
    for node in ast.walk(tree):
        for target in node.targets if isinstance(node, ast.Assign) else ():
            pairs = [(target, node.value)]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs = zip(target.elts, node.value.elts, strict=False)
            for one, value in pairs:
                if isinstance(one, ast.Name):
                    values.setdefault(one.id, []).append(value)
    return values


def texts_in(node, named):
    """Texts of an expression: of both branches, and of what a name stands for."""
    if isinstance(node, ast.IfExp):
        return [*texts_in(node.body, named), *texts_in(node.orelse, named)]
    if isinstance(node, ast.Name):
        return [text_of(value) for value in named.get(node.id, ())]
    return [text_of(node)]


@pytest.mark.parametrize("floor", FLOORS)
def test_no_error_is_left_in_english(floor):
    german = set(in_po("de"))
    assert not sorted(set(texts_of_errors(floor)) - german)


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_prints_a_sentence_that_is_not_translated(command):
    said = [
        text_of(node.args[0])
        for node in nodes_of(f"interfaces/cli/work/{command}.py")
        if isinstance(node, ast.Call)
        and getattr(node.func, "id", "") in PRINTS
        and node.args
    ]
    assert not [text for text in said if A_WORD.search(text)]
