"""Control of an adjustment against approximate points that agree among themselves.

An adjustment follows control and does without approximate points; half of the control
that lies apart bends its models, and leaves hardly a residual. Approximate points with
errors of their own, as of GNSS, show it where two steps go onto them: if what tells of
errors that these share is silent, it is control that contradicts them.

See docs/theory/claim.md.
"""

from dataclasses import replace

import numpy as np
from scipy.special import chdtrc

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.assessment.evidence.claim import KNOWN, REGIONS, missed_in_plan
from einschalt.pipeline.assessment.evidence.control.displacements import (
    moved_between_ways,
)
from einschalt.pipeline.assessment.evidence.known_differences import (
    MOST_POINTS,
    covariance_in_plan,
)
from einschalt.stages.error_propagation.given_points import (
    PLAN,
    approximations_are_control,
)
from einschalt.theory.adjustment.pattern_tests import examine_patterns
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE

# of a similarity, which leaves numbers to test only beyond them
N_PARAMETERS = 4


def with_contradiction_beside_given(adjusted, patterns):
    """Patterns, with what control does that contradicts given points, if none is found.

    What both ways lie apart by is told of control together, without names: a part of it
    is what moves points, and which nothing tells.
    """
    if patterns.moved_plan > 0.0 or not given_points_agree(adjusted):
        return patterns
    control = adjusted.adjustment.control
    held = control.loc[~control["is_suspect"], "point_id"]
    p_value = p_value_of_control(adjusted.two_step, held)
    moved = moved_between_ways(adjusted, adjusted.two_step).plan
    if not (p_value <= SYSTEMATIC_SIGNIFICANCE and moved > 0.0):
        return patterns
    n_control = patterns.n_control or len(adjusted.adjustment.control)
    return replace(
        patterns,
        moved_plan=moved,
        p_plan=p_value,
        n_control=n_control,
        is_beside_given=True,
    )


def given_points_agree(adjusted) -> bool:
    """Whether approximate points are as good as stated, by all that they show.

    Regions must have been looked for: strips are displaced by parts.
    """
    block, two_step = adjusted.block, adjusted.two_step
    is_stated = block.approximate_m_0_m is not None and block.high_flight is None
    if not is_stated or not two_step.is_possible or approximations_are_control(block):
        return False
    if two_step.error_model is None or two_step.is_put_off:
        return False
    claim = two_step.claim
    of_others = {test.name for test in claim.rejected} - set(KNOWN.values())
    return claim.of(REGIONS) is not None and not of_others


def p_value_of_control(two_step, point_ids) -> float:
    """Probability that control and approximate points differ so much, but for a frame.

    In plan, at the control points of these names, but for those whose approximate
    coordinates are the given ones. A similarity of all of them, as between two
    systems, tells nothing of control; 1 where too few are left, or nothing is known of
    the errors of either.
    """
    missed, roles = missed_in_plan(two_step)
    names = two_step.means.points["point_id"].to_numpy(dtype=object)
    is_known = (roles == "control") & np.isfinite(missed).all(axis=1)
    rows = np.flatnonzero(is_known & is_among(names, list(point_ids)))[:MOST_POINTS]
    if 2 * len(rows) <= N_PARAMETERS:
        return 1.0
    covariance = covariance_in_plan(two_step, names[rows])
    if covariance is None or not np.isfinite(covariance).all():
        return 1.0
    control = two_step.block.control_points
    place = encode(control["point_id"]).locate(encode(names[rows]))
    design = _of_similarity(values_of(control, PLAN)[place])
    observed = missed[rows].T.ravel()
    no_pattern = np.empty((0, len(observed), 1))
    try:
        rest = examine_patterns(observed, covariance, no_pattern, free=design)
    except np.linalg.LinAlgError:  # points without errors of their own
        return 1.0
    return float(chdtrc(rest.n, rest.total))


def _of_similarity(xy):
    """Shifts, turn and scale of points, all of one axis first, (2 n, 4)."""
    x, y = (xy - xy.mean(axis=0)).T
    one, none = np.ones(len(x)), np.zeros(len(x))
    easting, northing = [one, none, x, -y], [none, one, y, x]
    return np.concatenate([np.column_stack(easting), np.column_stack(northing)])
