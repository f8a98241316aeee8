"""What ``explain`` knows: every value of a setting, every finding, no LaTeX."""

import ast
import inspect
import json
import re
from itertools import permutations
from pathlib import Path

import pytest

from einschalt.foundations.language import catalogue, written_in
from einschalt.foundations.meanings_with_units import unit_and_meaning
from einschalt.foundations.result_figure_meanings import OF_BLOCKS, OF_DENSIFY
from einschalt.foundations.result_files.meanings import names_with_values
from einschalt.foundations.term_meanings import MEANINGS as TERMS
from einschalt.interfaces.cli.explained_findings import (
    GRAVITIES,
    SUBJECTS,
    explained_finding,
    known_remedies,
)
from einschalt.interfaces.cli.finding_meanings import CAUSES, MEANINGS
from einschalt.interfaces.cli.finding_tests import (
    FURTHER_REMEDIES,
    REMEDIES_OF,
    TESTS,
)
from einschalt.interfaces.cli.setting_meanings import KEYS, VALUES
from einschalt.interfaces.files import block_toml, camera_toml
from einschalt.interfaces.files.glossary import entries
from einschalt.interfaces.provenance import figures_of
from einschalt.pipeline.assessment import causes, findings
from einschalt.pipeline.assessment.findings.kinds import KINDS
from einschalt.pipeline.block.block import Flight
from einschalt.pipeline.settings import TOLERANCES, Settings, words_of
from einschalt.pipeline.summary.suggestions.catalogue import REMEDIES

OF_FLIGHTS = ("transformation", "orientation_case", "orientation_method", "model_unit")
PAIRS = [(name, value) for name, values in VALUES.items() for value in values]


def allowed(name):
    """Words that a key of block.toml may have, from what checks it."""
    if name == "tolerance":
        return set(TOLERANCES)
    if name in Settings.model_fields:
        return set(words_of(name))
    if name == "convention":
        return set(camera_toml.CONVENTIONS)
    said = re.search(rf"^ *{name} : \{{(.*)\}}", inspect.getdoc(Flight), re.MULTILINE)
    return set(re.findall(r'"(\w+)"', said[1]))


def test_every_value_of_every_setting_has_a_meaning():
    named = {name for name in Settings.model_fields if allowed(name)}
    assert set(VALUES) == named | {*OF_FLIGHTS, "convention"}
    assert set(OF_FLIGHTS) <= set(block_toml.FlightSection.model_fields)
    for name, values in VALUES.items():
        assert set(values) == allowed(name), name


@pytest.mark.parametrize("name", [*Settings.model_fields, *KEYS])
def test_every_setting_is_explained(name, invoke):
    shown = invoke("explain", name)
    assert shown.exit_code == 0
    for value, meaning in VALUES.get(name, {}).items():
        assert f"\n  {value}: {meaning}\n" in f"{shown.stdout}\n"
    known = Settings.model_fields.get(name)
    said = KEYS[name] if known is None else known.description
    assert f"{name} (setting)\n  {said}\n" in shown.stdout


@pytest.mark.parametrize(("name", "value"), PAIRS)
def test_every_value_is_explained(name, value, invoke):
    if value == "all":  # lists everything that is explained
        assert f"\n  {name}: all, most_central\n" in invoke("explain", "all").stdout
        return
    shown = invoke("explain", value).stdout
    assert f"{value} (value of {name})\n  {VALUES[name][value]}\n" in shown


def test_every_meaning_is_of_a_term():
    assert set(TERMS) <= {
        words for one in entries() for words in (one.english, one.cells["English"])
    }


def test_a_total_is_not_told_as_the_error_of_a_coordinate(invoke):
    shown = " ".join(invoke("explain", "m_0").stdout.split())
    assert "of both coordinates together" in shown
    assert "Error of one measured coordinate" in invoke("explain", "s_0").stdout
    assert "densification" in invoke("explain", "Einschaltung").stdout


@pytest.mark.parametrize("word", ["Passpunkt", "control point"])
def test_a_term_is_told_in_a_sentence(word, invoke):
    shown = " ".join(invoke("explain", word).stdout.split())
    assert f"{TERMS['control point']} German: Passpunkt, Passp." in shown
    meaning = catalogue("de").gettext(TERMS["control point"])
    shown = invoke("--language", "de", "explain", word).stdout
    assert f"{meaning} Englisch: control point" in " ".join(shown.split())


@pytest.mark.parametrize(
    ("language", "heading"),
    [
        ("en", "coverage, cov. (Points, flights, models)"),
        ("de", "Überdeckung, Deckung, Überd. (Punkte, Flüge, Modelle)"),
    ],
)
def test_the_heading_of_a_term_is_in_the_language_of_the_reader(
    invoke, language, heading
):
    shown = invoke("--language", language, "explain", "coverage").stdout
    assert shown.startswith(f"{heading}\n")
    terms = invoke("--language", language, "explain", "all").stdout
    assert f"\n  {heading.partition(' (')[0]}\n" in terms


