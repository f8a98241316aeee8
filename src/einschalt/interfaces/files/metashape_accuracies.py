"""Accuracies and switches of points, as Metashape states them: of one coordinate."""

import numpy as np

from einschalt.foundations.errors import name_some
from einschalt.foundations.number_parsing import is_number

OFF = {"0", "false", "no"}
ERRORS = ("standard_error_m", "standard_error_height")


def is_on(text):
    """Whether a switch is on: ``true`` of newer versions, ``1`` of older ones."""
    return text.strip().casefold() not in OFF


def accuracy(text):
    """Accuracy in metres; NaN where there is none, which may be written as 0."""
    is_stated = is_number(text or "") and 0.0 < float(text) < np.inf
    return float(text) if is_stated else np.nan


def in_plan(both, east, north):
    """TOTAL of both coordinates: of one number for each, or of two [m]."""
    return np.sqrt(2.0) * both if np.isfinite(both) else np.hypot(east, north)


def with_errors(table, source):
    """The table without errors that some points have not; and notes.

    ``table`` has a column for each of ERRORS [m], NaN where a point has none.
    """
    kept = [name for name in ERRORS if len(table) and table[name].notna().all()]
    left = [name for name in ERRORS if name not in kept and table[name].notna().any()]
    notes = []
    if kept:
        notes.append(f"{source}: its accuracies are standard errors of these points")
    if left:
        notes.append(
            f"{source}: {name_some(left)} left out, since some points have no accuracy"
        )
    unknown = [name for name in ERRORS if name not in kept]
    return table.drop(columns=unknown), tuple(notes)
