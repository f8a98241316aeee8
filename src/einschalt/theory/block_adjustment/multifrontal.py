"""Cholesky factor, solutions and selected inverse, front by front.

Every front collects its part of the normal equations and what its children left,
eliminates its own models with dense LAPACK, and leaves an update to its parent
(multifrontal method, Duff and Reid 1983). The way back down gives the elements of the
inverse where the normal equations have any (Erisman and Tinney 1975):

    Z_bs = −Z_bb Y,   Z_ss = (L_ss L_ssᴴ)⁻¹ − Yᴴ Z_bs,   Y = L_bs L_ss⁻¹,

s the models that a front eliminates and b its boundary, whose Z_bb the parent knows.
"""

from dataclasses import dataclass

import numba
import numpy as np

from einschalt.theory.block_adjustment.dense_kernels import (
    ADJOINT,
    LEFT,
    PLAIN,
    RIGHT,
    factor_lower,
    invert_lower,
    multiply_hermitian,
    one_thread,
    solve_triangle,
    subtract_product,
    subtract_square,
    work_arrays,
)
from einschalt.theory.block_adjustment.elimination_pattern import (
    BlockPattern,
    Fronts,
    Storage,
    storage_for,
)

# a pivot that has lost all but this share has no digit left that means anything
LEAST_PIVOT = 1e-14
# in place of such a pivot: the unknown is held
HELD = 1e100


@dataclass(frozen=True, eq=False)
class Factor:
    """Cholesky factor of the reduced normal equations.

    Attributes
    ----------
    pattern : BlockPattern
    fronts : Fronts
    storage : Storage
    panels : ndarray
        Columns of the factor, front after front.
    is_held : ndarray of bool, shape (n_models, n_unknowns)
        Unknowns, in the order of elimination, that nothing determines.
    """

    pattern: BlockPattern
    fronts: Fronts
    storage: Storage
    panels: np.ndarray
    is_held: np.ndarray

    @property
    def n_unknowns(self):
        """Unknowns of each model."""
        return self.is_held.shape[1]

    def solve(self, right_sides):
        """Solve for several right sides.

        Parameters
        ----------
        right_sides : ndarray, shape (n_models, n_unknowns, n_right)
            In the order of elimination.

        Returns
        -------
        ndarray
            Of the same shape; 0 for what is held.
        """
        n_models, n_unknowns, n_right = right_sides.shape
        x = np.moveaxis(right_sides, 2, 0).reshape(n_right, -1)
        x = np.ascontiguousarray(x, dtype=self.panels.dtype).copy()
        arrays = (self.fronts.start, self.fronts.boundary_start, self.fronts.boundary)
        with one_thread():
            _solve(
                x,
                self.panels,
                self.storage.panel_start,
                *arrays,
                n_unknowns,
                work_arrays(x.dtype),
            )
        return np.moveaxis(x.reshape(n_right, n_models, n_unknowns), 0, 2)

    def null_vector(self, place, unknown):
        """How everything moves with an unknown that nothing determines.

        Parameters
        ----------
        place, unknown : int
            One of ``is_held``.

        Returns
        -------
        ndarray, shape (n_models, n_unknowns)
        """
        x = np.zeros((1, self.is_held.size), dtype=self.panels.dtype)
        x[0, place * self.n_unknowns + unknown] = HELD
        arrays = (self.fronts.start, self.fronts.boundary_start, self.fronts.boundary)
        with one_thread():
            _solve_backward(
                x,
                self.panels,
                self.storage.panel_start,
                *arrays,
                self.n_unknowns,
                work_arrays(x.dtype),
            )
        return x.reshape(self.is_held.shape)

    def selected_inverse(self):
        """Inverse where the normal equations have blocks.

        Returns
        -------
        ndarray, shape (n_blocks, n_unknowns, n_unknowns)
            Block by block as in the pattern, lower triangle.
        """
        fronts, n_unknowns = self.fronts, self.n_unknowns
        shape = (len(self.pattern.row), n_unknowns, n_unknowns)
        inverse = np.zeros(shape, dtype=self.panels.dtype)
        with one_thread():
            _invert(
                inverse,
                (self.pattern.start, self.pattern.row),
                self.panels,
                self.storage.panel_start,
                (
                    fronts.start,
                    fronts.parent,
                    fronts.n_children,
                    fronts.boundary_start,
                    fronts.boundary,
                ),
                (self.storage.path, self.storage.largest),
                work_arrays(inverse.dtype),
            )
        return inverse


