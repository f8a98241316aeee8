"""Which models share points, and where models lie to each other.

Two models are neighbours where they hold a common point: these are the blocks of the
normal equations that are not zero once the points are eliminated. From the positions
of the models, found by chaining them together, the order of elimination is taken.
"""

from dataclasses import dataclass

import numba
import numpy as np

from einschalt.foundations.batches import segments


@dataclass(frozen=True, eq=False)
class Fans:
    """Observations sorted by model, and the same sorted by point.

    Attributes
    ----------
    model, point : ndarray of int64, shape (n_rows,)
        Of each observation; sorted by model.
    model_start : ndarray of int64, shape (n_models + 1,)
    point_start : ndarray of int64, shape (n_points + 1,)
    rows : ndarray of int64, shape (n_rows,)
        Observations of each point: point k owns ``rows[point_start[k]:…]``.
    """

    model: np.ndarray
    point: np.ndarray
    model_start: np.ndarray
    point_start: np.ndarray
    rows: np.ndarray

    @property
    def n_models(self):
        """Number of models."""
        return len(self.model_start) - 1

    @property
    def n_points(self):
        """Number of points."""
        return len(self.point_start) - 1

    def reordered(self, order):
        """Put the models in another order, their observations and points with them.

        Parameters
        ----------
        order : ndarray of int64, shape (n_models,)
            Models as they are to stand.

        Returns
        -------
        Reordered
            Points stand in the order of their first appearance, so that what is used
            together lies together.
        """
        model, point, rows, points = _reorder(order, self.point, self.model_start)
        fans = fans_of(model, point, self.n_models, len(points))
        return Reordered(fans, rows, points)


@dataclass(frozen=True, eq=False)
class Reordered:
    """Observations in another order.

    Attributes
    ----------
    fans : Fans
    rows, points : ndarray of int64
        Old number of each observation and of each point.
    """

    fans: Fans
    rows: np.ndarray
    points: np.ndarray


@numba.njit(cache=True, nogil=True)
def _reorder(order, point, model_start):
    n_rows = point.size
    n_points = 0
    for row in range(n_rows):
        n_points = max(n_points, point[row] + 1)
    model = np.empty(n_rows, dtype=np.int64)
    new_point = np.empty(n_rows, dtype=np.int64)
    rows = np.empty(n_rows, dtype=np.int64)
    points = np.empty(n_points, dtype=np.int64)
    number = np.full(n_points, -1, dtype=np.int64)
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


