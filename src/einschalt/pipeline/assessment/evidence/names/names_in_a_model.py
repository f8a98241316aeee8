"""The order in which the names of one model belong, where more than two are mixed.

Names that slipped by one row, all of them or those of a part of the rows, are one
mistake; two pairs, or three names that went round, are two exchanges one after the
other. The first of two need not improve a model, since what is left of the mistake
bends it as much: so the best orders of each round are kept, and all exchanges are tried
from each of them.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import PLAN, values_of, with_columns
from einschalt.foundations.names import is_among
from einschalt.stages.stage3_model_transformation import transform_models
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

LEAST_IMPROVEMENT = 5.0  # of the model, and of what fewer mistakes explain
MOST_EXCHANGES = 3  # one after the other
MOST_TRIED = 10  # rows of an order among which these are: 45 pairs
MOST_KEPT = 12  # orders from which further exchanges are tried
# rows of a model of which every part may have slipped; of longer ones its ends
MOST_IN_PARTS = 60
FEWEST_SLIPPED = 4  # three have gone round
MOST_ROWS = 300_000  # of the trials of one model


@dataclass(frozen=True, eq=False)
class RightOrder:
    """Whose name each row of a model has to get, so that it fits."""

    order: np.ndarray  # (n_rows,): row k is to have the name of row order[k]
    m_0: float  # of the model then [m]
    is_slip: bool  # names of rows one after the other, by one row


def right_order(model, limit) -> RightOrder | None:
    """Look for an order of names with which a model fits.

    Parameters
    ----------
    model : OneModel
    limit : float
        m_0 that the model must come down to [m].

    Returns
    -------
    RightOrder or None
        None where no order comes down to the limit, where the best leaves no less than
        a fifth of what fewer mistakes leave, and where chance might do it: residuals of
        any other kind are a share q of what they were with the probability q^r, r
        their redundancy, for each order that was tried. And where the model is right
        without its worst point.
    """
    least = model.fits(model.own)[0][0]

    def is_right(m_0, redundancy, n_tried):
        share = max(m_0 / least, np.finfo(float).tiny)
        log_chance = redundancy * np.log(share) + np.log(n_tried)
        is_enough = m_0 <= min(limit, least / LEAST_IMPROVEMENT)
        return is_enough and log_chance <= np.log(FINDING_SIGNIFICANCE)

    # one wrong point is no matter of names
    if model.n_known and is_right(*model.fit_without_worst(), model.n_known):
        return None
    n_tried = 0
    for orders, m_0, redundancy, is_slip in _rounds(model):
        n_tried += len(orders)
        if not np.isfinite(m_0).any():
            continue
        best = int(np.nanargmin(m_0))
        if is_right(m_0[best], redundancy[best], n_tried):
            order = model.told_apart(orders, best)
            return RightOrder(order, float(m_0[best]), is_slip)
        least = np.nanmin([least, m_0[best]])
    return None


def _rounds(model):
    """Orders of each round with their m_0 [m] and redundancy, and whether of a slip."""
    slips = slipped_orders(len(model.names))
    if len(slips) * model.n_known <= MOST_ROWS:
        yield slips, *model.fits(slips), True
    kept = model.own
    for _ in range(MOST_EXCHANGES):
        # what is left of a mistake hides another, smaller one
        orders = _with_exchanges(kept, model.worst_rows(kept))
        if len(orders) * model.n_known > MOST_ROWS:
            return
        m_0, redundancy = model.fits(orders)
        yield orders, m_0, redundancy, False
        kept = orders[np.argsort(m_0, kind="stable")[:MOST_KEPT]]


def slipped_orders(n):
    """Orders of rows of which a part has slipped by one, (n_orders, n).

    The name at the end of the part stands at its beginning, or the other way round.

    The longest part first, each of both ways.

    >>> slipped_orders(4).tolist()
    [[1, 2, 3, 0], [3, 0, 1, 2]]
    """
    first, end = np.triu_indices(n + 1, FEWEST_SLIPPED)
    is_tried = (n <= MOST_IN_PARTS) | (first == 0) | (end == n)
    longest = np.argsort(first - end, kind="stable")
    longest = longest[is_tried[longest]]
    first, end, row = first[longest, None], end[longest, None], np.arange(n)
    is_inside = (row >= first) & (row < end)
    after = np.where(row + 1 < end, row + 1, first)
    before = np.where(row > first, row - 1, end - 1)
    found = np.stack([np.where(is_inside, k, row) for k in (after, before)], axis=1)
    return found.reshape(-1, n)


def _with_exchanges(orders, tried):
    """All orders that one exchange of two rows makes of some, each once.

    ``tried``: rows among which each of them is changed, (n_orders, n_tried).
    """
    pairs = np.triu_indices(tried.shape[1], 1)
    one, other = (tried[:, place].ravel() for place in pairs)
    found = np.repeat(orders, len(pairs[0]), axis=0)
    trial = np.arange(len(found))
    found[trial, one], found[trial, other] = found[trial, other], found[trial, one]
    return np.unique(found, axis=0)


class OneModel:
    """The rows of a model, and the ground that its points may be fitted onto."""

    def __init__(self, points, ground, others, kind):
        """Take the rows of a model, and what is known of its points.

        ``points``: point_id, x, y [, z] of the rows in their order; ``ground``: what
        the models are fitted onto, with transformations of a ``kind``; ``others``:
        where further points lie by other models.
        """
        self.points, self.kind = points, kind
        self.names = points["point_id"].to_numpy(dtype=object)
        self._ground, self._others = (
            table[is_among(table["point_id"], self.names)] for table in (ground, others)
        )
        self._is_known = is_among(self.names, self._ground["point_id"])
        self._of_all = pd.concat([self._ground, self._others], ignore_index=True)

    @property
    def own(self):
        """The order of the rows as they were measured, (1, n_rows)."""
        return np.arange(len(self.names))[None]

    @property
    def n_known(self):
        """Number of rows whose names have coordinates on the ground."""
        return int(self._is_known.sum())

    def fits(self, orders):
        """m_0 [m] and redundancy of the model with each order, (n_orders,) each.

        NaN where it has none.
        """
        return self._fits(orders, self._is_known, self._ground)

    def fit_without_worst(self):
        """m_0 [m] and redundancy as it was measured, without its worst known point."""
        worst = self.worst_rows(self.own)[0]
        is_used = self._is_known.copy()
        is_used[worst[self._is_known[worst]][:1]] = False
        m_0, redundancy = self._fits(self.own, is_used, self._ground)
        return m_0[0], redundancy[0]

    def _fits(self, orders, is_known, ground):
        m_0, redundancy = np.full((2, len(orders)), np.nan)
        trial, row = np.nonzero(is_known[orders])  # others change no fit
        if not len(trial):
            return m_0, redundancy
        variants = self._variants(orders, trial, row)
        models = transform_models(variants, ground, self.kind).models
        place = models["model_id"].astype(int).to_numpy()
        m_0[place], redundancy[place] = models["m_0"], models["redundancy"]
        return m_0, redundancy

    def _variants(self, orders, trial, row):
        """Rows of trials with the names that they have there; model_id is the trial."""
        return with_columns(
            self.points.take(row),
            model_id=trial.astype(str),
            point_id=self.names[orders[trial, row]],
        )

    def worst_rows(self, orders):
        """Rows with the largest residuals in each order, (n_orders, MOST_TRIED).

        From the ground, and from where other models have further points.
        """
        trial, row = np.indices(orders.shape).reshape(2, -1)
        variants = self._variants(orders, trial, row)
        fit = transform_models(variants, self._ground, self.kind)
        there = self._of_all.drop_duplicates("point_id").set_index("point_id")
        there = values_of(there.reindex(variants["point_id"]), PLAN)
        miss = np.hypot(*(values_of(fit.transform(variants), PLAN) - there).T)
        miss = np.nan_to_num(miss).reshape(orders.shape)
        return np.argsort(-miss, axis=1, kind="stable")[:, :MOST_TRIED]

    def told_apart(self, orders, best):
        """Of orders that give known points the same names as ``best``, the likeliest.

        By where other models have the further points; the first where nothing tells.
        """
        of_known = np.where(self._is_known[orders], orders, -1)
        alike = orders[(of_known == of_known[best]).all(axis=1)]
        is_known = is_among(self.names, self._of_all["point_id"])
        m_0, _ = self._fits(alike, is_known, self._of_all)
        return alike[np.argmin(np.nan_to_num(m_0, nan=np.inf))]
