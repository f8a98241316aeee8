"""The tables of a simultaneous adjustment."""

import numpy as np
import pandas as pd
from scipy import sparse

from einschalt.stages.simultaneous.height_columns import (
    remaining_bias,
    with_heights_of_points,
    with_heights_of_residuals,
)
from einschalt.stages.simultaneous.image_errors import judge_of
from einschalt.stages.simultaneous.own_deformation import is_detected, own_columns
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.reliability import (
    minimal_detectable_bias,
    redundancy_numbers,
)
from einschalt.theory.block_adjustment.model_deformation import (
    neighbour_autocorrelation,
)
from einschalt.theory.transformation.helmert_3d import PARAMETER_NAMES

LEAST_REDUNDANCY = 1e-6
DEFORMATION_COLUMNS = [
    *("flight", "n_terms", "f_statistic", "p_value", "is_detected", "is_modelled"),
    *("size", "size_middle", "size_edge", "neighbour_correlation", "is_alike"),
    *("own_size_edge", "own_size_edge_height", "own_p_value", "own_is_modelled"),
]
AFFINE, HELMERT = ("a0", "a1", "a2", "b0", "b1", "b2"), ("a", "b", "te", "tn")


def point_table(tables, part, cleaned, covariance) -> pd.DataFrame:
    """Coordinates of all adjusted points with their covariances, (n_points, d, d).

    What was taken out as a gross error counts for no model, and for no spread.
    """
    east, north = covariance[:, 0, 0], covariance[:, 1, 1]
    solution, rows = cleaned.solution, np.flatnonzero(~cleaned.is_out)
    observations = solution.observations
    is_control = observations.is_control
    n_models = np.bincount(observations.point[rows], minlength=len(east))
    difference = solution.control_residuals
    points = pd.DataFrame(
        {
            "point_id": tables.point_id[part.points],
            "easting": solution.points[:, 0],
            "northing": solution.points[:, 1],
            "standard_error_easting": np.sqrt(east),
            "standard_error_northing": np.sqrt(north),
            "covariance_en": covariance[:, 0, 1],
            "standard_error_total": np.sqrt(east + north),
            "n_models": n_models,
            "n_coverages": _n_coverages(tables, part, solution, rows),
            "spread_total": _spread(solution, n_models, rows),
            "role": np.where(is_control, "control", "new"),
            "difference_easting": difference[:, 0],
            "difference_northing": difference[:, 1],
        }
    )
    if not tables.is_spatial:
        return points
    return with_heights_of_points(points, solution, covariance)


def _n_coverages(tables, part, solution, rows):
    observations = solution.observations
    coverage = tables.coverage[part.models][observations.model[rows]]
    shape = (observations.n_points, int(tables.coverage.max(initial=-1)) + 1)
    # many times as fast as unique pairs in a block of millions of observations
    held = sparse.csr_array(
        (np.ones(len(rows), dtype=bool), (observations.point[rows], coverage)), shape
    )
    return np.diff(held.indptr)


