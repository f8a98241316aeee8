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
    lines += [
        translated("remedy: {remedy}.", remedy=translated(remedy))
        for remedy in _remedies(code)
    ]
    title = translated("{code} (finding)", code=code)
    return "\n  ".join([title, *(line.replace("\n", "\n  ") for line in lines)])


def facts_of_finding(code):
    """What a finding is, for programs."""
    subject, gravity = KINDS[code]
    return {
        "code": code,
        "meaning": translated(MEANINGS[code]),
        "about": translated(SUBJECTS[subject.name]),
        "gravity": translated(GRAVITIES[gravity.name]),
        "cause": translated(CAUSES[code]),
        "tested": translated(TESTS[code]),
        "remedies": [f"{translated(remedy)}." for remedy in _remedies(code)],
        "text": explained_finding(code),
    }


def known_remedies():
    """Sentence of each remedy by its code, without the empty one."""
    return {code: text for code, text in (REMEDIES | FURTHER_REMEDIES).items() if code}


def _remedies(code):
    """Remedies of a finding, without those with which a longer one begins."""
    known = known_remedies()
    texts = list(dict.fromkeys(known[one] for one in REMEDIES_OF[code]))
    return [
        text
        for text in texts
        if not any(other != text and other.startswith(text) for other in texts)
    ]
