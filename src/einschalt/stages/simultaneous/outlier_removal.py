"""Gross errors and sizes of errors of a block, which must not be taken for each other.

A single exchanged name makes the errors of its whole flight look large, and errors that
are taken for larger than they are hide gross ones. So gross errors are looked for
first, the sizes follow from the rest, and both are repeated until nothing changes.
"""

from dataclasses import replace

import numpy as np

from einschalt.stages.simultaneous.image_errors import (
    covariances,
    has_images,
    judge_of,
)
from einschalt.stages.simultaneous.variance_components import (
    Weighed,
    groups_of,
    weigh_groups,
)
from einschalt.theory.block_adjustment.gross_errors import (
    CleanedBlock,
    OutlierFreeBlock,
    downweight,
    examine_control,
    outlier_free_block,
    with_all_control,
)
from einschalt.theory.block_adjustment.spatial_solution import NoConvergenceError

MOST_ROUNDS = 6


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


def weigh_part(tables, part, solution, options) -> Weighed:
    """Give the groups of a part the errors that they show, without gross ones.

    ``solution`` is that of the part. Gross errors are looked for unless they are to be
    kept, and in the same way whatever is to become of them.
    """
    estimates_all = options.variance_components == "estimated"
    if options.outliers == "keep":
        block = OutlierFreeBlock.whole(solution)
        return weigh_groups(tables, part, block, all_of_them=estimates_all)
    drawn = None
    if has_images(tables):
        given = np.ones(len(groups_of(tables, part).names) + 1)
        drawn = covariances(tables, part, given, solution).residuals
    judge = judge_of(part, drawn)
    block = outlier_free_block(solution, options.significance, judge)
    factors = 1.0
    for _ in range(MOST_ROUNDS):
        weighed = weigh_groups(
            tables, part, block, all_of_them=estimates_all, factors=factors
        )
        if weighed.part is part:
            break
        part, factors, before = weighed.part, weighed.factors, block
        solution = solution.readjusted(part.observations)
        block = outlier_free_block(solution, options.significance, judge)
        if block.has_the_errors_of(before):
            break
        weighed = replace(weighed, block=block)
    return weighed
