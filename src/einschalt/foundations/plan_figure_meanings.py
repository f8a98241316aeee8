"""What names in the JSON of a plan, in its GeoPackage and in simulations mean.

A row of a plan has the names of its table, whose meanings are those of the columns in
``plan_column_meanings``; here is the rest.
"""

from collections.abc import Iterator
from typing import NamedTuple

from einschalt.foundations.plan_column_meanings import (
    PLAN_COLUMNS,
    meaning_in_plan,
)


class Meaning(NamedTuple):
    """What a name means in one place."""

    place: str  # part of the JSON, or file and layer
    unit: str  # empty where it is no length and nothing that is counted per something
    text: str


JSON = "plan --json"
OF_95 = "expected TOTAL of the new points, 95th percentile: 95 of 100 are better"
OF_ROW = {
    "reached_on_layout": (
        "m",
        (
            "TOTAL at the place of the target, propagated on the layout; null where "
            "the plan cannot be laid out"
        ),
    ),
    "is_recommended": ("", "whether the target is reached on the layout"),
    "target": ("m", "TOTAL that was asked for"),
    "expected_on_layout": ("", "expected precision on the layout, by name"),
    "totals": ("", "what the whole area takes, by name; it is counted on the layout"),
    "images": (
        "1/km²",
        "images of both flights; counted on the layout of an area, otherwise estimated",
    ),
    "models": (
        "1/km²",
        "models of both flights; counted on the layout of an area, otherwise estimated",
    ),
    "settings": (
        "1/km²",
        (
            "pointings of both flights; counted on the layout of an area, otherwise "
            "estimated"
        ),
    ),
    "control_points": (
        "1/km²",
        "control points; counted on the layout of an area, otherwise estimated",
    ),
    "cost": (
        "1/km²",
        "cost of the plan; counted on the layout of an area, otherwise estimated",
    ),
}
PLAN_JSON = {
    "": {
        "command": ("", "command that was called"),
        "status": (
            "",
            (
                "exit status: 0 when the work was done, 1 when no plan reaches the "
                "target, 2 when the input or the call is wrong"
            ),
        ),
        "problems": ("", "what went wrong or has to be known, one object for each"),
        "paths": ("", "files and folders that were written"),
        "figures": ("", "headline figures by name"),
    },
    "problems": {
        "found": ("", "what was found"),
        "expected": ("", "what was expected; null where there is nothing to say"),
        "remedy": ("", "how to mend it; null where there is nothing to say"),
        "file": ("", "file that it is about, or null"),
        "row": ("", "line of the file that it is about, or null"),
        "point": ("", "point that it is about, or null"),
        "model": ("", "model that it is about, or null"),
    },
    "figures": {
        "question": ("", "what was asked: tables, target, area or expect"),
        "combinations": (
            "",
            (
                "the rows of plan.csv: all combinations of the values that were "
                "asked for, with their figures"
            ),
        ),
        **OF_ROW,
        "next_best": (
            "",
            (
                "the next best plan by the same names, or null: it comes next in cost "
                "and reaches the target as well"
            ),
        ),
        "finer": (
            "",
            (
                "values between those that were tried, by choice: a plan of them may "
                "be some per cent cheaper; empty where they were tried as well"
            ),
        ),
        "effort": ("", "the rows of effort.csv"),
        "cost_of_area": ("", "cost of the plan over the whole area, counted"),
        "next_cost_of_area": (
            "",
            "cost of the next best plan over the whole area, counted, or null",
        ),
    },
    "next_best": OF_ROW,
    "finer": {
        "scale_number": ("", "scale numbers of the low flight"),
        "high_over_low": ("", "those of the high flight over those of the low flight"),
        "n_settings": ("", "pointings at a point"),
    },
    "expected_on_layout": {
        "mean": ("m", "expected TOTAL of the mean of all values of a new point, RMS"),
        "worst": ("m", OF_95),
        "percentile_95": ("m", OF_95),
        "largest": ("m", "expected TOTAL of the worst new point"),
        "single": ("m", "expected TOTAL of one model's value anywhere in it, RMS"),
        "single_centre": ("m", "expected TOTAL of one model's value in its middle"),
        "single_edge": ("m", "expected TOTAL of one model's value at its edge"),
        "single_corner": ("m", "expected TOTAL of one model's value in its corners"),
        "paper_mean": ("m", "the same as mean, by the formula of 1971"),
        "paper_single": ("m", "the same as single, by the formula of 1971"),
        "paper_centre": ("m", "the same as single_centre, by the formula of 1971"),
        "paper_edge": ("m", "the same as single_edge, by the formula of 1971"),
        "paper_corner": ("m", "the same as single_corner, by the formula of 1971"),
        "m_0": ("m", "m_0 that the transformations of the low flight will show, TOTAL"),
        "from_control": ("m", "contribution of the control points to mean, TOTAL"),
        "from_high_flight": (
            "m",
            "contribution of measuring in the high flight to mean, TOTAL",
        ),
        "from_low_flight": (
            "m",
            "contribution of measuring in the low flight to mean, TOTAL",
        ),
        "n_new": ("", "new points of the layout"),
        "n_control": ("", "control points of the layout"),
        "n_high_models": ("", "models of the high flight of the layout"),
        "n_low_models": ("", "models of the low flight of the layout"),
    },
    "totals": {
        "area_km2": ("km²", "size of the area"),
        "photographs": ("", "photographs of both flights over the area"),
        "models": ("", "models of both flights over the area"),
        "pointings": ("", "pointings at points of the area, of both flights"),
        "control_points": ("", "control points of the area"),
        "flight_lines": ("", "flight lines of both flights"),
        "length_of_lines": ("m", "length of all flight lines together"),
        "cost": ("", "cost over the whole area, in the currency of the prices"),
    },
}
"""By part, and by name: the unit where it has one, and the meaning."""
SIMULATED = "simulate --json, repetitions.csv"
OF_SIMULATIONS = {
    "seed": ("", "number from which points and errors of a block are drawn"),
    "planned": ("m", "TOTAL that the plan expects of the new points, RMS"),
    "error_total": ("m", "computed less true coordinates of the new points, RMS"),
    "error_total_by_chance": (
        "m",
        (
            "standard deviation of error_total from block to block: points share "
            "errors, and few are independent"
        ),
    ),
    "share_in_ellipses": (
        "",
        "share of the new points whose true position lies in their ellipse (95 %)",
    ),
    "n_repetitions": ("", "how many blocks were simulated and computed"),
}
OF_AREA_LAYER = {
    "square_km": ("km²", "size of the area"),
    "reached_m": ("m", "TOTAL at the place of the target, propagated on the layout"),
    "target_m": ("m", "TOTAL that was asked for"),
    "is_recommended": ("", "whether the target is reached on the layout"),
}
OF_LAYERS = {
    "fid": ("", "number of the row in its layer"),
    "geom": ("m", "polygon, line or point, in the system of the area"),
}
PACKAGE = "flight_plan.gpkg"
LAYERS = {
    "area": tuple(OF_AREA_LAYER),
    **{name: PLAN_COLUMNS[name] for name in ("flight_lines", "photographs", "control")},
}
"""Layers of the GeoPackage with their columns."""
# the tables whose rows stand in a part of the JSON
TABLES_OF = {
    "figures": ("plans", "plan"),
    "next_best": ("plans",),
    "effort": ("effort",),
    "combinations": ("plan",),
}
# what stands nested in one answer, and flat in another
FLAT_FOR_EXPECT = "expected_on_layout"


