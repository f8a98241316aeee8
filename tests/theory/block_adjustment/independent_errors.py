"""The search for gross errors in blocks whose errors are independent."""

from einschalt.theory.block_adjustment.block_tests import judge_observations
from einschalt.theory.block_adjustment.gross_error_search import outlier_free_block
from einschalt.theory.block_adjustment.gross_errors import OutlierFreeBlock


def judged(solution, _, given):
    return judge_observations(solution, given)


def without_gross_errors(solution, significance=0.001):
    whole, given = OutlierFreeBlock.whole(solution), solution.observations
    return outlier_free_block(whole, given, significance, judged)
