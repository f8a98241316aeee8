"""JSON schema of block.toml, for editors: made of the models that check it."""

import json

from pydantic.json_schema import models_json_schema

from einschalt.interfaces.files.block_toml import SECTIONS, TableKeys
from einschalt.pipeline.settings import Settings

SCHEMA_FILE = "block.schema.json"
DIRECTIVE = f"#:schema {SCHEMA_FILE}\n"  # as editors of TOML understand it
DIALECT = "http://json-schema.org/draft-07/schema#"
NAMED_TABLES = ("model_points", "y_parallaxes", "image_points", "models", "base")


def block_schema() -> dict:
    """Schema of block.toml: sections, keys, units, allowed values."""
    kinds = [*dict.fromkeys(SECTIONS.values()), TableKeys, Settings]
    _, found = models_json_schema(
        [(kind, "validation") for kind in kinds],
        ref_template="#/definitions/{model}",
    )
    parts = found["$defs"]
    for part in parts.values():
        _without_titles(part)
    _name_tables(parts["FlightSection"]["properties"])
    sections = {
        name: {"$ref": f"#/definitions/{kind.__name__}"}
        for name, kind in (*SECTIONS.items(), ("settings", Settings))
    }
    return {
        "$schema": DIALECT,
        "title": "block.toml of einschalt",
        "type": "object",
        "additionalProperties": False,
        "properties": sections,
        "definitions": parts,
    }


def _without_titles(part):
    """Titles repeat names; the text of a class is written for programmers."""
    part.pop("title", None)
    text = part.get("description", "")
    part["description"] = text.split("\n")[0]
    keys = part.get("properties", {})
    part["properties"] = {name: _without_null(key) for name, key in keys.items()}


def _without_null(key):
    """TOML has no null: a key is left out."""
    key = {name: fact for name, fact in key.items() if name != "title"}
    kinds = [one for one in key.get("anyOf", ()) if one != {"type": "null"}]
    if len(kinds) == 1:
        del key["anyOf"]
        key.update(kinds[0])
    if key.get("default", "") is None:
        del key["default"]
    return key


def _name_tables(keys):
    """A table is named by its file, or by {file = …} with what is said of it."""
    for name in NAMED_TABLES:
        kinds = [{"type": "string"}, {"$ref": "#/definitions/TableKeys"}]
        kinds += [{"type": "number"}] if name == "base" else []
        keys[name] = {"anyOf": kinds, "description": keys[name].get("description", "")}
    camera = keys["camera"].get("description", "")
    kinds = [{"type": "string"}, {"type": "object"}]
    keys["camera"] = {"anyOf": kinds, "description": camera}


def schema_text():
    """Write the schema as text."""
    return json.dumps(block_schema(), indent=2, ensure_ascii=False) + "\n"
