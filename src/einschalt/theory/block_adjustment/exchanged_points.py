"""Given points under each other's name: what putting names right leaves of a block.

The adjustment is linear in the given coordinates l, whatever the models are like: their
residuals v = l - l_adjusted change by R e if l changes by e, with the redundancy matrix
R = I - H of the given points among each other, and so does the sum of squares,

    Ω(e) = Ω + 2 eᵀ P v + eᵀ P R e.

Names that are put right are e = l_σ(i) - l_i at each point i whose coordinates stand
under the name σ(i); an exchange of two is its shortest. So all pairs are tried with one
answer of the block to each given coordinate, and again all pairs after the best ones:
two pairs, or names that went round, are some exchanges one after the other. A list from
which one name was lost leaves a point whose coordinates are not given: e is free there,
and the least of Ω has g_iᵀ (P R)_ii⁻¹ g_i less, g = P v + P R e. No change of l takes
more than vᵀ P (P R)⁺ P v from Ω, which given coordinates explain: the rest is of other
errors, gross ones of measurements among them.

Source of R: Baarda 1968, A testing procedure for use in geodetic networks. See
docs/theory/claim.md.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

# given points that are tried, all of them with each other: three seconds
MOST_GIVEN = 500
# answers of all points that are computed together, and orders
AT_ONCE, MOST_AT_ONCE = 64, 1000
# of the largest element, added to the diagonal of P R, which no shift of all changes
HOLD = 1e-10
# of what is explained: where one point leaves less, it alone is wrong
LEAST_BESIDE = 1e-3
# one after the other, and those in a row that gain nothing: one may lead away from what
# two lead to
MOST_EXCHANGES, MOST_IDLE = 20, 2
# orders that further exchanges start from; of many points fewer, that all of them with
# another pair are no more than so many
LEAST_KEPT, MOST_KEPT, MOST_FURTHER = 2, 12, 130_000
NOWHERE = -1  # in place of a point
# rows by which the names of a list, or of a part of it, have slipped
SLIPS = (1, -1, 2, -2, 3, -3)
# rows of a list of which every part may have slipped; of a longer one its ends
MOST_OF_PARTS = 40


@dataclass(frozen=True, eq=False)
class NamesOfGivenPoints:
    """A block with the coordinates of its given points under other names.

    An ``order`` has for each point the place of the name under which its coordinates
    stand, (n_given,).
    """

    # (n_given,): the given points that were tried, rows of the points of the block
    places: np.ndarray
    given: np.ndarray  # their coordinates, (n_given, d)
    matrix: np.ndarray  # P R, (n_given, n_given, d, d)
    pull: np.ndarray  # P v, (n_given, d)
    explained: float  # the most that given coordinates take from the sum of squares
    # coordinates that check each other as well as so many would whose redundancies are
    # equal: (tr R)²/tr R² (Satterthwaite 1946)
    n_checks: float

    @property
    def as_given(self):
        """The order of names that are as they are, (n_given,)."""
        return np.arange(len(self.places))

    def left(self, orders, free=None):
        """Share of what given coordinates explain that is left, shape (n_orders,).

        Infinite where nothing is there to be explained. ``free`` has for each order the
        place of a point that may lie anywhere, NOWHERE for none; the share is of what
        no single point explains then, so that a wrong one is no mistake of a list.
        """
        free = np.full(len(orders), NOWHERE) if free is None else free
        rows = np.flatnonzero(free != NOWHERE)
        at = free[rows]
        change = self.given[orders] - self.given
        change[rows, at] = 0.0
        flat = change.reshape(len(orders), -1)
        answer = (flat @ _whole(self.matrix)).reshape(change.shape)
        squares = np.sum(change * (2.0 * self.pull + answer), axis=(1, 2))
        own = np.linalg.pinv(np.einsum("iiab->iab", self.matrix), hermitian=True)
        right = (self.pull + answer)[rows, at]
        squares[rows] -= np.einsum("ka,kab,kb->k", right, own[at], right)
        # of the point that explains most by itself
        alone = np.einsum("ka,kab,kb->k", self.pull, own, self.pull).max()
        return self._share(squares, np.where(free != NOWHERE, alone, 0.0))

    def left_with_another_pair(self, order):
        """The same with any two exchanged besides, (n_given, n_given)."""
        given = self.given[order]
        change = given - self.given
        pull = self.pull + np.einsum("ijab,jb->ia", self.matrix, change)
        before = np.sum(change * (self.pull + pull))
        own = np.einsum("iiab->iab", self.matrix)
        both = own[:, None] + own - self.matrix - np.swapaxes(self.matrix, 0, 1)
        further = given - given[:, None]
        squares = np.einsum("ija,ijab,ijb->ij", further, both, further)
        squares += 2.0 * np.sum(further * (pull[:, None] - pull), axis=2)
        left = self._share(before + squares)
        np.fill_diagonal(left, np.inf)
        return left

    def _share(self, squares, beside=0.0):
        """What is left of what is explained, but for what something else explains."""
        explained = np.broadcast_to(self.explained - beside, squares.shape)
        is_told = explained > LEAST_BESIDE * self.explained
        left = np.full(squares.shape, np.inf)
        rest = np.maximum(self.explained + squares, 0.0)
        return np.divide(rest, explained, out=left, where=is_told)

    def log_chance(self, left, log_trials, n_free=0):
        """Logarithm of the probability that some trial leaves so little by chance.

        Of errors of any other kind, which lie anywhere in a space of r = ``n_checks``
        dimensions; a change that is given leaves a share q or less of their square with
        q^(r/2), the part of a ball that one of its square takes (Bonferroni). A point
        that is free takes its coordinates from r.
        """
        with np.errstate(divide="ignore"):
            log_share = np.log(np.minimum(left, 1.0))
        n_free = np.asarray(n_free) * self.given.shape[1]
        degrees = np.maximum(self.n_checks - n_free, 0.0)
        # 0 · -inf would be NaN
        log_share = np.where(degrees > 0.0, degrees / 2.0 * log_share, 0.0)
        return np.minimum(log_trials + log_share, 0.0)


class Slips(NamedTuple):
    """Orders of points where names of a list have slipped by some rows."""

    orders: np.ndarray  # (n_slips, n_given)
    free: np.ndarray  # (n_slips,): place of the point that has lost its coordinates
    rows: np.ndarray  # (n_slips,): by how many


@dataclass(frozen=True, eq=False)
class PutRight:
    """Orders that so many mistakes lead to, the least probable by chance first."""

    n_mistakes: int
    orders: np.ndarray  # (n_orders, n_given)
    free: np.ndarray  # (n_orders,): the point whose coordinates are lost, or NOWHERE
    rows: np.ndarray  # (n_orders,): by how many a list has slipped, 0 for exchanges
    left: np.ndarray  # share of what given coordinates explain, (n_orders,)
    # that errors of any other kind leave so little, (n_orders,): logarithm
    log_chance: np.ndarray


def names_of_given_points(solution, most=MOST_GIVEN) -> NamesOfGivenPoints:
    """How a block of plane models answers to other coordinates of its given points.

    Errors that given points share are counted as if each had its own.

    Parameters
    ----------
    solution : BlockSolution
        Linear in the given coordinates. Points that are held are not exchanged.
    most : int
        Of more given points those with the largest residuals are tried.
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
    matrix = np.einsum("iab,ibjc->ijac", weight, redundancy)
    # adjusted less given
    pull = -np.einsum("iab,ib->ia", weight, solution.control_residuals[places])
    explained = _explained(matrix, pull) if n else 0.0
    trace = np.einsum("iaia->", redundancy)
    of_square = np.einsum("iajb,jbia->", redundancy, redundancy)
    n_checks = float(trace**2 / of_square) if n else 0.0
    return NamesOfGivenPoints(places, given, matrix, pull, explained, n_checks)


