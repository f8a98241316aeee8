"""What findings are, apart from any block: for ``einschalt explain``."""

from einschalt.foundations.language import mark_each, translated
from einschalt.interfaces.cli.finding_meanings import CAUSES, MEANINGS
from einschalt.interfaces.cli.finding_tests import (
    FURTHER_REMEDIES,
    REMEDIES_OF,
    TESTS,
)
from einschalt.pipeline.assessment.findings.kinds import KINDS
from einschalt.pipeline.summary.suggestions.catalogue import REMEDIES

SUBJECTS = mark_each(
    {
        "POINT": "point",
        "MODEL": "model",
        "FLIGHT": "flight",
        "BLOCK": "block",
        "MEASUREMENT": "measurement",
        "CONTROL": "control",
    }
)
GRAVITIES = mark_each({"GRAVE": "grave", "NOTE": "note", "WARNING": "warning"})


def explained_finding(code):
    """Explain a finding: what it is, its cause, what is tested, what may be done."""
    subject, gravity = KINDS[code]
    facts = translated(
        "about: {subject}; gravity: {gravity}",
        subject=translated(SUBJECTS[subject.name]),
        gravity=translated(GRAVITIES[gravity.name]),
    )
    lines = [
        translated(MEANINGS[code]),
        facts,
        translated("cause: {cause}", cause=translated(CAUSES[code])),
        translated("tested: {tested}", tested=translated(TESTS[code])),
    ]
    known = REMEDIES | FURTHER_REMEDIES
    for one in REMEDIES_OF[code]:
        remedy = translated(known[one])
        lines.append(translated("remedy: {remedy}.", remedy=remedy))
    title = translated("{code} (finding)", code=code)
    return "\n  ".join([title, *(line.replace("\n", "\n  ") for line in lines)])
