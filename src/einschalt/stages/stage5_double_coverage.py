"""Stage 5: the values of all models and coverages become one value per point."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from einschalt.foundations import tables, typesetting
from einschalt.foundations.arguments import require_choice, require_kind
from einschalt.foundations.batches import segments
from einschalt.foundations.errors import TableError, raise_problems
from einschalt.foundations.frame_columns import values_of, with_columns
from einschalt.foundations.names import encode, encode_pairs
from einschalt.foundations.tables import Column, Schema, check_table
from einschalt.stages.results import Result
from einschalt.stages.value_weights import (
    WEIGHTED,
    WEIGHTINGS,
    require_covariances,
    value_weights,
)
from einschalt.theory.double_coverage import (
    internal_standard_error,
    mean_of_values,
    most_central_rows,
    position_in_extent,
)

COVERAGE_MEANS = ("all", "most_central")


def _may_be_missing(name, unit="metres", *, is_required=False):
    return Column(name, "number", unit, is_required, may_be_missing=True)


VALUES = Schema(
    "values",
    (
        tables.COVERAGE,
        Column("model_id", "id", is_required=False),
        tables.POINT_ID,
        _may_be_missing("easting", is_required=True),
        _may_be_missing("northing", is_required=True),
        _may_be_missing("height"),
        _may_be_missing("standard_error_paper"),
        _may_be_missing("position_u", "a fraction"),
        _may_be_missing("position_v", "a fraction"),
    ),
    key=("coverage", "model_id", "point_id"),
)


@dataclass(frozen=True, eq=False, repr=False)
class CoverageMean(Result):
    """One value per point.

    Attributes
    ----------
    points : DataFrame
        point_id, easting, northing [, height], standard_error_paper,
        standard_error_internal, n_models, n_coverages, spread_total [m].
    used : DataFrame
        The rows of the values that entered the means.
    row_numbers : ndarray of int, shape (n_used,)
        Their places among the given values.
    weights : ndarray, shape (n_used,) or (n_used, n_coordinates, n_coordinates)
        Numbers; or matrices whose sum is the unit matrix at every point, where they
        are rigorous.
    coverage_weights : ndarray, shape as ``weights``
        The same in the mean of the values of one coverage.
    internal_single : float
        TOTAL error of one coverage's value from the differences of the coverages [m];
        NaN without a second coverage.
    """

    points: pd.DataFrame
    used: pd.DataFrame
    row_numbers: np.ndarray
    weights: np.ndarray
    coverage_weights: np.ndarray
    internal_single: float

    @property
    def is_rigorous(self) -> bool:
        """Whether the means are those of least variance."""
        return self.weights.ndim > 1

    def summary(self) -> str:
        """Say how many points were averaged, and how far the coverages differ."""
        twice = int((self.points["n_coverages"] > 1).sum())
        return (
            f"{len(self.points)} points from {len(self.used)} values, "
            f"{twice} of them in several coverages\n"
            "one coverage, from the differences of the coverages (internal, total)  "
            f"{typesetting.length(self.internal_single)}"
        )


def average_coverages(
    values: pd.DataFrame,
    *,
    coverage_mean: Literal["all", "most_central"] = "all",
    weighting: Literal["plain", "weighted", "rigorous"] = "plain",
    covariances: Callable[[NDArray[np.int64]], NDArray[np.float64]] | None = None,
) -> CoverageMean:
    """Average the values that models and coverages give for each point.

    Parameters
    ----------
    values : DataFrame
        point_id, easting, northing [, height] [, coverage, model_id]
        [, standard_error_paper] [, position_u, position_v] [m]. Rows without
        coordinates are passed over.
    coverage_mean : {"all", "most_central"}
        Every value, or per coverage the one with the smallest max(abs u, abs v).
    weighting : {"plain", "weighted", "rigorous"}
        Arithmetic mean; weights 1 / standard_error_paper²; or the mean of least
        variance by the joint covariance of a point's values.
    covariances : callable, optional
        Needed for the latter: of an array of pairs of rows of ``values``, shape
        (n_pairs, 2), gives the covariances between their coordinates, shape (n_pairs,
        n_coordinates, n_coordinates) [m²].

    Returns
    -------
    CoverageMean
        ``standard_error_paper`` is that of the mean if the values were independent.
        ``standard_error_internal`` comes from the differences of the coverages, is
        one figure for the block divided by the root of the coverages, and sees only
        what the coverages do not share.

    Raises
    ------
    SettingsError
        An option is unknown, or covariances are missing.
    TableError
        A column is missing, a value is not what it should be, a model gives a point
        twice, or no row has coordinates.
    """
    require_choice("coverage_mean", coverage_mean, COVERAGE_MEANS)
    require_choice("weighting", weighting, WEIGHTINGS)
    require_covariances(weighting, covariances)
    expected = "a DataFrame with point_id, easting, northing"
    require_kind("values", values, pd.DataFrame, expected=expected)
    _check_options(values, coverage_mean, weighting)
    given = _usable_values(values.set_axis(range(len(values))), weighting)
    if coverage_mean == "most_central":
        given = given.iloc[_central(given)]
    points = encode(given["point_id"])
    sort = segments(points.codes, len(points))
    used = given.iloc[sort.order]
    coordinates = values_of(used, _coordinate_names(used))
    error = used["standard_error_paper"].to_numpy(dtype=float)
    row_numbers = used.index.to_numpy()
    weights = value_weights(weighting, error, row_numbers, sort.start, covariances)
    means = mean_of_values(coordinates, error, weights.in_mean, sort.start)
    by_coverage, start, own = _coverage_values(used, coordinates, weights, points, sort)
    n_coverages = np.diff(start)
    single = internal_standard_error(by_coverage, start)
    table = with_columns(
        pd.DataFrame({"point_id": points.names}),
        **dict(zip(_coordinate_names(used), means.mean.T, strict=True)),
        standard_error_paper=means.standard_error,
        standard_error_internal=single / np.sqrt(n_coverages),
        n_models=means.n_values,
        n_coverages=n_coverages,
        spread_total=means.spread_total,
    )
    return CoverageMean(
        table, used.reset_index(drop=True), row_numbers, weights.in_mean, own, single
    )


def with_positions(values, model_points) -> pd.DataFrame:
    """Add to each value the position of its point in the extent of the model.

    position_u, position_v: −½ to ½ from edge to edge of the box around the points of
    the model. ``values`` are row for row those of ``model_points``.
    """
    models = encode_pairs(values["coverage"], values["model_id"])
    sort = segments(models.codes, len(models))
    xy = values_of(model_points, ["x", "y"])
    position = np.empty_like(xy)
    position[sort.order] = position_in_extent(xy[sort.order], sort.start)
    return with_columns(values, position_u=position[:, 0], position_v=position[:, 1])


def _coverage_values(used, coordinates, weights, points, sort):
    """Means of coverages in plan sorted by point, their starts, the values' weights."""
    coverage = encode(used["coverage"])
    point = np.repeat(np.arange(len(points)), np.diff(sort.start))
    key = point * len(coverage) + coverage.codes
    distinct, group = np.unique(key, return_inverse=True)
    parts = segments(group, len(distinct))
    own, order = weights.in_groups(parts.order, parts.start), parts.order
    ones = np.ones(len(used))
    means = mean_of_values(coordinates[order], ones, own[order], parts.start)
    count = np.bincount(distinct // len(coverage), minlength=len(points))
    start = np.concatenate([[0], np.cumsum(count)])
    return means.mean[:, :2], start, own


def _central(values):
    point = encode(values["point_id"]).codes
    coverage = encode(values["coverage"]).codes
    position = values_of(values, ["position_u", "position_v"])
    return most_central_rows(point, coverage, position, _places_of_models(values))


def _places_of_models(values):
    """Place of each row's model among all names, as people count: 1/9 before 1/10."""
    if "model_id" not in values:
        return np.zeros(len(values), dtype=np.int64)
    codes, names = pd.factorize(values["model_id"].to_numpy(str))
    order = sorted(range(len(names)), key=lambda k: _counted(names[k]))
    place = np.empty(len(names), dtype=np.int64)
    place[order] = np.arange(len(names))
    return place[codes]


def _counted(name):
    """Parts of a name, numbers as numbers; the name itself where these are equal."""
    parts = re.split(r"([0-9]+)", name)
    parts[1::2] = [number.lstrip("0") for number in parts[1::2]]
    # of two numbers the one with more digits is the larger one
    return [(len(part) * (k % 2), part) for k, part in enumerate(parts)], name


def _coordinate_names(values):
    return ["easting", "northing", *(["height"] if "height" in values else [])]


def _usable_values(values, weighting):
    # without the models nobody can tell whether a value stands twice
    schema = VALUES if "model_id" in values else replace(VALUES, key=())
    checked = check_table(values, schema)
    raise_problems(checked.problems)
    names = _coordinate_names(values)
    is_given = np.isfinite(values_of(checked.frame, names)).all(axis=1)
    given = with_columns(values, **checked.frame)[is_given]
    if given.empty:
        raise TableError(
            "no row has coordinates",
            expected="easting and northing from at least one model",
            file="values",
        )
    if "standard_error_paper" not in given:
        given = given.assign(standard_error_paper=np.nan)
    error = given["standard_error_paper"].to_numpy(dtype=float)
    is_bad = ~(np.isfinite(error) & (error > 0.0))
    if weighting == WEIGHTED and is_bad.any():
        place = int(np.argmax(is_bad))
        raise TableError(
            f"standard_error_paper {error[place]}",
            expected="a positive error for every value that is weighted",
            remedy='Use weighting="plain", or leave the value out',
            point=given["point_id"].iloc[place],
        )
    return given


def _check_options(values, coverage_mean, weighting):
    needed = []
    if coverage_mean == "most_central":
        needed += ["position_u", "position_v"]
    if weighting == WEIGHTED:
        needed += ["standard_error_paper"]
    for name in needed:
        if name not in values:
            raise TableError(
                f"column '{name}' is missing",
                expected=", ".join(needed),
                remedy=f"Add a column '{name}'",
                file="values",
            )
