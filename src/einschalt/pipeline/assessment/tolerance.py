"""Tolerances: pass or fail of every point, with the figure that was used.

Source: Austrian surveying ordinances (VermV) of 1994 § 7, 2010 § 6 and 2016 § 6; see
docs/tolerances.md.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.language import mark
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.credibility import TOTAL
from einschalt.pipeline.assessment.credible_heights import COLUMN as HEIGHT
from einschalt.pipeline.settings import NO_TOLERANCE

GROSS = 10.0
"""So many times the claim an error is that of the block: names, control, units. No
residual of a point need show it, and no point's own figure says anything."""


@dataclass(frozen=True)
class Tolerance:
    """What an ordinance, or the user, allows."""

    title: str
    point: float  # largest standard error of a point, TOTAL [m]
    # largest difference at a control point [m]; NaN where none is set
    control: float = np.nan


PRESETS = {
    "vermv_1994": Tolerance(mark("VermV 1994 § 7, densification points"), 0.07),
    "vermv_2010": Tolerance(mark("VermV 2010 § 6, survey points"), 0.04),
    "vermv_2016": Tolerance(mark("VermV 2016 § 6, points not by GNSS"), 0.04, 0.05),
}


@dataclass(frozen=True)
class CheckedFigure:
    """The figure of precision that the tolerance is held against."""

    column: str  # of ``points``; empty where no figure is known
    factor: float  # by which it was enlarged, since measurements exceed it
    # whether the measurements leave it standing. Where they do not, the true error is
    # larger by an unknown amount.
    is_supported: bool
    is_tested: bool  # whether any measurement could have contradicted it
    # whether it is told which points are off, where given points are displaced
    is_told: bool = True


def tolerance_of(settings):
    """The tolerance that the settings ask for, or None."""
    asked = settings.tolerance
    if asked == NO_TOLERANCE:
        return None
    return PRESETS[asked] if asked in PRESETS else Tolerance(mark("as set"), asked)


def checked_figure_of_two_steps(examined) -> CheckedFigure:
    """The propagated figure, or the larger one of the budget, as it was tested."""
    if examined.is_put_off:
        return _checked_beside_points_put_off(examined)
    figure = examined.credible
    return CheckedFigure(
        figure.column,
        figure.factor,
        is_supported=examined.claim.is_supported and not _is_bound(figure),
        is_tested=bool(examined.claim.tests),
    )


def _is_bound(figure):
    """Whether points may be worse than a figure, and nothing tells which."""
    return figure.is_lower_bound and not figure.is_bound_by_names


def checked_figure_of_adjustment(examined) -> CheckedFigure:
    """The figure of one adjustment, never made smaller by s_0.

    It falls where known points or residuals contradict it.
    """
    if examined.is_put_off:
        return _checked_beside_points_put_off(examined)
    redundancy, n_check = examined.adjustment.redundancy, examined.figures.n_check
    return CheckedFigure(
        column=TOTAL if TOTAL in examined.points else "",
        factor=examined.credible.factor,
        is_supported=not _is_bound(examined.credible),
        is_tested=redundancy > 0 or n_check > 0,
    )


def _checked_beside_points_put_off(examined):
    """That of the points which no displaced region or point moves, if it is told."""
    figure, is_told = examined.corrected.checked, examined.displaced_part_is_told
    is_supported = figure.is_supported and is_told
    return replace(figure, is_supported=is_supported, is_told=is_told)


def _is_block_suspect(examined):
    """Whether the block is off by so much more than its claim that no point is good.

    Beside single given points that are wrong, what they do to each point is known.
    """
    if examined.wrong_given_points and not examined.displaced_regions:
        examined = examined.corrected
    found, figures = examined.credible, examined.figures
    claimed = np.fmin(figures.mean_total, figures.mean_paper)
    # what a new point under the name of a known one does is known of that point
    value = found.elsewhere if found.is_bound_by_names else found.value
    return bool(found.is_lower_bound and value > GROSS * claimed)


def judged_points(examined):
    """Judge every point: what its figure is worth, and whether it is to be doubted.

    With ``standard_error_checked`` (the figure to believe, TOTAL [m], enlarged where
    measurements exceed it; a lower bound where the claim does not stand), and
    ``standard_error_height_checked`` where heights have standard errors;
    ``is_suspect`` holds the points of ``suspects``, those of a displaced region, those
    that are given wrong, and all points where the figure is a lower bound more than
    ``GROSS`` times what was claimed; with a tolerance in the settings
    ``is_within_tolerance``. Nothing passes where the claim does not stand, and no
    suspect passes.
    """
    points = examined.points
    if points.empty:
        return points
    used, tolerance = examined.checked, tolerance_of(examined.settings)
    figure = points[used.column].to_numpy(dtype=float) if used.column else np.nan
    if used.column != TOTAL:  # which alone holds what all points share
        figure = np.hypot(figure, examined.figures.shared_error / used.factor)
    off = examined.moved_by_region
    for lone in examined.lone_points:
        off = np.where(points["point_id"] == lone.found_there, lone.miss, off)
    checked = np.hypot(used.factor * figure, off)
    is_suspect = points["is_suspect"] | points["point_id"].isin(examined.suspects)
    is_suspect |= _is_block_suspect(examined)
    is_suspect |= examined.is_displaced
    wrong = [each.point_id for each in examined.wrong_given_points]
    is_suspect |= is_among(points["point_id"], wrong)
    judged = points.assign(standard_error_checked=checked, is_suspect=is_suspect)
    if HEIGHT in points:
        factor = examined.credible_heights.factor
        judged[f"{HEIGHT}_checked"] = factor * points[HEIGHT]
    if tolerance is None:
        return judged
    # a figure that is not known passes nothing: nan <= limit is False
    is_small = checked <= tolerance.point
    return judged.assign(is_within_tolerance=is_small & used.is_supported & ~is_suspect)
