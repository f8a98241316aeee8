"""Stage 1: approximate coordinates from the high flight."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.arguments import require_kind
from einschalt.foundations.errors import GeometryError, name_some, raise_problems
from einschalt.foundations.frame_columns import columns_of
from einschalt.foundations.tables import CONTROL_POINTS, check_table
from einschalt.stages.model_screening import GROUND_NAMES
from einschalt.stages.results import Result
from einschalt.stages.stage3_model_transformation import (
    ModelTransformation,
    transform_models,
)
from einschalt.stages.stage5_double_coverage import (
    CoverageMean,
    average_coverages,
    with_positions,
)

STAGE = "stage1_approximate_coordinates"
OTHERWISE = 'Or adjust all models together: method = "simultaneous" needs less control'
# From five control points m_0 is uncertain by a third: as a weight it would do harm
# (5.11 cm instead of 4.71 on simulated Neukirchen).
REDUNDANCY_OF_OWN_M_0 = 30
PAPER, INTERNAL = "standard_error_paper", "standard_error_internal"


@dataclass(frozen=True, eq=False, repr=False)
class ApproximateCoordinates(Result):
    """Approximate coordinates of all points of the high flight.

    Attributes
    ----------
    points : DataFrame
        point_id, easting, northing [, height], n_models, n_coverages, spread_total
        [m].
    transformation : ModelTransformation
        Of the models of the high flight onto the control points.
    means : CoverageMean
        The means behind ``points``.
    """

    points: pd.DataFrame
    transformation: ModelTransformation
    means: CoverageMean

    @property
    def internal_single(self) -> float:
        """TOTAL error of one coverage's value from the differences [m]."""
        return self.means.internal_single

    @property
    def failures(self) -> pd.DataFrame:
        """Models that could not be transformed."""
        return self.transformation.failures.assign(stage=STAGE)

    def summary(self) -> str:
        """Say how many points got coordinates, from which models."""
        return (
            f"approximate coordinates of {len(self.points)} points\n"
            f"{self.transformation.summary()}\n"
            "one coverage, from the differences of the coverages (internal, total)  "
            f"{typesetting.length(self.internal_single)}"
        )


def approximate_coordinates(
    model_points: pd.DataFrame,
    control_points: pd.DataFrame,
    kind: Literal["affine", "helmert", "rigid", "helmert_3d"] = "affine",
    *,
    coverage_mean: Literal["all", "most_central"] = "all",
    weighting: Literal["plain", "weighted"] = "plain",
) -> ApproximateCoordinates:
    """Transform every high-flight model onto its control points and average.

    Parameters
    ----------
    model_points : DataFrame
        coverage, model_id, point_id, x, y [, z].
    control_points : DataFrame
        point_id, easting, northing [, height] [, role] [m]. Points with the role
        ``check`` take no part.
    kind : {"affine", "helmert", "rigid", "helmert_3d"}
    coverage_mean : {"all", "most_central"}
    weighting : {"plain", "weighted"}
        Weights 1 / m_t² where weighted; there a model with a redundancy below 30 has
        the m_0 of all models together, since its own says little (in ``transform`` of
        ``transformation`` it has its own).

    Raises
    ------
    GeometryError
        Not one model could be transformed.
    TableError
        A column is missing or a value is not what it should be.
    """
    transformation = transform_high_flight(model_points, control_points, kind)
    return average_high_flight(
        transformation, model_points, coverage_mean=coverage_mean, weighting=weighting
    )


def transform_high_flight(model_points, control_points, kind) -> ModelTransformation:
    """Transform every high-flight model onto its control points.

    Arguments and errors as of :func:`approximate_coordinates`.
    """
    expected = "a DataFrame with point_id, easting, northing"
    require_kind("control_points", control_points, pd.DataFrame, expected=expected)
    if "role" in control_points.columns:
        checked = check_table(control_points, CONTROL_POINTS.only("point_id", "role"))
        raise_problems(checked.problems)
        control_points = control_points[(checked.frame["role"] != "check").to_numpy()]
    return transform_models(model_points, control_points, kind)


def average_high_flight(
    transformation,
    model_points,
    *,
    coverage_mean="all",
    weighting="plain",
    is_gross=None,
    covariances=None,
) -> ApproximateCoordinates:
    """Average the values that the models of the high flight give for each point.

    Measurements that ``is_gross`` marks, (n_model_points,), give no coordinates; a
    point that has no others gets none. Options, ``covariances`` and errors as of
    :func:`average_coverages`.
    """
    require_usable(transformation, "high flight", STAGE, OTHERWISE)
    values = transformation.values(model_points, least_redundancy=REDUNDANCY_OF_OWN_M_0)
    values = with_positions(values, model_points)
    if is_gross is not None and np.any(is_gross):
        values.loc[is_gross, [name for name in GROUND_NAMES if name in values]] = np.nan
    names = [PAPER if name == "m_t" else name for name in values.columns]
    values = values.set_axis(names, axis="columns")
    means = average_coverages(
        values,
        coverage_mean=coverage_mean,
        weighting=weighting,
        covariances=covariances,
    )
    kept = [name for name in means.points.columns if name not in (PAPER, INTERNAL)]
    points = columns_of(means.points, kept)
    return ApproximateCoordinates(points, transformation, means)


def require_usable(transformation, flight, stage, otherwise=""):
    """Refuse to go on where not one model of a flight could be transformed.

    ``otherwise`` follows the remedy of the first model.
    """
    if transformation.is_usable:
        return
    failures = transformation.failures
    raise GeometryError(
        f"no model of the {flight} could be transformed: {failures['reason'].iloc[0]}",
        expected="at least one usable model",
        remedy=". ".join(filter(None, [failures["remedy"].iloc[0], otherwise])),
        model=name_some(failures["model_id"]),
        stage=stage,
    )
