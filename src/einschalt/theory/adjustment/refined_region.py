"""Which points belong to a region that is displaced, one by one.

See displaced_regions for the scores and for what is known by them.
"""

import numpy as np

from einschalt.theory.adjustment.tried_regions import FEWEST_POINTS

# χ² that a point must add, so that it is taken into a region or out of it
LEAST_GAIN = 3.0
# of what is known of a region, where a point less leaves nearly nothing of it
LEAST_LEFT = 0.1


def refine(scores, information, shown, known, right, n_in, is_in, was_in, n_changed):
    """Take points into a region, or out of it, as long as it becomes clearer.

    ``scores`` and ``information`` are of the points that may change, ``shown`` what is
    known of each by the region (W p), ``known``, ``right`` and ``n_in`` the sums of
    information, of scores, and of points of the whole region, of which ``n_changed``
    others have changed. Gives which of them belong to it, and its χ² less what chance
    gains by every choice against what it was.
    """
    is_in, shown = is_in.copy(), shown.copy()
    diagonal = np.real(np.diag(information))
    price, certain = 2.0 * np.log(max(len(scores), 2)), 0.0
    for _ in range(len(scores)):
        # of all points nothing is known: that they are moved shows nowhere
        square = abs(right) ** 2 / known if known > 0.0 else 0.0
        n_all = n_changed + np.count_nonzero(is_in != was_in)
        certain = max(certain, square - price * n_all)
        sign = np.where(is_in, -1.0, 1.0)
        others = known + 2.0 * sign * shown + diagonal
        is_allowed = (others > LEAST_LEFT * known) & (n_in + sign >= FEWEST_POINTS)
        squares = np.abs(right + sign * scores) ** 2
        squares = np.where(is_allowed, squares / np.where(is_allowed, others, 1.0), 0.0)
        best = int(np.argmax(squares))
        if squares[best] <= square + LEAST_GAIN:
            break
        is_in[best] = not is_in[best]
        known, right = others[best], right + sign[best] * scores[best]
        n_in += sign[best]
        shown += sign[best] * np.real(information[:, best])
    return is_in, certain
