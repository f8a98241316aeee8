"""flight_plan.gpkg: area, flight lines, photographs and control as map layers."""

import numpy as np
import pandas as pd

from einschalt.interfaces.files import map_shapes
from einschalt.interfaces.files.geopackage import write_layers
from einschalt.interfaces.files.map_layers import Layer

FILE = "flight_plan.gpkg"


def write_flight_plan(plan, path):
    """Write an AreaPlan as GeoPackage, in the system of its area."""
    flown = plan.flown
    layers = [
        _area_layer(plan),
        _lines_layer(flown.flight_lines),
        _points_layer(
            "photographs", flown.photographs, "Where photographs are taken; metres"
        ),
        _points_layer(
            "control", flown.control, "Where control is to be signalised and surveyed"
        ),
    ]
    write_layers(layers, plan.area.crs, path)


def _area_layer(plan):
    shape = plan.area.shape
    about = pd.DataFrame(
        {
            "square_km": [plan.area.square_km],
            "reached_m": [plan.checked.reached],
            "target_m": [plan.checked.target],
            "is_recommended": [plan.is_recommended],
        }
    )
    said = "What is covered, and the total error that is to be expected [m]"
    return Layer("area", about, map_shapes.shapes([shape]), shape.geom_type, said)


def _lines_layer(lines):
    ends = [["start_easting", "start_northing"], ["end_easting", "end_northing"]]
    from_to = np.stack([lines[names].to_numpy(dtype=float) for names in ends], axis=1)
    said = "Flight lines, from their first to their last photograph"
    shapes = map_shapes.lines(from_to)
    return Layer("flight_lines", lines, shapes, "LineString", said)


def _points_layer(name, table, said):
    return Layer(name, table, map_shapes.points(_plane(table)), "Point", said)


def _plane(table):
    return table[["easting", "northing"]].to_numpy(dtype=float)
