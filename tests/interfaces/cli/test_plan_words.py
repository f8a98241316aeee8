"""Words of plans: every one that the output uses can be looked up, and is German."""

import json
import re

import pandas as pd
import pyogrio
import pytest

from einschalt.foundations.language import catalogue
from einschalt.foundations.meanings_with_units import unit_and_meaning
from einschalt.foundations.plan_column_meanings import (
    PLAN_COLUMNS,
    PLAN_TABLES,
    meaning_in_plan,
)
from einschalt.foundations.plan_figure_meanings import (
    OF_AREA_LAYER,
    OF_LAYERS,
    PLAN_JSON,
    meanings_of_name,
    names_of_figures,
)

pytestmark = pytest.mark.usefixtures("undrawn")

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
    *("scale", "double", "middle", "corner", "error", "best scale", "safe from"),
    *("overlap", "sidelap", "endlap", "base-height ratio", "total", "RMS"),
    *("least variance", "plain mean", "contributions", "recommended"),
    *("Punktfehler", "Überd.", "Passp.", "hoch", "bis", "Abstand", "Maßstab"),
    *("Ziel", "erwartet", "Formel", "Regel von 1971", "zweitbeste", "nächstbeste"),
    *("empfohlen", "quadratisches Mittel", "kleinste Varianz", "Anteile", "Kosten"),
    *("Mitte", "Rand", "Ecke", "geschlossene Abschätzung", "Blockanordnung"),
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


LAYERS = {
    "area": tuple(OF_AREA_LAYER),
    **{name: PLAN_COLUMNS[name] for name in ("flight_lines", "photographs", "control")},
}
# the tables whose rows stand in a part of the JSON
TABLES_OF = {
    "figures": ("plans", "plan"),
    "next_best": ("plans",),
    "effort": ("effort",),
    "combinations": ("plan",),
}


def meaning_in_json(name, part):
    """Unit and meaning of a name in a part of the JSON of a plan; None of no name."""
    if found := PLAN_JSON.get(part, {}).get(name):
        return unit_and_meaning(found)
    for table in TABLES_OF.get(part, ()):
        if name in PLAN_COLUMNS[table]:
            return meaning_in_plan(name, table)
    # what stands nested in one answer, and flat in another
    return PLAN_JSON["expected_on_layout"].get(name) if part == "figures" else None


def meaning_in_package(name, layer):
    """Unit and meaning of a column in a layer of the GeoPackage."""
    own = OF_LAYERS | (OF_AREA_LAYER if layer == "area" else {})
    return unit_and_meaning(own[name]) if name in own else meaning_in_plan(name, layer)


def area_in(folder):
    area = folder / "area.geojson"
    system = {"type": "name", "properties": {"name": "EPSG:32633"}}
    polygon = {"type": "Polygon", "coordinates": [SQUARE], "crs": system}
    area.write_text(json.dumps(polygon), "utf-8")
    return area


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    from typer.testing import CliRunner

    from einschalt.interfaces.cli.main import app

    folder = tmp_path_factory.mktemp("plans")
    area = area_in(folder)
    for name, options in {
        "tables": (),
        "target": ("--target", "6cm", *ONE_PLAN),
        "area": ("--target", "6cm", *ONE_PLAN, "--area", area),
    }.items():
        words = map(str, ("plan", *options, "--output", folder / name))
        shown = CliRunner().invoke(app, list(words))
        assert shown.exit_code == 0, shown.stderr
    return folder


@pytest.fixture(scope="module")
def flight_plan(folder):
    return folder / "area" / "flight_plan.gpkg"


@pytest.fixture(scope="module")
def written(folder):
    return {file.stem: list(pd.read_csv(file)) for file in folder.glob("*/*.csv")}


ALONE = ("--target", "6cm", *ONE_PLAN)
LAID_OUT = ("--expect", "--spacing", 300, "--width", 4000, "--height", 4000)
UNREACHED = ("--target", "1mm", "--scale-number", 9000, "--spacing", 300)


def parts_of(told, part=""):
    """Names of an object, each with the part of the JSON in which it stands."""
    for name, value in told.items():
        yield part, name
        if isinstance(value, dict):
            yield from parts_of(value, name)
        for one in value if isinstance(value, list) else ():
            if isinstance(one, dict):
                yield from parts_of(one, name)