def meaning_in_json(name, part="figures"):
    """Unit and meaning of a name in a part of the JSON of a plan; None of no name.

    >>> meaning_in_json("area_km2", "totals")
    ('km²', 'size of the area')
    >>> meaning_in_json("gsd", "next_best")
    ('m', 'ground sampling distance: size of a pixel on the ground')
    """
    if found := PLAN_JSON.get(part, {}).get(name):
        return found
    for table in TABLES_OF.get(part, ()):
        if name in PLAN_COLUMNS[table]:
            return meaning_in_plan(name, table)
    return PLAN_JSON[FLAT_FOR_EXPECT].get(name) if part == "figures" else None


def meaning_in_package(name, layer):
    """Unit and meaning of a column in a layer of the GeoPackage; None of no column.

    >>> meaning_in_package("target_m", "area")
    ('m', 'TOTAL that was asked for')
    """
    if name in OF_LAYERS:
        return OF_LAYERS[name]
    if name not in LAYERS.get(layer, ()):
        return None
    own = OF_AREA_LAYER if layer == "area" else {}
    return own.get(name) or meaning_in_plan(name, layer)


def meanings_of_name(name) -> Iterator[Meaning]:
    """Give what a name means in each part of the JSON and of the GeoPackage.

    Columns of tables are left out: their meanings are those of the tables.
    """
    for part, named in PLAN_JSON.items():
        if name in named and part != "next_best":
            yield Meaning(f"{JSON}, {part}".removesuffix(", "), *named[name])
    if name in OF_SIMULATIONS:
        yield Meaning(SIMULATED, *OF_SIMULATIONS[name])
    if name in OF_AREA_LAYER:
        yield Meaning(f"{PACKAGE}, area", *OF_AREA_LAYER[name])
    if name in OF_LAYERS:
        yield Meaning(PACKAGE, *OF_LAYERS[name])


def names_of_figures() -> frozenset[str]:
    """All names of the JSON and of the GeoPackage that no table has alone."""
    parts = (*PLAN_JSON.values(), OF_SIMULATIONS, OF_AREA_LAYER, OF_LAYERS)
    return frozenset(name for part in parts for name in part)
