"""What a test of the whole block must leave out, since each is named by itself.

A gross error tells nothing of the size of measuring errors, or of control, but would
decide every test and figure that it took part in.
"""

import numpy as np

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import is_among
from einschalt.pipeline.densification.gross_errors import is_gross
from einschalt.stages.coverage_screening import DIFFERENCES, coverage_differences
from einschalt.stages.error_propagation.error_model import HIGH, LOW
from einschalt.stages.model_screening import suspect_rows

# beyond this share suspects are no gross errors: the model of errors is wrong
MOST_SUSPECTS = 0.05
# times the median of the errors that coverage differences have
BADLY_DETERMINED = 3.0


def gross_rows(examined, flight, transformation):
    """Tell which model points of a flight are gross errors, (n_model_points,).

    Suspects of their model, and what contradicts the other models of the flight. A
    point of the low flight without approximate coordinates has no residual: its
    coverages tell.
    """
    points = examined.model_points[flight]
    is_out = suspect_rows(transformation.own_values, transformation)
    is_out |= is_gross(examined.gross_measurements, flight, points)
    if flight == LOW:
        has_residual = np.zeros(len(points), dtype=bool)
        has_residual[transformation.observed.row_numbers] = True
        suspects = examined.screening.suspects
        is_out |= ~has_residual & is_among(points["point_id"], suspects)
    return is_out


def excluded_control(two_step):
    """Names of the control points whose high-flight measurements are all gross errors.

    Nothing follows from their given coordinates: these, or the measurements, are wrong.
    """
    gross, control = two_step.gross_measurements, two_step.block.control_points
    gross = gross.loc[gross["flight"] == HIGH, "point_id"]
    if control is None or gross.empty:
        return frozenset()
    measured = two_step.model_points[HIGH]["point_id"].value_counts()
    out = gross.value_counts()
    names = out.index[(out == measured.reindex(out.index)).to_numpy()]
    return frozenset(names[is_among(names, control["point_id"])])


def good_rows(is_suspect):
    """All but the suspects; everything where there are too many of them."""
    if is_suspect.sum() > MOST_SUSPECTS * len(is_suspect):
        return np.ones(len(is_suspect), dtype=bool)
    return ~is_suspect


def internal_of_good_points(two_step):
    """Internal figure of the new points without those whose coverages differ [m].

    And, where means are of least variance, without those of which one coverage is
    determined so badly that it hardly counts in the mean. TOTAL; NaN where no point has
    two coverages. The figure of the block has them all.
    """
    internal, screening = two_step.figures.mean_internal, two_step.screening
    table = coverage_differences(two_step.means).needed().table
    good = np.ones(len(table), dtype=bool)
    if len(screening.suspects):
        good = good_rows(table["point_id"].isin(screening.suspects).to_numpy())
    if two_step.means.is_rigorous and screening.is_propagated:
        good &= ~is_among(table["point_id"], _badly_determined(screening.table))
    if good.all() or not good.any():
        return internal
    squares = np.sum(values_of(table, DIFFERENCES) ** 2, axis=1)
    whole = np.mean(squares)
    return float(internal * np.sqrt(np.mean(squares[good]) / whole)) if whole else 0.0


def _badly_determined(coverages):
    """Points of which a coverage has an error far beyond that of most differences."""
    error = coverages["standard_error_difference"].to_numpy(dtype=float)
    if not np.isfinite(error).any():
        return coverages["point_id"].iloc[:0]
    is_bad = error > BADLY_DETERMINED * np.nanmedian(error)
    return coverages.loc[is_bad, "point_id"].unique()
