"""Suspects that stand out of all tests of a block, and those that chance makes.

A model is tested at a level at which one good model in a thousand has a suspect. Of a
block with many models that is no reason to say anything, and none to believe its
claim less: only what stands out of all tests, and is told, counts against it.
"""

import numpy as np

from einschalt.foundations.key_columns import rows_among
from einschalt.pipeline.assessment.evidence.control.expected_scatter import (
    expected_spread,
)
from einschalt.theory.adjustment.multiple_testing import any_significant
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

OBSERVATION = ["flight", "coverage", "model_id", "point_id"]
# of the usual distance between the models of a point
LARGE_SPREAD = 5.0


def residuals_not_yet_named(examined):
    """Residuals of all but the gross measurements, where a finding names these."""
    residuals, found = examined.residuals, examined.named_measurements
    if found.empty:
        return residuals
    return residuals[~rows_among(residuals, found, OBSERVATION)]


def residuals_stand_out(examined):
    """Whether the worst residual is more than chance makes of all of them."""
    p_value = residuals_not_yet_named(examined)["p_value"].to_numpy(dtype=float)
    return any_significant(p_value, FINDING_SIGNIFICANCE)


def coverages_stand_out(examined):
    """Whether the worst difference of coverages is, or nothing tells of chance."""
    p_value = examined.coverages["p_value"].to_numpy(dtype=float)
    if not np.isfinite(p_value).any():
        return True
    n_tested = examined.screening.n_tested
    return any_significant(p_value, FINDING_SIGNIFICANCE, n_tested)


def points_far_apart(examined):
    """Which points have models that lie much farther apart than is usual, a mask.

    And farther than the errors of these models, where they are propagated.
    """
    points = examined.points
    spread = points["spread_total"].to_numpy(dtype=float)
    usual = np.nanmedian(spread) if np.isfinite(spread).any() else 0.0
    is_far = (spread > LARGE_SPREAD * usual) & (usual > 0.0)
    if is_far.any():
        expected = expected_spread(examined, points.loc[is_far, "point_id"])
        is_far[is_far] = ~(spread[is_far] <= LARGE_SPREAD * expected)
    return is_far


def suspects_by_chance(examined):
    """Names of points that are suspects of tests out of which none stands, a set."""
    found, told = set(), set(examined.named_measurements["point_id"])
    rest, coverages = residuals_not_yet_named(examined), examined.coverages
    for table, stand_out in (
        (rest, residuals_stand_out(examined)),
        (coverages, coverages_stand_out(examined)),
    ):
        names = table.loc[table["is_suspect"].astype(bool), "point_id"]
        (told if stand_out else found).update(names)
    points = examined.points
    told.update(points.loc[examined.far_apart, "point_id"])
    return found - told
