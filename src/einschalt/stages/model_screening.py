"""Gross errors kept from spoiling the transformations of a flight."""

from dataclasses import replace

import numpy as np
import pandas as pd

from einschalt.foundations.errors import SettingsError
from einschalt.stages.residual_table import (
    RESIDUAL_NAMES,
    SIGNIFICANCE,
    residual_table,
)
from einschalt.stages.stage3_model_transformation import transformation_of
from einschalt.stages.transformation_kinds import KINDS
from einschalt.theory.adjustment.norms import HUBER, TUKEY
from einschalt.theory.adjustment.robust import fit_robustly, snoop
from einschalt.theory.transformation.point_tests import (
    fitted_point_tests,
    other_point_tests,
    plan_sums,
)
from einschalt.theory.transformation.robust_plane import fit_plane_robustly

KEY = ["coverage", "model_id", "point_id"]
GROUND_NAMES = ("easting", "northing", "height")
TESTS = ["w", "p_value", "is_suspect"]
OUTLIERS = ("keep", "snoop", "huber", "tukey")


def screen_models(transformation, outliers="snoop", significance=SIGNIFICANCE):
    """Fit the models of a flight again so that gross errors do not spoil them.

    Parameters
    ----------
    transformation : ModelTransformation
    outliers : {"keep", "snoop", "huber", "tukey"}
        Keep all points and only name the suspects; take the worst out of each model
        and fit again until none is left; or give large residuals less weight.
    significance : float
        Probability with which a model without gross errors gets a suspect.

    Returns
    -------
    ModelTransformation
        ``residuals`` has all points, also those that were taken out: their
        ``leverage`` is 0, their residual is what the model misses them by, and they
        are suspects. ``observed`` and ``models`` tell of those that were fitted, with
        their final weights.

    Raises
    ------
    SettingsError
        An option is unknown, or the significance does not lie between 0 and 1.

    Notes
    -----
    Residuals of a robust fit have no distribution that is known in small models.
    Therefore ``w``, ``p_value`` and ``is_suspect`` are those of data snooping with
    ``huber`` and ``tukey`` as well.
    """
    if outliers not in OUTLIERS:
        raise SettingsError(
            f"outliers = {outliers!r} is unknown", expected=" or ".join(OUTLIERS)
        )
    if not 0.0 < significance < 1.0:
        raise SettingsError(
            f"significance = {significance!r}", expected="a number between 0 and 1"
        )
    return _SCREENS[outliers](transformation, significance)


def without_suspects(values, transformation):
    """Take the coordinates of suspects from their values, where others remain.

    Parameters
    ----------
    values : DataFrame
        Row for row as the model points that were transformed.
    transformation : ModelTransformation

    Returns
    -------
    DataFrame
        NaN in the coordinates of a suspect whose point has a value that is not one. A
        point that is suspect everywhere keeps all its values: then it is not they that
        are wrong.
    """
    residuals = transformation.residuals
    suspects = residuals.loc[residuals["is_suspect"], KEY]
    if suspects.empty:
        return values
    codes = pd.MultiIndex.from_frame(values[KEY])
    is_suspect = codes.isin(pd.MultiIndex.from_frame(suspects))
    is_good = values["easting"].notna() & ~is_suspect
    has_others = is_good.groupby(values["point_id"].to_numpy()).transform("any")
    names = [name for name in GROUND_NAMES if name in values]
    screened = values.copy()
    screened.loc[is_suspect & has_others.to_numpy(), names] = np.nan
    return screened


def _only_name(transformation, significance):
    observed = transformation.observed
    residuals = residual_table(transformation.fit, observed, significance)
    return _rebuilt(transformation, transformation.fit, observed, residuals)


def _rebuilt(transformation, fit, observed, residuals):
    return transformation_of(
        fit,
        observed,
        transformation.kind,
        residuals,
        has_coverages=transformation.has_coverages,
    )


def _take_out(transformation, significance):
    """Data snooping."""
    snooped = _Snooped(transformation, significance)
    kept = snooped.table[~snooped.is_out]
    screened = _rebuilt(transformation, snooped.fit, snooped.kept, kept)
    is_usable = screened.models["is_usable"].to_numpy()[snooped.points.model]
    residuals = snooped.table[is_usable].reset_index(drop=True)
    return replace(screened, residuals=residuals)


class _Snooped:
    """Gross errors that data snooping finds.

    Attributes
    ----------
    points : CommonPoints
        All of them.
    is_out : ndarray of bool, shape (n_points,)
    kept : Observations
        The others.
    fit : PlaneFit or SpatialFit
        Of these.
    table : DataFrame
        Residuals and tests of all points.
    """

    def __init__(self, transformation, significance):
        observed, fit_of = transformation.observed, _fit_of(transformation.kind)

        def tests_of(points):
            return fitted_point_tests(fit_of(points), points)

        self.points = observed.points
        self.is_out = snoop(self.points, tests_of, significance)
        self.kept, self.fit = observed, transformation.fit
        if self.is_out.any():
            self.kept = _without(observed, self.is_out)
            self.fit = fit_of(self.kept.points)
        self.table = residual_table(self.fit, self.kept, significance)
        if self.is_out.any():
            out = _residuals_of_others(self.fit, self.kept, observed, self.is_out)
            place = np.argsort(
                np.concatenate(
                    [np.flatnonzero(~self.is_out), np.flatnonzero(self.is_out)]
                )
            )
            both = pd.concat([self.table, out])
            self.table = both.iloc[place].reset_index(drop=True)


def _fit_of(kind):
    def fit(points):
        return KINDS[kind].fit(
            points.source, points.target, points.weights, points.start
        )

    return fit


def _without(observed, is_out):
    """Observations without some of their rows."""
    points = observed.points.chosen(~is_out)
    return replace(
        observed,
        source=points.source,
        target=points.target,
        weights=points.weights,
        start=points.start,
        rows=observed.rows[~is_out],
        row_numbers=observed.row_numbers[~is_out],
        ground_rows=observed.ground_rows[~is_out],
    )


def _residuals_of_others(fit, kept, observed, is_out):
    """Rows of the residual table for points that were taken out."""
    out = observed.points.chosen(is_out)
    sums = plan_sums(fit, kept.weights, kept.start)
    residuals, tests = other_point_tests(fit, sums, out.model, out)
    table = observed.rows[is_out].reset_index(drop=True)
    table[list(RESIDUAL_NAMES[: residuals.shape[1]])] = residuals
    return table.assign(
        leverage=0.0,
        redundancy_number=1.0,
        w=tests.w,
        p_value=tests.p_value,
        is_suspect=True,
    )


def _weigh_less(norms, start_norms=None):
    """Screening by a robust norm, begun with another one."""

    def screen(transformation, significance):
        observed, fit_of = transformation.observed, _fit_of(transformation.kind)
        points, n_axes = observed.points, observed.source.shape[1]
        fit_all = fit_plane_robustly if n_axes == 2 else fit_robustly
        begun = None
        if start_norms is not None:
            begun = fit_all(points, fit_of, start_norms[n_axes]).weights
        robust = fit_all(points, fit_of, norms[n_axes], begun)
        weighted = replace(observed, weights=robust.weights)
        table = residual_table(robust.fit, weighted, significance)
        snooped = _Snooped(transformation, significance).table
        residuals = table.assign(**{name: snooped[name] for name in TESTS})
        return _rebuilt(transformation, robust.fit, weighted, residuals)

    return screen


_SCREENS = {
    "keep": _only_name,
    "snoop": _take_out,
    "huber": _weigh_less(HUBER),
    "tukey": _weigh_less(TUKEY, HUBER),
}
