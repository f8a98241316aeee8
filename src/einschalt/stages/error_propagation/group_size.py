"""How large the shifts are that groups of given points share, where nobody says it.

A model that holds points of two groups cannot follow both: what the points of a group
in a model have in common of their residuals shows the size of the shifts, by Helmert's
components of variance with everything else held.
"""

from dataclasses import replace

import numpy as np
from scipy import sparse

from einschalt.foundations.key_columns import rows_among
from einschalt.stages.error_propagation.given_points import GROUPS
from einschalt.theory.adjustment.monte_carlo import draw_errors
from einschalt.theory.adjustment.point_operator import by_coordinate, selection
from einschalt.theory.adjustment.variance_components import (
    SumOfSquares,
    estimate_factors,
)

KEY = ["coverage", "model_id", "point_id"]

# share of the squares of shifts that residuals must show
LEAST_SHOWN = 0.02
N_DRAWS = 20


def with_group_sizes(model, given, flight, fit, free=()):
    """Give the groups of given points shifts of the size that the residuals show.

    ``flight`` was fitted onto points with the errors ``given``; ``fit`` is its
    transformation. ``free`` are sources whose sizes nobody gave either: beside shifts
    they are what the residuals leave. Where the residuals do not tell the shifts, these
    are left out and the model is one that assumes.
    """
    source = given.to_be_estimated
    shifts = model.standard_errors.keys() & set(GROUPS.values())
    if not source and not (free and shifts):
        return model
    if source:
        sums = _sums(model, source, flight, fit)
    else:
        sums = [sum_of_residuals(model, flight, fit)]
    held = dict.fromkeys(model.standard_errors.keys() - {source, *free}, 0.0)
    found = _factors(sums, model.standard_errors, held)
    # 0 where the residuals do not tell
    factors, is_told = {source: 0.0}, found is not None
    if is_told:
        # what hides in the noise may be as large as it is uncertain
        spread = np.sqrt(np.diag(found.covariance))
        found = replace(found, factors=np.maximum(found.factors, spread))
        factors = dict(zip(found.sources, found.factors, strict=True))
    sizes = {
        name: size * np.sqrt(factors.get(name, 1.0))
        for name, size in model.standard_errors.items()
    }
    return replace(
        model,
        standard_errors=sizes,
        is_assumed=model.is_assumed or not is_told,
    )


def _factors(sums, standard_errors, held):
    """Estimate factors of variances; None where no sum tells one from another."""
    if sums is None:
        return None
    try:
        return estimate_factors(sums, standard_errors, held=held)
    except np.linalg.LinAlgError:
        return None


def sum_of_residuals(model, flight, fit) -> SumOfSquares:
    """Residuals of a flight in plan, and how they come from the errors of all sources.

    ``fit`` is its transformation; suspects count as 0.
    """
    observed, axes = fit.observed, model.axes
    operator = model.low if model.is_last(flight) else model.high.operator
    rows, n_rows = observed.row_numbers, operator.measured.n_points
    fitted = selection(rows, n_rows, axes)
    plan = sparse.diags_array(_is_sound(fit).astype(float))
    plan = by_coordinate(plan, axes, is_plan_only=True)
    # what a model leaves of misclosures at its points
    left = (plan @ fitted @ operator.measured @ fitted.T).formed().finite()
    residuals = axes.packed(np.nan_to_num(fit.fit.residuals))
    chains = model.chains_to_fits(flight, observed)
    return SumOfSquares(
        plan.apply(residuals), {name: -left @ c for name, c in chains.items()}
    )


def _is_sound(fit):
    """Which of the fitted points are no suspects."""
    # what was taken out has a residual, and is no row of the fit
    suspects = fit.residuals.loc[fit.residuals["is_suspect"].astype(bool), KEY]
    return ~rows_among(fit.observed.rows, suspects, KEY)


def _sums(model, source, flight, fit):
    """Sums of squares: of all residuals, and of their means by model and group.

    None where the latter show nothing of the shifts.
    """
    observed = fit.observed
    cells = _cells(observed, model.groups_of_fits(flight, source, observed))
    # of single points they are the residuals again
    if cells is None or cells.nnz == cells.shape[0]:
        return None
    every = sum_of_residuals(model, flight, fit)
    means = by_coordinate(cells, model.axes)
    of_cells = {name: means @ chain for name, chain in every.chains.items()}
    of_cells = SumOfSquares(means.apply(every.values), of_cells)
    size, n_fits = model.standard_errors[source], cells.shape[1]
    shown = _share_that_shows(of_cells, source, size, n_fits)
    return [every, of_cells] if shown > LEAST_SHOWN else None


def _cells(observed, group):
    """Means over the points of a group in a model, times √n, (n_cells, n_fits)."""
    rows = np.flatnonzero(group >= 0)
    if len(rows) == 0:
        return None
    model = np.repeat(np.arange(len(observed.start) - 1), np.diff(observed.start))
    key = model[rows] * (group.max() + 1) + group[rows]
    _, cell, count = np.unique(key, return_inverse=True, return_counts=True)
    shape = (len(count), len(group))
    return sparse.csr_array((1.0 / np.sqrt(count[cell]), (cell, rows)), shape)


def _share_that_shows(part, source, size, n_fits):
    """Squares of shifts that the means show, over all squares at these points."""
    axes = part.chains[source].axes
    drawn = draw_errors({source: size}, axes, n_draws=N_DRAWS, seed=0)[source]
    shown = np.abs(part.chains[source].apply(drawn)) ** 2
    each = 2.0 * np.mean(np.square(size)) * n_fits
    return float(shown.sum(axis=0).mean() / each)
