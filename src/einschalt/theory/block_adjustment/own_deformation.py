"""Deformations that each model has for itself: random effects of the adjustment.

Film, lens, photographs and their orientation bend every model in its own way. Each
model m of a flight is displaced on the ground by

    Σ_k τ_d f_k(x, y) c_mk,   c_mk ~ N(0, 1) for each axis,

f_k the products of powers of the position in the model of degree d (1 at the edge); of
similarities also the mirrored position, an affinity. Heights have sizes of their own.
See :mod:`.own_deformation_size` for the sizes τ, docs/theory/own_deformation.md for
both.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    CUBIC,
    QUADRATIC,
    positions_in_model,
    powers_of,
)

PLAN, HEIGHT = "plan", "height"
TERMS = {AFFINITY: 1, QUADRATIC: 3, CUBIC: 4}
# deformations below this share of the measuring error at the edge change nothing
LEAST_SHARE = 0.2
EDGE = 0.75


@dataclass(frozen=True, eq=False)
class OwnDeformation:
    """Sizes of the deformations that each model of a flight has for itself."""

    flight: np.ndarray  # (n,): of each size
    family: tuple[str, ...]  # "affinity", "quadratic" or "cubic"
    axis: tuple[str, ...]  # "plan" or "height"
    size: np.ndarray  # (n,): τ on the ground [m]; 0 where nothing shows
    relative_error: np.ndarray  # (n,): standard error over size; NaN where this is 0
    p_value: float  # that chance makes such sizes, all together; NaN without a test

    def edge(self, flight, axis=PLAN):
        """Displacement at the edge of the models of a flight (RMS, in plan total) [m].

        Without what an affine transformation takes up.
        """
        along = np.linspace(-1.0, 1.0, 41)
        position = np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)
        is_edge = np.abs(position).max(axis=1) > EDGE
        plane = np.column_stack([np.ones(len(position)), position])
        square = 0.0
        for k in np.flatnonzero(self._is(axis=axis) & (self.flight == flight)):
            terms = bending_terms(self.family[k], position)
            if self.family[k] != AFFINITY:
                terms = terms - plane @ np.linalg.lstsq(plane, terms.real)[0]
            each = (np.abs(terms[is_edge]) ** 2).sum(axis=1)
            square += self.size[k] ** 2 * each.mean()
        return float(np.sqrt(square * (2.0 if axis == PLAN else 1.0)))

    def without_small(self, errors):
        """Set sizes to 0 that change nothing beside ``errors`` of measuring (n,)."""
        is_small = self.size < LEAST_SHARE * errors
        return replace(
            self,
            size=np.where(is_small, 0.0, self.size),
            relative_error=np.where(is_small, np.nan, self.relative_error),
        )

    def _is(self, **wanted):
        fits = np.ones(len(self.size), dtype=bool)
        for name, value in wanted.items():
            fits &= np.array([own == value for own in getattr(self, name)])
        return fits

    def size_of(self, flight, family, axis):
        """One of the sizes [m]."""
        is_it = self._is(family=family, axis=axis) & (self.flight == flight)
        return float(self.size[is_it].sum())

    @property
    def families(self):
        """Families of which any size is not 0, tuple of str."""
        used = {family for family, _ in self.kinds}
        return tuple(family for family in TERMS if family in used)

    def displacements(self, flight, xy, model):
        """Displacements of all points of a flight by coefficients of variance 1.

        In plan (complex, one coefficient for each axis) and in height, both (n_points,
        n_terms) with the terms of ``families`` [m].
        """
        position, _ = positions_in_model(xy, model)
        terms = {family: bending_terms(family, position) for family in self.families}
        plan, height = (
            [self.size_of(flight, f, axis) * part for f, part in terms.items()]
            for axis in (PLAN, HEIGHT)
        )
        return np.hstack(plan), np.hstack(height).real

    @property
    def error_of_variance(self):
        """Standard error of the variance of all together, over this variance."""
        is_known = np.isfinite(self.relative_error) & (self.size > 0.0)
        weight = self.size[is_known] ** 2
        errors = 2.0 * self.relative_error[is_known] * weight
        return float(np.sqrt(np.sum(errors**2)) / weight.sum())

    @property
    def kinds(self):
        """Family and axis of the columns that flights share, tuple of pairs."""
        pairs = zip(self.family, self.axis, self.size, strict=True)
        used = {(family, axis) for family, axis, size in pairs if size > 0.0}
        every = ((family, axis) for axis in (PLAN, HEIGHT) for family in TERMS)
        return tuple(kind for kind in every if kind in used)


def bending_terms(family, position):
    """Displacement by each term with the coefficient 1, (n, n_terms), complex."""
    if family == AFFINITY:
        return position[:, :1] - 1j * position[:, 1:]
    return powers_of(family, position) + 0j


def bent_columns(observations, own):
    """Displacements by own deformations, as ``bent`` of the observations [m].

    Kind after kind as in ``own.kinds``; None where all sizes are 0.
    """
    if not own.kinds:
        return None
    flight_of_row = observations.flight[observations.model]
    n_terms = [TERMS[family] for family in own.families]
    plan = np.zeros((len(flight_of_row), sum(n_terms)), dtype=complex)
    height = np.zeros(plan.shape)
    for flight in np.unique(own.flight):
        rows = np.flatnonzero(flight_of_row == flight)
        if len(rows):
            xy, model = observations.xy_in_model[rows], observations.model[rows]
            plan[rows], height[rows] = own.displacements(flight, xy, model)
    if not observations.is_in_space:
        is_mirrored = AFFINITY in own.families
        return plan if is_mirrored else np.ascontiguousarray(plan.real)
    ends = np.cumsum(n_terms)[:-1]
    by_axis = {
        axis: dict(zip(own.families, np.split(terms, ends, axis=1), strict=True))
        for axis, terms in ((PLAN, plan), (HEIGHT, height))
    }
    parts = [_in_space(by_axis[axis][family], axis) for family, axis in own.kinds]
    return np.concatenate(parts, axis=2)


def _in_space(terms, axis):
    """Easting, northing, height by each coefficient, (n, 3, n_columns)."""
    nil = np.zeros_like(terms.real)
    if axis == HEIGHT:
        return np.stack([nil, nil, terms.real], axis=1)
    turns = np.concatenate([terms, 1j * terms], axis=1)
    return np.stack([turns.real, turns.imag, np.concatenate([nil, nil], 1)], axis=1)


def columns_of_sizes(own, observations):
    """Models of the flight and columns of ``bent`` of each size that is not 0, dict.

    By the number of the size; each pair selects from (n_models, n_columns).
    """
    per_term = {PLAN: 2 if observations.is_in_space else 1, HEIGHT: 1}
    widths = [TERMS[family] * per_term[axis] for family, axis in own.kinds]
    ends = np.cumsum(widths)
    columns = {
        kind: np.arange(end - width, end)
        for kind, width, end in zip(own.kinds, widths, ends, strict=True)
    }
    return {
        k: np.ix_(
            observations.flight == own.flight[k], columns[own.family[k], own.axis[k]]
        )
        for k in np.flatnonzero(own.size)
    }
