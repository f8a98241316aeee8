"""Which judges look at a block, and the order in which their findings are told."""

from einschalt.pipeline.assessment.finding import Finding
from einschalt.pipeline.assessment.findings import (
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
from einschalt.pipeline.assessment.findings.kinds import KINDS

MODULES = (
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
TWO_STEP = tuple(judge for module in MODULES for judge in module.TWO_STEP)
SIMULTANEOUS = tuple(judge for module in MODULES for judge in module.SIMULTANEOUS)

ORDER = tuple(KINDS)
_RANK = {code: rank for rank, code in enumerate(ORDER)}


def findings_of(examined, judges) -> tuple[Finding, ...]:
    """Let judges look for everything that the user of a result should know.

    Each gives a finding, several in a tuple, or None. In the order of ORDER.
    """
    found = []
    for judge in judges:
        finding = judge(examined)
        if finding is not None:
            found += finding if isinstance(finding, tuple) else (finding,)
    return in_order(found)


def in_order(findings) -> tuple[Finding, ...]:
    """Sort findings as they are told."""
    return tuple(sorted(findings, key=lambda finding: _RANK[finding.code]))
