"""The words for every finding."""

from einschalt.foundations.language import translated
from einschalt.pipeline.summary.suggestion import Suggestion, filled
from einschalt.pipeline.summary.suggestions import (
    causes,
    claim,
    heights,
    iterations,
    known_points,
    models,
    notes,
    orientations,
    precision,
    suspects,
    systematic_errors,
)

MODULES = (
    causes,
    models,
    orientations,
    claim,
    precision,
    iterations,
    known_points,
    heights,
    suspects,
    systematic_errors,
    notes,
)
# of a finding by its code: a sentence to fill, or what makes it of the finding
WORDS = {code: words for module in MODULES for code, words in module.WORDS.items()}
REMEDIES = {"": ""} | {
    code: words for module in MODULES for code, words in module.REMEDIES.items()
}


def suggestion_of(finding) -> Suggestion:
    """Put a finding into words."""
    words = WORDS[finding.code]
    said = filled(words, finding) if isinstance(words, str) else words(finding)
    if isinstance(said, Suggestion):  # with details, or a remedy of its own
        return said
    remedy = REMEDIES[finding.remedy]
    details = causes.explained(finding.facts.get("explains", ()))
    return Suggestion(said, translated(remedy) if remedy else "", details=details)


def suggestions_of(findings) -> tuple[Suggestion, ...]:
    """Put findings into words, all but those that another one explains, and notes."""
    told = (f for f in findings if not f.explained_by and f.code not in notes.WORDS)
    return tuple(map(suggestion_of, told))


def notes_of(findings) -> tuple[Suggestion, ...]:
    """Put into words what was noted while a block was read: nothing is wrong there."""
    return tuple(suggestion_of(f) for f in findings if f.code in notes.WORDS)
