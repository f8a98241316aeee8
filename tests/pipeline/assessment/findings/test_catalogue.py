"""Findings are plain data, in one order, and every code that is used is in it."""

import ast
from pathlib import Path

import pytest

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.assessment.findings import catalogue
from einschalt.pipeline.assessment.findings.catalogue import (
    ORDER,
    SIMULTANEOUS,
    TWO_STEP,
    findings_of,
)

ROOM = Path(catalogue.__file__).parent
RESULTS = ["good", "faulty", "given_approximations", "unchecked"]


def texts_in(call):
    """Texts that a call is given first: ``finding("code", …)``."""
    return {
        node.value
        for node in ast.walk(call.args[0])
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def codes_in(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    makers = {"finding", "_found", "weak_models", "weak_points"}
    found = [call for call in calls if getattr(call.func, "id", "") in makers]
    return set().union(*map(texts_in, found))


def is_plain(value):
    if isinstance(value, dict):
        return all(isinstance(k, str) and is_plain(v) for k, v in value.items())
    if isinstance(value, tuple):
        return all(map(is_plain, value))
    # not numpy's numbers, which are float by inheritance
    return type(value) in {str, bool, int, float}


def test_every_code_has_its_place_and_stands_once():
    causes = (ROOM.parent / "causes").glob("*.py")
    codes = set().union(*map(codes_in, [*ROOM.glob("*.py"), *causes]))
    assert codes == set(ORDER)
    assert len(set(ORDER)) == len(ORDER)


def test_every_judge_serves_a_way():
    judges = {
        name
        for path in ROOM.glob("*.py")
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and takes_what_is_examined(node)
        for name in [node.name]
    }
    serving = {judge.__name__ for judge in (*TWO_STEP, *SIMULTANEOUS)}
    assert judges == serving


def takes_what_is_examined(function):
    arguments = [argument.arg for argument in function.args.args]
    is_public = not function.name.startswith("_")
    return is_public and arguments in (["examined"], ["two_step"], ["adjusted"])


def test_findings_come_in_their_order_whatever_the_order_of_the_judges():
    def judge_of(code):
        return lambda _: Finding(code, Subject.BLOCK)

    judges = [judge_of(ORDER[k]) for k in (9, 2, 5)]
    judges += [lambda _: None, lambda _: (judge_of(ORDER[0])(_), judge_of(ORDER[7])(_))]
    found = findings_of(None, judges)
    assert [finding.code for finding in found] == [ORDER[k] for k in (0, 2, 5, 7, 9)]


@pytest.mark.parametrize("name", RESULTS)
def test_findings_are_plain_data(name, request):
    result = request.getfixturevalue(f"{name}_result")
    found = findings_of(result.examination, TWO_STEP)
    assert bool(found) == (name != "good")
    for finding in found:
        assert is_plain(dict(finding.facts)), finding
        assert is_plain(finding.names), finding
        numbers = (finding.observed, finding.expected, finding.probability)
        assert all(type(number) is float for number in numbers), finding
        assert len(finding.names) <= 100
