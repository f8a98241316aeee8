"""The errors of the new points that figures are about."""

import numpy as np

from einschalt.foundations.arguments import described, is_choice
from einschalt.foundations.errors import SettingsError, TableError, name_some


def error_column(result, column=None) -> str:
    """Column of the points that is drawn: the one that is claimed where none is said.

    SettingsError where the points have no such standard error.
    """
    if column is None:
        return result.assessment.credible.column
    known = [n for n in result.points if n.startswith(("standard_error_", "spread_"))]
    if not is_choice(column, known):
        raise SettingsError(
            f"column = {described(column)} is none of the points",
            expected=name_some(known, 12),
        )
    return column


def claimed_errors(result, column=None):
    """Standard errors of the new points, those that are known, and their column [m]."""
    column, points = error_column(result, column), result.points
    errors = points.loc[points["role"] == "new"].get(column)
    errors = np.empty(0) if errors is None else errors.to_numpy(dtype=float)
    errors = errors[np.isfinite(errors)]
    if not errors.size:
        raise TableError(
            f"no new point of this result has a {column}",
            expected="new points, and errors whose sizes are known",
        )
    return column, errors
