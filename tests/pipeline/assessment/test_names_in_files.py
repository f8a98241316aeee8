"""Every name in assessment.json and provenance.json has a meaning, and each is used.

By files of results of several kinds, and by the sources: what none of these results
shows must be explained as well.
"""

import ast
import inspect
import json
import re
from dataclasses import asdict, fields, is_dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from types import UnionType
from typing import Union, get_args, get_origin, get_type_hints

import pytest

from einschalt.foundations.language import catalogue
from einschalt.foundations.result_files.meanings import (
    ASSESSMENT,
    PARTS,
    PROVENANCE,
    meanings_in_files,
    names_with_values,
    path_of,
    words_of_files,
)
from einschalt.interfaces import provenance
from einschalt.interfaces.cli.setting_meanings import VALUES
from einschalt.interfaces.files import camera_toml, output_folder, written_files
from einschalt.interfaces.files.result_folder import write_result
from einschalt.pipeline.assessment import findings
from einschalt.pipeline.assessment.assess import Assessment
from einschalt.pipeline.assessment.causes import kept_gross_errors, ranked
from einschalt.pipeline.assessment.evidence import claim
from einschalt.pipeline.assessment.evidence.control import other_targets
from einschalt.pipeline.assessment.evidence.exchanged_names import ExchangedNames
from einschalt.pipeline.assessment.evidence.images.exchanged_image_names import (
    ExchangedImageNames,
)
from einschalt.pipeline.assessment.facts.tolerance import ROLES
from einschalt.pipeline.assessment.finding import Finding
from einschalt.pipeline.assessment.plain_values import IS_PLAIN
from einschalt.pipeline.block.block import Flight
from einschalt.pipeline.densification.figures import BlockFigures
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings, words_of
from einschalt.pipeline.summary.sections.error_sources import NAMES as SOURCES

FACTS = "findings[].facts"
# objects whose names a block or its settings give
OPEN = {
    *(f"block.{name}_m" for name in ("shared_errors", "group_errors")),
    *("block.correlation_lengths_m", "outputs"),
}
# a table in an assessment, with its columns
TABLES = {"patterns.patterns.strain.displacements": ("point_id", "easting", "northing")}

SETTINGS = {
    "auto": {"method": "auto", "tolerance": 0.05},
    "iterated": {"iterations": 3, "residual_distribution": "natural_neighbour"},
    "estimated": {"method": "simultaneous", "variance_components": "estimated"},
}
RESULTS = (
    *("good", "faulty", "given_approximations", "unchecked", "simultaneous"),
    *("parallaxes", "spatial", "images", *SETTINGS),
)


def part_at(file, place):
    """Names of the object at a place of a file; None if it has none of its own."""
    return next((part for part in PARTS[file] if place in part.places), None)


@pytest.fixture(scope="module", params=RESULTS)
def result(request):
    if request.param in SETTINGS:
        block = request.getfixturevalue("demo_block")
        return densify(block, Settings(**SETTINGS[request.param]))
    if request.param == "images":
        return densify(request.getfixturevalue("image_block"))
    return request.getfixturevalue(f"{request.param}_result")


def names_of(value, place=""):
    """Names in a file, each with its place."""
    if isinstance(value, list):
        for one in value:
            yield from names_of(one, f"{place}[]")
    if not isinstance(value, dict) or place in OPEN:
        return
    if place == "flights":
        for flight in value.values():
            yield from names_of(flight, "flights.*")
        return
    for name, one in value.items():
        yield place, name
        yield from names_of(one, path_of(place, name))


def unexplained(file, names):
    return {
        (place, name)
        for place, name in names
        if (part := part_at(file, place)) is None or name not in part.names
    }


@pytest.mark.slow
def test_every_name_of_an_assessment_is_explained(result):
    told = set(names_of(result.assessment.to_dict()))
    assert len(told) > 100
    assert not unexplained(ASSESSMENT, told)


def test_every_name_of_a_provenance_is_explained(result):
    told = set(names_of(provenance.provenance(result)))
    settings = {name for place, name in told if place == "settings"}
    assert settings == set(Settings.model_fields)  # which explain knows as settings
    told -= {("settings", name) for name in settings}
    assert len(told) > 40
    assert not unexplained(PROVENANCE, told)


