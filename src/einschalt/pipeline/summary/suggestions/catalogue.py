"""The words for every finding."""

from einschalt.pipeline.assessment.findings.catalogue import findings_of, judges_of
from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.suggestions import (
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
    """Put a finding into words.

    Parameters
    ----------
    finding : Finding

    Returns
    -------
    Suggestion
    """
    return WORDS[finding.code](finding)


def find_suggestions(result) -> tuple[Suggestion, ...]:
    """Say everything that the user of a result should know before using it.

    Parameters
    ----------
    result : DensificationResult

    Returns
    -------
    tuple of Suggestion
        The gravest first; empty where nothing was found.
    """
    return tuple(map(suggestion_of, findings_of(result, judges_of(result))))