def put_right(names, slips=None) -> list[PutRight]:
    """Exchange names two by two, from the orders that explain the block best.

    Until that gains nothing.

    Parameters
    ----------
    names : NamesOfGivenPoints
    slips : Slips, optional
        One mistake each, as an exchange is; exchanges follow these as well.

    Returns
    -------
    list of PutRight
        Fewest mistakes first. Empty where given points are missed by nothing.
    """
    n = len(names.places)
    if n < 2 or not names.explained > 0.0:
        return []
    n_slips = 0 if slips is None else len(slips.orders)
    log_trials = np.log(n * (n - 1) / 2.0 + n_slips)
    kept, found = names.as_given[None], []
    least, n_idle = 1.0, 0
    while len(found) < min(MOST_EXCHANGES, n - 1) and n_idle < MOST_IDLE:
        orders, left = _with_another_pair(names, kept)
        none = np.full(len(orders), NOWHERE)
        parts = [(orders, none, np.zeros(len(orders), dtype=int), left)]
        if not found and n_slips:
            parts.append(_best_slips(names, slips))
        orders, free, rows, left = map(np.concatenate, zip(*parts, strict=True))
        n_mistakes, is_free = len(found) + 1, free != NOWHERE
        chance = names.log_chance(left, n_mistakes * log_trials, is_free)
        best = np.lexsort([left, chance])
        found.append(
            PutRight(n_mistakes, *(a[best] for a in (orders, free, rows, left, chance)))
        )
        kept = orders[~is_free]
        n_idle = 0 if left.min() < least else n_idle + 1
        least = min(least, left.min())
    return found


