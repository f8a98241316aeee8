"""Gross errors and sizes of errors of a block, which must not be taken for each other.

A single exchanged name makes the errors of its whole flight look large, and errors that
are taken for larger than they are hide gross ones. So gross errors are looked for
first, the sizes follow from the rest, and both are repeated until nothing changes.
"""

from dataclasses import replace

import numpy as np

from einschalt.stages.simultaneous.image_drawings import ImageSizes
from einschalt.stages.simultaneous.image_errors import (
    covariances,
    has_images,
    judge_of,
)
from einschalt.stages.simultaneous.image_sizes import with_image_sizes
from einschalt.stages.simultaneous.variance_components import (
    Weighed,
    weigh_groups,
)
from einschalt.theory.block_adjustment.determinacy import INCREDIBLE, loose_models
from einschalt.theory.block_adjustment.gross_error_search import (
    begin,
    begin_in_space,
    outlier_free_block,
)
from einschalt.theory.block_adjustment.gross_errors import (
    CleanedBlock,
    OutlierFreeBlock,
    downweight,
    examine_control,
    with_all_control,
    without_rows,
)
from einschalt.theory.block_adjustment.spatial_solution import (
    NoConvergenceError,
    adjust_models,
    adjust_spatially,
)

MOST_ROUNDS = 6


def begin_part(part, options, terms=()) -> OutlierFreeBlock:
    """Adjust a part, without projection centres, to begin with.

    Where it does not stand beside gross errors that are looked for, without what is far
    off.
    """
    looks = options.outliers != "keep"
    try:
        solution = adjust_models(part.observations, terms)
    except NoConvergenceError:
        if not looks:
            raise
        return begin_in_space(part.observations, options.significance)
    if looks and solution.s_0 > INCREDIBLE and loose_models(solution).any():
        return begin(solution, options.significance)
    return OutlierFreeBlock.whole(solution)


def with_centres(tables, part, begun, is_kept):
    """Part with the projection centres of the models that are kept, and its block.

    The block begins where the points of the part stand.
    """
    is_far = np.zeros(len(tables.observations.model), dtype=bool)
    is_far[part.rows] = begun.is_out
    part = tables.observations.of_models(is_kept)
    is_far = is_far[part.rows]
    without = without_rows(part.observations, is_far)
    block = OutlierFreeBlock.whole(adjust_spatially(without, begun.solution.placement))
    if is_far.any():
        block = replace(block, is_out=is_far).readjusted(part.observations)
    return part, block


def clean_part(weighed, options) -> CleanedBlock:
    """Deal with the gross errors of a part that was weighed."""
    observations, block = weighed.part.observations, weighed.block
    if options.outliers == "keep":
        return CleanedBlock(block.solution, block.is_out, block.is_out)
    if options.outliers == "snoop":
        return with_all_control(block, observations)
    return downweight(block, observations, options.outliers)


def stands_without_gross_errors(weighed, significance) -> bool:
    """Whether an adjustment comes to an end where gross errors are taken out.

    Of one with a robust norm, which begins with the same ``weighed`` blocks.
    """
    try:
        for each in weighed:
            cleaned = with_all_control(each.block, each.part.observations)
        examine_control(cleaned.solution, significance)
    except NoConvergenceError:
        return False
    return True


def weigh_part(tables, part, begun, options) -> Weighed:
    """Give the groups of a part the errors that they show, without gross ones.

    ``begun`` is the OutlierFreeBlock of the part to begin with: without what is far
    off. Gross errors are looked for unless they are to be kept, and in the same way
    whatever is to become of them.
    """
    weighed = _weighed(tables, part, begun, options)
    if options.variance_components == "given" or not has_images(tables):
        return weighed
    return with_image_sizes(tables, weighed)


def _weighed(tables, part, begun, options):
    estimates_all = options.variance_components == "estimated"
    if options.outliers == "keep":
        return weigh_groups(tables, part, begun, all_of_them=estimates_all)
    drawn = None
    if has_images(tables):
        given = ImageSizes.as_given(len(tables.flights))
        drawn = covariances(tables, part, given, begun.solution).residuals
    judge = judge_of(part, drawn)
    block = outlier_free_block(begun, part.observations, options.significance, judge)
    factors, n_left, found = 1.0, MOST_ROUNDS, [block]
    while n_left > 0:
        weighed = weigh_groups(
            tables, part, block, all_of_them=estimates_all, factors=factors
        )
        if weighed.part is part:
            break
        part, factors, before = weighed.part, weighed.factors, block
        begun = begun.readjusted(part.observations)
        block = outlier_free_block(
            begun, part.observations, options.significance, judge
        )
        if block.has_the_errors_of(before):
            break
        weighed = replace(weighed, block=block)
        n_left = _rounds_left(found, block, n_left - 1)
        found.append(block)
    return weighed


def _rounds_left(found, block, n_left):
    """Rounds that still change something where gross errors and sizes go in a circle.

    ``found`` are the blocks so far: from one of the same gross errors the same follow
    anew, so that whole circles are left out.
    """
    for period, earlier in enumerate(reversed(found), start=1):
        if block.has_the_errors_of(earlier):
            return n_left % period
    return n_left
