"""Densified minus given coordinates at the known points."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.frame_columns import values_of
from einschalt.pipeline.assessment.evidence.claim import KNOWN, LEFT_OUT

MOST_NAMED = 3


@dataclass(frozen=True)
class LeftOutFacts:
    """Control points, each predicted from all the others."""

    # mean of the squares over what the standard errors let expect
    normalized_square: float
    worst: tuple[str, ...]  # names, the one of the smallest probability first
    largest: float  # difference at the first of them, TOTAL [m]


@dataclass(frozen=True)
class KnownPointFacts:
    """Differences at the known points."""

    # what was compared, number of points, root mean square, TOTAL [m]
    differences: tuple[tuple[str, int, float], ...]
    left_out: LeftOutFacts | None  # None where no control point could be left out


def known_point_facts(examined) -> KnownPointFacts:
    """Collect the differences at control and check points."""
    figures, left_out = examined.figures, examined.control_left_out
    rms = float(np.sqrt(np.mean(_total(left_out) ** 2))) if len(left_out) else 0.0
    rows = (
        (KNOWN["control"], figures.n_control, figures.control_rms),
        (LEFT_OUT, len(left_out), rms),
        (KNOWN["check"], figures.n_check, figures.check_rms),
    )
    return KnownPointFacts(tuple(row for row in rows if row[1]), _left_out(examined))


def _left_out(examined):
    table = examined.control_left_out
    if table.empty:
        return None
    worst = table.sort_values("p_value", kind="stable").head(MOST_NAMED)
    return LeftOutFacts(
        float(examined.left_out_control.normalized_square),
        tuple(worst["point_id"]),
        float(_total(worst)[0]),
    )


def _total(table):
    differences = values_of(table, ["difference_easting", "difference_northing"])
    return np.sqrt(np.sum(differences**2, axis=1))
