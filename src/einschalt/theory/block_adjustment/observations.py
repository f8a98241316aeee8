"""What is adjusted: measured points of all models, and control with its errors."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy import sparse

from einschalt.theory.adjustment.monte_carlo import draws_in_parts


@dataclass(frozen=True, eq=False)
class SharedControl:
    """What the errors of given points have in common, in each coordinate alike."""

    # (n_points, n_sources) sparse: errors over their sizes, which each point has beside
    # the shift of its group, by independent ones of variance 1; None where each has
    # its own
    factor: sparse.csr_array | None
    # (n_points, n_groups) sparse: shift of its group by one of variance 1 [m]
    groups: sparse.csr_array
    # whether nobody has said how large these are; then no covariance has them
    is_unknown: bool = False

    @property
    def variance(self):
        """Of the shift that each point has with its group, (n_points,) [m²]."""
        squares = self.groups.power(2).sum(axis=1)
        return np.zeros(self.groups.shape[0]) if self.is_unknown else squares

    def of_points(self, points):
        """Take some of the points."""
        factor = None if self.factor is None else self.factor[points]
        return replace(self, factor=factor, groups=self.groups[points])

    def scaled(self, factor):
        """Shifts that are larger by a factor."""
        return replace(self, groups=self.groups * factor)


@dataclass(frozen=True, eq=False, kw_only=True)
class ObservedBlock:
    """What observations in plan (d = 2) and in space (d = 3) have in common.

    They are sorted by model. The names say which arrays go by rows and by models; those
    of control go by points.
    """

    model: np.ndarray  # (n_rows,)
    point: np.ndarray  # (n_rows,): every one from 0 to n_points − 1 occurs
    # (n_models,): models of one flight share their common parameters
    flight: np.ndarray
    # (n_points, d): given [m]; NaN where a point is no control, and for the height of
    # control that is known in plan alone
    control: np.ndarray
    # (n_points, d, d): of the given coordinates with the shifts of their groups [m²]; 0
    # where they are to be held, and of what is not given
    control_covariance: np.ndarray
    shared_control: SharedControl | None = None
    # points on the ground by the coefficients of deformations that each model has for
    # itself, of variance 1 [m]: in plan (n_rows, n_bent) by one for each axis, complex
    # where a term is mirrored; in space (n_rows, 3, n_bent)
    bent: np.ndarray | None = None
    # (n_models,), (n_points,): their places in the order of their names, in which
    # errors are drawn: the order of the rows of a table must not decide. Without, they
    # are drawn as they stand here
    model_rank: np.ndarray | None = None
    point_rank: np.ndarray | None = None

    _by_row: ClassVar[tuple[str, ...]]
    _by_model: ClassVar[tuple[str, ...]]

    @property
    def n_models(self):
        """Number of models."""
        return len(self.flight)

    @property
    def n_points(self):
        """Number of points."""
        return len(self.control)

    @property
    def is_in_space(self):
        """Whether heights are observed too."""
        return self.control.shape[1] > 2

    @property
    def is_control(self):
        """Which points have given coordinates, in plan at least."""
        # all() and any() over axes of two elements take many times as long
        return np.logical_and.reduce([np.isfinite(axis) for axis in self.control.T[:2]])

    @property
    def is_given(self):
        """Which coordinates of control are given, (n_points, d)."""
        return self.is_control[:, None] & np.isfinite(self.control)

    @property
    def is_fixed(self):
        """Which of them are held."""
        elements = self.control_covariance.reshape(-1, self.control.shape[1] ** 2).T
        return self.is_control & np.logical_and.reduce([e == 0.0 for e in elements])

    @property
    def control_weight(self):
        """Inverse of the covariances of control, 0 elsewhere, (n_points, d, d)."""
        weight = np.zeros(self.control_covariance.shape)
        is_observed = self.is_control & ~self.is_fixed
        nothing = self._not_given[is_observed]
        covariance = self.control_covariance[is_observed] + nothing
        weight[is_observed] = np.linalg.inv(covariance) - nothing
        return weight

    @property
    def _not_given(self):
        """Ones on the diagonal, of the coordinates that are not given, (n, d, d).

        With these in their place covariances are regular; they are apart from the rest.
        """
        return ~self.is_given[:, :, None] * np.eye(self.control.shape[1])

    def drawn_control(self, rng, n_draws, *, with_shifts=True):
        """Draw errors of the given coordinates, 0 where there are none.

        (n_points, d, n_draws) [m]; with the shifts of groups where these are known.
        """
        shared, covariance = self.shared_control, self.control_covariance
        if shared is not None:
            covariance = covariance - self._each_with(shared)
        root = np.zeros(covariance.shape)
        is_observed = self.is_control & ~self.is_fixed
        nothing = self._not_given[is_observed]
        own = np.linalg.cholesky(covariance[is_observed] + nothing)
        root[is_observed] = own - nothing
        shape = (*self.control.shape[1:], n_draws)
        if shared is None or shared.factor is None:
            own = _normal(rng, (self.n_points, *shape), self._drawn_points)
        else:
            own = _times_normal(rng, shared.factor, shape)
        if shared is None or shared.is_unknown or not with_shifts:
            return root @ own
        shifts = _times_normal(rng, shared.groups, shape)
        return root @ own + shifts * self.is_given[:, :, None]

    def with_shared_control(self, shared):
        """Put shifts of groups, of known sizes, beside the errors that control has.

        What is held is without errors.
        """
        is_free = sparse.diags_array((~self.is_fixed).astype(float))
        shared = replace(shared, groups=(is_free @ shared.groups).tocsr())
        covariance = self.control_covariance + self._each_with(shared)
        return replace(self, shared_control=shared, control_covariance=covariance)

    def _each_with(self, shared):
        """Variances of the shifts of groups in what is given, (n_points, d, d) [m²]."""
        own = shared.variance[:, None] * self.is_given
        return own[:, :, None] * np.eye(self.control.shape[1])

    def control_in_parts(self, n_draws):
        """Draw errors of the given coordinates, part after part.

        Gives the generator, with which further errors of the part are drawn, their
        number, and those of :meth:`drawn_control`.
        """
        rng = np.random.default_rng(1971)
        n_numbers = self.control.shape[1] * len(self.model)
        for n_of_part in draws_in_parts(n_draws, n_numbers):
            yield rng, n_of_part, self.drawn_control(rng, n_of_part)

    def drawn_errors(self, rng, n_draws, linear):
        """Draw errors of all measured points on the ground, (n_rows, d, n_draws) [m].

        Those of the points, and those that all points of a model share; ``linear``
        (n_models, d, d) leads from the models to the ground.
        """
        error = self.standard_error.reshape(len(self.model), -1, 1)
        shape = (len(self.model), self.control.shape[1], n_draws)
        drawn = _normal(rng, shape, self._drawn_rows)
        return error * drawn + self._shared(rng, n_draws, linear)

    def _shared(self, rng, n_draws, linear):  # noqa: ARG002 - plane models need all
        """Errors that all points of a model share."""
        return self._drawn_by_model(rng, n_draws, self.bent)

    def _drawn_by_model(self, rng, n_draws, columns):
        """What coefficients of each model do, of variance 1; columns (n_rows, d, k)."""
        if columns is None:
            return 0.0
        size = (self.n_models, columns.shape[2], n_draws)
        return columns @ _normal(rng, size, self._drawn_models)[self.model]

    @cached_property
    def _drawn_rows(self):
        """Place of each row among those that are drawn, (n_rows,); None: as it is."""
        if self.point_rank is None:
            return None
        ranks = self.point_rank[self.point], self.model_rank[self.model]
        return _inverse(np.lexsort(ranks))

    @cached_property
    def _drawn_models(self):
        return None if self.model_rank is None else _inverse(self.model_rank.argsort())

    @cached_property
    def _drawn_points(self):
        return None if self.point_rank is None else _inverse(self.point_rank.argsort())

    def of_models(self, is_kept):
        """Leave models out, and the points that only these hold."""
        rows = np.flatnonzero(is_kept[self.model])
        return self.of_rows(rows, np.flatnonzero(is_kept))

    def of_rows(self, rows, models):
        """Take some of the observations, ascending, and the models that hold them."""
        model_number = np.full(self.n_models, -1)
        model_number[models] = np.arange(len(models))
        points, point = np.unique(self.point[rows], return_inverse=True)
        places = {
            **dict.fromkeys(self._by_row, rows),
            **dict.fromkeys(self._by_model, models),
            **dict.fromkeys(("control", "control_covariance", "point_rank"), points),
        }
        given = {name: getattr(self, name) for name in places}
        shared = self.shared_control
        kept = replace(
            self,
            shared_control=None if shared is None else shared.of_points(points),
            model=model_number[self.model[rows]],
            point=point,
            **{n: a[places[n]] for n, a in given.items() if a is not None},
        )
        return Part(kept, rows, models, points)


def _normal(rng, shape, places):
    """Errors of variance 1, drawn in an order in which each has its place."""
    drawn = rng.standard_normal(shape)
    return drawn if places is None else drawn[places]


def _inverse(order):
    """Place of each number in an order of all of them."""
    places = np.empty(len(order), dtype=np.int64)
    places[order] = np.arange(len(order))
    return places


def _times_normal(rng, factor, shape):
    """Sparse rows times independent errors of variance 1, (n_rows, *shape)."""
    drawn = rng.standard_normal((factor.shape[1], int(np.prod(shape))))
    return (factor @ drawn).reshape(-1, *shape)


@dataclass(frozen=True, eq=False, kw_only=True)
class BlockObservations(ObservedBlock):
    """Observations of a block in plan."""

    xy: np.ndarray  # (n_rows, 2): model coordinates, in any unit
    # (n_rows,): of one measured coordinate on the ground [m]
    standard_error: np.ndarray
    is_affine: np.ndarray  # (n_models,): affine, or helmert
    # (n_rows, 2, n_elements): ``xy`` by errors that all points of a model share:
    # independent, of variance 1
    orientation: np.ndarray | None = None

    _by_row = ("xy", "standard_error", "orientation", "bent")
    _by_model = ("is_affine", "flight", "model_rank")

    @property
    def xy_in_model(self):
        """Model coordinates in plan, (n_rows, 2)."""
        return self.xy

    def _shared(self, rng, n_draws, linear):
        turned, bent = None, None
        if self.orientation is not None:
            turned = linear[self.model] @ self.orientation
        if self.bent is not None:  # by one coefficient for each axis
            turns = np.concatenate([self.bent, 1j * self.bent], axis=1)
            bent = np.stack([turns.real, turns.imag], axis=1)
        parts = (self._drawn_by_model(rng, n_draws, part) for part in (turned, bent))
        return sum(parts)

    @property
    def is_coupled(self):
        """Whether the control of any point couples easting and northing."""
        covariance = self.control_covariance[self.is_control]
        is_even = covariance[:, 0, 0] == covariance[:, 1, 1]
        return not (is_even & (covariance[:, 0, 1] == 0.0)).all()


@dataclass(frozen=True, eq=False)
class Part:
    """Part of the observations of a block."""

    observations: ObservedBlock
    rows: np.ndarray  # old number of each observation, model and point
    models: np.ndarray
    points: np.ndarray
