from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of


def test_notes_of_reading_are_passed_on_as_sentences():
    for note in ("low.csv: ignored column colour", "low.csv: ignored column colour. "):
        found = Finding("note_of_reading", Subject.BLOCK, facts={"note": note})
        assert str(suggestion_of(found)) == "low.csv: ignored column colour."
