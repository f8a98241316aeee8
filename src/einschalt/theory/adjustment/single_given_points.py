"""Single given points that are wrong, each by a vector of its own.

In an adjustment of everything with the given points as observations the scores u
(weight times correction) have the covariance W, and a point i that is off by d makes
them W e_i d larger. So d is estimated by u_i / W_ii, and T = |u_i|² / W_ii is χ² with
two degrees of freedom without an error. The worst of all is set free, and what is left
is tested again (data snooping, iterated), against the median of all T: one gross error
does not enlarge it, and errors that are larger than stated do.

Sources: Baarda 1968, A testing procedure for use in geodetic networks; Kok 1984, On
data snooping and multiple outlier testing. See docs/theory/claim.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

FEWEST_POINTS = 20  # of fewer the median of T says little
MOST_FREED = 0.02  # of the points; of more the model of errors is wrong
FEW_FREED = 3  # as many always are, but for two of fewer than 40 points
# of the weight of a point: what is known less of it checks nothing
LEAST_INFORMATION = 1e-3
# that tell what is known of each point; a point is computed where T is as large as this
# part of the largest one, since by draws it may be off by a half
N_DRAWS, NEARLY_LARGEST = 64, 0.5
MEDIAN_OF_SQUARES = 2.0 * np.log(2.0)  # of χ² with two degrees of freedom
AT_ONCE = 64


@dataclass(frozen=True, eq=False)
class WrongPoints:
    """Given points that stand out, the one that was found first, first."""

    rows: np.ndarray  # (n_wrong,)
    shift: np.ndarray  # complex (n_wrong,): how far each is off, east + i north [m]
    standard_error: np.ndarray  # (n_wrong,): of each coordinate of the shift [m]
    p_value: np.ndarray  # (n_wrong,): by chance, of all points together


def _none():
    empty = np.zeros(0)
    return WrongPoints(empty.astype(int), empty.astype(complex), empty, empty)


def find_wrong_points(checks, weights) -> WrongPoints:
    """Find given points that are wrong by themselves.

    None where more than ``MOST_FREED`` of all points stand out, and more than
    ``FEW_FREED``: then errors are larger for many, or neighbours share them.

    Parameters
    ----------
    checks
        As :func:`~einschalt.theory.adjustment.displaced_regions.find_displaced_regions`
        has them: ``scores``, ``times(columns)`` and ``draw(n_draws, seed)``.
    weights : ndarray, shape (n,)
        Of the given points [1/m²].
    """
    if len(weights) < FEWEST_POINTS:
        return _none()
    snooped = _Snooped(checks, weights)
    n = len(weights)
    most = max(int(np.ceil(MOST_FREED * n)), min(FEW_FREED, n // FEWEST_POINTS + 1))
    while (row := snooped.worst()) is not None:
        if len(snooped.rows) == most:
            return _none()
        snooped.set_free(row)
    return snooped.told()


class _Snooped:
    """Scores beside the points that were set free."""

    def __init__(self, checks, weights):
        self.times, self.given = checks.times, checks.scores
        drawn = checks.draw(N_DRAWS, seed=0)
        n_parts = 2 if np.iscomplexobj(drawn) else 1
        self.information = (np.abs(drawn) ** 2).sum(axis=1) / (n_parts * N_DRAWS)
        self.is_exact = np.zeros(len(weights), dtype=bool)
        self.least = LEAST_INFORMATION * weights
        self.rows = np.zeros(0, dtype=int)
        self.shown = np.zeros((len(weights), 0))
        self._beside(self.rows)

    def _beside(self, rows):
        """Scores and what is lost of the information, with some points set free."""
        among = self.shown[rows]
        self.cofactor = np.linalg.inv(among) if len(rows) else among
        self.shifts = self.cofactor @ self.given[rows]
        self.scores = self.given - self.shown @ self.shifts
        self.lost = np.real(
            np.sum((self.shown @ self.cofactor) * self.shown.conj(), axis=1)
        )

    def set_free(self, row):
        """Go on without what one more point is given as."""
        column = sparse.csc_array(([1.0], ([row], [0])), (len(self.given), 1))
        self.shown = np.column_stack([self.shown, self.times(column)])
        self.rows = np.append(self.rows, row)
        self._beside(self.rows)

    def worst(self):
        """The point that stands out most, a row; None where chance explains it."""
        squares = self._squares()
        while (is_open := self._is_open(squares)).any():
            self._look_at(np.flatnonzero(is_open)[:AT_ONCE])
            squares = self._squares()
        row = int(np.argmax(squares))
        is_out = self._p_value(squares[row]) <= FINDING_SIGNIFICANCE
        return row if is_out else None

    def _is_open(self, squares):
        return ~self.is_exact & (squares > NEARLY_LARGEST * squares.max())

    def _squares(self):
        """T of all points; 0 of those that were set free, and that nothing checks."""
        left = self.information - self.lost
        is_known = left > self.least
        is_known[self.rows] = False
        squares = np.zeros(len(left))
        squares[is_known] = np.abs(self.scores[is_known]) ** 2 / left[is_known]
        self.scatter = 1.0
        if is_known.any():
            middle = np.median(squares[is_known])
            self.scatter = float(max(middle / MEDIAN_OF_SQUARES, 1.0))
        return squares

    def _look_at(self, rows):
        """Compute the information of some points."""
        picked = np.ones(len(rows)), (rows, np.arange(len(rows)))
        shown = self.times(sparse.csc_array(picked, (len(self.given), len(rows))))
        self.information[rows] = np.real(shown[rows, np.arange(len(rows))])
        self.is_exact[rows] = True

    def _p_value(self, square):
        """Of all points together: F of two degrees and as many as there are points."""
        n = len(self.given)
        ratio = square / self.scatter
        return np.minimum(n * (1.0 + ratio / n) ** (-n / 2.0), 1.0)

    def told(self):
        """Those that stand out beside all the others that were set free."""
        variance = np.real(np.diag(self.cofactor))
        p_value = self._p_value(np.abs(self.shifts) ** 2 / variance)
        is_out = p_value <= FINDING_SIGNIFICANCE
        error = np.sqrt(self.scatter * variance)
        columns = self.rows, self.shifts, error, p_value
        return WrongPoints(*(column[is_out] for column in columns))
