"""Every finding has words, and words know nothing but the finding."""

import ast
from pathlib import Path

import pytest
from tests.changed_results import changed

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.assessment.findings.catalogue import ORDER
from einschalt.pipeline.summary.suggestions import catalogue
from einschalt.pipeline.summary.suggestions.catalogue import (
    MODULES,
    WORDS,
    notes_of,
    suggestion_of,
    suggestions_of,
)

ROOM = Path(catalogue.__file__).parent
ALLOWED = (
    "einschalt.foundations.display_names",
    "einschalt.foundations.kept_texts",
    "einschalt.foundations.language",
    "einschalt.foundations.typesetting",
    "einschalt.pipeline.summary.",
)


def test_every_code_has_words_and_all_words_have_a_code():
    assert set(WORDS) == set(ORDER)
    assert sum(len(module.WORDS) for module in MODULES) == len(WORDS)


def imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


@pytest.mark.parametrize("path", sorted(ROOM.glob("*.py")), ids=lambda path: path.stem)
def test_words_compute_nothing(path):
    for module in imported(path):
        if path.stem == "catalogue" and module.endswith("findings.catalogue"):
            continue
        assert module == "math" or module.startswith(ALLOWED), module


def remedies_in(room):
    """Every text that a judge gives as a remedy."""
    for path in room.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.keyword) and node.arg == "remedy":
                for part in ast.walk(node.value):
                    if isinstance(part, ast.Constant) and isinstance(part.value, str):
                        yield part.value


def test_every_remedy_has_words():
    known = set().union(*(getattr(module, "REMEDIES", {}) for module in MODULES))
    judges = Path(catalogue.__file__).parents[2] / "assessment" / "findings"
    # of affinity the words name the flights; the others are put together
    others = {"set_affine", "one_pass_or_", "keep", ""}
    assert set(remedies_in(judges)) - others <= known


def test_a_finding_is_put_into_its_words():
    note = Finding("note_of_reading", Subject.BLOCK, facts={"note": "a note"})
    assert str(suggestion_of(note)) == "a note."


def test_a_good_block_has_no_problems(good_result):
    assert suggestions_of(good_result.assessment.findings) == ()


@pytest.mark.slow
def test_notes_of_reading_are_no_problems(unchecked_result):
    block = unchecked_result.block
    object.__setattr__(block, "notes", ("low.csv: ignored column colour", "two"))
    try:
        noted = changed(unchecked_result).assessment.findings
    finally:
        object.__setattr__(block, "notes", ())
    found = [str(note) for note in notes_of(noted)]
    assert found == ["low.csv: ignored column colour.", "two."]
    problems = suggestions_of(unchecked_result.assessment.findings)
    assert suggestions_of(noted) == problems != ()
