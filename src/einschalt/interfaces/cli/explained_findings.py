"""What findings are, apart from any block: for ``einschalt explain``."""

import inspect
import re
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from einschalt.pipeline.assessment import causes, findings
from einschalt.pipeline.assessment.findings.kinds import KINDS
from einschalt.pipeline.summary.suggestions.catalogue import REMEDIES

PLACE = f"{findings.__name__}."


def explained_finding(code):
    """Explain a finding: what is judged, how grave it is, what may be done about it."""
    subject, gravity = KINDS[code]
    judge = judges()[code]
    facts = f"about: {subject.name.lower()}; gravity: {gravity.name.lower()}"
    # a function for several findings, or within one, says nothing of each
    doc = inspect.getdoc(judge) if judge.__name__ == code else None
    said = " ".join((doc or "").split()) or f"{code.replace('_', ' ').capitalize()}."
    lines = [f"{code} (finding)", f"  {said}", f"  {facts}"]
    lines += [f"  remedy: {REMEDIES[one]}." for one in _remedies_in(judge)]
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
