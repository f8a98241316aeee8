"""Deformations that each model has for itself as a source of the propagation."""

import numpy as np

from einschalt.foundations.frame_columns import values_of
from einschalt.theory.adjustment.point_operator import Axes, PointOperator
from einschalt.theory.adjustment.propagation import scattered
from einschalt.theory.block_adjustment.own_deformation import TERMS


def bending_chains(own, points, fits, axes):
    """Operators from coefficients of variance 1 to the measuring errors on the ground.

    By flight, those of all flights side by side; none where ``own`` is None or 0.
    ``points`` and ``fits`` are the model points of each flight and what they were
    transformed to; flights are numbered in this order in ``own``.
    """
    if own is None or not own.kinds:
        return {}
    n_terms = sum(TERMS[family] for family in own.families)
    counts = [len(fits[name].models) * n_terms for name in points]
    starts = np.cumsum([0, *counts])
    chains = {}
    for number, (name, table) in enumerate(points.items()):
        xy, model = values_of(table, ["x", "y"]), fits[name].observed.models.codes
        displaced = own.displacements(number, xy, model)
        place = starts[number], starts[-1]
        chains[name] = _operator(displaced, model, place, axes)
    return chains


def _operator(displacements, model, place, axes):
    plan, height = displacements
    n_points, n_terms = plan.shape
    start, n_sources = place
    sources = start + model[:, None] * n_terms + np.arange(n_terms)
    if axes is Axes.COMPLEX:
        blocks = plan[:, None, :]
    else:
        turns = np.zeros((n_points, axes.value, n_terms, axes.value))
        turns[:, 0, :, 0] = turns[:, 1, :, 1] = plan.real
        turns[:, 1, :, 0], turns[:, 0, :, 1] = plan.imag, -plan.imag
        if axes is Axes.SPACE:
            turns[:, 2, :, 2] = height
        blocks = turns.reshape(n_points, axes.value, -1)
    rows = axes.rows(np.arange(n_points))
    columns = axes.rows(sources).reshape(n_points, -1)
    shape = (axes.size(n_points), axes.size(n_sources))
    return PointOperator((scattered(blocks, rows, columns, shape),), axes)
