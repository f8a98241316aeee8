"""Easting and northing as the solver takes them: what they share is computed once.

Where every observation has one weight for both coordinates, a similarity is linear in
complex numbers (two unknowns in place of four), and the two rows of an affinity have
the same normal equations (three unknowns and two right sides in place of six). Control
with correlated or unequal coordinates, or flights of different kinds, couple the two.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.kernels import compiled


@dataclass(frozen=True, eq=False)
class ModelFrames:
    """Where the reduced coordinates of each model have their origin, and their unit."""

    centroid: np.ndarray  # (n_models, 2)
    extent: np.ndarray  # (n_models,): root mean square distance from the centroid


def reduce_models(xy, model, n_models):
    """Reduce coordinates, sorted by model, to centroid and extent of each model.

    The reduced ones, (n_rows, 2), and the ModelFrames.
    """
    reduced = np.empty((len(xy), 2))
    centroid, extent = np.zeros((n_models, 2)), np.ones(n_models)
    start = np.searchsorted(model, np.arange(n_models + 1))
    _reduce(np.ascontiguousarray(xy), start, reduced, centroid, extent)
    return reduced, ModelFrames(centroid, extent)


@compiled
def _reduce(xy, start, reduced, centroid, extent):
    for m in range(start.size - 1):
        low, high = start[m], start[m + 1]
        if low == high:
            continue
        # about a point of the model first: sums far from the origin lose digits
        x_0, y_0 = xy[low, 0], xy[low, 1]
        x_mean, y_mean = 0.0, 0.0
        for row in range(low, high):
            x_mean += xy[row, 0] - x_0
            y_mean += xy[row, 1] - y_0
        x_mean /= high - low
        y_mean /= high - low
        square = 0.0
        for row in range(low, high):
            x, y = xy[row, 0] - x_0 - x_mean, xy[row, 1] - y_0 - y_mean
            reduced[row, 0], reduced[row, 1] = x, y
            square += x * x + y * y
        if square > 0.0:
            extent[m] = np.sqrt(square / (high - low))
        centroid[m, 0], centroid[m, 1] = x_0 + x_mean, y_0 + y_mean
        for row in range(low, high):
            reduced[row, 0] /= extent[m]
            reduced[row, 1] /= extent[m]


class Channels:
    """One way to arrange easting and northing.

    The real unknowns of a model are E0, N0, E_x, N_x, E_y, N_y for affine and E0, N0,
    a, b for helmert, in reduced coordinates; coupled, helmert has two more, which are
    0.

    The ``way`` is "complex", one complex coordinate; "shared", one real system with two
    right sides; or "coupled", two rows for each point: where control couples easting
    and northing, models are of both kinds, or have errors that all their points share
    (``n_shared`` further unknowns). ``n_bent`` terms of a deformation that each model
    has for itself have complex coefficients, or one for each axis.
    """

    def __init__(self, is_affine, *, is_coupled, n_shared=0, n_bent=0):
        self.is_affine, self.n_shared, self.n_bent = is_affine, n_shared, n_bent
        is_mixed = is_affine.any() and not is_affine.all()
        pure = "shared" if is_affine.all() else "complex"
        self.way = "coupled" if is_coupled or is_mixed or n_shared else pure

    @property
    def n_unknowns(self):
        """Real unknowns of a model."""
        return self.n_parameters + self.n_shared + 2 * self.n_bent

    @property
    def n_parameters(self):
        """Those that the transformation has; the others come after them."""
        return 4 if self.way == "complex" else 6

    @property
    def prior(self):
        """Weight with which each solved unknown is 0 before it is observed."""
        weight = np.zeros(self.is_empty.shape[1])
        n_known = {"complex": 2, "shared": 3, "coupled": 6}[self.way]
        weight[n_known:] = 1.0
        return weight

    def design(self, xy, model, shared=None, bent=None):
        """Coefficients of the unknowns of each observation, (n_rows, d, n_unknowns).

        ``xy`` is reduced; ``shared`` (n_rows, 2, n_shared) is what the errors of
        variance 1 that a model shares do on the ground [m], ``bent`` (n_rows, n_bent)
        what a deformation of its own with coefficients of variance 1 does.
        """
        if bent is None:
            bent = np.zeros((len(xy), 0))
        x, y = xy.T
        if self.way == "complex":
            design = np.empty((len(xy), 1, 2 + bent.shape[1]), dtype=complex)
            design[:, 0, 0], design[:, 0, 2:] = 1.0, bent
            design[:, 0, 1].real, design[:, 0, 1].imag = x, y
            return design
        if self.way == "shared":
            design = np.empty((len(xy), 1, 3 + bent.shape[1]))
            design[:, 0, 0], design[:, 0, 3:] = 1.0, bent.real
            design[:, 0, 1], design[:, 0, 2] = x, y
            return design
        one, nil = np.ones(len(xy)), np.zeros(len(xy))
        turned = np.where(self.is_affine[model], 0.0, y)
        own = y - turned
        east = np.stack([one, nil, x, -turned, own, nil], -1)
        north = np.stack([nil, one, turned, x, nil, own], -1)
        both = [np.stack([east, north], 1)]
        if shared is not None:
            both.append(shared)
        turns = np.stack([bent, 1j * bent], -1).reshape(len(xy), -1)
        both.append(np.stack([turns.real, turns.imag], 1))
        return np.concatenate(both, 2)

    @property
    def is_empty(self):
        """Unknowns that a model does not have, shape (n_models, n_unknowns)."""
        known = {"complex": 2, "shared": 3, "coupled": 6 + self.n_shared + self.n_bent}
        shape = (len(self.is_affine), known[self.way] + self.n_bent)
        empty = np.zeros(shape, dtype=bool)
        if self.way == "coupled":
            empty[~self.is_affine, 4:6] = True
        return empty

    def split(self, values):
        """Arrange easting and northing, (n, 2, …), as right sides, (n, d, n_right)."""
        if self.way == "complex":
            return values[:, :1] + 1j * values[:, 1:]
        if self.way == "shared":
            return np.ascontiguousarray(values.reshape(len(values), 1, -1))
        return np.ascontiguousarray(values)

    def join(self, values):
        """Give easting and northing back; the inverse of :meth:`split`."""
        if self.way == "complex":
            if values.shape[2] == 1:  # a column holds both as it is
                return np.ascontiguousarray(values).view(float).reshape(-1, 2, 1)
            return np.concatenate([values.real, values.imag], 1)
        if self.way == "shared":
            return values.reshape(len(values), 2, -1)
        return values

    def plane(self, cofactors):
        """Cofactors of easting and northing, (n, 2, 2), from those of points."""
        if self.way == "coupled":
            return cofactors
        both = np.zeros((len(cofactors), 2, 2))
        both[:, 0, 0] = both[:, 1, 1] = cofactors[:, 0, 0].real
        return both

    def control_weight(self, weight):
        """Weights of control as the points take them, (n_points, d, d)."""
        if self.way == "coupled":
            return weight
        return np.ascontiguousarray(weight[:, :1, :1])

    def unknowns(self, solved):
        """Real unknowns of each model, (n_models, n_unknowns, n_columns)."""
        if self.way == "complex":
            both = np.stack([solved.real, solved.imag], 2)
            return both.reshape(len(solved), self.n_unknowns, -1)
        if self.way == "shared":
            return solved.reshape(len(solved), self.n_unknowns, -1)
        return solved

    def unknown_cofactors(self, solved):
        """Cofactors of the real unknowns of each model."""
        if self.way == "coupled":
            return np.where(self.is_empty[:, :, None], 0.0, solved)
        n_models, u, _ = solved.shape
        both = np.zeros((n_models, u, 2, u, 2))
        both[:, :, 0, :, 0] = both[:, :, 1, :, 1] = solved.real
        if self.way == "complex":
            both[:, :, 1, :, 0] = solved.imag
            both[:, :, 0, :, 1] = -solved.imag
        return both.reshape(n_models, 2 * u, 2 * u)

    def affinities(self, unknowns):
        """Every model as an affinity of its reduced coordinates, (n_models, 2, 3).

        Rows are easting, northing; columns shift, x, y.
        """
        e0, n0, ex, nx = unknowns[:, :4].T
        if self.way == "complex":
            ey, ny = -nx, ex
        else:
            ey = np.where(self.is_affine, unknowns[:, 4], -nx)
            ny = np.where(self.is_affine, unknowns[:, 5], ex)
        rows = np.stack([e0, ex, ey], -1), np.stack([n0, nx, ny], -1)
        return np.stack(rows, 1)