def test_what_stands_in_brackets_is_no_part_of_the_heading(invoke):
    shown = invoke("explain", "coverage").stdout
    assert "\n  one flight over the whole area\n  German: Überdeckung" in shown


def test_values_are_explained_in_german():
    known = catalogue("de")._catalog
    texts = [text for values in VALUES.values() for text in values.values()]
    assert not [text for text in (*texts, *KEYS.values()) if text not in known]


@pytest.mark.parametrize(
    ("word", "beginning"),
    [
        ("Outliers", "outliers (setting)"),
        ("two-step", "two-step method"),
        ("two_step", "two-step method"),
        ("Helmert", "similarity, Helmert transformation"),
        ("Kovarik", "Kovarik (Methods and their authors)"),
        ("Baarda", "Baarda (Methods and their authors)"),
        ("huber", "robust estimation"),
    ],
)
def test_words_that_users_missed(word, beginning, invoke):
    assert invoke("explain", word).stdout.startswith(beginning)


def test_a_word_that_is_meant_is_one_that_is_explained(invoke):
    """``Helmrt`` was told to be written 'helmert: a', which is no word."""
    said = invoke("explain", "Helmrt").stderr
    meant = re.search("Write '(.*)'", said)[1]
    assert invoke("explain", meant).exit_code == 0
    assert "helmert: a" not in {word for one in entries() for word in one.words}


def test_no_term_is_printed_in_latex_or_markdown():
    for one in entries():
        assert not re.search(r"[$\\`{}^]", one.text), one.text
    by_title = {one.title: one.text for one in entries()}
    assert "m_0 = √2 s_0" in by_title["mittlerer Einheits-Einpassfehler"]
    assert "dω_1 − dω_2" in by_title["Differenzkippung"]


def test_json_names_the_kind_of_what_was_found(invoke):
    figures = json.loads(invoke("explain", "tukey", "--json").stdout)["figures"]
    assert set(figures) == {"term", "setting"}
    assert figures["setting"][0]["text"].startswith("tukey (value of outliers)")


def test_json_has_parts_of_what_is_explained(invoke):
    def told(word):
        return json.loads(invoke("explain", word, "--json").stdout)["figures"]

    term = told("coverage")["term"][0]
    assert term["title"].startswith("Überdeckung")
    assert (term["code"], term["unit"]) == ("coverage, n_coverages", None)
    (column,) = told("coverage")["column"]
    first = column["tables"][0]
    assert (first["table"], first["of"]) == ("model_points", "block")
    assert first["needed"] == "no (1 if omitted)"
    assert column["words"]["de"] == ["ueberdeckung", "befliegung", "deckung"]
    (finding,) = told("strained_network")["finding"]
    assert (finding["about"], finding["gravity"]) == ("control", "grave")
    assert len(finding["remedies"]) == 1
    (figure,) = told("percentile_95")["figure"]
    assert figure["places"][0]["unit"] == "m"
    printed = invoke("explain", "coverage").stdout
    assert all(one["text"] in printed for one in told("coverage")["term"])


@pytest.mark.parametrize("code", KINDS)
def test_a_finding_has_meaning_cause_test_and_remedy(code, invoke):
    shown = invoke("explain", code).stdout.splitlines()
    shown = shown[shown.index(f"{code} (finding)") :]
    subject, gravity = KINDS[code]
    words = SUBJECTS[subject.name], GRAVITIES[gravity.name]
    about = "  about: {}; gravity: {}".format(*words)
    assert shown[1:3] == [f"  {MEANINGS[code]}", about]
    assert shown[3:5] == [f"  cause: {CAUSES[code]}", f"  tested: {TESTS[code]}"]
    remedies = [line for line in shown if line.startswith("  remedy: ")]
    assert 0 < len(remedies) <= len(REMEDIES_OF[code])
    texts = [text.rstrip(".") for text in remedies]
    assert not any(b.startswith(a) for a, b in permutations(texts, 2))  # said twice
    for text in (MEANINGS[code], CAUSES[code], TESTS[code]):
        assert len(text.split()) > 3
        assert text.endswith(".")


def test_tables_of_findings_are_whole():
    for table in (MEANINGS, CAUSES, TESTS, REMEDIES_OF):
        assert list(table) == list(KINDS)
    named = {one for codes in REMEDIES_OF.values() for one in codes}
    assert named - set(REMEDIES) == set(FURTHER_REMEDIES)
    assert set(REMEDIES) - {""} <= named


