"""Which models share points, and where models lie to each other.

Two models are neighbours where they hold a common point: these are the blocks of the
normal equations that are not zero once the points are eliminated. From the positions
of the models, found by chaining them together, the order of elimination is taken.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segments
from einschalt.foundations.kernels import compiled

# a similarity that shrinks more than this is no similarity
LEAST_FACTOR = 1e-3


@dataclass(frozen=True, eq=False)
class Incidence:
    """Observations sorted by model, and the same sorted by point."""

    model: np.ndarray  # (n_rows,): of each observation, ascending
    point: np.ndarray  # (n_rows,): of each observation
    model_start: np.ndarray  # (n_models + 1,)
    point_start: np.ndarray  # (n_points + 1,)
    # (n_rows,): observations of each point: point k owns ``rows[point_start[k]:…]``
    rows: np.ndarray

    @property
    def n_models(self):
        """Number of models."""
        return len(self.model_start) - 1

    @property
    def n_points(self):
        """Number of points."""
        return len(self.point_start) - 1

    @property
    def arrays(self):
        """All of them, as the kernels take them."""
        return self.model, self.point, self.model_start, self.point_start, self.rows

    def reordered(self, order):
        """Put the models in another order, their observations and points with them.

        Points stand in the order of their first appearance, so that what is used
        together lies together.
        """
        model, point, rows, points = _reorder(order, self.point, self.model_start)
        incidence = incidence_of(model, point, self.n_models, len(points))
        return Reordered(incidence, rows, points)


@dataclass(frozen=True, eq=False)
class Reordered:
    """Observations in another order."""

    incidence: Incidence
    rows: np.ndarray  # old number of each observation and of each point
    points: np.ndarray


@compiled
def _reorder(order, point, model_start):
    n_rows = point.size
    n_points = 0
    for row in range(n_rows):
        n_points = max(n_points, point[row] + 1)
    model = np.empty(n_rows, dtype=np.int64)
    new_point = np.empty(n_rows, dtype=np.int64)
    rows = np.empty(n_rows, dtype=np.int64)
    points = np.empty(n_points, dtype=np.int64)
    number = np.empty(n_points, dtype=np.int64)
    number[:] = -1
    place, count = 0, 0
    for i in range(order.size):
        for row in range(model_start[order[i]], model_start[order[i] + 1]):
            p = point[row]
            if number[p] < 0:
                number[p] = count
                points[count] = p
                count += 1
            model[place], new_point[place], rows[place] = i, number[p], row
            place += 1
    return model, new_point, rows, points[:count]


def incidence_of(model, point, n_models, n_points) -> Incidence:
    """Sort observations, which are sorted by model, by their point as well."""
    model = np.ascontiguousarray(model, dtype=np.int64)
    point = np.ascontiguousarray(point, dtype=np.int64)
    by_point = segments(point, n_points)
    count = np.bincount(model, minlength=n_models)
    start = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
    return Incidence(model, point, start, by_point.start, by_point.order)


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Neighbours of every model."""

    start: np.ndarray  # (n_models + 1,)
    # (n_pairs,): model k has the neighbours ``models[start[k]:start[k + 1]]``, without
    # itself
    models: np.ndarray


def neighbours_of(incidence) -> Neighbours:
    """Find the models that share a point with each model."""
    return Neighbours(*_find_neighbours(*incidence.arrays))


@compiled
def _find_neighbours(model, point, model_start, point_start, rows):
    n_models = model_start.size - 1
    start = np.empty(n_models + 1, dtype=np.int64)
    start[:] = 0
    found = np.empty(0, dtype=np.int64)
    for is_counted in (False, True):
        if is_counted:
            found = np.empty(start[-1], dtype=np.int64)
        seen = np.empty(n_models, dtype=np.int64)
        seen[:] = -1
        for m in range(n_models):
            seen[m] = m
            place = start[m]
            for row in range(model_start[m], model_start[m + 1]):
                p = point[row]
                for k in range(point_start[p], point_start[p + 1]):
                    other = model[rows[k]]
                    if seen[other] != m:
                        seen[other] = m
                        if is_counted:
                            found[place] = other
                        place += 1
            start[m + 1] = place
    return start, found