def test_every_name_of_a_file_of_provenance_is_explained(good_result, tmp_path):
    write_result(good_result, tmp_path / "out", report=False)
    file = tmp_path / "out" / PROVENANCE
    told = set(names_of(json.loads(file.read_text(encoding="utf-8"))))
    told = {(place, name) for place, name in told if place != "settings"}
    assert {("", "seal"), ("origin", "place")} <= told
    assert not unexplained(PROVENANCE, told)


@cache
def fields_of_assessment():
    """Every field that an assessment may have, by place and name, with its type."""
    return dict(_fields(Assessment, ""))


def _fields(kind, place):
    if get_origin(kind) in (Union, UnionType):
        for one in get_args(kind):
            yield from _fields(one, place)
    elif get_origin(kind) is tuple:
        yield from _fields(get_args(kind)[0], f"{place}[]")
    elif is_dataclass(kind):
        hints = get_type_hints(kind)
        for field in fields(kind):
            if field.metadata.get(IS_PLAIN, True):
                yield (place, field.name), hints[field.name]
                yield from _fields(hints[field.name], path_of(place, field.name))
    elif place in TABLES:
        yield from (((f"{place}[]", name), None) for name in TABLES[place])


def explained(file):
    """Every name that has a meaning, with each of its places."""
    return {
        (place, name)
        for part in PARTS[file]
        for place in part.places
        for name in part.names
    }


def test_names_of_an_assessment_are_those_of_its_fields():
    told = {(p, n) for p, n in explained(ASSESSMENT) if not p.startswith(FACTS)}
    known = set(fields_of_assessment())
    assert sorted(told - known) == []
    assert sorted(known - told) == []


def test_tables_are_those_of_an_assessment(good_result):
    strain = good_result.assessment.patterns.patterns.strain
    (columns,) = TABLES.values()
    assert tuple(strain.displacements) == columns


def test_every_member_of_an_enumeration_is_explained():
    found = 0
    for (place, name), kind in fields_of_assessment().items():
        kinds = [kind, *get_args(kind)]
        for one in kinds:
            if isinstance(one, type) and issubclass(one, Enum):
                told = part_at(ASSESSMENT, place).values[name]
                members = [str(member.value) for member in one if member.value != ""]
                assert sorted(told) == sorted(members), (place, name)
                found += 1
    assert found > 15


def values_at(place, name):
    return set(part_at(ASSESSMENT, place).values[name])


TEXTS_OF_TESTS = {
    *(claim.COVERAGES, claim.COVERAGES_HIGH, claim.RESIDUALS, claim.NEIGHBOURS),
    *(claim.REGIONS, claim.LEFT_OUT, *claim.KNOWN.values()),
}
WORDS = {
    ("claim.tests[]", "name"): TEXTS_OF_TESTS,
    ("known_points", "differences"): {claim.LEFT_OUT, *claim.KNOWN.values()},
    ("flights[]", "transformation"): set(VALUES["transformation"]),
    ("error_sources.sources[]", "source"): set(SOURCES),
    ("tolerance.roles[]", "role"): set(ROLES),
    ("choice", "method"): set(words_of("method")) - {"auto"},
    ("precision", "coverage_mean"): set(words_of("coverage_mean")),
    ("distribution", "way"): set(words_of("residual_distribution")) - {"none"},
}


@pytest.mark.parametrize(("at", "words"), WORDS.items(), ids=map(".".join, WORDS))
def test_words_without_an_enumeration_are_explained(at, words):
    assert values_at(*at) == words


def codes_in(modules, pattern):
    text = "".join(inspect.getsource(module) for module in modules)
    return set(re.findall(pattern, text))


def test_codes_of_what_was_not_tested_are_explained():
    from einschalt.pipeline.assessment.evidence.ground import displaced_region
    from einschalt.pipeline.assessment.findings import claim as judges

    untested = codes_in([displaced_region], r'untested="(\w+)"')
    assert values_at("claim", "untested_regions") == untested
    untested = codes_in([judges], r'(?:untested=|why = )"(\w+)"')
    assert values_at("findings[]", "untested") == untested
    (assumed,) = codes_in([claim], r'return "(\w+)" if is_given else "(\w+)"')
    assert values_at("claim", "assumption") == set(assumed)


# words of dicts that are no facts
NO_FACTS = {field.name for field in fields(Finding)} - {"observed", "remedy"}
NO_FACTS |= {"keep", "snoop", "outliers", "control_points", "check"}
SOURCES_OF_FACTS = (
    *sorted(Path(findings.__file__).parent.glob("*.py")),
    *(Path(module.__file__) for module in (ranked, kept_gross_errors)),
)