def factorize(blocks, pattern, fronts) -> Factor:
    """Factor the reduced normal equations.

    Parameters
    ----------
    blocks : ndarray, shape (n_blocks, n_unknowns, n_unknowns)
        Of the pattern; float or complex.
    pattern : BlockPattern
    fronts : Fronts

    Returns
    -------
    Factor
    """
    n_unknowns = blocks.shape[1]
    storage = storage_for(fronts, n_unknowns)
    panels = np.zeros(storage.panel_start[-1], dtype=blocks.dtype)
    is_held = np.zeros((len(pattern.start) - 1, n_unknowns), dtype=np.bool_)
    with one_thread():
        _factorize(
            blocks,
            (pattern.start, pattern.row),
            panels,
            storage.panel_start,
            (
                fronts.start,
                fronts.n_children,
                fronts.boundary_start,
                fronts.boundary,
            ),
            (storage.stack, storage.largest),
            is_held,
            work_arrays(blocks.dtype),
        )
    return Factor(pattern, fronts, storage, panels, is_held)


@numba.njit(cache=True, nogil=True)
def _collect(panel, sizes, own_first, blocks, column, row, local):
    """Put the blocks of a front's own columns into its panel."""
    n_own, size, u = sizes
    for i in range(own_first, own_first + n_own):
        left = (i - own_first) * u
        for k in range(column[i], column[i + 1]):
            top = local[row[k]] * u
            for b in range(u):
                for a in range(u):
                    panel[(left + b) * size + top + a] += blocks[k, a, b]


@numba.njit(cache=True, nogil=True)
def _add_update(panel, update, sizes, child, n_child, boundary, local):
    """Add what a child left, lower triangle, to panel and update of its parent."""
    n_own, size, u = sizes
    own, rest = n_own * u, size - n_own * u
    ld = n_child * u
    for j in range(n_child):
        column = local[boundary[j]] * u
        for i in range(j, n_child):
            top = local[boundary[i]] * u
            for b in range(u):
                source = (j * u + b) * ld + i * u
                first = b if i == j else 0
                if column < own:
                    target = (column + b) * size + top
                    for a in range(first, u):
                        panel[target + a] += child[source + a]
                else:
                    target = (column - own + b) * rest + top - own
                    for a in range(first, u):
                        update[target + a] += child[source + a]


@numba.njit(cache=True, nogil=True)
def _factor_carefully(panel, k, size, reference, held):
    """Cholesky factor of a front's own part; pivots that vanish are held."""
    for j in range(k):
        pivot = panel[j * size + j].real
        for c in range(j):
            value = panel[c * size + j]
            pivot -= value.real**2 + value.imag**2
        if pivot <= LEAST_PIVOT * reference[j]:
            held[j] = True
            panel[j * size + j] = HELD
            for i in range(j + 1, k):
                panel[j * size + i] = 0.0
            continue
        root = np.sqrt(pivot)
        panel[j * size + j] = root
        for i in range(j + 1, k):
            value = panel[j * size + i]
            for c in range(j):
                value -= panel[c * size + i] * np.conj(panel[c * size + j])
            panel[j * size + i] = value / root


@numba.njit(cache=True, nogil=True)
def _factor_own(panel, k, size, reference, held, copy, work):
    for j in range(k):
        for i in range(j, k):
            copy[j * k + i] = panel[j * size + i]
    is_sound = factor_lower(panel, k, size, work) == 0
    for j in range(k):
        pivot = panel[j * size + j].real
        # not so written that NaN would pass
        if not pivot * pivot > LEAST_PIVOT * reference[j]:
            is_sound = False
    if is_sound:
        return
    for j in range(k):
        for i in range(j, k):
            panel[j * size + i] = copy[j * k + i]
    _factor_carefully(panel, k, size, reference, held)


