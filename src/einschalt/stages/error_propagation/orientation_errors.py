"""Errors of orientations as a source of the propagation."""

import numpy as np

from einschalt.theory.adjustment.point_operator import Axes, PointOperator
from einschalt.theory.adjustment.propagation import scattered

N_ELEMENTS = 5
# one error more that moves nothing: the operators have blocks of two or three columns
N_COLUMNS = 6


def orientation_chains(flights, fits):
    """Operators from the errors of all orientations to those of measured points.

    Of each flight that was oriented: its measuring errors on the ground [m] from
    independent errors of variance 1, those of all flights side by side. ``fits`` are
    the transformations of each flight.
    """
    oriented = {name: errors for name, errors in flights.items() if errors is not None}
    widths = [N_COLUMNS * errors.n_models for errors in oriented.values()]
    starts = dict(zip(oriented, np.cumsum([0, *widths]), strict=False))
    return {
        name: _operator(errors, fits[name], starts[name], sum(widths))
        for name, errors in oriented.items()
    }


def _operator(errors, fit, first_column, width):
    models = fit.observed.models
    linear = fit.fit.linear[models.codes]
    n_points, n_coordinates = linear.shape[:2]
    axes = Axes(n_coordinates)
    on_ground = np.einsum("nab,nbk->nak", linear, errors.factors[:, :n_coordinates])
    elements = np.arange(N_ELEMENTS)
    columns = first_column + N_COLUMNS * errors.model[:, None] + elements
    rows, shape = axes.rows(np.arange(n_points)), (axes.size(n_points), width)
    return PointOperator((scattered(on_ground, rows, columns, shape),), axes)