def functions_of_facts():
    for path in SOURCES_OF_FACTS:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                yield node


def texts(node):
    """Texts of an expression, those of f-strings left out."""
    found = (one.value for one in ast.walk(node) if isinstance(one, ast.Constant))
    return {one for one in found if isinstance(one, str)}


def facts_where_made():
    """Names of facts, written out where judges make them."""
    found = set()
    for function in functions_of_facts():
        named = {
            node.targets[0].id: texts(node.value)
            for node in ast.walk(function)
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
        }
        for node in ast.walk(function):
            if isinstance(node, ast.Dict):
                found |= {key.value for key in node.keys if hasattr(key, "value")}
            elif isinstance(node, ast.DictComp):
                source = node.generators[0].iter
                found |= named.get(getattr(source, "id", ""), set())
            elif isinstance(node, ast.Call) and called(node) == "weak_points":
                found |= {one.arg for one in node.keywords if one.arg != "remedy"}
    for kind in (ExchangedNames, ExchangedImageNames, other_targets.OtherTarget):
        found |= {field.name for field in fields(kind)}
    from einschalt.pipeline.assessment.evidence.variance_components import Component

    found |= set(Component(1.0, 1.0, 1.0).facts_of("low_flight"))
    return {one for one in found if isinstance(one, str)} - {"model_points"}


def called(node):
    return getattr(node.func, "id", "")


def test_facts_are_those_that_judges_give():
    told = {name for place, name in explained(ASSESSMENT) if place.startswith(FACTS)}
    made = facts_where_made()
    assert len(made) > 90
    assert sorted(made - NO_FACTS - told) == []
    assert sorted(told - made) == []


def constants_of(module):
    return texts(ast.parse(inspect.getsource(module)))


def test_names_of_a_provenance_are_those_that_are_written():
    tree = ast.parse(inspect.getsource(provenance))
    written = {
        key.value
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for node in ast.walk(function)
        if isinstance(node, ast.Dict)
        for key in node.keys
        if isinstance(key, ast.Constant)
    }
    cameras = [
        set(model.model_fields)
        for _, model in inspect.getmembers(camera_toml, inspect.isclass)
        if issubclass(model, camera_toml._Constants)
    ]
    flight = {
        name
        for name, kind in get_type_hints(Flight).items()
        if "DataFrame" not in str(kind) or name == "base"
    }
    figures = {field.name for field in fields(BlockFigures)}
    known = written | flight | figures | set(provenance.versions())
    told = {name for _, name in explained(PROVENANCE)}
    assert sorted(known - told) == []
    # constants of cameras as TOML has them, and as they are kept
    known |= set().union(*cameras) | {"f", "fx", "fy", "cx", "cy", "c", "x0", "y0"}
    known |= written_files.ORIGIN | {written_files.SEAL, written_files.BLOCKS}
    known |= constants_of(output_folder) | constants_of(provenance)
    assert sorted(told - known) == []


def test_places_are_named_once():
    for parts in PARTS.values():
        places = [place for part in parts for place in part.places]
        assert len(set(places)) == len(places)
        for part in parts:
            assert set(part.values) <= set(part.names)


def all_texts():
    for parts in PARTS.values():
        for part in parts:
            yield from (part.meaning(name)[1] for name in part.names)
            for values in part.values.values():
                yield from values.values()


def test_meanings_are_phrases_and_are_german_as_well():
    known = catalogue("de")._catalog
    assert not [text for text in all_texts() if text not in known]
    assert not [text for text in all_texts() if text.endswith(".") or "{" in text]


def test_every_word_of_the_files_is_found():
    words = words_of_files()
    assert len(words) > 400
    assert not [word for word in words if not list(meanings_in_files(word))]
    assert set(names_with_values()) <= words
    (shared,) = meanings_in_files("elsewhere")
    assert len(shared.places) == 5
    assert asdict(shared)["unit"] == "m"


def test_a_name_without_a_meaning_is_told():
    """The tests above would say nothing if names were not looked for."""
    told = {"credible": {"value": 1.0, "sheen": 2.0}, "claim": {"tests": [{"hue": 1}]}}
    assert unexplained(ASSESSMENT, names_of(told)) == {
        ("credible", "sheen"),
        ("claim.tests[]", "hue"),
    }
