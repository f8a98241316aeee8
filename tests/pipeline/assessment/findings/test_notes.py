from types import SimpleNamespace

from einschalt.pipeline.assessment.findings.notes import notes_of_reading


def test_every_note_of_reading_is_a_finding():
    notes = ("low.csv: ignored column colour", "crs is missing.")
    found = notes_of_reading(SimpleNamespace(block=SimpleNamespace(notes=notes)))
    assert [finding.facts["note"] for finding in found] == list(notes)


def test_without_notes_there_is_none():
    assert notes_of_reading(SimpleNamespace(block=SimpleNamespace(notes=()))) == ()
