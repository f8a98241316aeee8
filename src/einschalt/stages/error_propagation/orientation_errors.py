"""Errors of orientations as a source of the propagation."""

import numpy as np

from einschalt.theory.adjustment.propagation import scattered

N_ELEMENTS = 5
# one error more that moves nothing: the operators have blocks of two or three columns
N_COLUMNS = 6


def orientation_chains(flights, fits):
    """Operators from the errors of all orientations to those of measured points.

    Parameters
    ----------
    flights : dict of str to OrientationErrors or None
        Of each flight; None where nothing was oriented.
    fits : dict of str to ModelTransformation
        Of the model points of each flight.

    Returns
    -------
    dict of str to csr_array
        Of each flight that was oriented, shape (n_axes · n_points, n_columns): its
        measuring errors on the ground [m] from independent errors of variance 1, those
        of all flights side by side.
    """
    oriented = {name: errors for name, errors in flights.items() if errors is not None}
    widths = [N_COLUMNS * errors.n_models for errors in oriented.values()]
    starts = dict(zip(oriented, np.cumsum([0, *widths]), strict=False))
    return {
        name: _operator(errors, fits[name], starts[name], sum(widths))
        for name, errors in oriented.items()
    }


def n_orientation_errors(flights, n_axes):
    """Count the sources of ``n_axes`` columns that the operators have.

    Parameters
    ----------
    flights : dict of str to OrientationErrors or None
    n_axes : int

    Returns
    -------
    int
    """
    oriented = [errors for errors in flights.values() if errors is not None]
    return sum(N_COLUMNS // n_axes * errors.n_models for errors in oriented)


def _operator(errors, fit, first_column, width):
    models = fit.observed.models
    linear = fit.fit.linear[models.codes]
    n_points, n_axes = linear.shape[:2]
    on_ground = np.einsum("nab,nbk->nak", linear, errors.factors[:, :n_axes])
    rows = n_axes * np.arange(n_points)[:, None] + np.arange(n_axes)
    elements = np.arange(N_ELEMENTS)
    columns = first_column + N_COLUMNS * errors.model[:, None] + elements
    return scattered(on_ground, rows, columns, (n_axes * n_points, width))
