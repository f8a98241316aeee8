"""The low flight once onto given ground coordinates: stages 3, 4 and 5."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import MODEL, with_columns
from einschalt.foundations.key_columns import rows_among
from einschalt.pipeline.block.given_points import (
    ONE_ADJUSTMENT,
    fitted_onto,
    known_of_models,
)
from einschalt.pipeline.densification.simultaneous import PLANE_KINDS
from einschalt.stages.error_propagation.error_model import places_fitted_onto
from einschalt.stages.model_screening import (
    screen_models,
    suspect_rows,
    without_gross_errors,
)
from einschalt.stages.stage1_approximate_coordinates import require_usable
from einschalt.stages.stage3_model_transformation import (
    STAGE,
    ModelTransformation,
    transform_models,
)
from einschalt.stages.stage4_error_budget import error_budget
from einschalt.stages.stage5_double_coverage import (
    CoverageMean,
    average_coverages,
    with_positions,
)
from einschalt.stages.transformation_kinds import (
    SPATIAL,
    TRANSFORMATION_KINDS,
    more_points_for,
)

TOGETHER = 'Or adjust all models together: method = "auto"'


@dataclass(frozen=True, eq=False)
class LowFlightFit:
    """What the low flight gives on given ground coordinates."""

    low: ModelTransformation  # stage 3
    values: pd.DataFrame  # every model's value of every point, with its budget
    means: CoverageMean  # stage 5


def transform_low_flight(
    block, model_points, ground, precision, settings, *, covariances=None, is_gross
):
    """Transform the low flight onto ground points, check points excepted.

    Rows that ``is_gross`` marks take no part either; ``precision`` weighs the tests of
    residuals, and ``covariances`` are those behind them, see
    :func:`~einschalt.stages.model_screening.screen_models`. A GeometryError where not
    one model could be transformed.
    """
    kind = block.low_flight.transformation
    fitted = places_fitted_onto(block, ground["point_id"])
    low = transform_models(model_points, ground.iloc[fitted], kind)
    how = (settings.outliers, settings.significance, precision)
    low = screen_models(low, *how, covariances=covariances, is_gross=is_gross)
    tied = _tied_models(block, model_points, settings, low.failures)
    if not low.is_usable:
        otherwise = TOGETHER if len(tied) else ""
        require_usable(low, "low flight", STAGE, otherwise)
    is_tied = rows_among(low.failures, tied, MODEL)
    is_tied &= (low.failures["remedy"] == more_points_for(kind)).to_numpy()
    if not is_tied.any():
        return low
    remedy = low.failures["remedy"].mask(is_tied, ONE_ADJUSTMENT)
    return replace(low, failures=low.failures.assign(remedy=remedy))


def _tied_models(block, model_points, settings, failures):
    """Models that have too few given points, and that one adjustment can place.

    DataFrame of coverage, model_id; without rows where one adjustment was asked for,
    or cannot be made.
    """
    control, kind = block.control_points, block.low_flight.transformation
    is_adjustable = control is not None and kind in (*PLANE_KINDS, SPATIAL)
    if failures.empty or settings.method != "two_step" or not is_adjustable:
        return model_points.loc[:, MODEL].iloc[:0]
    least = TRANSFORMATION_KINDS[kind].least_points
    known = known_of_models(model_points, fitted_onto(control, control), least)
    return model_points.loc[known.is_lacking & known.is_tied, MODEL]


def average_low_flight(
    block, model_points, low, settings, *, is_gross, averaging
) -> LowFlightFit:
    """Budget and means of the values that the models of the low flight give.

    Rows that ``is_gross`` marks take no part; ``averaging`` are arguments of
    :func:`~einschalt.stages.stage5_double_coverage.average_coverages`.
    """
    values = _single_values(block.low_flight, low, model_points)
    usable = values
    if settings.outliers != "keep":
        usable = without_gross_errors(values, is_gross | suspect_rows(values, low))
    means = average_coverages(usable, **averaging)
    return LowFlightFit(low, values, _internally_checked(means, low))


def _single_values(flight, low, model_points):
    values = with_positions(low.own_values, model_points)
    budget = error_budget(
        flight.m_g_um_of(model_points), flight.scale_number, values["m_t"].to_numpy()
    )
    return with_columns(values, standard_error_paper=budget)


def _internally_checked(means, low):
    if low.fit.redundancy.any():
        return means
    # models without redundancy repeat the approximate coordinates in both coverages:
    # that they agree says nothing
    points = means.points.assign(standard_error_internal=np.nan)
    return replace(means, points=points, internal_single=np.nan)
