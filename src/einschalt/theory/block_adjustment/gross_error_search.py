"""Where the search for gross errors begins.

With all measurements, as least squares adjust them; but where these have shrunk or bent
to gross errors, so that the search ends with a block that is not credible, without the
measurements that are far off by absolute residuals. Of them the good ones come back
first.
"""

from dataclasses import replace

import numpy as np

from einschalt.theory.block_adjustment.absolute_residuals import far_measurements
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.block_tests import judge_observations
from einschalt.theory.block_adjustment.common_border import UndeterminedTermsError
from einschalt.theory.block_adjustment.determinacy import INCREDIBLE
from einschalt.theory.block_adjustment.gross_errors import (
    MOST_RETURNS,
    NEARLY_WORST,
    ContradictedModelError,
    OutlierFreeBlock,
    are_credible,
    take_out,
    without_given,
    without_rows,
)
from einschalt.theory.block_adjustment.spatial_solution import (
    NoConvergenceError,
    adjust_models,
    adjust_spatially,
)

# growth of s_0 by which a measurement that has come back is seen to be wrong
GROWS = 2.0
FAILURES = (ContradictedModelError, NoConvergenceError, UndeterminedTermsError)


def outlier_free_block(begun, given, significance, judge) -> OutlierFreeBlock:
    """Take gross errors out, as :func:`.gross_errors.take_out`.

    Where least squares have led to nothing credible, the block is begun anew without
    what is far off.
    """
    how = given, significance, judge
    found, failure = None, None
    try:
        found = take_out(begun, *how)
    except FAILURES as error:
        failure = error
    is_found = found is not None and _size(found) <= INCREDIBLE
    if is_found or begun.is_out.any() or not begun.solution.s_0 > INCREDIBLE:
        return _found_or_raised(found, failure)
    try:
        anew = take_out(begin(begun.solution, significance), *how)
    except FAILURES:
        return _found_or_raised(found, failure)
    return min(found or anew, anew, key=_size)


def _size(block):
    """s_0 of a block; infinite where nothing is left that tells it."""
    s_0 = block.solution.s_0
    return s_0 if np.isfinite(s_0) else np.inf


def _found_or_raised(found, failure):
    if failure is not None:
        raise failure
    return found


def begin(solution, significance) -> OutlierFreeBlock:
    """Leave out what is far off, where least squares are not credible.

    A spatial block is placed anew: where it stands it may have shrunk to nothing.
    """
    if not solution.s_0 > INCREDIBLE:
        return OutlierFreeBlock.whole(solution)
    if solution.observations.is_in_space:
        return begin_in_space(solution.observations, significance)
    return _begun(solution, *far_measurements(solution), significance)


def adjust_without_far_measurements(observations, significance) -> OutlierFreeBlock:
    """Adjust a block without the measurements that are far off.

    They are looked for before a spatial block is placed, if it does not stand beside
    them.
    """
    try:
        return begin(adjust_models(observations), significance)
    except NoConvergenceError:
        return begin_in_space(observations, significance)


def begin_in_space(observations, significance) -> OutlierFreeBlock:
    """Leave out what is far off in plan; a block in space may not stand beside that."""
    far, is_wrong = far_measurements(adjust(observations.in_plan(is_affine=False)))
    is_far = far > 0.0
    placed = without_given(without_rows(observations, is_far), is_wrong)
    solution = replace(adjust_spatially(placed), observations=observations)
    return _begun(solution, far, is_wrong, significance)


def _begun(solution, far, is_wrong, significance):
    """Block without what is far off, by so much; of observations as they are given.

    Good measurements look wrong beside a gross error. What is credible comes back, the
    nearest of each model and point first: where these hardly hold without them, nothing
    but that tells them from the gross error, and what it does to the block.
    """
    block, given = OutlierFreeBlock.whole(solution), solution.observations
    if not (far.any() or is_wrong.any()):
        return block
    block = replace(block, is_out=far > 0.0, is_wrong=is_wrong).readjusted(given)
    may_return = block.is_out.copy()
    for _ in range(MOST_RETURNS):
        tests = judge_observations(block.solution, given)
        is_credible = may_return & are_credible(given, tests, significance)
        if not is_credible.any():
            break
        is_back = _nearest(given, far, is_credible)
        tried = replace(block, is_out=block.is_out & ~is_back).readjusted(given)
        if tried.solution.s_0 > max(INCREDIBLE, GROWS * block.solution.s_0):
            may_return &= ~(is_back & (far >= np.median(far[is_back])))
            continue
        block, may_return = tried, may_return & ~is_back
    return block


def _nearest(observations, far, is_asked):
    """Of some measurements those that are the least far off of their model and point.

    Or hardly farther.
    """
    is_nearest = is_asked.copy()
    for holder in (observations.model, observations.point):
        least = np.full(holder.max() + 1, np.inf)
        np.minimum.at(least, holder[is_asked], far[is_asked])
        is_nearest &= far * NEARLY_WORST <= least[holder]
    return is_nearest
