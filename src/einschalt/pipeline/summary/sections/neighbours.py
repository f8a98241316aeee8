"""How well the coordinates of neighbours agree: the precision of their differences."""

import numpy as np

from einschalt.foundations.typesetting import length, lengths
from einschalt.pipeline.summary.sections.section import Section

REMARK = (
    "Neighbours share errors. Their coordinate differences have the first figure; the "
    "second is what two independent points of their precision would have."
)


def section(result) -> Section:
    """Precision of coordinate differences between neighbours; no rows where unknown."""
    table = result.neighbours
    if table.empty:
        return Section("", (), ())
    figures = [
        np.sqrt(np.mean(table[name].to_numpy() ** 2))
        for name in ("standard_error_total", "standard_error_if_independent")
    ]
    distance = length(float(table["distance"].median()))
    row = ("neighbours", f"{len(table):d}", distance, *lengths(figures))
    header = ("", "pairs", "median distance", "propagated", "if independent")
    title = "Coordinate differences between neighbours (total, RMS)"
    return Section(title, header, (row,), (REMARK,))
