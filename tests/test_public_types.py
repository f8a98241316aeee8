"""The public names are annotated, completely and truly."""

import ast
import dataclasses
import inspect
import os
import re
import subprocess
import sys
import types
import typing
import warnings
from functools import cache, cached_property
from pathlib import Path

import pandas as pd
import pytest

import einschalt as es
from einschalt.interfaces.notebook.plan_plots import ExpectedPlots, SearchPlots
from einschalt.interfaces.notebook.result_plots import ResultPlots
from einschalt.interfaces.python_plans import CheckedPlan
from einschalt.interfaces.python_simulation import SimulatedBlock
from einschalt.pipeline.assessment.evidence.claim import Claim
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.layout import AreaLayout
from einschalt.pipeline.planning.propagation.expected_precision import ExpectedFigures
from einschalt.pipeline.result_parts import FormerPart, Part
from einschalt.stages.results import ModelResult, Result

ROOT = Path(__file__).parents[1]
USER_CODE = ROOT / "tests/typing/user_code.py"
SELF = ("self", "cls")
# what results are computed with: its arrays are for who reads the sources, and lead
# on into all theory
INNER = (
    *(
        "foundations.",
        "theory.",
        "stages.error_propagation.",
        "stages.identical_points",
    ),
    *("pipeline.assessment.examination", "pipeline.assessment.evidence."),
)
# of these what a result itself has: result.claim, result.errors and so on
SHOWN = {
    *("Claim", "ClaimTest", "BlockComponents", "Component", "LeftOutControl"),
    *("SystematicPatterns", "FilmAffinity", "NetworkStrain", "CommonCurvature"),
    *("PropagatedErrors", "PlannedModel", "PlannedPrecision", "PlannedLeverage"),
    *("EinschaltError", "Camera"),
}


@cache
def for_checkers(module):
    """Names that a module imports for type checkers alone."""
    found = {"pd": pd}
    for node in ast.parse(inspect.getsource(sys.modules[module])).body:
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            exec(compile(ast.Module(node.body, []), module, "exec"), found)
    return found


def public_functions():
    return [v for n in es.__all__ if inspect.isfunction(v := getattr(es, n))]


def hints(function):
    """Annotations as objects."""
    # pandas itself knows no Series of something, its stubs do
    given = dict(getattr(inspect.unwrap(function), "__annotations__", {}))
    for name, hint in given.items():
        if isinstance(hint, str):
            given[name] = hint.replace("pd.Series[Any]", "pd.Series")
    told = types.SimpleNamespace(__annotations__=given)
    own = vars(sys.modules[function.__module__])
    return typing.get_type_hints(told, own, for_checkers(function.__module__))


def fields_of(kind):
    """Public annotated attributes of a class itself, as objects."""
    told = types.FunctionType((lambda: None).__code__, {})
    told.__module__ = kind.__module__
    told.__annotations__ = {
        name: hint
        for name, hint in inspect.get_annotations(kind).items()
        if not name.startswith("_")
    }
    found = hints(told)
    for name, value in vars(kind).items():
        if isinstance(value, Part | FormerPart):
            (found[name],) = typing.get_args(value.__orig_class__)
    return found


def classes_in(hint):
    """Our own classes that an annotation names."""
    if inspect.isclass(hint) and hint.__module__.startswith("einschalt."):
        yield hint
    for part in typing.get_args(hint):
        for one in part if isinstance(part, list | tuple) else (part,):
            yield from classes_in(one)


def is_inner(kind):
    place = kind.__module__.removeprefix("einschalt.")
    return place.startswith(INNER) and kind.__name__ not in SHOWN


@cache
def public_classes():
    """Public classes, and those that lead from them: of fields, methods, and bases."""
    plots = [ResultPlots, ExpectedPlots, SearchPlots]
    found = [one for name in es.__all__ if inspect.isclass(one := getattr(es, name))]
    waiting = [*found, *plots, SimulatedBlock]
    for function in public_functions():
        waiting += [k for hint in hints(function).values() for k in classes_in(hint)]
    found = set()
    while waiting:
        kind = waiting.pop()
        is_ours = kind.__module__.startswith("einschalt.")
        if not is_ours or kind in found or is_inner(kind):
            continue
        found.add(kind)
        given = [*fields_of(kind).values()]
        given += [h for _, f in members(kind) for h in hints(f).values()]
        waiting += [*kind.__mro__, *(k for hint in given for k in classes_in(hint))]
    return found


