"""What a transformation makes of identical points that it was not told."""

import numpy as np

from einschalt.foundations.errors import name_some
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, translated

DIFFERENCES = ["difference_easting", "difference_northing"]


def held_out_points(fit):
    """Identical points, each predicted by its model without it: DataFrame.

    coverage, model_id, point_id, difference_easting, difference_northing (predicted
    minus given) [m] of a ModelTransformation. A residual v of leverage h becomes
    v / (1 − h), without a new fit: exactly for affine and helmert, to first order for
    the others. NaN where the model is not determined without the point.
    """
    differences = without_point(fit.fit.residuals[:, :2], fit.fit.leverage[:, :2])
    return table_of_differences(fit, differences)


def without_point(residuals, leverage):
    """Differences of points from models that were fitted without them [m].

    ``residuals`` (n_points, 2) [m], ``leverage`` (n_points, 1) or (n_points, 2); NaN
    where the model is not determined without the point.

    >>> without_point([[0.02, 0.01], [0.0, 0.0]], [[0.5], [1.0 - 1e-12]])
    array([[0.04, 0.02],
           [ nan,  nan]])
    """
    redundancy = 1.0 - np.asarray(leverage, dtype=float)
    is_held = redundancy > np.sqrt(np.finfo(float).eps)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(is_held, np.asarray(residuals) / redundancy, np.nan)


def table_of_differences(fit, differences):
    """Differences (n_points, 2) [m] beside the names of the identical points."""
    table = fit.observed.rows.reset_index(drop=True)
    table[DIFFERENCES] = differences
    return table


def held_out_error(differences):
    """TOTAL RMS of held-out points [m], and their number; NaN where there are none."""
    squares = (np.asarray(differences, dtype=float) ** 2).sum(axis=1)
    known = squares[np.isfinite(squares)]
    return (float(np.sqrt(known.mean())) if len(known) else np.nan), len(known)


def said_of_held_out(error, n_held):
    """Say how large the error of held-out points is."""
    return translated(
        "held-out points (total, RMS of {n:point|points})  {error} m",
        n=n_held,
        error=figure(error, ".4f"),
    )


def said_of_left_out(left_out):
    """Say which identical points took no part."""
    return translated(
        "{n:point|points} left out: {names}",
        n=len(left_out),
        names=retold(name_some(left_out["point_id"])),
    )
