"""Gross errors of a block: taken out one after the other, or given less weight.

An observation is taken out by a standard error so large that it counts for nothing;
so the structure of the block stays, and no order has to be found anew. In one step the
worst observations are taken out together that share neither model nor point, and are at
least half as bad as the worst of all: a gross error makes others look wrong, those of
its model and point first, and where it is large those of other models as well. What is
worse is told by w: p is 0 for every observation that a large error has touched.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from einschalt.foundations.batches import segment_min_max
from einschalt.theory.adjustment.norms import HUBER, TUKEY
from einschalt.theory.block_adjustment.adjusted_block import AdjustedBlock
from einschalt.theory.block_adjustment.block_tests import judge_control
from einschalt.theory.block_adjustment.determinacy import loose_models
from einschalt.theory.block_adjustment.majority import outvoted
from einschalt.theory.block_adjustment.spatial_solution import SETTLED

OUT = 1e5  # times its standard error: a weight of 1e-10
FAR = 6.0  # times the usual contradiction of a given point, which is no chance
MOST_STEPS = 100
# how often measurements that were left out too early may come back
MOST_RETURNS = 20
# of the worst w, above which observations are taken out in the same step
NEARLY_WORST = 0.5
# models over which a wrong given point may make others look wrong
REACH = 2
# share of what others check of a model, above which it is the model that is wrong
MOST_LOST = 0.5
# residual over its error beyond which a norm leaves no pull to what is refused: on the
# scale of a block that grows with the error, as its distance does
BEYOND = 100.0
# share of the smallest error that the last step of a spatial block may have while
# gross errors are looked for: the next step would be a tenth of it
SETTLED_IN_SEARCH = 0.01
MOST_ITERATIONS = 50
TOLERANCE = 1e-3
LEAST_FACTOR = 1e-9
NORMS = {"huber": HUBER, "tukey": TUKEY}


class ContradictedModelError(ArithmeticError):
    """The measurements of a spatial model contradict the block, most of them or all.

    ``model`` of so many models; it has lost the largest share of its measurements.
    """

    def __init__(self, model, n_models):
        super().__init__(f"model {model} of {n_models} contradicts the block")
        self.model, self.n_models = model, n_models


@dataclass(frozen=True, eq=False)
class CleanedBlock:
    """A block after its gross errors were dealt with."""

    solution: AdjustedBlock  # its observations have the standard errors that were used
    is_out: np.ndarray  # (n_rows,): what was taken out
    is_refused: np.ndarray  # (n_rows,): that, and what weighs less where it was refused


@dataclass(frozen=True, eq=False)
class OutlierFreeBlock:
    """A block without its gross errors."""

    solution: AdjustedBlock  # of the sound observations and the sound control
    is_out: np.ndarray  # (n_rows,): measurements that were taken out
    is_wrong: np.ndarray  # (n_points,): given points that were set aside

    @classmethod
    def whole(cls, solution):
        """Take a block as it is."""
        n_rows, n_points = len(solution.residuals), solution.observations.n_points
        return cls(solution, np.zeros(n_rows, dtype=bool), np.zeros(n_points, bool))

    def has_the_errors_of(self, other):
        """Whether another block has the same gross errors."""
        return np.array_equal(self.is_out, other.is_out) and np.array_equal(
            self.is_wrong, other.is_wrong
        )

    def continued(self, solution, given):
        """Take another solution without the same rows and given points."""
        other = replace(self, solution=solution)
        is_whole = not (self.is_out.any() or self.is_wrong.any())
        return other if is_whole else other.readjusted(given)

    def readjusted(self, given):
        """Adjust with other errors anew, without the same rows and given points."""
        solution = _without(self.solution, given, self.is_out, self.is_wrong)
        return OutlierFreeBlock(solution, self.is_out, self.is_wrong)


def take_out(begun, given, significance, judge) -> OutlierFreeBlock:
    """Take the worst observations and given points out until the test refuses none.

    Given points that contradict the block more than any measurement of theirs are set
    aside: the measurements would be taken out in their place. A large gross error makes
    good control look wrong as well, so all of it is judged once more in the end.
    ``begun`` is the OutlierFreeBlock to begin with, its errors are ``given``; what was
    left out too early there comes back. ``significance`` is the probability with which
    a model without gross errors loses a point. ``judge(solution, is_out, given)`` gives
    the BlockTests of the observations.
    Where most measurements of a point were taken out and agree, those that are left are
    the wrong ones, which no test refuses once they are alone.
    Raises ContradictedModelError for a spatial model that loses most of its
    measurements, or its hold: only what was taken out would place it, anywhere.
    """
    solution, is_out = begun.solution, begun.is_out.copy()
    n_returns, may_return, is_settled = MOST_RETURNS, is_out.any(), True
    is_aside = begun.is_wrong.copy()
    for _ in range(MOST_STEPS):
        tests = judge(solution, is_out, given)
        if solution is begun.solution and is_out.any():
            _require_hold(solution, is_out, np.isfinite(tests.p_value))
        of_control = judge_control(solution)
        doubted = _wrong_control(solution, (of_control, tests), is_out, significance)
        worst = _worst_rows(solution, tests, is_out, significance)
        # the worst of all is the one that is wrong: it makes others look so
        w_of_rows = tests.w[worst].max(initial=0.0)
        if len(doubted) and of_control.w[doubted].max() >= w_of_rows:
            is_aside[doubted] = True
        elif len(worst):
            is_out[worst] = True
        else:
            both = given, tests
            is_other = _changing_sides(
                solution, both, is_out, significance, may_return=may_return
            )
            if n_returns > 0 and is_other.any():
                is_out ^= is_other
                n_returns -= 1
            elif is_settled:
                break
            else:  # nothing more is found: to every digit
                solution = _without(solution, given, is_out, is_aside)
                is_settled = True
                continue
        solution = _without(solution, given, is_out, is_aside, in_search=True)
        is_settled = not given.is_in_space
        _require_hold(solution, is_out, np.isfinite(tests.p_value))
    if not is_settled:
        solution = _without(solution, given, is_out, is_aside)
    if not is_aside.any():
        return OutlierFreeBlock(solution, is_out, is_aside)
    solution = _without(solution, given, is_out, np.zeros_like(is_aside))
    verdict = examine_control(solution, significance)
    return OutlierFreeBlock(verdict.without, is_out, verdict.is_suspect)


def _changing_sides(solution, both, is_out, significance, *, may_return):
    """Measurements that were taken out too early, or instead of those that are left."""
    given, tests = both
    is_back = is_out & are_credible(given, tests, significance)
    if may_return and is_back.any():
        return is_back
    return outvoted(solution.residuals, given, is_out)


def are_credible(observations, tests, significance):
    """Which measurements no test refuses."""
    is_tested = np.isfinite(tests.p_value)
    return ~_are_refused(observations, tests, is_tested, significance)


def _are_refused(observations, tests, is_tested, significance):
    """Which of the tested measurements are refused, each by the number in its model."""
    model = observations.model[is_tested]
    n_tested = np.bincount(model, minlength=observations.n_models)
    is_refused = is_tested.copy()
    is_refused[is_tested] = tests.p_value[is_tested] * n_tested[model] <= significance
    return is_refused


def _require_hold(solution, is_out, is_tested):
    """Refuse a spatial model that hangs on what was taken out.

    Or that has lost most of what others check of it: no estimate stands against a
    majority, and it is the model that is wrong.
    """
    observations = solution.observations
    if not observations.is_in_space:
        return
    model, n_models = observations.model, observations.n_models
    n_rows = np.bincount(model[is_tested | is_out], minlength=n_models)
    n_out = np.bincount(model[is_out], minlength=n_models)
    is_lost = (loose_models(solution) & (n_out > 0)) | (n_out > MOST_LOST * n_rows)
    if is_lost.any():
        share = np.where(is_lost, n_out / np.maximum(n_rows, 1), 0.0)
        raise ContradictedModelError(int(share.argmax()), n_models)


def with_all_control(block, given) -> CleanedBlock:
    """Put given points that were set aside back, to be named by ``examine_control``."""
    solution = block.solution
    if block.is_wrong.any():
        none = np.zeros_like(block.is_wrong)
        solution = _without(solution, given, block.is_out, none)
    return CleanedBlock(solution, block.is_out, block.is_out)


def _without(solution, given, is_out, is_aside, *, in_search=False):
    """Adjust the block anew, without these rows and given points.

    A spatial block, which takes a pass for each digit, ``in_search`` so far that what
    is left counts nothing beside the errors.
    """
    changed = without_given(without_rows(given, is_out), is_aside)
    how = {}
    if in_search and given.is_in_space:
        share = SETTLED_IN_SEARCH * float(np.min(given.standard_error))
        how["settled"] = max(SETTLED, share)
    solution = solution.readjusted(changed, **how)
    n_lost = np.count_nonzero(is_out) + np.count_nonzero(is_aside)
    lost = solution.residuals.shape[1] * n_lost
    return replace(solution, redundancy=solution.redundancy - lost)


def _wrong_control(solution, both, is_out, significance):
    """The worst given points that are refused, and worse than their measurements."""
    tests, of_rows = both
    w = np.where(np.isfinite(of_rows.w) & ~is_out, of_rows.w, 0.0)
    worst_row = np.zeros(solution.observations.n_points)
    np.maximum.at(worst_row, solution.observations.point, w)
    is_tested = np.isfinite(tests.p_value)
    is_wrong = is_tested & (tests.w > worst_row)
    is_wrong[is_wrong] = tests.p_value[is_wrong] * is_tested.sum() <= significance
    return _worst_given(solution.observations, tests.w, is_wrong)


# parameters of a transformation of the whole block
DATUM_IN_SPACE, DATUM_OF_AFFINE, DATUM_OF_HELMERT = 7, 6, 4
# heights without which nothing places a block
FEWEST_HEIGHTS = 3


def _worst_given(observations, w, is_refused):
    """Refused given points that are the worst far around; a wrong one spreads too."""
    model, point = observations.model, observations.point
    w = np.where(is_refused, w, 0.0)
    around = w
    for _ in range(REACH):
        of_model = np.zeros(observations.n_models)
        np.maximum.at(of_model, model, around[point])
        around = np.zeros(observations.n_points)
        np.maximum.at(around, point, of_model[model])
    is_worst = (w >= around) & (w >= NEARLY_WORST * w.max(initial=0.0))
    places = np.flatnonzero(is_refused & is_worst)
    # of equal ones, the first
    return places[np.unique(w[places], return_index=True)[1]]


def _times(standard_error, factors):
    """Standard errors of rows, or of their coordinates, times a factor for each row."""
    return (standard_error.T * factors).T


def _worst_rows(solution, tests, is_out, significance):
    """Refused observations that are the worst of their model and of their point."""
    model, point = solution.observations.model, solution.observations.point
    is_tested = np.isfinite(tests.p_value) & ~is_out
    is_refused = _are_refused(solution.observations, tests, is_tested, significance)
    w = np.where(is_refused, tests.w, 0.0)
    start = np.searchsorted(model, np.arange(solution.observations.n_models + 1))
    worst_of_model = segment_min_max(w, start)[1]
    worst_of_point = np.zeros(solution.observations.n_points)
    np.maximum.at(worst_of_point, point, w)
    is_worst = (w >= worst_of_model[model]) & (w >= worst_of_point[point])
    is_worst &= w >= NEARLY_WORST * w.max(initial=0.0)
    rows = np.flatnonzero(is_refused & is_worst)
    # of equal ones the first: two measurements of a point are refused alike
    rows = rows[np.unique(model[rows], return_index=True)[1]]
    return rows[np.unique(point[rows], return_index=True)[1]]


def without_rows(observations, is_out):
    """Observations of which some rows count for nothing."""
    if not is_out.any():
        return observations
    error = _times(observations.standard_error, np.where(is_out, OUT, 1.0))
    return replace(observations, standard_error=error)


def without_given(observations, is_aside):
    """Observations of which some given points count for nothing."""
    factors = np.where(is_aside, OUT**2, 1.0)[:, None, None]
    covariance = observations.control_covariance * factors
    return replace(observations, control_covariance=covariance)


def norms_of(name):
    """Names of the norms that are used one after the other."""
    return ("huber", "tukey") if name == "tukey" else (name,)


def downweight(block, given, norm_name) -> CleanedBlock:
    """Give observations with large residuals less weight (iteratively).

    The weights begin with the residuals of the sound block, and without its wrong
    control: the measurements of that would lose their weight in its place, and nothing
    would contradict it any more. Tukey's norm begins where Huber's ends. The block has
    all control again, for ``examine_control`` to name what is wrong.
    """
    # what was taken out comes back, with little weight
    n_back = block.solution.residuals.shape[1] * np.count_nonzero(block.is_out)
    solution = replace(block.solution, redundancy=block.solution.redundancy + n_back)
    is_beyond = block.is_out & (_lengths(solution, given.standard_error) > BEYOND)
    given_error = without_rows(given, is_beyond).standard_error
    for name in norms_of(norm_name):
        solution = _weighted(solution, NORMS[name], given_error)
    if block.is_wrong.any():
        error = solution.observations.standard_error
        solution = solution.readjusted(replace(given, standard_error=error))
    norm = NORMS[norm_name][solution.residuals.shape[1]]
    solution = _consistent(solution, norm, block.is_out)
    return CleanedBlock(solution, is_beyond, block.is_out)


def _lengths(solution, error):
    """Lengths of the residuals over the errors of their coordinates, (n_rows,)."""
    scaled = solution.residuals / error.reshape(len(solution.residuals), -1)
    return np.sqrt((scaled**2).sum(axis=1))


def _consistent(solution, norm, is_gross):
    """With the sum of squares that clean observations would have at full weight.

    The norm takes weight from these too: s_0 would be 0.9 or 0.85 where errors are as
    large as given, and the tests would refuse what chance does. Gross errors are no
    part of it: Huber's norm leaves them a share that grows with them.
    """
    error = solution.observations.standard_error
    error = error.reshape(len(solution.residuals), -1)
    weighted = ((solution.residuals / error) ** 2).sum(axis=1)
    lost = weighted[~is_gross].sum() * (1.0 / norm.consistency - 1.0)
    n_gross = solution.residuals.shape[1] * np.count_nonzero(is_gross)
    return replace(
        solution,
        sum_of_squares=solution.sum_of_squares - weighted[is_gross].sum() + lost,
        redundancy=solution.redundancy - n_gross,
    )


def _weighted(solution, norms, given_error):
    """Weights that belong to the residuals that they lead to."""
    n_rows, d = solution.residuals.shape
    share = solution.redundancy / (d * n_rows)  # without what is set aside
    factors = np.ones(n_rows)
    for _ in range(MOST_ITERATIONS):
        length = _lengths(solution, given_error)
        scale = np.median(length) / np.sqrt(chdtri(d, 0.5) * share)
        if not scale > 0.0:
            break
        new = np.maximum(norms[d].weights(length / scale), LEAST_FACTOR)
        is_settled = np.abs(new - factors).max() < TOLERANCE
        factors = new
        error = _times(given_error, 1.0 / np.sqrt(factors))
        changed = replace(solution.observations, standard_error=error)
        solution = solution.readjusted(changed)
        if is_settled:
            break
    return solution


@dataclass(frozen=True, eq=False)
class ControlVerdict:
    """Given points against the block, row for row as the points."""

    is_suspect: np.ndarray  # (n_points,)
    # of a suspect, when it was found; of the others, without the suspects. NaN where
    # nothing checks a point
    w: np.ndarray
    p_value: np.ndarray
    # (n_points, 2): error of the given coordinates that explains the contradiction [m]
    error: np.ndarray
    without: AdjustedBlock  # the block with the suspects set aside


def _is_placed(observations, is_left):
    """Whether given points that are left place a block, and one of them checks it."""
    is_given = observations.is_given[is_left]
    if observations.is_in_space:
        n_heights = np.count_nonzero(is_given[:, 2])
        return is_given.sum() > DATUM_IN_SPACE and n_heights >= FEWEST_HEIGHTS
    datum = DATUM_OF_AFFINE if observations.is_affine.all() else DATUM_OF_HELMERT
    return is_given.sum() > datum


def examine_control(solution, significance) -> ControlVerdict:
    """Find the given points that contradict the block, the worst first.

    A wrong one makes its neighbours look wrong too. So it is set aside before these are
    judged; the solution that is given is left as it is. So many are left that they
    check each other: of fewer any may be the wrong one. ``significance`` is the
    probability with which good control has a suspect.
    """
    tests = judge_control(solution)
    is_suspect = np.zeros(len(tests.w), dtype=bool)
    lost = None
    found = {name: getattr(tests, name).copy() for name in ("w", "p_value", "error")}
    for _ in range(MOST_STEPS):
        observations = solution.observations
        is_refused = ~is_suspect & np.isfinite(tests.p_value)
        n_tested = np.count_nonzero(is_refused)
        is_refused[is_refused] = tests.p_value[is_refused] * n_tested <= significance
        worst = _worst_given(observations, tests.w, is_refused)
        is_left = ~is_suspect
        is_left[worst] = False
        if len(worst) == 0 or not _is_placed(observations, is_left):
            break
        is_suspect[worst] = True
        covariance = observations.control_covariance.copy()
        covariance[worst] *= OUT**2
        changed = replace(observations, control_covariance=covariance)
        if lost is None:  # what robust weights lost of the sum of squares, see there
            same = solution.readjusted(observations)
            lost = solution.sum_of_squares / same.sum_of_squares
        without = solution.readjusted(changed)
        solution = replace(
            without,
            redundancy=solution.redundancy - int(observations.is_given[worst].sum()),
            sum_of_squares=without.sum_of_squares * lost,
        )
        tests = judge_control(solution)
        for name, values in found.items():
            values[~is_suspect] = getattr(tests, name)[~is_suspect]
    return ControlVerdict(is_suspect, **found, without=solution)


def without_far_control(solution, significance):
    """Observations without the given points that contradict the block by far.

    By more than ``FAR`` times what is usual for the others, as names and systems make
    it: they bend the models that hold them. Others check each of them, so that what is
    left holds the block.
    """
    verdict = examine_control(solution, significance)
    size = np.abs(verdict.w)
    others = size[~verdict.is_suspect & np.isfinite(size)]
    observations = solution.observations
    if not verdict.is_suspect.any() or not len(others):
        return observations
    usual = np.median(others) / np.sqrt(chdtri(observations.control.shape[1], 0.5))
    control = observations.control.copy()
    control[verdict.is_suspect & (size > FAR * usual)] = np.nan
    return replace(observations, control=control)
