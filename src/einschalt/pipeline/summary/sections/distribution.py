"""How far the distribution of control residuals moved the points."""

import numpy as np

from einschalt.foundations.typesetting import lengths
from einschalt.pipeline.summary.sections.section import Section

SHARES = (
    "Control points keep the coordinates that were given; the others took their share "
    "of the differences (distributed_easting, distributed_northing)."
)
BEFORE = "paper and internal are figures before the distribution"
FIGURES = f"{BEFORE}; the propagated one is that after it."


def section(result) -> Section:
    """Say how far points of each role were moved; no rows where nothing was."""
    points = result.points
    rows = []
    if "distributed_easting" in points:
        moved = np.hypot(points["distributed_easting"], points["distributed_northing"])
        for role, of_role in moved.groupby(points["role"]):
            root_mean_square = np.sqrt(np.mean(of_role**2))
            rows.append(
                (
                    f"{role} points",
                    f"{len(of_role):d}",
                    *lengths([root_mean_square, of_role.max()]),
                )
            )
    way = result.settings.residual_distribution.replace("_", " ")
    return Section(
        f"Residuals of control, distributed by {way} (total)",
        ("", "points", "moved, RMS", "at most"),
        tuple(rows),
        (SHARES, FIGURES if "standard_error_total" in points else f"{BEFORE}."),
    )
