"""The tables of a simultaneous adjustment."""

import numpy as np
import pandas as pd

from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.reliability import (
    external_reliability,
    minimal_detectable_bias,
    redundancy_numbers,
)
from einschalt.theory.block_adjustment.block_tests import judge_observations
from einschalt.theory.block_adjustment.model_deformation import neighbour_likeness

LEAST_REDUNDANCY = 1e-6
DEFORMATION_COLUMNS = [
    *("flight", "n_terms", "f_statistic", "p_value", "is_detected", "is_modelled"),
    *("size", "size_middle", "size_edge", "neighbour_correlation", "is_alike"),
]
AFFINE, HELMERT = ("a0", "a1", "a2", "b0", "b1", "b2"), ("a", "b", "te", "tn")


def point_table(tables, part, solution):
    """Coordinates of all adjusted points with their covariances.

    Parameters
    ----------
    tables : BlockTables
    part : Part
        What of it was adjusted.
    solution : BlockSolution

    Returns
    -------
    DataFrame
    """
    covariance = solution.point_cofactors
    east, north = covariance[:, 0, 0], covariance[:, 1, 1]
    observations = solution.observations
    is_control = observations.is_control
    n_models = np.bincount(observations.point, minlength=len(east))
    difference = solution.control_residuals
    return pd.DataFrame(
        {
            "point_id": tables.point_id[part.points],
            "easting": solution.points[:, 0],
            "northing": solution.points[:, 1],
            "standard_error_easting": np.sqrt(east),
            "standard_error_northing": np.sqrt(north),
            "covariance_en": covariance[:, 0, 1],
            "standard_error_total": np.sqrt(east + north),
            "n_models": n_models,
            "n_coverages": _n_coverages(tables, part, solution),
            "spread_total": _spread(solution, n_models),
            "role": np.where(is_control, "control", "new"),
            "difference_easting": difference[:, 0],
            "difference_northing": difference[:, 1],
        }
    )


def _n_coverages(tables, part, solution):
    observations = solution.observations
    coverage = tables.coverage[part.models][observations.model]
    pairs = np.unique(np.column_stack([observations.point, coverage]), axis=0)
    return np.bincount(pairs[:, 0], minlength=observations.n_points)


