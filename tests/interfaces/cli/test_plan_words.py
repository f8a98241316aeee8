"""Words of plans: every one that the output uses can be looked up, and is German."""

import json
import re

import pandas as pd
import pytest

from einschalt.foundations.language import catalogue
from einschalt.foundations.plan_column_meanings import (
    PLAN_COLUMNS,
    PLAN_TABLES,
    meaning_in_plan,
)

EAST, NORTH = 500_000, 5_300_000
SQUARE = [
    [EAST + x, NORTH + y]
    for x, y in ((0, 0), (6000, 0), (6000, 5000), (0, 5000), (0, 0))
]
ONE_PLAN = ("--scale-number", 9000, "--spacing", 300, "--n-settings", 2)
TERMS = (
    *("GSD", "m_g", "m_t", "m_0", "M", "layout", "flying height", "forward overlap"),
    *("side overlap", "coverage", "coverages", "spacing", "scale number", "setting"),
    *("principal distance", "settings", "pointings", "pointing", "target", "expected"),
    *("formula", "rule of 1971", "closed estimate", "break-even", "high flight"),
    *("control point", "control points per model", "costs", "prices", "edge"),
    *("centre", "control_per_model", "high_over_low", "n_settings", "n_coverages"),
    *("m_g_um", "gsd", "image_format", "flight line", "photograph", "effort"),
    *("cov.", "c. points", "up to", "high", "control", "next best"),  # in tables
)


@pytest.mark.parametrize("term", TERMS)
def test_terms_of_plans_are_explained(term, invoke):
    shown = invoke("explain", term)
    assert shown.exit_code == 0, shown.stderr
    assert shown.stdout.strip()


@pytest.mark.parametrize("term", ["m", "mm", "µm", "–"])
def test_units_are_no_terms(term, invoke):
    """Else all that is measured in metres would be explained at once."""
    shown = invoke("explain", term)
    assert "Flughöhe" not in shown.stdout


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    from typer.testing import CliRunner

    from einschalt.interfaces.cli.main import app

    folder = tmp_path_factory.mktemp("plans")
    area = folder / "area.geojson"
    system = {"type": "name", "properties": {"name": "EPSG:32633"}}
    polygon = {"type": "Polygon", "coordinates": [SQUARE], "crs": system}
    area.write_text(json.dumps(polygon), "utf-8")
    for name, options in {
        "tables": (),
        "target": ("--target", "6cm", *ONE_PLAN),
        "area": ("--target", "6cm", *ONE_PLAN, "--area", area),
    }.items():
        words = map(str, ("plan", *options, "--output", folder / name))
        shown = CliRunner().invoke(app, list(words))
        assert shown.exit_code == 0, shown.stderr
    return {file.stem: list(pd.read_csv(file)) for file in folder.glob("*/*.csv")}


def test_all_tables_and_columns_are_explained(written, invoke):
    assert set(written) == set(PLAN_TABLES) == set(PLAN_COLUMNS)
    for table, columns in written.items():
        assert columns == list(PLAN_COLUMNS[table])
        for column in columns:
            unit, meaning = meaning_in_plan(column, table)
            said = f"{table} (plan): {meaning}" + (f" [{unit}]" if unit else "")
            assert said in invoke("explain", column).stdout


def test_their_meanings_are_german_too():
    german = catalogue("de")._catalog
    meanings = {
        meaning_in_plan(column, table)[1]
        for table, columns in PLAN_COLUMNS.items()
        for column in columns
    }
    assert {*PLAN_TABLES.values(), *meanings} <= set(german)


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--target", "7cm", "--scale-number", 9000, "--spacing", 300),
        ("--target", "1mm", "--scale-number", 9000, "--spacing", 300),
        ("--target", "8cm", "--spacing", 300, "--n-coverages", 1),
        ("--expect", "--spacing", 300, "--width", 4000, "--height", 4000),
        ("--target", "5cm", "--camera", "uav_one_inch", "--spacing", 100),
    ],
)
def test_what_plan_prints_is_german(options, invoke):
    shown = invoke("plan", *options, "--where", "edge", "--language", "de")
    said = re.sub(r"--[a-z-]+|kind = \w+", "", shown.stdout + shown.stderr)
    english = r"\b(the|of|with|and|plan|plans|layout|pointings?|affine|Anlage|at)\b"
    assert not re.findall(english, said)


def test_pointings_have_one_name(invoke):
    target = ("--target", "7cm", "--scale-number", 9000, "--spacing", 300)
    for options in ((), target):
        said = invoke("plan", *options).stdout
        assert "pointing" in said
        assert not re.search(r"\bsettings?\b", said)
