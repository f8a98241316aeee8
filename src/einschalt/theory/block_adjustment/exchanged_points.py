"""Two given points under each other's name: what their exchange leaves of a block.

The adjustment is linear in the given coordinates l, whatever the models are like: their
residuals v = l - l_adjusted change by R e if l changes by e, with the redundancy matrix
R = I - H of the given points among each other, and so does the sum of squares,

    Ω(e) = Ω + 2 eᵀ P v + eᵀ P R e.

An exchange of the points i and j is e = d at i and -d at j, d = l_j - l_i. So all pairs
are tried with one answer of the block to each given coordinate. No change of l takes
more than vᵀ P (P R)⁺ P v from Ω, which given coordinates explain: the rest is of other
errors, gross ones of measurements among them.

Source of R: Baarda 1968, A testing procedure for use in geodetic networks. See
docs/theory/claim.md.
"""

from dataclasses import dataclass

import numpy as np

# given points that are tried, all of them with each other: two seconds
MOST_GIVEN = 500
# answers of all points that are computed together
AT_ONCE = 64
# of the largest element, added to the diagonal of P R, which no shift of all changes
HOLD = 1e-10


@dataclass(frozen=True, eq=False)
class PairsOfGivenPoints:
    """What is left of a block with two of its given points exchanged."""

    # (n_given,): the given points that were tried, rows of the points of the block
    places: np.ndarray
    # (n_given, n_given): share of what given coordinates explain of the sum of squares
    # that is left with both exchanged; infinite on the diagonal
    left: np.ndarray
    # coordinates that check each other as well as so many would whose redundancies are
    # equal: (tr R)²/tr R² (Satterthwaite 1946)
    n_checks: float

    def chance(self):
        """Probability that some pair leaves so little of errors of any other kind.

        Of each pair, shape (n_given, n_given). These errors lie anywhere in a space of
        r = ``n_checks`` dimensions; a change that is given leaves a share q or less of
        their square with q^(r/2), the part of a ball that one of its square takes
        (Bonferroni for all pairs).
        """
        n = len(self.places)
        chance = np.minimum(self.left, 1.0) ** (self.n_checks / 2.0)
        return np.minimum(n * (n - 1) / 2.0 * chance, 1.0)


def pairs_of_given_points(solution, most=MOST_GIVEN) -> PairsOfGivenPoints:
    """Exchange every pair of the given points of an adjusted block of plane models.

    Errors that given points share are counted as if each had its own.

    Parameters
    ----------
    solution : BlockSolution
        Linear in the given coordinates. Points that are held are not exchanged.
    most : int
        Of more given points those with the largest residuals are tried.

    Returns
    -------
    PairsOfGivenPoints
        ``left`` is infinite for all pairs where given points are missed by nothing.
    """
    observations = solution.observations
    places = np.flatnonzero(observations.is_control & ~observations.is_fixed)
    away = np.hypot(*solution.control_residuals[places].T)
    places = np.sort(places[np.argsort(-away, kind="stable")[:most]])
    given = observations.control[places]
    weight = observations.control_weight[places]
    n, d = given.shape
    hat = _answers(solution, places)  # of coordinate b of point j in a of point i
    redundancy = np.eye(n * d).reshape(n, d, n, d) - hat
    matrix = np.einsum("iab,ibjc->ijac", weight, redundancy)  # P R
    own = matrix[np.arange(n), np.arange(n)]
    both = own[:, None] + own - matrix - np.swapaxes(matrix, 0, 1)
    # adjusted less given
    pull = -np.einsum("iab,ib->ia", weight, solution.control_residuals[places])
    change = given - given[:, None]
    squares = np.einsum("ija,ijab,ijb->ij", change, both, change)
    squares += 2.0 * np.sum(change * (pull[:, None] - pull), axis=2)
    explained = _explained(matrix, pull) if n else 0.0
    left = np.full((n, n), np.inf)  # where nothing is there to be explained
    if explained > 0.0:
        left = np.maximum(explained + squares, 0.0) / explained
        np.fill_diagonal(left, np.inf)
    trace = np.einsum("iaia->", redundancy)
    of_square = np.einsum("iajb,jbia->", redundancy, redundancy)
    n_checks = float(trace**2 / of_square) if n else 0.0
    return PairsOfGivenPoints(places, left, n_checks)


def _explained(matrix, pull):
    """The most that a change of given coordinates takes from the sum of squares."""
    n = pull.size
    whole = matrix.swapaxes(1, 2).reshape(n, n)
    whole = (whole + whole.T) / 2.0
    held = whole + HOLD * np.abs(whole).max() * np.eye(n)
    return float(pull.ravel() @ np.linalg.solve(held, pull.ravel()))


def _answers(solution, places):
    """How each given point moves with the given coordinates, (n, d, n, d)."""
    shape = solution.observations.control.shape
    n, d = len(places), shape[1]
    found = np.empty((n, d, n * d))
    for start in range(0, n * d, AT_ONCE):
        columns = np.arange(start, min(start + AT_ONCE, n * d))
        errors = np.zeros((*shape, len(columns)))
        errors[places[columns // d], columns % d, np.arange(len(columns))] = 1.0
        none = np.zeros((*solution.residuals.shape, len(columns)))
        found[:, :, columns] = solution.answer_to(none, errors)[0][places]
    return found.reshape(n, d, n, d)