@pytest.mark.parametrize("options", [(), ALONE, LAID_OUT, UNREACHED, "area", "none"])
def test_all_names_of_the_json_are_explained(options, invoke, tmp_path):
    if options == "area":
        options = (*ALONE, "--n-settings", 4, "--area", area_in(tmp_path))
    if options == "none":
        options = ("--target", "6cm", "--scale-number", 9000, "--spacing", 9000)
    told = json.loads(invoke("plan", *options, "--json").stdout)
    names = set(parts_of(told))
    assert {("", "figures"), ("", "problems")} <= names
    unknown = {found for found in names if meaning_in_json(found[1], found[0]) is None}
    assert not unknown
    for name in {name for _, name in names}:
        shown = invoke("explain", name)
        assert shown.exit_code == 0, (name, shown.stderr)
        column = any(name in columns for columns in PLAN_COLUMNS.values())
        assert column or "plan --json" in shown.stdout, name


def test_the_next_best_plan_has_what_the_recommended_one_has(invoke, tmp_path):
    options = (*ALONE, "--n-settings", 4, "--area", area_in(tmp_path))
    told = json.loads(invoke("plan", *options, "--json").stdout)["figures"]
    other = told["next_best"]
    not_twice = {"next_best", "effort", "question", "cost_of_area", "finer"}
    assert set(told) - set(other) - not_twice == {"next_cost_of_area"}
    assert other["totals"]["cost"] == told["next_cost_of_area"]
    assert other["totals"]["cost"] > told["totals"]["cost"] == told["cost_of_area"]
    assert set(other["totals"]) == set(told["totals"])
    layout = other["expected_on_layout"]
    assert layout["mean"] == pytest.approx(other["reached_on_layout"], rel=1e-9)
    parts = [layout[f"from_{of}"] for of in ("control", "high_flight", "low_flight")]
    assert sum(part**2 for part in parts) == pytest.approx(layout["mean"] ** 2)
    per_km2 = other["totals"]["cost"] / other["totals"]["area_km2"]
    assert other["cost"] == pytest.approx(per_km2)


@pytest.mark.slow
def test_all_columns_of_the_map_are_explained(flight_plan, invoke):
    layers = {name for name, _ in pyogrio.list_layers(flight_plan)}
    assert layers == set(LAYERS)
    for layer in layers:
        about = pyogrio.read_info(flight_plan, layer=layer)
        assert tuple(about["fields"]) == LAYERS[layer]
        for name in (*about["fields"], about["fid_column"], about["geometry_name"]):
            unit, meaning = meaning_in_package(name, layer)
            said = f": {meaning}" + (f" [{unit}]" if unit else "")
            assert said in invoke("explain", name).stdout, name


def test_names_of_figures_mean_nothing_else(invoke):
    """``totals`` was explained as errors of which a total is taken."""
    shown = invoke("explain", "totals").stdout
    assert shown.startswith("totals\n  plan --json, figures: what the whole area takes")
    assert list(meanings_of_name("area_km2")) == [
        ("plan --json, totals", "km²", "size of the area")
    ]


@pytest.mark.parametrize(
    "word", ["node_of_area", "cost_of_model", "sum", "foo", "expected_pint", "largo"]
)
def test_unknown_words_are_not_taken_for_others(word, invoke):
    shown = invoke("explain", word)
    assert shown.exit_code == 2
    assert "Write" not in shown.stderr


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("percentil_95", "percentile_95"),
        ("overlapp", "overlap"),
        ("standard_eror_total", "standard_error_total"),
        ("Hochflg", "Hochflug"),
    ],
)
def test_a_word_with_a_wrong_letter_is_found(word, meant, invoke):
    assert f"Write '{meant}'" in invoke("explain", word).stderr


@pytest.mark.slow
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
    figures = {
        found.text for name in names_of_figures() for found in meanings_of_name(name)
    }
    of_next = {unit_and_meaning(said)[1] for said in PLAN_JSON["next_best"].values()}
    assert figures | of_next <= set(german)


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


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("repeat", [(), ("--repeat", 2)])
def test_every_name_of_a_simulation_is_explained(repeat, invoke, tmp_path):
    preset = ("--width", 6000, "--height", 6000, "--seed", 3, *repeat)
    shown = invoke("simulate", *preset, "--output", tmp_path / "out", "--json")
    assert shown.exit_code == 0, shown.stderr
    names = {*json.loads(shown.stdout)["figures"]}
    if repeat:
        names |= {*pd.read_csv(tmp_path / "out" / "repetitions.csv").columns}
    assert "seed" in names
    for name in sorted(names):
        assert invoke("explain", name).exit_code == 0, name