def fans_of(model, point, n_models, n_points) -> Fans:
    """Sort observations by their point.

    Parameters
    ----------
    model, point : ndarray of int, shape (n_rows,)
        Sorted by model.
    n_models, n_points : int

    Returns
    -------
    Fans
    """
    model = np.ascontiguousarray(model, dtype=np.int64)
    point = np.ascontiguousarray(point, dtype=np.int64)
    by_point = segments(point, n_points)
    count = np.bincount(model, minlength=n_models)
    start = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
    return Fans(model, point, start, by_point.start, by_point.order)


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Neighbours of every model.

    Attributes
    ----------
    start : ndarray of int64, shape (n_models + 1,)
    models : ndarray of int64, shape (n_pairs,)
        Model k has the neighbours ``models[start[k]:start[k + 1]]``, without itself.
    """

    start: np.ndarray
    models: np.ndarray


def neighbours_of(fans) -> Neighbours:
    """Find the models that share a point with each model.

    Parameters
    ----------
    fans : Fans

    Returns
    -------
    Neighbours
    """
    arrays = (fans.model, fans.point, fans.model_start, fans.point_start, fans.rows)
    start = np.concatenate([[0], np.cumsum(_count_neighbours(*arrays))])
    return Neighbours(start, _fill_neighbours(start, *arrays))


@numba.njit(cache=True, nogil=True)
def _count_neighbours(model, point, model_start, point_start, rows):
    n_models = model_start.size - 1
    count = np.zeros(n_models, dtype=np.int64)
    seen = np.full(n_models, -1, dtype=np.int64)
    for m in range(n_models):
        seen[m] = m
        for row in range(model_start[m], model_start[m + 1]):
            p = point[row]
            for k in range(point_start[p], point_start[p + 1]):
                other = model[rows[k]]
                if seen[other] != m:
                    seen[other] = m
                    count[m] += 1
    return count


@numba.njit(cache=True, nogil=True)
def _fill_neighbours(start, model, point, model_start, point_start, rows):
    n_models = model_start.size - 1
    found = np.empty(start[-1], dtype=np.int64)
    seen = np.full(n_models, -1, dtype=np.int64)
    for m in range(n_models):
        seen[m] = m
        place = start[m]
        for row in range(model_start[m], model_start[m + 1]):
            p = point[row]
            for k in range(point_start[p], point_start[p + 1]):
                other = model[rows[k]]
                if seen[other] != m:
                    seen[other] = m
                    found[place] = other
                    place += 1
    return found


def chained_positions(fans, xy):
    """Put the models together one after the other, to see where they lie.

    From one model to the next, similarities from the points that are placed already
    give a place to its other points. Errors add up on the way; the positions serve
    the order of elimination only, which may be any.

    Parameters
    ----------
    fans : Fans
    xy : ndarray, shape (n_rows, 2)
        Model coordinates, each model about its own centre.

    Returns
    -------
    ndarray, shape (n_models, 2)
        In the frame of the first model.
    """
    z = np.ascontiguousarray(xy[:, 0] + 1j * xy[:, 1])
    placed = _chain(z, fans.model, fans.point, fans.model_start, *_by_point(fans))
    position = np.nan_to_num(placed, posinf=0.0, neginf=0.0)
    return np.column_stack([position.real, position.imag])


def _by_point(fans):
    return fans.point_start, fans.rows


@numba.njit(cache=True, nogil=True)
def _chain(z, model, point, model_start, point_start, rows):
    n_models = model_start.size - 1
    position = np.zeros(n_models, dtype=np.complex128)
    place = np.zeros(point_start.size - 1, dtype=np.complex128)
    is_placed = np.zeros(point_start.size - 1, dtype=np.bool_)
    n_placed = np.zeros(n_models, dtype=np.int64)
    queue = np.empty(n_models, dtype=np.int64)
    state = np.zeros(n_models, dtype=np.int8)  # 0 waits, 1 in the queue, 2 done
    next_seed = 0
    head, tail = 0, 0
    while head < n_models:
        if head == tail:
            # nothing hangs together any more: begin again, with the best known model
            while state[next_seed] != 0:
                next_seed += 1
            queue[tail], state[next_seed] = next_seed, 1
            tail += 1
        m = queue[head]
        head += 1
        first, last = model_start[m], model_start[m + 1]
        n, zs, gs = 0, 0.0 + 0.0j, 0.0 + 0.0j
        for row in range(first, last):
            if is_placed[point[row]]:
                n += 1
                zs += z[row]
                gs += place[point[row]]
        a, shift = 1.0 + 0.0j, 0.0 + 0.0j
        if n > 0:
            zs, gs = zs / n, gs / n
            cross, square = 0.0 + 0.0j, 0.0
            for row in range(first, last):
                if is_placed[point[row]]:
                    d = z[row] - zs
                    cross += (place[point[row]] - gs) * np.conj(d)
                    square += d.real**2 + d.imag**2
            if n > 1 and square > 0.0 and abs(cross) > 1e-3 * square:
                a = cross / square
            shift = gs - a * zs
        state[m] = 2
        position[m] = shift
        for row in range(first, last):
            p = point[row]
            if is_placed[p]:
                continue
            is_placed[p] = True
            place[p] = a * z[row] + shift
            for k in range(point_start[p], point_start[p + 1]):
                other = model[rows[k]]
                n_placed[other] += 1
                # three points carry a scale well enough; a smaller model brings fewer
                size = model_start[other + 1] - model_start[other]
                if state[other] == 0 and n_placed[other] >= min(3, size):
                    queue[tail], state[other] = other, 1
                    tail += 1
    return position
