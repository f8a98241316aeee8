"""The page of all columns, and the schema of block.toml."""

import json
import os
import tomllib
from pathlib import Path

import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.files import block_toml
from einschalt.interfaces.files.block_schema import block_schema, schema_text
from einschalt.interfaces.files.columns_page import (
    columns_page,
    explanation_of,
    written_columns,
)
from einschalt.interfaces.files.result_folder import tables_of
from einschalt.interfaces.new_block.block_text import TEMPLATE
from einschalt.pipeline.settings import Settings

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "columns.md"


def test_the_page_is_what_the_schemas_say():
    if os.environ.get("EINSCHALT_WRITE_GOLDEN"):
        PAGE.write_text(columns_page(), encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == columns_page()


def test_every_column_of_a_result_is_on_it(
    good_result, faulty_result, given_approximations_result
):
    for result in (good_result, faulty_result, given_approximations_result):
        for name, table in tables_of(result).items():
            assert set(table) <= set(written_columns(name)), name


def test_a_column_is_explained_under_any_of_its_names():
    said = explanation_of("Rechtswert")
    assert said.startswith("Rechtswert: easting\n")
    assert "control_points: ground coordinate to the east [metres], needed: yes" in said
    assert "English: easting, east" in said
    total = explanation_of("standard_error_total")
    assert "neighbours (result): standard error of both differences, TOTAL [m]" in total
    assert "kontrollpunkt" in explanation_of("role")
    with pytest.raises(SettingsError, match="'easing' is no column; expected easting"):
        explanation_of("easing")


def test_the_schema_knows_every_key_and_no_other():
    schema = json.loads(schema_text())
    parts = schema["definitions"]
    models = {**block_toml.SECTIONS, "settings": Settings}
    assert set(schema["properties"]) == set(models)
    for section, reference in schema["properties"].items():
        part = parts[reference["$ref"].rpartition("/")[2]]
        assert set(part["properties"]) == set(models[section].model_fields)
        assert part["additionalProperties"] is False
    assert parts["Settings"]["properties"]["method"]["enum"]
    assert "null" not in schema_text()


def test_blocks_that_are_read_fit_the_schema():
    properties, parts = (block_schema()[name] for name in ("properties", "definitions"))
    kinds = {"string": str, "number": (int, float), "boolean": bool, "object": dict}
    blocks = [path.read_text() for path in ROOT.glob("data_examples/*/block.toml")]
    assert len(blocks) > 1
    for text in (*blocks, TEMPLATE):
        for section, keys in tomllib.loads(text).items():
            part = parts[properties[section]["$ref"].rpartition("/")[2]]
            for key, value in keys.items():
                known = part["properties"][key]
                allowed = [one.get("type", "object") for one in known.get("anyOf", ())]
                allowed = allowed or [known["type"]]
                assert isinstance(value, tuple(kinds[one] for one in allowed)), key
            assert set(part.get("required", ())) <= set(keys)