def test_german_of_findings_is_whole():
    known = catalogue("de")._catalog
    texts = [text for table in (MEANINGS, CAUSES, TESTS) for text in table.values()]
    assert not [text for text in texts if text not in known]
    with written_in("de"):
        assert "Ursache: " in explained_finding("failed_models")


def remedies_where_made():
    """Remedies that a judge gives to a finding where it makes it, written out."""
    folder = Path(findings.__file__).parent
    found = {}
    for path in (Path(causes.__file__), *folder.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call) or not node.args:
                continue
            code = getattr(node.args[0], "value", None)
            said = [one.value for one in node.keywords if one.arg == "remedy"]
            if code in KINDS and said:
                words = [getattr(one, "value", "") for one in ast.walk(said[0])]
                found[code] = {one for one in words if isinstance(one, str) and one}
    return found


def test_remedies_are_those_that_judges_give():
    """What a table says is compared with sources here, and not when explain runs."""
    made = remedies_where_made()
    assert len(made) > 40
    for code, remedies in made.items():
        assert remedies & set(REMEDIES) <= set(REMEDIES_OF[code]), code


def test_what_stands_for_a_column_that_is_omitted_is_told(invoke):
    said = invoke("explain", "coverage").stdout
    assert "  model_points: coverage to which the model belongs [text], " in said
    assert "needed: no (1 if omitted)\n" in said
    assert "needed: no\n" in said
    assert "nötig: nein\n" in invoke("--language", "de", "explain", "coverage").stdout


def test_figures_of_results_are_explained(good_result, invoke):
    """18 of the 27 names in the JSON of densify were no words that are known."""
    for name in figures_of(good_result):
        assert invoke("explain", name).exit_code == 0, name
    (figure,) = json.loads(invoke("explain", "mean_total", "--json").stdout)["figures"][
        "figure"
    ]
    assert figure["places"][0]["place"] == "densify --json"
    assert figure["places"][0]["unit"] == "m"


def test_german_of_figures_of_results_is_whole():
    known = catalogue("de")._catalog
    for named in (OF_DENSIFY, OF_BLOCKS):
        texts = [unit_and_meaning(said)[1] for said in named.values()]
        assert not [text for text in texts if text not in known]


def test_names_in_files_of_results_are_explained(invoke):
    """94 of 168 names in both files of the demo block were no words."""
    # one of four: that each has a meaning, tests of the assessment show
    for name, words in list(names_with_values().items())[::4]:
        shown = invoke("explain", name)
        assert shown.exit_code == 0, name
        assert re.search(
            r"^  (assessment|provenance)\.json", shown.stdout, re.MULTILINE
        )
        assert not [word for word in words if f"\n    {word}: " not in shown.stdout]


def test_a_name_in_a_file_is_told_at_each_place_with_its_words(invoke):
    shown = invoke("explain", "reason").stdout
    # beside the columns of that name
    assert "  failures (result): why it was not used" in shown
    assert "  assessment.json, choice, better: why this method was selected\n" in shown
    assert "\n    only_way: the other method is not possible\n" in shown
    figures = json.loads(invoke("explain", "reason", "--json").stdout)["figures"]
    (figure,) = figures["figure"]
    by_place = {one["place"]: one for one in figure["places"]}
    assert by_place["assessment.json, better"]["values"]["only_way"] == (
        "the other method is not possible"
    )
    assert len(by_place) == 8
    assert "values" not in by_place["assessment.json, findings[].facts.reasons[]"]
    german = invoke("--language", "de", "explain", "reason").stdout
    assert "    only_way: das andere Verfahren ist nicht möglich\n" in german


def test_words_in_files_of_results_are_explained(invoke):
    shown = invoke("explain", "only_way").stdout
    place = "assessment.json, choice.reason, better.reason = only_way"
    assert f"  {place}: the other method is not possible\n" in shown
    for code, text in known_remedies().items():
        place = f"assessment.json, findings[].remedy = {code}"
        assert f"  {place}: {text}\n" in invoke("explain", code).stdout


def test_names_in_files_are_listed_and_found_when_misspelt(invoke):
    shown = invoke("explain", "all").stdout
    listed = shown.partition("Names in assessment.json and provenance.json\n")[2]
    assert "\n  normalized_square\n" in listed.partition("\n\n")[0]
    assert "\n  measure_again\n" in listed.partition("Remedies\n")[2]
    figures = json.loads(invoke("explain", "all", "--json").stdout)["figures"]
    assert figures["result_files"] == sorted(names_with_values())
    assert figures["remedies"] == sorted(known_remedies())
    said = invoke("explain", "normalised_square").stderr
    assert "Write 'normalized_square'" in said