def _best_slips(names, slips):
    """The slips that leave least, and what they leave."""
    parts = [
        names.left(
            slips.orders[start:][:MOST_AT_ONCE], slips.free[start:][:MOST_AT_ONCE]
        )
        for start in range(0, len(slips.orders), MOST_AT_ONCE)
    ]
    left = np.concatenate(parts)
    best = np.argsort(left, kind="stable")[:MOST_KEPT]
    return slips.orders[best], slips.free[best], slips.rows[best], left[best]


def slipped_names(listed, n_given) -> Slips:
    """Orders of points of which a part of the list has names slipped by some rows.

    Either the names that slip out at one end of the part are those at the other, or
    one is lost: where a cell was deleted from the names, or inserted.

    Parameters
    ----------
    listed : (n,) int array
        Places of the points, or of some of them, in the order of their list.
    n_given : int
        Number of all points.

    Returns
    -------
    Slips
        Of every part of a list of up to 40 rows; of the ends of a longer one.
    """
    n = len(listed)
    parts = [
        (first, last)
        for first in range(n)
        for last in range(first + 3, n + 1)
        if n <= MOST_OF_PARTS or first == 0 or last == n
    ]
    slips = []
    for first, last in parts:
        part = listed[first:last]
        for rows in SLIPS:
            if abs(rows) < len(part):
                order = np.arange(n_given)
                order[part] = np.roll(part, rows)
                slips.append((order, NOWHERE, rows))
                if abs(rows) == 1:
                    # the one that takes the place at the other end of the part
                    lost = part[0] if rows == 1 else part[-1]
                    slips.append((order, lost, rows))
    if not slips:
        none = np.empty(0, dtype=int)
        return Slips(np.empty((0, n_given), dtype=int), none, none)
    orders, free, rows = zip(*slips, strict=True)
    return Slips(np.array(orders), np.array(free), np.abs(rows))


def _with_another_pair(names, orders):
    """The best of all orders with two names exchanged besides, and what they leave."""
    n = len(names.places)
    one, other = np.triu_indices(n, 1)
    n_kept = int(np.clip(MOST_FURTHER // len(one), LEAST_KEPT, MOST_KEPT))
    left = [names.left_with_another_pair(order)[one, other] for order in orders]
    left = np.concatenate(left)
    # some lead to the same order: enough of them that so many differ
    n_most = min(len(left), n_kept * len(orders))
    best = np.argpartition(left, n_most - 1)[:n_most]
    best = best[np.argsort(left[best], kind="stable")]
    which, pair = np.divmod(best, len(one))
    found = orders[which]
    rows = np.arange(n_most)
    one, other = one[pair], other[pair]
    exchanged = found.copy()
    exchanged[rows, one], exchanged[rows, other] = found[rows, other], found[rows, one]
    _, first = np.unique(exchanged, axis=0, return_index=True)
    first = np.sort(first)[:n_kept]
    return exchanged[first], left[best[first]]


def _explained(matrix, pull):
    """The most that a change of given coordinates takes from the sum of squares."""
    whole = _whole(matrix)
    held = whole + HOLD * np.abs(whole).max() * np.eye(pull.size)
    return float(pull.ravel() @ np.linalg.solve(held, pull.ravel()))


def _whole(matrix):
    """Elements of points and coordinates as one symmetric matrix."""
    n, _, d, _ = matrix.shape
    whole = matrix.swapaxes(1, 2).reshape(n * d, n * d)
    return (whole + whole.T) / 2.0


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