def _spread(solution, n_models):
    """TOTAL standard deviation of one model's value among all of a point."""
    point, residuals = solution.observations.point, solution.residuals
    count = np.maximum(n_models, 1)
    squares = np.bincount(point, (residuals**2).sum(axis=1), len(count))
    means = [np.bincount(point, column, len(count)) / count for column in residuals.T]
    squares -= count * (means[0] ** 2 + means[1] ** 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.sqrt(np.maximum(squares, 0.0) / (n_models - 1))
    return np.where(n_models > 1, spread, np.nan)


def residual_table(tables, part, cleaned, significance):
    """Residuals of all observations, tested, and what stays undetected.

    Parameters
    ----------
    tables : BlockTables
    part : Part
    cleaned : CleanedBlock
    significance : float
        Probability with which a model without gross errors has a suspect.

    Returns
    -------
    DataFrame
    """
    solution, observations = cleaned.solution, part.observations
    tests = judge_observations(solution, observations)
    leverage = solution.leverage.mean(axis=1)
    r = redundancy_numbers(leverage)
    bias = minimal_detectable_bias(observations.standard_error, r)
    start = np.searchsorted(observations.model, np.arange(observations.n_models + 1))
    names = tables.models.iloc[part.models[observations.model]].reset_index(drop=True)
    return names.assign(
        point_id=tables.point_id[part.points[observations.point]],
        residual_easting=solution.residuals[:, 0],
        residual_northing=solution.residuals[:, 1],
        leverage=leverage,
        redundancy_number=r,
        w=tests.w,
        p_value=tests.p_value,
        is_suspect=cleaned.is_out
        | is_rejected_by_holm(tests.p_value, start, significance),
        minimal_detectable_bias=bias,
        external_reliability=_remaining(bias, r),
    )


def _remaining(bias, r):
    # where nothing checks an observation, all of its error stays
    finite = np.where(np.isfinite(bias), bias, 0.0)
    return np.where(np.isfinite(bias), external_reliability(finite, r), np.inf)


def control_table(tables, part, solution, tests):
    """Control against the block: who disagrees, by how much and where to.

    Parameters
    ----------
    tables : BlockTables
    part : Part
    solution : BlockSolution
    tests : ControlVerdict

    Returns
    -------
    DataFrame
    """
    observations = solution.observations
    places = np.flatnonzero(observations.is_control)
    difference = solution.control_residuals[places]
    r = redundancy_numbers(solution.control_leverage[places].mean(axis=1))
    trace = np.trace(observations.control_covariance[places], axis1=1, axis2=2)
    p_value = tests.p_value[places]
    strain = tests.error[places]
    return pd.DataFrame(
        {
            "point_id": tables.point_id[part.points[places]],
            "difference_easting": difference[:, 0],
            "difference_northing": difference[:, 1],
            "standard_error_given": np.sqrt(trace),
            "redundancy_number": r,
            "w": tests.w[places],
            "p_value": p_value,
            "is_suspect": tests.is_suspect[places],
            "strain_easting": strain[:, 0],
            "strain_northing": strain[:, 1],
        }
    )


def model_table(tables, part, solution, reasons):
    """All models, those that could not be determined too, with their parameters.

    Parameters
    ----------
    tables : BlockTables
    part : Part
    solution : BlockSolution
    reasons : ndarray of object, shape (n_all_models,)
        Why a model could not be determined; empty where it was.

    Returns
    -------
    DataFrame
    """
    everything, kept = tables.observations, part.models
    n_all = everything.n_models
    model = solution.observations.model
    redundancy = np.bincount(model, (1.0 - solution.leverage).sum(axis=1))
    # rounding is no redundancy
    redundancy = np.where(redundancy > LEAST_REDUNDANCY, redundancy, 0.0)
    squares = np.bincount(model, (solution.residuals**2).sum(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        s_0 = np.sqrt(squares / np.where(redundancy > 0.0, redundancy, np.nan))
    is_usable = np.zeros(n_all, dtype=bool)
    is_usable[kept] = True
    models = tables.models.assign(
        transformation=np.where(everything.is_affine, "affine", "helmert"),
        n_points=np.bincount(everything.model, minlength=n_all),
        redundancy=_spread_out(redundancy, kept, n_all),
        m_0=_spread_out(SQRT2 * s_0, kept, n_all),
        s_0=_spread_out(s_0, kept, n_all),
        is_usable=is_usable,
        reason=reasons,
    )
    for name, values in _parameters(solution).items():
        models[name] = _spread_out(values, kept, n_all)
    return models


def _spread_out(values, kept, n_all):
    result = np.full(n_all, np.nan)
    result[kept] = values
    return result


def _parameters(solution):
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

    Parameters
    ----------
    solution : BlockSolution

    Returns
    -------
    cofactors : ndarray, shape (n_models, n_parameters, n_parameters)
    names : tuple of str
        Those of affine where models are of both kinds.
    """
    own = solution.parameter_cofactors
    if not solution.observations.is_affine.any() and own.shape[1] == 4:
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


def common_table(tables, solution):
    """Deformations that the models of a flight share.

    Parameters
    ----------
    tables : BlockTables
    solution : BlockSolution

    Returns
    -------
    DataFrame
    """
    deformation = solution.deformation
    names = np.array([*tables.flights, ""], dtype=object)
    flights = np.array(deformation.flight, dtype=np.int64)
    return pd.DataFrame(
        {
            "flight": names[flights],
            "term": np.array(deformation.names, dtype=object),
            "value": solution.common,
            "standard_error": np.sqrt(np.diag(solution.common_cofactors)),
        }
    )


def deformation_table(tables, solution, tests, terms, options):
    """Deformations that the models of each flight share, and what is left of them.

    Parameters
    ----------
    tables : BlockTables
    solution : BlockSolution
        After what was modelled.
    tests : sequence of DeformationTest
    terms : sequence of CommonTerms
        With which it was computed.
    options : AdjustmentOptions

    Returns
    -------
    DataFrame
    """
    rows = []
    for test in tests:
        likeness = neighbour_likeness(solution, test.terms.flight)
        rows.append(
            {
                "flight": tables.flights[test.terms.flight],
                "n_terms": len(test.terms.names),
                "f_statistic": test.f_statistic,
                "p_value": test.p_value,
                "is_detected": bool(test.p_value < options.significance),
                "is_modelled": test.terms in terms,
                "size": test.size,
                "size_middle": test.size_middle,
                "size_edge": test.size_edge,
                "neighbour_correlation": likeness.correlation,
                "is_alike": likeness.is_large,
            }
        )
    return pd.DataFrame(rows, columns=DEFORMATION_COLUMNS)