@numba.njit(cache=True, nogil=True)
def _factorize(blocks, pattern, panels, panel_start, fronts, sizes, is_held, work):
    column, row = pattern
    start, n_children, boundary_start, boundary = fronts
    stack_size, largest = sizes
    n_fronts, u = start.size - 1, blocks.shape[1]
    stack = np.empty(stack_size, dtype=blocks.dtype)
    place = np.zeros(n_fronts + 1, dtype=np.int64)  # of each waiting update
    waiting = np.empty(n_fronts, dtype=np.int64)
    local = np.empty(start[-1], dtype=np.int64)
    reference = np.empty(largest)
    held = np.zeros(largest, dtype=np.bool_)
    update = np.empty(0, dtype=blocks.dtype)
    copy = np.empty(0, dtype=blocks.dtype)
    top = 0
    for f in range(n_fronts):
        first, last = start[f], start[f + 1]
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        n_own, n_edge = last - first, edge.size
        k, rest = n_own * u, n_edge * u
        size = k + rest
        if update.size < rest * rest:
            update = np.empty(rest * rest, dtype=blocks.dtype)
        if copy.size < k * k:
            copy = np.empty(k * k, dtype=blocks.dtype)
        for i in range(first, last):
            local[i] = i - first
        for i in range(n_edge):
            local[edge[i]] = n_own + i
        panel = panels[panel_start[f] : panel_start[f + 1]]
        update[: rest * rest] = 0.0
        dims = (n_own, size, u)
        _collect(panel, dims, first, blocks, column, row, local)
        for _ in range(n_children[f]):
            top -= 1
            child = waiting[top]
            edge_of_child = boundary[boundary_start[child] : boundary_start[child + 1]]
            _add_update(
                panel,
                update,
                dims,
                stack[place[top] :],
                edge_of_child.size,
                edge_of_child,
                local,
            )
        if k > 0:
            for i in range(n_own):
                for a in range(u):
                    reference[i * u + a] = blocks[column[first + i], a, a].real
            held[:k] = False
            _factor_own(panel, k, size, reference, held, copy, work)
            for i in range(n_own):
                for a in range(u):
                    is_held[first + i, a] = held[i * u + a]
            if rest > 0:
                solve_triangle(
                    RIGHT, ADJOINT, (rest, k), panel, size, panel[k:], size, work
                )
                subtract_square(panel[k:], rest, k, size, update, rest, work)
        for j in range(rest):
            low = place[top] + j * rest
            stack[low + j : low + rest] = update[j * rest + j : (j + 1) * rest]
        waiting[top] = f
        place[top + 1] = place[top] + rest * rest
        top += 1


@numba.njit(cache=True, nogil=True)
def _solve(x, panels, panel_start, start, boundary_start, boundary, u, work):
    n_right = x.shape[0]
    buffer = np.empty(0, dtype=x.dtype)
    for f in range(start.size - 1):
        first, k = start[f] * u, (start[f + 1] - start[f]) * u
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        rest = edge.size * u
        size = k + rest
        if k == 0:
            continue
        if buffer.size < size * n_right:
            buffer = np.empty(size * n_right, dtype=x.dtype)
        panel = panels[panel_start[f] :]
        for r in range(n_right):
            buffer[r * size : r * size + k] = x[r, first : first + k]
            buffer[r * size + k : (r + 1) * size] = 0.0
        solve_triangle(LEFT, PLAIN, (k, n_right), panel, size, buffer, size, work)
        if rest > 0:
            subtract_product(
                PLAIN,
                panel[k:],
                size,
                buffer,
                size,
                buffer[k:],
                size,
                (rest, n_right, k),
                work,
            )
        for r in range(n_right):
            x[r, first : first + k] = buffer[r * size : r * size + k]
            for i in range(edge.size):
                for a in range(u):
                    x[r, edge[i] * u + a] += buffer[r * size + k + i * u + a]
    _solve_backward(x, panels, panel_start, start, boundary_start, boundary, u, work)


@numba.njit(cache=True, nogil=True)
def _solve_backward(x, panels, panel_start, start, boundary_start, boundary, u, work):
    n_right = x.shape[0]
    buffer = np.empty(0, dtype=x.dtype)
    for f in range(start.size - 2, -1, -1):
        first, k = start[f] * u, (start[f + 1] - start[f]) * u
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        rest = edge.size * u
        size = k + rest
        if k == 0:
            continue
        if buffer.size < size * n_right:
            buffer = np.empty(size * n_right, dtype=x.dtype)
        panel = panels[panel_start[f] :]
        for r in range(n_right):
            buffer[r * size : r * size + k] = x[r, first : first + k]
            for i in range(edge.size):
                for a in range(u):
                    buffer[r * size + k + i * u + a] = x[r, edge[i] * u + a]
        if rest > 0:
            subtract_product(
                ADJOINT,
                panel[k:],
                size,
                buffer[k:],
                size,
                buffer,
                size,
                (k, n_right, rest),
                work,
            )
        solve_triangle(LEFT, ADJOINT, (k, n_right), panel, size, buffer, size, work)
        for r in range(n_right):
            x[r, first : first + k] = buffer[r * size : r * size + k]


