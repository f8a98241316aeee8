"""What the package imports is declared, and what is declared is imported."""

import ast
import re
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import pytest

from einschalt.foundations.extras import EXTRA

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "src" / "einschalt"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
NAME = re.compile(r"[A-Za-z0-9._-]+")
# of the extras of users; those of developers are not imported by the package
EXTRAS = ("cluster", "export", "notebook", "serve")
# modules of what a declared distribution requires itself
BROUGHT = {
    "anyio": "starlette",
    "llvmlite": "numba",
    "markupsafe": "jinja2",
    "pydantic_core": "pydantic",
}


def normalized(name):
    return re.sub(r"[-_.]+", "-", name).casefold()


def declared(requirements):
    return {normalized(NAME.match(one)[0]) for one in requirements}


# what reads every source waits until it is asked, and each worker of a run does not
@cache
def nodes_of(path):
    """Every node of a file, of which two lists are made."""
    return tuple(ast.walk(ast.parse(path.read_text("utf-8"))))


def imported_by(path):
    """Top-level modules that a file imports, anywhere in it."""
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (one.name.split(".")[0] for one in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.split(".")[0]


def asked_of_extras(path):
    """Modules that ``imported`` of the extras is asked for, and the extra of each."""
    for node in nodes_of(path):
        is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        if is_call and node.func.id == "imported":
            named = {one.arg: one.value for one in node.keywords}
            extra = named["extra"].value if "extra" in named else EXTRA
            yield node.args[0].value.split(".")[0], extra


@cache
def third_party():
    """Modules of others, with a file that imports each."""
    found = {}
    for path in sorted(SOURCES.rglob("*.py")):
        for module in imported_by(path):
            if module not in sys.stdlib_module_names and module != "einschalt":
                found.setdefault(module, path.relative_to(SOURCES))
    return found


@cache
def asked():
    """Modules of extras that any file asks for, and the extra of each."""
    return {one for path in SOURCES.rglob("*.py") for one in asked_of_extras(path)}


distributions = cache(packages_distributions)


def distributions_of(module):
    return {normalized(name) for name in distributions().get(module, [])}


REQUIRED = declared(PROJECT["dependencies"])
OPTIONAL = {name: declared(PROJECT["optional-dependencies"][name]) for name in EXTRAS}


@pytest.mark.slow
def test_what_is_imported_is_declared():
    allowed = REQUIRED.union(*OPTIONAL.values())
    missing = {
        module: str(file)
        for module, file in third_party().items()
        if module not in BROUGHT and not distributions_of(module) & allowed
    }
    assert not missing


@pytest.mark.parametrize("module", BROUGHT)
def test_what_is_brought_is_required_by_what_brings_it(module):
    assert module in third_party()
    assert BROUGHT[module] in REQUIRED.union(*OPTIONAL.values())
    assert distributions_of(module) & declared(requires(BROUGHT[module]))


def test_the_extra_that_a_message_names_has_the_library():
    assert {extra for _, extra in asked()} == {"export", "notebook"}
    for module, extra in asked():
        assert distributions_of(module) & OPTIONAL[extra], module


def test_what_is_declared_is_imported():
    modules = {*third_party(), *(module for module, _ in asked())}
    used = set().union(*map(distributions_of, modules))
    assert not REQUIRED.union(*OPTIONAL.values()) - used


def test_the_lists_are_not_empty():
    assert {"numpy", "pyproj", "uvicorn"} <= set(third_party())
    assert "scikit-image" not in REQUIRED
    assert all(OPTIONAL.values())