def chained_positions(incidence, xy):
    """Put the models together one after the other, to see where they lie.

    Each model, given by coordinates about its own centre, is put onto the one that it
    shares most points with, of those that lie already. Errors add up on the way; the
    positions serve the order of elimination only, which may be any.
    """
    z = np.ascontiguousarray(xy, dtype=float).view(complex)[:, 0]
    # models side by side for each point: looked up there, they take twice as long
    fan = incidence.point_start, incidence.rows, incidence.model[incidence.rows]
    placed = _chain(z, incidence.point, incidence.model_start, fan)
    position = np.nan_to_num(placed, posinf=0.0, neginf=0.0)
    return np.column_stack([position.real, position.imag])


@compiled
def _most_shared(m, point, model_start, fan, is_placed, shared, seen):
    """Placed model that shares most points with this one, and how many; −1: none."""
    point_start, _, holders = fan
    best, most = -1, 0
    for row in range(model_start[m], model_start[m + 1]):
        for k in range(point_start[point[row]], point_start[point[row] + 1]):
            other = holders[k]
            if is_placed[other]:
                if seen[other] != m:
                    seen[other], shared[other] = m, 0
                shared[other] += 1
                if shared[other] > most:
                    best, most = other, shared[other]
    return best, most


@compiled
def _onto(m, anchor, z, point, model_start, fan, pairs):
    """Similarity from a model to one that shares points with it: factor and shift."""
    point_start, rows, holders = fan
    n, zs, gs = 0, 0.0 + 0.0j, 0.0 + 0.0j
    for row in range(model_start[m], model_start[m + 1]):
        for k in range(point_start[point[row]], point_start[point[row] + 1]):
            if holders[k] == anchor:
                pairs[n, 0], pairs[n, 1] = z[row], z[rows[k]]
                zs, gs = zs + pairs[n, 0], gs + pairs[n, 1]
                n += 1
    zs, gs = zs / n, gs / n
    cross, square = 0.0 + 0.0j, 0.0
    for i in range(n):
        d = pairs[i, 0] - zs
        cross += (pairs[i, 1] - gs) * np.conj(d)
        square += d.real**2 + d.imag**2
    factor = 1.0 + 0.0j
    if n > 1 and square > 0.0 and abs(cross) > LEAST_FACTOR * square:
        factor = cross / square
    return factor, gs - factor * zs


@compiled
def _chain(z, point, model_start, fan):
    point_start, _, holders = fan
    n_models = model_start.size - 1
    position = np.zeros(n_models, dtype=np.complex128)
    factor = np.ones(n_models, dtype=np.complex128)
    is_placed = np.zeros(n_models, dtype=np.bool_)
    is_seen = np.zeros(point_start.size - 1, dtype=np.bool_)
    n_seen = np.zeros(n_models, dtype=np.int64)
    shared = np.zeros(n_models, dtype=np.int64)
    seen = np.full(n_models, -1, dtype=np.int64)
    pairs = np.empty((0, 2), dtype=np.complex128)
    queue = np.empty(n_models, dtype=np.int64)
    is_waiting = np.ones(n_models, dtype=np.bool_)  # not in the queue yet
    next_seed, head, tail = 0, 0, 0
    while head < n_models:
        if head == tail:
            # nothing hangs together any more: begin again
            while not is_waiting[next_seed]:
                next_seed += 1
            queue[tail], is_waiting[next_seed] = next_seed, False
            tail += 1
        m = queue[head]
        head += 1
        anchor, n = _most_shared(m, point, model_start, fan, is_placed, shared, seen)
        if anchor >= 0:
            if len(pairs) < n:
                pairs = np.empty((2 * n, 2), dtype=np.complex128)
            own, shift = _onto(m, anchor, z, point, model_start, fan, pairs)
            factor[m] = factor[anchor] * own
            position[m] = position[anchor] + factor[anchor] * shift
        is_placed[m] = True
        for row in range(model_start[m], model_start[m + 1]):
            p = point[row]
            if is_seen[p]:
                continue
            is_seen[p] = True
            for k in range(point_start[p], point_start[p + 1]):
                other = holders[k]
                n_seen[other] += 1
                # three points carry a scale well enough; a smaller model brings fewer
                size = model_start[other + 1] - model_start[other]
                if is_waiting[other] and n_seen[other] >= min(3, size):
                    queue[tail], is_waiting[other] = other, False
                    tail += 1
    return position
