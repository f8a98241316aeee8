"""What names in the JSON of a plan, in its GeoPackage and in simulations mean.

A row of a plan has the names of its table, whose meanings are those of the columns in
``plan_column_meanings``; here is the rest.
"""

from collections.abc import Iterator
from typing import NamedTuple

from einschalt.foundations.meanings_with_units import unit_and_meaning


class Meaning(NamedTuple):
    """What a name means in one place."""

    place: str  # part of the JSON, or file and layer
    unit: str  # empty where it is no length and nothing that is counted per something
    text: str


JSON = "plan --json"
OF_95 = "expected TOTAL of the new points, 95th percentile: 95 of 100 are better [m]"
OF_ROW = {
    "reached_on_layout": (
        "TOTAL at the place of the target, propagated on the layout; null where the "
        "plan cannot be laid out [m]"
    ),
    "is_recommended": "whether the target is reached on the layout",
    "target": "TOTAL that was asked for [m]",
    "expected_on_layout": "expected precision on the layout, by name",
    "totals": "what the whole area takes, by name; it is counted on the layout",
    "images": (
        "images of both flights; counted on the layout of an area, otherwise estimated "
        "[1/km²]"
    ),
    "models": (
        "models of both flights; counted on the layout of an area, otherwise estimated "
        "[1/km²]"
    ),
    "settings": (
        "pointings of both flights; counted on the layout of an area, otherwise "
        "estimated [1/km²]"
    ),
    "control_points": (
        "control points; counted on the layout of an area, otherwise estimated [1/km²]"
    ),
    "cost": (
        "cost of the plan; counted on the layout of an area, otherwise estimated "
        "[1/km²]"
    ),
}
PLAN_JSON = {
    "": {
        "command": "command that was called",
        "status": (
            "exit status: 0 when the work was done, 1 when no plan reaches the target, "
            "2 when the input or the call is wrong"
        ),
        "problems": "what went wrong or has to be known, one object for each",
        "paths": "files and folders that were written",
        "figures": "headline figures by name",
    },
    "problems": {
        "found": "what was found",
        "expected": "what was expected; null where there is nothing to say",
        "remedy": "how to mend it; null where there is nothing to say",
        "file": "file that it is about, or null",
        "row": "line of the file that it is about, or null",
        "point": "point that it is about, or null",
        "model": "model that it is about, or null",
    },
    "figures": {
        "question": "what was asked: tables, target, area or expect",
        "combinations": (
            "the rows of plan.csv: all combinations of the values that were asked for, "
            "with their figures"
        ),
        **OF_ROW,
        "next_best": (
            "the next best plan by the same names, or null: it comes next in cost and "
            "reaches the target as well"
        ),
        "finer": (
            "values between those that were tried, by choice: a plan of them may be "
            "some per cent cheaper; empty where they were tried as well"
        ),
        "effort": "the rows of effort.csv",
        "cost_of_area": "cost of the plan over the whole area, counted",
        "next_cost_of_area": (
            "cost of the next best plan over the whole area, counted, or null"
        ),
    },
    "next_best": OF_ROW,
    "finer": {
        "scale_number": "scale numbers of the low flight",
        "high_over_low": "those of the high flight over those of the low flight",
        "n_settings": "pointings at a point",
    },
    "expected_on_layout": {
        "mean": "expected TOTAL of the mean of all values of a new point, RMS [m]",
        "worst": OF_95,
        "percentile_95": OF_95,
        "largest": "expected TOTAL of the worst new point [m]",
        "single": "expected TOTAL of one model's value anywhere in it, RMS [m]",
        "single_centre": "expected TOTAL of one model's value in its middle [m]",
        "single_edge": "expected TOTAL of one model's value at its edge [m]",
        "single_corner": "expected TOTAL of one model's value in its corners [m]",
        "paper_mean": "the same as mean, by the formula of 1971 [m]",
        "paper_single": "the same as single, by the formula of 1971 [m]",
        "paper_centre": "the same as single_centre, by the formula of 1971 [m]",
        "paper_edge": "the same as single_edge, by the formula of 1971 [m]",
        "paper_corner": "the same as single_corner, by the formula of 1971 [m]",
        "m_0": "m_0 that the transformations of the low flight will show, TOTAL [m]",
        "from_control": "contribution of the control points to mean, TOTAL [m]",
        "from_high_flight": (
            "contribution of measuring in the high flight to mean, TOTAL [m]"
        ),
        "from_low_flight": (
            "contribution of measuring in the low flight to mean, TOTAL [m]"
        ),
        "n_new": "new points of the layout",
        "n_control": "control points of the layout",
        "n_high_models": "models of the high flight of the layout",
        "n_low_models": "models of the low flight of the layout",
    },
    "totals": {
        "area_km2": "size of the area [km²]",
        "photographs": "photographs of both flights over the area",
        "models": "models of both flights over the area",
        "pointings": "pointings at points of the area, of both flights",
        "control_points": "control points of the area",
        "flight_lines": "flight lines of both flights",
        "length_of_lines": "length of all flight lines together [m]",
        "cost": "cost over the whole area, in the currency of the prices",
    },
}
"""By part, and by name: the unit where it has one, and the meaning."""
SIMULATED = "simulate --json, repetitions.csv"
OF_SIMULATIONS = {
    "seed": "number from which points and errors of a block are drawn",
    "planned": "TOTAL that the plan expects of the new points, RMS [m]",
    "error_total": "computed less true coordinates of the new points, RMS [m]",
    "error_total_by_chance": (
        "standard deviation of error_total from block to block: points share errors, "
        "and few are independent [m]"
    ),
    "share_in_ellipses": (
        "share of the new points whose true position lies in their ellipse (95 %)"
    ),
    "n_repetitions": "how many blocks were simulated and computed",
}
OF_AREA_LAYER = {
    "square_km": "size of the area [km²]",
    "reached_m": "TOTAL at the place of the target, propagated on the layout [m]",
    "target_m": "TOTAL that was asked for [m]",
    "is_recommended": "whether the target is reached on the layout",
}
OF_LAYERS = {
    "fid": "number of the row in its layer",
    "geom": "polygon, line or point, in the system of the area [m]",
}
PACKAGE = "flight_plan.gpkg"


def meanings_of_name(name) -> Iterator[Meaning]:
    """Give what a name means in each part of the JSON and of the GeoPackage.

    Columns of tables are left out: their meanings are those of the tables.
    """
    named = {
        f"{JSON}, {part}".removesuffix(", "): names
        for part, names in PLAN_JSON.items()
        if part != "next_best"
    }
    named |= {SIMULATED: OF_SIMULATIONS}
    named |= {f"{PACKAGE}, area": OF_AREA_LAYER, PACKAGE: OF_LAYERS}
    for place, names in named.items():
        if name in names:
            yield Meaning(place, *unit_and_meaning(names[name]))


def names_of_figures() -> frozenset[str]:
    """All names of the JSON and of the GeoPackage that no table has alone."""
    parts = (*PLAN_JSON.values(), OF_SIMULATIONS, OF_AREA_LAYER, OF_LAYERS)
    return frozenset(name for part in parts for name in part)
