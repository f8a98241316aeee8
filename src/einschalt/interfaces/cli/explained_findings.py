"""What findings are, apart from any block: for ``einschalt explain``."""

import inspect
import re
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from einschalt.foundations.language import mark_each, translated
from einschalt.pipeline.assessment import causes, findings
from einschalt.pipeline.assessment.findings.kinds import KINDS
from einschalt.pipeline.summary.suggestions.catalogue import REMEDIES

PLACE = f"{findings.__name__}."
# of those that have no sentence of their own
TITLES = mark_each(
    {
        "exchanged_names": "Exchanged names.",
        "drift_without_control": "Drift without control.",
        "iterations_that_spoil": "Iterations that spoil.",
        "drift_that_nothing_tells": "Drift that nothing tells.",
        "control_set_aside": "Control set aside.",
        "all_models_mirrored": "All models mirrored.",
        "note_of_reading": "Note of reading.",
    }
)
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
    """Explain a finding: what is judged, how grave it is, what may be done about it."""
    subject, gravity = KINDS[code]
    judge = judges()[code]
    facts = translated(
        "about: {subject}; gravity: {gravity}",
        subject=translated(SUBJECTS[subject.name]),
        gravity=translated(GRAVITIES[gravity.name]),
    )
    # a function for several findings, or within one, says nothing of each
    doc = inspect.getdoc(judge) if judge.__name__ == code else None
    said = translated(" ".join((doc or "").split()) or TITLES[code])
    title = translated("{code} (finding)", code=code)
    lines = [title, f"  {said}", f"  {facts}"]
    for one in _remedies_in(judge):
        remedy = translated("remedy: {remedy}.", remedy=translated(REMEDIES[one]))
        lines.append(f"  {remedy}")
    return "\n".join(line.replace("\n", "\n  ") for line in lines)


@cache
def judges():
    """The function that judges each finding, by its code.

    That of its name, or the one in which the code stands.
    """
    names = [one.name for one in iter_modules(findings.__path__, PLACE)]
    named, within = {}, {}
    for name in (causes.__name__, *names):
        for function in vars(import_module(name)).values():
            if inspect.isfunction(function) and function.__module__ == name:
                named[function.__name__.lstrip("_")] = function
                for word in re.findall(r'"(\w+)"', inspect.getsource(function)):
                    within[word] = function
    found = {code: named.get(code, within.get(code)) for code in KINDS}
    return {code: function for code, function in found.items() if function is not None}


def _remedies_in(judge):
    """Codes of the remedies that a judge names, itself or by a constant."""
    source, constants = inspect.getsource(judge), vars(inspect.getmodule(judge))
    words = dict.fromkeys(re.findall(r"\w+", source))
    named = (constants.get(word, word) for word in words)
    return [one for one in named if isinstance(one, str) and one and one in REMEDIES]
