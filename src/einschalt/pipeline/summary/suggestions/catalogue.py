"""The words for every finding."""

from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.suggestions import (
    causes,
    claim,
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
    suspects,
    systematic_errors,
    notes,
)
WORDS = {code: words for module in MODULES for code, words in module.WORDS.items()}


def suggestion_of(finding) -> Suggestion:
    """Put a finding into words."""
    return WORDS[finding.code](finding)


def suggestions_of(findings) -> tuple[Suggestion, ...]:
    """Put findings into words, all but those that another one explains."""
    return tuple(suggestion_of(f) for f in findings if not f.explained_by)