@numba.njit(cache=True, nogil=True)
def _gather(known, size_known, target, n_edge, local, edge, u):
    """Lower triangle of the boundary's inverse, out of the parent's."""
    rest = n_edge * u
    for j in range(n_edge):
        left = local[edge[j]] * u
        for i in range(j, n_edge):
            top = local[edge[i]] * u
            for b in range(u):
                source = (left + b) * size_known + top
                place = (j * u + b) * rest + i * u
                for a in range(b if i == j else 0, u):
                    target[place + a] = known[source + a]


@numba.njit(cache=True, nogil=True)
def _invert(inverse, pattern, panels, panel_start, fronts, sizes, work):
    column, row = pattern
    start, parent, n_children, boundary_start, boundary = fronts
    path, _ = sizes
    n_fronts, u = start.size - 1, inverse.shape[1]
    pile = np.empty(path, dtype=inverse.dtype)
    depth_of = np.zeros(n_fronts, dtype=np.int64)
    place = np.zeros(n_fronts + 1, dtype=np.int64)
    local = np.empty(start[-1], dtype=np.int64)
    y = np.empty(0, dtype=inverse.dtype)
    below = np.empty(0, dtype=inverse.dtype)
    edge_inverse = np.empty(0, dtype=inverse.dtype)
    own_inverse = np.empty(0, dtype=inverse.dtype)
    for f in range(n_fronts - 1, -1, -1):
        first, last = start[f], start[f + 1]
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        n_own, n_edge = last - first, edge.size
        k, rest = n_own * u, n_edge * u
        size = k + rest
        above = parent[f]
        depth = 0 if above < 0 else depth_of[above] + 1
        depth_of[f] = depth
        if edge_inverse.size < rest * rest:
            edge_inverse = np.empty(rest * rest, dtype=inverse.dtype)
        if y.size < rest * k:
            y = np.empty(rest * k, dtype=inverse.dtype)
            below = np.empty(rest * k, dtype=inverse.dtype)
        if own_inverse.size < k * k:
            own_inverse = np.empty(k * k, dtype=inverse.dtype)
        if rest > 0:
            first_above, last_above = start[above], start[above + 1]
            edge_above = boundary[boundary_start[above] : boundary_start[above + 1]]
            n_above = last_above - first_above
            for i in range(first_above, last_above):
                local[i] = i - first_above
            for i in range(edge_above.size):
                local[edge_above[i]] = n_above + i
            size_above = (n_above + edge_above.size) * u
            known = pile[place[depth - 1] :]
            _gather(known, size_above, edge_inverse, n_edge, local, edge, u)
        panel = panels[panel_start[f] :]
        for j in range(k):
            own_inverse[j * k + j : (j + 1) * k] = panel[j * size + j : j * size + k]
        if k > 0:
            if rest > 0:
                for j in range(k):
                    y[j * rest : (j + 1) * rest] = panel[j * size + k : (j + 1) * size]
                solve_triangle(RIGHT, PLAIN, (rest, k), panel, size, y, rest, work)
                multiply_hermitian(
                    edge_inverse, rest, y, rest, below, rest, (rest, k), work
                )
            invert_lower(own_inverse, k, k, work)
            if rest > 0:
                subtract_product(
                    ADJOINT, y, rest, below, rest, own_inverse, k, (k, k, rest), work
                )
        for i in range(first, last):
            local[i] = i - first
        for i in range(n_edge):
            local[edge[i]] = n_own + i
        for i in range(n_own):
            for slot in range(column[first + i], column[first + i + 1]):
                top = local[row[slot]]
                for b in range(u):
                    for a in range(u):
                        if top > i and top >= n_own:
                            value = below[(i * u + b) * rest + (top - n_own) * u + a]
                        elif top > i or a >= b:
                            value = own_inverse[(i * u + b) * k + top * u + a]
                        else:
                            value = np.conj(own_inverse[(i * u + a) * k + top * u + b])
                        inverse[slot, a, b] = value
        place[depth + 1] = place[depth]
        if n_children[f] > 0:
            whole = pile[place[depth] :]
            for j in range(k):
                low = j * size
                whole[low + j : low + k] = own_inverse[j * k + j : (j + 1) * k]
                whole[low + k : low + size] = below[j * rest : (j + 1) * rest]
            for j in range(rest):
                low = (k + j) * size + k
                whole[low + j : low + rest] = edge_inverse[
                    j * rest + j : (j + 1) * rest
                ]
            place[depth + 1] = place[depth] + size * size
