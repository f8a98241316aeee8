"""The public names are annotated, completely and truly."""

import dataclasses
import inspect
import os
import subprocess
import sys
import typing
import warnings
from functools import cached_property
from pathlib import Path

import pandas as pd
import pytest

import einschalt as es
from einschalt.interfaces.notebook.plan_plots import ExpectedPlots, SearchPlots
from einschalt.interfaces.notebook.result_plots import ResultPlots
from einschalt.interfaces.python_api import SimulatedBlock
from einschalt.interfaces.python_plans import AreaPlan, ExpectedPrecision
from einschalt.pipeline.result_parts import FormerPart, Part
from einschalt.stages.results import ModelResult, Result

ROOT = Path(__file__).parents[1]
USER_CODE = ROOT / "tests/typing/user_code.py"
SELF = ("self", "cls")
PLANS = (es.FlightDesign, es.PlanFrame, ExpectedPrecision, AreaPlan)


def public_functions():
    return [v for n in es.__all__ if inspect.isfunction(v := getattr(es, n))]


def hints(function):
    """Annotations as objects; some modules import a name for type checkers alone."""
    later = {"pd": pd, "DensificationResult": es.DensificationResult}
    later |= {one.__name__: one for one in PLANS}
    return typing.get_type_hints(function, localns=later)


def public_classes():
    """Public classes, those of the results that functions give, and their bases."""
    plots = {ResultPlots, ExpectedPlots, SearchPlots}
    found = {SimulatedBlock, *plots, *(getattr(es, name) for name in es.__all__)}
    found |= {hints(function)["return"] for function in public_functions()}
    bases = {base for one in found if inspect.isclass(one) for base in one.__mro__}
    return {one for one in bases if one.__module__.startswith("einschalt.")}


def function_of(value):
    """Function behind a property or a method; None of other attributes."""
    for place in ("fget", "func", "__func__"):
        if hasattr(value, place):
            return getattr(value, place)
    return value if inspect.isfunction(value) else None


def members(kind):
    """Public methods and properties of a class itself, and its own constructor."""
    own_init = () if dataclasses.is_dataclass(kind) else ("__init__",)
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
    named = [(f.__name__, f) for f in public_functions()]
    named += [member for kind in classes for member in members(kind)]
    assert len(named) > 100
    assert [missing for one in named for missing in left_out(*one)] == []
    assert (Path(es.__file__).parent / "py.typed").exists()


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


def test_a_type_checker_accepts_code_that_uses_every_public_name(tmp_path):
    pytest.importorskip("mypy", reason="mypy is not installed")
    code = USER_CODE.read_text(encoding="utf-8")
    unused = [n for n in es.__all__ if f"es.{n}" not in code]
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
