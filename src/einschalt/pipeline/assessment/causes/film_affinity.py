"""Affinity of film as the cause of what else is found.

See docs/theory/systematic_patterns.md.
"""

from dataclasses import replace

from einschalt.foundations.errors import EinschaltError
from einschalt.pipeline.assessment.causes.kept_gross_errors import can_follow, is_small
from einschalt.pipeline.assessment.causes.ranked import with_consequences
from einschalt.pipeline.assessment.findings.catalogue import findings_of

FILM = "film_affinity"


def with_film_affinity(examined, judges, findings):
    """Put what is gone with affine models under an affinity of film, and tell it first.

    A small block is computed once more with such models.
    """
    cause = next((found for found in findings if found.code == FILM), None)
    if cause is None or cause.explained_by or not is_small(examined.two_step):
        return findings
    block = examined.block
    affine = {
        name: replace(getattr(block, name), transformation="affine")
        for name in cause.names
    }
    try:
        again = examined.computed_again(replace(block, **affine))
        remaining = {found.code for found in findings_of(again, judges)}
    except EinschaltError:  # too few points for such models
        return findings
    explained = tuple(
        found.code
        for found in findings
        if can_follow(found) and found.code not in {FILM, *remaining}
    )
    if not explained:
        return findings
    findings = with_consequences(cause, findings, explained)
    return tuple(sorted(findings, key=lambda found: found.code != FILM))