def _spread(solution, n_models, rows):
    """TOTAL standard deviation of one model's value among all of a point."""
    point, residuals = solution.observations.point[rows], solution.residuals[rows, :2]
    count = np.maximum(n_models, 1)
    squares = np.bincount(point, (residuals**2).sum(axis=1), len(count))
    means = [np.bincount(point, column, len(count)) / count for column in residuals.T]
    squares -= count * (means[0] ** 2 + means[1] ** 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.sqrt(np.maximum(squares, 0.0) / (n_models - 1))
    return np.where(n_models > 1, spread, np.nan)


def residual_table(
    tables, part, cleaned, control, significance, drawn=None
) -> pd.DataFrame:
    """Residuals of all observations, tested, and what stays undetected.

    ``significance`` is the probability with which a model without gross errors has a
    suspect. Without ``control`` that contradicts, a suspect must still be one.
    ``drawn`` is the covariance of the residuals, of models from images.
    """
    solution, observations = cleaned.solution, part.observations
    judge = judge_of(part, drawn)
    none_out = np.zeros(len(observations.model), dtype=bool)
    tests = judge(solution, none_out, observations)
    leverage = solution.leverage[:, :2].mean(axis=1)
    r = redundancy_numbers(leverage)
    error = observations.standard_error  # of spatial models by axis
    bias = minimal_detectable_bias(error if error.ndim == 1 else error[:, 0], r)
    start = np.searchsorted(observations.model, np.arange(observations.n_models + 1))
    is_refused = is_rejected_by_holm(tests.p_value, significance, start)
    if control.is_suspect.any():
        # what only wrong control makes look wrong was measured well
        still = judge(control.without, none_out, observations).p_value
        is_refused &= is_rejected_by_holm(still, significance, start) | np.isnan(still)
    names = tables.models.iloc[part.models[observations.model]].reset_index(drop=True)
    residuals = names.assign(
        point_id=tables.point_id[part.points[observations.point]],
        residual_easting=solution.residuals[:, 0],
        residual_northing=solution.residuals[:, 1],
        leverage=leverage,
        redundancy_number=r,
        w=tests.w,
        p_value=tests.p_value,
        is_suspect=cleaned.is_refused | is_refused,
        minimal_detectable_bias=bias,
        external_reliability=remaining_bias(bias, r),
    )
    if not tables.is_spatial:
        return residuals
    return with_heights_of_residuals(residuals, solution, observations)


def control_table(tables, part, solution, tests, *, is_set_aside) -> pd.DataFrame:
    """Control against the block: who disagrees, by how much and where to.

    ``is_set_aside`` where the solution is that without the suspects.
    """
    observations = solution.observations
    places = np.flatnonzero(observations.is_control)
    difference = solution.control_residuals[places]
    r = redundancy_numbers(solution.control_leverage[places, :2].mean(axis=1))
    rows = part.points[places]
    given = tables.observations.control_covariance[rows, :2, :2]
    trace = np.trace(given, axis1=1, axis2=2)
    p_value = tests.p_value[places]
    strain = tests.error[places]
    control = pd.DataFrame(
        {
            "point_id": tables.point_id[rows],
            "difference_easting": difference[:, 0],
            "difference_northing": difference[:, 1],
            "standard_error_given": np.sqrt(trace),
            "redundancy_number": r,
            "w": tests.w[places],
            "p_value": p_value,
            "is_suspect": tests.is_suspect[places],
            "is_set_aside": tests.is_suspect[places] & is_set_aside,
            "strain_easting": strain[:, 0],
            "strain_northing": strain[:, 1],
        }
    )
    if tables.is_spatial:
        control.insert(3, "difference_height", difference[:, 2])
        control["strain_height"] = strain[:, 2]
    return control


def model_table(tables, part, cleaned, reasons) -> pd.DataFrame:
    """All models, those that could not be determined too, with their parameters.

    ``reasons`` (n_all_models,) say why a model could not be determined; empty where it
    was. What was taken out as a gross error is no redundancy, and not in m_0.
    """
    solution = cleaned.solution
    everything, kept = tables.observations, part.models
    n_all = everything.n_models
    is_point = ~tables.is_centre[everything.point]
    is_own = ~tables.is_centre[part.points][solution.observations.point]
    is_own &= ~cleaned.is_out
    free = (1.0 - solution.leverage).sum(axis=1)
    redundancy = np.bincount(solution.observations.model, free * is_own)
    # rounding is no redundancy
    redundancy = np.where(redundancy > LEAST_REDUNDANCY, redundancy, 0.0)
    s_0 = _in_plan(solution, is_own)
    is_usable = np.zeros(n_all, dtype=bool)
    is_usable[kept] = True
    models = tables.models.assign(
        transformation=tables.kind,
        n_points=np.bincount(everything.model[is_point], minlength=n_all),
        redundancy=_spread_out(redundancy, kept, n_all),
        m_0=_spread_out(SQRT2 * s_0, kept, n_all),
        s_0=_spread_out(s_0, kept, n_all),
        is_usable=is_usable,
        reason=reasons,
    )
    for name, values in _parameters(solution, is_spatial=tables.is_spatial).items():
        models[name] = _spread_out(values, kept, n_all)
    return models


def _in_plan(solution, is_own):
    """Standard error of a coordinate in plan that the points of each model show [m]."""
    model = solution.observations.model
    share = (1.0 - solution.leverage[:, :2]).sum(axis=1)
    free = np.bincount(model, share * is_own)
    own = (solution.residuals[:, :2] ** 2).sum(axis=1)
    squares = np.bincount(model, own * is_own)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.sqrt(squares / np.where(free > LEAST_REDUNDANCY, free, np.nan))


def _spread_out(values, kept, n_all):
    result = np.full(n_all, np.nan)
    result[kept] = values
    return result


def _parameters(solution, *, is_spatial):
    if is_spatial:
        return dict(zip(PARAMETER_NAMES, solution.parameters.T, strict=True))
    affinities, is_affine = solution.affinities, solution.observations.is_affine
    parameters = {}
    if is_affine.any():
        columns = affinities.reshape(-1, 6).T
        for name, column in zip(AFFINE, columns, strict=True):
            parameters[name] = np.where(is_affine, column, np.nan)
    if not is_affine.all():
        picked = ((0, 1), (1, 1), (0, 0), (1, 0))
        for name, (axis, place) in zip(HELMERT, picked, strict=True):
            column = affinities[:, axis, place]
            parameters[name] = np.where(is_affine, np.nan, column)
    return parameters


def parameter_cofactors(solution):
    """Cofactors of the parameters of each model, in the order of their names.

    Cofactors (n_models, n_parameters, n_parameters) and names; those of affine where
    models are of both kinds.
    """
    own = solution.parameter_cofactors
    if solution.residuals.shape[1] > len("xy"):
        return own, PARAMETER_NAMES
    if not solution.observations.is_affine.any():
        # two more unknowns are empty where easting and northing are coupled
        order, names = [2, 3, 0, 1], HELMERT
    else:
        order, names = [0, 2, 4, 1, 3, 5], AFFINE
        helmert = ~solution.observations.is_affine
        own = own.copy()
        # a helmert model as an affinity: E_y = −N_x, N_y = E_x
        turn = np.eye(6)
        turn[4], turn[5] = 0.0, 0.0
        turn[4, 3], turn[5, 2] = -1.0, 1.0
        own[helmert] = turn @ own[helmert] @ turn.T
    return own[:, order][:, :, order], names


def common_table(tables, solution, bends) -> pd.DataFrame:
    """Deformations that the models of a flight share.

    ``bends`` are the SharedBends of spatial models.
    """
    flight, names = bends.flights, bends.names
    if not tables.is_spatial:
        flight, names = solution.deformation.flight, solution.deformation.names
    of_flights = np.array(tables.flights, dtype=object)
    return pd.DataFrame(
        {
            "flight": of_flights[np.array(flight, dtype=np.int64)],
            "term": np.array(names, dtype=object),
            "value": solution.common,
            "standard_error": np.sqrt(np.diag(solution.common_cofactors)),
        }
    )


def scale_table(tables, bends) -> pd.DataFrame:
    """Flights whose heights are surely out of scale, as of SharedBends."""
    columns = ["flight", "ratio", "p_value", "moved_height"]
    rows = [
        (tables.flights[scale.flight], scale.ratio, scale.p_value, scale.moved)
        for scale in bends.scales
        if scale.is_told_apart
    ]
    return pd.DataFrame(rows, columns=columns)


def deformation_table(tables, solution, found, options) -> pd.DataFrame:
    """Deformations that the models of each flight share, and those that each has.

    ``found`` are tests in plan of the former, the SharedBends of spatial models, and an
    OwnDeformation or None; ``solution`` is that after what was modelled.
    """
    tests, bends, own = found
    is_modelled = options.deformation == "modelled" and is_detected(own)
    rows = [
        {
            "flight": tables.flights[test.flight],
            "n_terms": test.n_terms,
            "f_statistic": test.f_statistic,
            "p_value": test.p_value,
            "is_detected": bool(test.p_value < options.significance),
            "is_modelled": _is_modelled(test, solution, bends),
            "size": test.size,
            "size_middle": test.size_middle,
            "size_edge": test.size_edge,
            **_neighbours_of(test, solution),
            **own_columns(own, test.flight, is_modelled=is_modelled),
        }
        for test in (*tests, *bends.tests)
    ]
    return pd.DataFrame(rows, columns=DEFORMATION_COLUMNS)


def _is_modelled(test, solution, bends):
    if solution.observations.is_in_space:
        return test.flight in bends.flights
    return test.terms in solution.terms


def _neighbours_of(test, solution):
    """Columns on residuals of neighbouring points, which are compared in plan."""
    if solution.observations.is_in_space:
        return {"neighbour_correlation": np.nan, "is_alike": False}
    likeness = neighbour_autocorrelation(solution, test.flight)
    return {
        "neighbour_correlation": likeness.correlation,
        "is_alike": likeness.is_large,
    }
