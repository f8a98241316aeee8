"""Regions of control that are displaced, all points of each by the same vector.

All models of both flights, adjusted at once, tell what they know of the errors of
control (``ControlScores``). A scan of these finds a part of the network of whatever
shape that lies apart from the rest, where a step along a line only cuts through it.
Single points look wrong then, and the flights seem to have measured other targets:
where a region explains everything, none of them is to blame by itself.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.spatial import cKDTree

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.evidence.control.signatures import PLAN as AXES
from einschalt.pipeline.assessment.evidence.control.signatures import (
    Kind,
    Pattern,
    Signatures,
)
from einschalt.pipeline.assessment.evidence.ground.given_region import (
    SURELY,
    KnownPoints,
    by_known_points,
    exceeds_stated,
    told_region,
    turned,
)
from einschalt.pipeline.assessment.known_points import given_errors
from einschalt.stages.error_propagation.error_model import CONTROL
from einschalt.stages.error_propagation.given_points import PLAN
from einschalt.theory.adjustment.displaced_group import find_displaced_group
from einschalt.theory.adjustment.displaced_regions import find_displaced_regions
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.block_adjustment.common_parameters import COMPLEX

# of shifts of two regions: what is as near is one region
ALIKE = 0.1
# of a shift: differences of check points that are less have no sign
LEAST_MISS = 0.15
# times the stated errors: where what is left beside regions is larger, something else
# is wrong as well
MOST_ENLARGED = 2.0
# points that are predicted: fewer tell no region, of more covariances are too large
FEWEST, MOST_CONTROL = 10, 500


@dataclass(frozen=True, eq=False)
class _Checks:
    """What the adjustment of everything knows of control, written out."""

    scores: np.ndarray  # complex (n,)
    information: np.ndarray  # (n, n)

    def times(self, columns):
        """Information times columns, sparse or dense."""
        return np.asarray((columns.T @ self.information).T)

    def draw(self, n_draws, seed):
        """Scores of errors of the given sizes, complex (n, n_draws)."""
        values, vectors = np.linalg.eigh(self.information)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        normal = np.random.default_rng(seed).standard_normal
        shape = (len(values), n_draws)
        return root @ (normal(shape) + 1j * normal(shape))


def scan_control(two_step):
    """Look for regions of control that are displaced: GivenRegion each, a tuple.

    Under a high flight only, which control is of. Empty where chance explains
    everything, or errors as large as stated that neighbours may share.
    """
    model = two_step.error_model
    if two_step.block.high_flight is None or model is None:
        return ()
    errors, known = model.standard_errors.get(CONTROL), _known_of_control(two_step)
    if known is None or errors is None:
        return ()
    places, checks = known
    control = two_step.block.control_points.iloc[places]
    errors = np.reshape(errors, (len(two_step.block.control_points), -1))[places, 0]
    if not (errors > 0.0).all():
        return ()
    xy = values_of(control, PLAN)
    found = _regions(checks, errors, xy - xy.mean(axis=0))
    if not found:
        found = _group(two_step, control, checks, errors)
    elif len(found) == 1:
        found = _group(two_step, control, checks, errors, found[0].rows) or found
    if not found:
        return ()

    def beside(region):
        """Check points; of two steps, which hold control."""
        return [check_points_beside(two_step, xy, region)]

    found, is_decided = by_known_points(found, len(control), beside)
    n_elsewhere = len(control) - sum(len(region.rows) for region in found)
    how = {"is_of_control": True, "is_decided": is_decided}
    return tuple(
        told_region(
            control, region, n_elsewhere, moved_with(region, *beside(region)), **how
        )
        for region in found
    )


def _regions(checks, errors, xy):
    """Parts of the control that lie together."""
    scan = find_displaced_regions(checks, errors**-2.0, xy)
    found = scan.regions if scan.enlargement < MOST_ENLARGED else ()
    if not found or not exceeds_stated(found, errors * scan.enlargement):
        return ()
    return _smaller_part(_merged(found), len(xy))


def _group(two_step, control, checks, errors, region=()):
    """A part whose points lie anywhere, if it explains more than a region: a list.

    None where a line parts it from the others, which is told as such.
    """
    if len(control) > MOST_CONTROL:
        return []
    xy = values_of(control, PLAN)
    among = checks.scores, checks.information, xy - xy.mean(axis=0)
    group = find_displaced_group(*among, FINDING_SIGNIFICANCE, region)
    if group is None or not exceeds_stated((group,), errors):
        return []
    step = two_step.network_step
    if step is not None:
        is_behind = is_among(control["point_id"], list(step.point_ids))
        n_behind = np.count_nonzero(is_behind[group.rows])
        if is_behind.sum() == n_behind == len(group.rows):
            return []
    return [group]


def _known_of_control(two_step):
    """Rows of control, and what is known of its errors, _Checks; None without.

    By the adjustment of everything, or where there is none, as of spatial models, by
    what the others predict for each point.
    """
    scores, left_out = two_step.patterns.scores, two_step.left_out_control
    if scores is not None:
        return scores.places, _Checks(scores.values @ COMPLEX, scores.information)
    if left_out is None or not FEWEST <= len(left_out.point_ids) <= MOST_CONTROL:
        return None
    control, signatures = two_step.block.control_points, Signatures(two_step, left_out)
    is_used = (control["role"] != "check").to_numpy()
    is_used = is_used & ~is_among(control["point_id"], two_step.excluded_control)
    points = [Pattern(Kind.POINT, row) for row in np.eye(len(control))[is_used]]
    shown, covariance = signatures.of(points, AXES), signatures.covariance(AXES)
    try:
        root = np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:  # points without errors of their own
        return None
    white = solve_triangular(root, signatures.observed(AXES), lower=True)
    n, n_errors = shown.shape[:2]
    design = np.moveaxis(shown, 0, 1).reshape(n_errors, 2 * n)
    design = solve_triangular(root, design, lower=True)
    # in either axis alike: what one of them says of the other is hardly anything
    scores = (design.T @ white).reshape(n, 2) @ COMPLEX
    information = (design.T @ design).reshape(n, 2, n, 2)
    information = np.einsum("iaja->ij", information) / 2.0
    return np.flatnonzero(is_used), _Checks(scores, information)


def check_points_beside(two_step, xy, region):
    """Check points as KnownPoints: inside where the nearest control point is."""
    points = two_step.points
    points = points[(points["role"] == "check").to_numpy()]
    misses = values_of(points, ["difference_easting", "difference_northing"])
    given = values_of(points, PLAN) - misses
    is_known = np.isfinite(misses).all(axis=1)
    points, given = points[is_known], given[is_known]
    errors = np.hypot(
        points[two_step.claimed_column].to_numpy(dtype=float),
        given_errors(two_step, points["point_id"]),
    )
    return KnownPoints(
        points["point_id"].to_numpy(dtype=object),
        np.isin(cKDTree(xy).query(given)[1], region.rows),
        misses[is_known],
        errors / SQRT2,
    )


def moved_with(region, check):
    """The check points that are displaced with a region, as KnownPoints.

    The block moves with control by a part of the shift, and they by nothing or by all
    of it: what sign the difference has tells, or the place where there is none.
    """
    along = check.misses @ region.shift / (region.shift @ region.shift)
    is_alike = np.where(np.abs(along) < LEAST_MISS, check.is_inside, along < 0.0)
    return replace(check, is_inside=is_alike)


def _merged(regions):
    """Regions, those that are displaced alike as one."""
    merged = []
    for region in regions:
        place = next((k for k, each in enumerate(merged) if _alike(each, region)), None)
        if place is None:
            merged.append(region)
        else:
            merged[place] = _together(merged[place], region)
    return merged


def _alike(one, other):
    error = np.hypot(one.standard_error, other.standard_error)
    most = max(SURELY * error, ALIKE * np.hypot(*one.shift))
    return np.hypot(*(one.shift - other.shift)) < most


def _together(one, other):
    weights = np.array([one.standard_error, other.standard_error]) ** -2.0
    shift = np.average([one.shift, other.shift], axis=0, weights=weights)
    return replace(
        one,
        rows=np.union1d(one.rows, other.rows),
        shift=shift,
        standard_error=max(one.standard_error, other.standard_error),
        p_value=max(one.p_value, other.p_value),
    )


def _smaller_part(regions, n):
    """The region that is left where most points are in one: it is off the other way."""
    if len(regions) != 1 or 2 * len(regions[0].rows) <= n:
        return regions
    return [turned(regions[0], n)]
