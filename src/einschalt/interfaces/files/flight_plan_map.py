"""flight_plan.gpkg: area, flight lines, photographs and control as map layers."""

import numpy as np
import pandas as pd

from einschalt.interfaces.files import map_shapes
from einschalt.interfaces.files.geopackage import write_layers
from einschalt.interfaces.files.map_layers import Layer

FILE = "flight_plan.gpkg"


def write_flight_plan(plan, path):
    """Write an AreaPlan as GeoPackage, in the system of its area."""
    flown, area = plan.flown, plan.area
    lines = flown.flight_lines
    ends = [["start_easting", "start_northing"], ["end_easting", "end_northing"]]
    from_to = np.stack([lines[names].to_numpy(dtype=float) for names in ends], axis=1)
    about = pd.DataFrame(
        {
            "square_km": [area.square_km],
            "reached_m": [plan.checked.reached],
            "target_m": [plan.checked.target],
            "is_recommended": [plan.is_recommended],
        }
    )
    layers = [
        Layer(
            "area",
            about,
            map_shapes.shapes([area.shape]),
            "Polygon" if area.shape.geom_type == "Polygon" else "MultiPolygon",
            "What is covered, and the total error that is to be expected [m]",
        ),
        Layer(
            "flight_lines",
            lines,
            map_shapes.lines(from_to),
            "LineString",
            "Flight lines, from their first to their last photograph",
        ),
        Layer(
            "photographs",
            flown.photographs,
            map_shapes.points(_plane(flown.photographs)),
            "Point",
            "Where photographs are taken; heights in metres",
        ),
        Layer(
            "control",
            flown.control,
            map_shapes.points(_plane(flown.control)),
            "Point",
            "Where control is to be signalised and surveyed",
        ),
    ]
    write_layers(layers, area.crs, path)


def _plane(table):
    return table[["easting", "northing"]].to_numpy(dtype=float)