def function_of(value):
    """Function behind a property or a method; None of other attributes."""
    for place in ("fget", "func", "__func__"):
        if hasattr(value, place):
            value = getattr(value, place)
            break
    return value if inspect.isfunction(value) else None


def members(kind):
    """Public methods and properties of a class itself, and its own constructor."""
    is_made = dataclasses.is_dataclass(kind) or getattr(kind, "_is_protocol", False)
    own_init = () if is_made else ("__init__",)
    for name, value in vars(kind).items():
        function = function_of(value)
        if function is not None and (not name.startswith("_") or name in own_init):
            yield f"{kind.__name__}.{name}", function


def left_out(name, function):
    """What a signature says no type of."""
    signature = inspect.signature(function)
    arguments = [p for p in signature.parameters.values() if p.name not in SELF]
    yield from (f"{name}: {p.name}" for p in arguments if p.annotation is p.empty)
    if signature.return_annotation is signature.empty:
        yield f"{name}: what it gives"


def test_no_public_argument_or_result_is_without_annotation():
    classes = public_classes()
    assert {es.DensificationResult, es.Camera, ModelResult} <= classes
    # what leads from the results of results
    assert {CheckedPlan, FlightArea, AreaLayout, Claim, ExpectedFigures} <= classes
    named = [(f.__name__, f) for f in public_functions()]
    named += [member for kind in classes for member in members(kind)]
    assert len(named) > 250
    assert [missing for one in named for missing in left_out(*one)] == []
    assert (Path(es.__file__).parent / "py.typed").exists()


def test_no_field_is_said_to_be_any_object():
    said = {
        f"{kind.__name__}.{name}"
        for kind in public_classes()
        for name, hint in fields_of(kind).items()
        if hint is object
    }
    # one of many fits, of all kinds of transformations
    assert said == {"ModelTransformation.fit"}


def hint_of(kind, name):
    """Annotation of an attribute of a result, or None of a method."""
    for base in kind.__mro__:
        value = vars(base).get(name)
        if isinstance(value, Part | FormerPart):
            (hint,) = typing.get_args(value.__orig_class__)
            return hint | None if isinstance(value, FormerPart) else hint
        if isinstance(value, property | cached_property):
            return hints(function_of(value))["return"]
    return None


def is_of(value, hint):
    if hint is typing.Any:
        return True
    options = typing.get_args(hint) if isinstance(hint, typing.types.UnionType) else ()
    if options:
        return any(is_of(value, option) for option in options)
    return isinstance(value, typing.get_origin(hint) or hint)


@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_attributes_of_a_result_are_what_their_annotations_say(method, demo_block):
    result = es.densify(demo_block, es.Settings(method=method))
    assert isinstance(result, Result)
    looked_at, wrong = 0, {}
    for name in dir(result):
        if name.startswith("_") or (hint := hint_of(type(result), name)) is None:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            value = getattr(result, name)
        looked_at += 1
        if not is_of(value, hint):
            wrong[name] = type(value), hint
    assert looked_at > 40
    assert wrong == {}


@pytest.mark.slow
def test_a_type_checker_accepts_code_that_uses_every_public_name(tmp_path):
    pytest.importorskip("mypy", reason="mypy is not installed")
    code = USER_CODE.read_text(encoding="utf-8")
    unused = [n for n in es.__all__ if not re.search(rf"\bes\.{n}\b", code)]
    assert unused == []
    mistaken = tmp_path / "mistaken.py"
    mistaken.write_text(
        "import einschalt as es\n"
        'es.densify("a folder")\n'
        "es.error_budget(5.0, 8000)\n"
        "es.no_such_name\n",
        encoding="utf-8",
    )
    options = ["--config-file", "pyproject.toml", "--cache-dir", ".mypy_cache"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, USER_CODE, mistaken],
        cwd=ROOT,
        env={**os.environ, "MYPYPATH": "src"},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    lines = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert [line.split(":")[1] for line in lines] == ["2", "3", "4"], done.stdout
    assert all(mistaken.name in line for line in lines), done.stdout
