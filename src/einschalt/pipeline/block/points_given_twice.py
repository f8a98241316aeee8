"""Points that are given twice: as known points, and as approximate points.

Before anything is computed they show where approximate coordinates, or control beside
them, are wrong: of a region, or of a single point.
"""

import numpy as np

from einschalt.foundations.errors import name_some
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode
from einschalt.theory.adjustment.multiple_testing import bonferroni
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

PLAN = ["easting", "northing"]


def contradictions(block, control, approximate, sources):
    """Note the points that are given in two places, farther apart than chance explains.

    Parameters
    ----------
    block : Block
        With the errors of the approximate coordinates; without these, there is no note.
    control, approximate : DataFrame
        point_id, easting, northing; control with standard_error_m (TOTAL) where it has
        errors.
    sources : tuple of str
        Names of the files of both.

    Returns
    -------
    list of str
        One note, or none.
    """
    error = block.approximate_m_0_m
    if not (isinstance(error, (int, float)) and error > 0.0):
        return []
    groups = ("control_points", "approximate_points")
    shared = [block.group_errors_m.get(table, 0.0) or 0.0 for table in groups]
    names = encode(control["point_id"])
    place = encode(approximate["point_id"]).locate(names)[names.codes]
    known = control[place >= 0]
    other = values_of(approximate, PLAN)[place[place >= 0]]
    apart = np.hypot(*(other - values_of(known, PLAN)).T)
    own = np.zeros(len(known))
    if "standard_error_m" in known:
        own = known["standard_error_m"].fillna(0.0).to_numpy(dtype=float)
    # normal errors of both coordinates: TOTAL squares are twice those of each
    p_value = np.exp(-(apart**2) / (np.sum(np.square([error, *shared])) + own**2))
    rows = np.flatnonzero(bonferroni(p_value) < FINDING_SIGNIFICANCE)
    if not len(rows):
        return []
    rows = rows[np.argsort(-apart[rows], kind="stable")]
    points = name_some(known["point_id"].iloc[rows])
    note = (
        f"{sources[1]}: {len(rows)} of {len(known)} points that {sources[0]} gives too "
        f"lie elsewhere here, by up to {apart[rows[0]]:.3g} m, more than the stated "
        f"errors explain: {points}"
    )
    return [note]
