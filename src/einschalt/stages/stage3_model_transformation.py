"""Stage 3: every model onto all its points with ground coordinates."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from einschalt.foundations import tables, typesetting
from einschalt.foundations.arguments import require_choice
from einschalt.foundations.errors import TableError, raise_problems
from einschalt.foundations.frame_columns import (
    columns_of,
    values_of,
    with_columns,
)
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.names import encode_pairs, pair_up
from einschalt.stages.identical_points import ROW_NAMES, Observations
from einschalt.stages.residual_table import of_usable_models, residual_table
from einschalt.stages.results import (
    FAILURE_COLUMNS,
    Estimates,
    ModelResult,
    coverages_of_models,
    failures_table,
    row_of_model,
)
from einschalt.stages.transformation_kinds import (
    TRANSFORMATION_KINDS,
    ground_schema,
    model_schema,
    placed_ground_schema,
    reasons_for,
    remedies_for,
)
from einschalt.theory.adjustment.least_squares import (
    pooled_standard_error,
    standard_error_of_unit_weight,
    total_from_coordinate,
)
from einschalt.theory.adjustment.reliability import (
    external_reliability,
    minimal_detectable_bias,
    redundancy_numbers,
)
from einschalt.theory.transformation.point_tests import plan_sums

STAGE = "stage3_model_transformation"


@dataclass(frozen=True, eq=False, repr=False)
class ModelTransformation(ModelResult):
    """Transformations of all models of a flight.

    Attributes
    ----------
    kind : str
    fit : PlaneFit or SpatialFit
        Arrays by model, in the order of ``models``.
    models : DataFrame
        coverage, model_id, transformation, n_points, redundancy, m_0 (total) [m],
        s_0 (per coordinate) [m], is_usable, reason.
    parameters : DataFrame
        Index model_id; NaN where a model is not usable.
    residuals : DataFrame
        coverage, model_id, point_id, residual_easting, residual_northing
        [, residual_height] [m] (transformed minus given), leverage, redundancy_number
        (means of easting and northing), w (length of the standardized residual vector,
        √(w_E² + w_N²)), p_value (joint test of both coordinates, of spatial
        models the less probable of plan and height, after Bonferroni; both NaN where
        the redundancy is 2 or less), is_suspect (after Holm over the points of the
        model, with the significance 0.001).
    failures : DataFrame
        coverage, model_id, stage, reason, remedy.
    observed : Observations
        The identical points that were fitted.
    """

    kind: str
    fit: object
    models: pd.DataFrame
    parameters: pd.DataFrame
    residuals: pd.DataFrame
    failures: pd.DataFrame
    observed: Observations
    has_coverages: bool

    @property
    def m_0(self) -> float:
        """TOTAL standard error of unit weight of all models together [m]."""
        # a mirrored model has residuals as large as itself
        row = self.models["is_usable"].to_numpy()
        squares, redundancy = self.fit.sum_of_squares[row], self.fit.redundancy[row]
        return float(total_from_coordinate(pooled_standard_error(squares, redundancy)))

    @property
    def m_0_plan(self) -> float:
        """The same from easting and northing alone, without heights [m]."""
        return float(total_from_coordinate(self._pooled_s_0))

    @property
    def _pooled_s_0(self):
        row = self.models["is_usable"].to_numpy()
        plan = plan_sums(self.fit, self.observed.weights, self.observed.start)
        return pooled_standard_error(plan.sum_of_squares[row], plan.redundancy[row])

    @property
    def is_usable(self) -> bool:
        """Whether any model could be transformed."""
        return bool(self.models["is_usable"].any())

    @cached_property
    def estimates(self) -> Estimates:
        """Parameters of the transformations: Estimates."""
        return Estimates(
            names=self.fit.parameter_names,
            cofactors=TRANSFORMATION_KINDS[self.kind].cofactors(self.fit),
            unit_error=self.fit.s_0,
            is_usable=self.models["is_usable"].to_numpy(),
        )

    @cached_property
    def reliability(self) -> pd.DataFrame:
        """How large an error of each fitted point must be to be found, a DataFrame.

        coverage, model_id, point_id, redundancy_number, minimal_detectable_bias,
        external_reliability (what of it would stay in the point's own fitted value)
        [m], per coordinate, with the m_0 of all models together.
        """
        r = redundancy_numbers(self.fit.leverage[:, :2].mean(axis=1))
        sigma = self._pooled_s_0 / np.sqrt(self.observed.weights)
        bias = minimal_detectable_bias(sigma, r)
        table = self.observed.rows.reset_index(drop=True).assign(
            redundancy_number=r,
            minimal_detectable_bias=bias,
            external_reliability=external_reliability(bias, r),
        )
        return of_usable_models(table, self.models, self.observed)

    def transform(self, model_points: pd.DataFrame) -> pd.DataFrame:
        """Transform points, whether they were fitted or not.

        Parameters
        ----------
        model_points : DataFrame
            [coverage,] model_id, point_id, x, y [, z]. The coverage is needed where
            two coverages have a model of that name.

        Returns
        -------
        DataFrame
            [coverage,] model_id, point_id, easting, northing [, height],
            m_t (TOTAL, in plan) [m]; the rows and the index of ``model_points``. NaN
            in the rows of a model that is not usable; m_t is NaN where the model has
            no redundancy.

        Raises
        ------
        TableError
            A model was not among those that were fitted, or was fitted in several
            coverages of which none is named.
        """
        points = self._placed(_checked_points(model_points, self.kind), model_points)
        table = self._transformed(points, self.fit.s_0)
        return table if self.has_coverages else table.drop(columns="coverage")

    def values(
        self, model_points: pd.DataFrame, *, least_redundancy: int = 1
    ) -> pd.DataFrame:
        """Coordinates of every point from every model that holds it.

        As :meth:`transform`, but always with ``coverage``, with an m_t for models
        without redundancy as well, and with the m_0 of the plan alone where heights are
        transformed. Models with less than ``least_redundancy`` take the m_0 of all
        models together: their own says little.
        """
        points = self._placed(_checked_points(model_points, self.kind), model_points)
        return self._transformed(points, self._plan_s_0(least_redundancy))

    @cached_property
    def own_values(self) -> pd.DataFrame:
        """The :meth:`values` of all points that were given, fitted or not."""
        return self._transformed(self.observed.given, self._plan_s_0())

    def _plan_s_0(self, least_redundancy=1):
        is_own = self.fit.redundancy >= least_redundancy
        plan = plan_sums(self.fit, self.observed.weights, self.observed.start)
        own = standard_error_of_unit_weight(plan.sum_of_squares, plan.redundancy)
        return np.where(is_own, own, self._pooled_s_0)

    def _transformed(self, table, s_0):
        kind = TRANSFORMATION_KINDS[self.kind]
        place = self._places(table)
        checked = table.frame
        xyz = values_of(checked, kind.source)
        table = columns_of(checked, ROW_NAMES)
        is_usable = self.models["is_usable"].to_numpy()[place]
        ground, m_t = self._forward(place, xyz, s_0)
        ground = np.where(is_usable[:, None], ground, np.nan)
        return with_columns(
            table,
            **dict(zip(kind.target, ground.T, strict=True)),
            m_t=np.where(is_usable, m_t, np.nan),
            **self._ellipses(place, xyz),
        )

    def _ellipses(self, _place, _xyz):
        """Further columns of transformed points, where the result has them."""
        return {}

    def _forward(self, place, xyz, s_0):
        """Ground coordinates of points and their m_t [m], each by its model."""
        cofactors = self.fit.point_cofactors(place, xyz)
        plan = cofactors[:, 0, 0] + cofactors[:, 1, 1]
        return self.fit.apply(place, xyz), s_0[place] * np.sqrt(plan)

    def _backward(self, place, ground):
        """Model coordinates of points on the ground, each by its model."""
        return self.fit.invert(place, ground)

    def inverse(self, ground_points: pd.DataFrame) -> pd.DataFrame:
        """Model coordinates of ground points.

        Parameters
        ----------
        ground_points : DataFrame
            [coverage,] model_id, point_id, easting, northing [, height]; the coverage
            as for :meth:`transform`.

        Returns
        -------
        DataFrame
            [coverage,] model_id, point_id, x, y [, z]; NaN in the rows of a model that
            is not usable, or that has no inverse: affine with ground points on a line
            puts the whole model there.

        Raises
        ------
        TableError
            A model was not among those that were fitted, or was fitted in several
            coverages of which none is named.
        """
        kind = TRANSFORMATION_KINDS[self.kind]
        given = _checked(ground_points, placed_ground_schema(kind), "ground_points")
        given = self._placed(given, ground_points)
        place = self._places(given)
        checked = given.frame
        table = columns_of(checked, ROW_NAMES)
        is_usable = self.models["is_usable"].to_numpy()[place]
        xyz = self._backward(place, values_of(checked, kind.target))
        table[list(kind.source)] = np.where(is_usable[:, None], xyz, np.nan)
        return table if self.has_coverages else table.drop(columns="coverage")

    def proj_pipeline(self, model_id: str, coverage: str | None = None) -> str:
        """Return the transformation of a model as a PROJ string.

        Parameters
        ----------
        model_id : str
        coverage : str, optional

        Returns
        -------
        str
            A ``+proj=affine`` step, exact for every kind.
        """
        row = row_of_model(self.models, model_id, coverage)
        matrix, shift = self.fit.homogeneous(row)
        if not self.models["is_usable"].iloc[row]:
            raise TableError(
                "it has no transformation",
                expected=TRANSFORMATION_KINDS[self.kind].needs,
                remedy="Its row in failures says why",
                model=model_id,
            )
        # imported when it is asked for: a fit does not wait for pyproj
        from einschalt.foundations.published_systems import affine_step  # noqa: PLC0415

        return f"+proj=pipeline +step {affine_step(matrix, shift)}"

    def to_statsmodels(self, model_id: str, coverage: str | None = None) -> Any:
        """Results object of statsmodels for one model: diagnostics, tests, summary.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
            Needed where two coverages have a model of that name.

        Returns
        -------
        RegressionResultsWrapper
            Of WLS, with an equation for each coordinate of each point (``resid`` is
            given less transformed). Coordinates are reduced to the weighted centroids
            ``centroid_model``, ``centroid_ground``, and shifts are those of the
            centroid; ``params_at_origin`` and ``cov_params_at_origin`` are those of
            :attr:`parameters` and :meth:`covariance`. Rigid and helmert_3d are
            linearised at their solution. ``get_influence()`` is of the weighted
            equations.

        Raises
        ------
        TableError
            There is no such model, or there is one in each of several coverages.
        GeometryError
            The model could not be fitted.
        """
        # statsmodels takes longer to import than most blocks to be computed
        from einschalt.stages.regression_results import (  # noqa: PLC0415
            regression_of_model,
        )

        return regression_of_model(self, model_id, coverage)

    def _placed(self, checked, given):
        """Points in the coverages in which their models were fitted.

        Where a table names none, the check took all of it for the first.
        """
        if "coverage" in given.columns or not self.has_coverages:
            return checked
        frame = checked.frame
        coverage = coverages_of_models(self.models, frame["model_id"])
        return replace(checked, frame=frame.assign(coverage=pd.array(coverage, "str")))

    def _places(self, checked):
        known = encode_pairs(self.models["coverage"], self.models["model_id"])
        asked = pair_up(checked.coded["coverage"], checked.coded["model_id"])
        place = known.locate(asked)
        if (place < 0).any():
            model_id = asked.second[int(np.argmax(place < 0))]
            raise TableError(
                "the model was not fitted",
                expected="a model of the points that were transformed",
                remedy="Take its rows out",
                model=model_id,
            )
        return place[asked.codes]

    def summary(self) -> str:
        """Say how many models were transformed, with which m_0, and what failed."""
        usable = self.models[self.models["is_usable"]]
        done = translated(
            "{kind} transformation of {n} of {n_all} models, {n_points} points, "
            "redundancy {redundancy}",
            kind=self.kind,
            n=len(usable),
            n_all=len(self.models),
            n_points=int(usable["n_points"].sum()),
            redundancy=int(usable["redundancy"].sum()),
        )
        message = mark("m_0 is not known: no model has redundancy")
        if usable["redundancy"].any():
            message = mark("m_0 (total, all models together)  {m_0} m")
        lines = [done, translated(message, m_0=figure(self.m_0, ".4f"))]
        if usable["m_0"].count() > 1:
            message = mark("m_0 of single models  {low} to {high} m, median {mid} m")
            found = (
                figure(m_0, ".4f") for m_0 in usable["m_0"].quantile([0.0, 0.5, 1.0])
            )
            names = ("low", "mid", "high")
            lines.append(translated(message, **dict(zip(names, found, strict=True))))
        return "\n".join([*lines, *self._failed()])

    def _failed(self):
        """The first models that failed, and why."""
        if not len(self.failures):
            return []
        shown = self.failures[["model_id", "reason", "remedy"]].head(5)
        rows = [
            [name, retold(str(reason)), retold(str(remedy))]
            for name, reason, remedy in shown.itertuples(index=False)
        ]
        failed = translated("{n:model|models} failed:", n=len(self.failures))
        return ["", failed, typesetting.table(rows)]


def transform_models(
    model_points: pd.DataFrame,
    ground_points: pd.DataFrame,
    kind: Literal["affine", "helmert", "rigid", "helmert_3d"] = "affine",
    weights: pd.Series | NDArray[np.float64] | None = None,
) -> ModelTransformation:
    """Fit every model onto all of its points that have ground coordinates.

    Parameters
    ----------
    model_points : DataFrame
        [coverage,] model_id, point_id, x, y [, z] [, weight].
    ground_points : DataFrame
        point_id, easting, northing [, height] [, weight] [m]. A point without height
        takes no part where heights are transformed.
    kind : {"affine", "helmert", "rigid", "helmert_3d"}
    weights : Series or ndarray, optional
        Series by point_id, or one weight for each row of ``model_points`` (array, or
        Series with the same index). Multiplies
        the columns ``weight``, where they are given.

    Returns
    -------
    ModelTransformation
        Models with too few points, points in a line, or ground points in one place,
        are rows of ``failures``.

    Raises
    ------
    TableError
        A column is missing or a value is not what it should be; a weight is not
        positive, or does not belong to one row or point.
    SettingsError
        ``kind`` is unknown.

    Examples
    --------
    >>> import pandas as pd
    >>> model = pd.DataFrame({"model_id": "1", "point_id": ["a", "b", "c"],
    ...                       "x": [0.0, 1.0, 0.0], "y": [0.0, 0.0, 1.0]})
    >>> ground = pd.DataFrame({"point_id": ["a", "b", "c"],
    ...                        "easting": [5.0, 7.0, 5.0],
    ...                        "northing": [5.0, 5.0, 7.0]})
    >>> fit = transform_models(model, ground, kind="helmert")
    >>> fit.parameters.loc["1"].round(9).tolist()
    [2.0, 0.0, 5.0, 5.0]
    """
    require_choice("kind", kind, TRANSFORMATION_KINDS)
    needed = TRANSFORMATION_KINDS[kind]
    checked = _checked_points(model_points, kind)
    ground = _checked(ground_points, ground_schema(needed), "ground_points")
    observed = Observations.of(checked, ground, needed, weights)
    fit = needed.fit(observed.source, observed.target, observed.weights, observed.start)
    table = residual_table(fit, observed)
    has_coverages = "coverage" in model_points.columns
    return transformation_of(fit, observed, kind, table, has_coverages=has_coverages)


def transformation_of(fit, observed, kind, residuals, *, has_coverages):
    """Put a fit into the tables of a result.

    The rows of ``residuals`` are those of ``observed``, the points that were fitted.
    """
    models = _models_table(fit, kind, observed)
    return ModelTransformation(
        kind=kind,
        fit=fit,
        models=models,
        parameters=_parameters_table(fit, models),
        residuals=of_usable_models(residuals, models, observed),
        failures=_failures(models, remedies_for(fit)),
        observed=observed,
        has_coverages=has_coverages,
    )


def _checked_points(model_points, kind):
    schema = model_schema(TRANSFORMATION_KINDS[kind])
    return _checked(model_points, schema, "model_points")


def _checked(frame, schema, source):
    checked = tables.check_table(frame, schema, source=source)
    raise_problems(checked.problems)
    return checked


def _models_table(fit, kind, observed):
    is_usable, models = fit.status == 0, observed.models
    return pd.DataFrame(
        {
            "coverage": models.first,
            "model_id": models.second,
            "transformation": kind,
            "n_points": fit.n_points,
            "redundancy": fit.redundancy,
            "m_0": fit.m_0,
            "s_0": fit.s_0,
            "is_usable": is_usable & ~fit.is_mirrored,
            "reason": reasons_for(fit, TRANSFORMATION_KINDS[kind]),
        }
    )


def _failures(models, remedies):
    is_failed = ~models["is_usable"].to_numpy()
    if not is_failed.any():
        return failures_table(())
    failed = models[is_failed].assign(remedy=remedies[is_failed], stage=STAGE)
    return failures_table(columns_of(failed, FAILURE_COLUMNS).itertuples(index=False))


def _parameters_table(fit, models):
    values = np.where(models["is_usable"].to_numpy()[:, None], fit.parameters, np.nan)
    index = pd.Index(models["model_id"], name="model_id")
    return pd.DataFrame(values, index=index, columns=list(fit.parameter_names))
