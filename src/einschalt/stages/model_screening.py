"""Gross errors kept from spoiling the transformations of a flight."""

from dataclasses import replace

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.batches import segment_sum
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.key_columns import rows_among
from einschalt.stages.correlated_residuals import (
    NumberedPoints,
    tested_again,
    tested_beside,
)
from einschalt.stages.residual_table import RESIDUAL_NAMES, residual_table
from einschalt.stages.results import OUTLIERS
from einschalt.stages.stage3_model_transformation import transformation_of
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.theory.adjustment.norms import HUBER, TUKEY
from einschalt.theory.adjustment.robust import fit_robustly, snoop
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.transformation.point_tests import fitted_tests, other_tests
from einschalt.theory.transformation.robust_plane import fit_plane_robustly

KEY = ["coverage", "model_id", "point_id"]
GROUND_NAMES = ("easting", "northing", "height")
TESTS = ["w", "p_value", "is_suspect"]


def screen_models(
    transformation,
    outliers="snoop",
    significance=GROSS_ERROR_SIGNIFICANCE,
    precision=None,
    *,
    covariances=None,
    is_gross=None,
):
    """Fit the models of a flight again so that gross errors do not spoil them.

    ``outliers`` "keep" only names the suspects; "snoop" takes the worst out of each
    model and fits again until none is left; "huber" and "tukey" give large residuals
    less weight. ``significance`` is the probability with which a model without gross
    errors gets a suspect. ``precision`` has for each row of the model points its weight
    in the tests, in proportion to 1 / σ² of what it contributes to a residual; the fit
    keeps its own weights. Models of which a point stands out are tested with all
    ``covariances`` of their points, a function of pairs of rows as in
    :func:`~einschalt.stages.correlated_residuals.tested_again`. Known gross errors,
    ``is_gross`` (n_model_points,), are taken out first, unless too few points would be
    left for their model.

    ``residuals`` of the result has all points: those that were taken out have leverage
    0, the residual by which the model misses them, and are suspects. ``observed`` and
    ``models`` tell of those that were fitted, with their final weights.

    Notes
    -----
    Residuals of a robust fit have no distribution that is known in small models.
    Therefore ``w``, ``p_value`` and ``is_suspect`` are those of data snooping with
    ``huber`` and ``tukey`` as well.

    The tests are exact where the errors of a model's points are independent and their
    sizes in the proportion of ``precision``. Points of unequal precision that are taken
    for equal are suspects too often: the worse ones stand out. What points share beyond
    that needs their covariances.
    """
    require_choice("outliers", outliers, OUTLIERS)
    if not 0.0 < significance < 1.0:
        raise SettingsError(
            f"significance = {significance!r}", expected="a number between 0 and 1"
        )
    screen = _SCREENS[outliers]
    tested = _Tested(transformation, significance, precision, covariances)
    is_out = _that_can_be_spared(transformation, is_gross)
    if not is_out.any():
        return screen(tested)
    return _with_rows_of(screen(tested.without(is_out)), tested, is_out)


def suspect_rows(values, transformation):
    """Tell which values are those of suspects.

    ``values`` are row for row the model points that were transformed.
    """
    residuals = transformation.residuals
    if not residuals["is_suspect"].any():
        return np.zeros(len(values), dtype=bool)
    return rows_among(values, residuals.loc[residuals["is_suspect"], KEY], KEY)


def without_gross_errors(values, is_gross) -> pd.DataFrame:
    """Take the coordinates of gross errors from their values, where others remain.

    NaN in their coordinates where the point has another value. A point all of whose
    values are gross errors keeps them: then it is not they that are wrong.
    """
    if not is_gross.any():
        return values
    is_good = values["easting"].notna() & ~is_gross
    has_others = is_good.groupby(values["point_id"].to_numpy()).transform("any")
    names = [name for name in GROUND_NAMES if name in values]
    screened = values.copy()
    screened.loc[is_gross & has_others.to_numpy(), names] = np.nan
    return screened


class _Tested:
    """A transformation, and the fit in which its points are tested."""

    def __init__(self, transformation, significance, precision, covariances):
        self.transformation, self.significance = transformation, significance
        self.covariances = covariances
        self.observed = transformation.observed
        self.fit_of = _fit_of(transformation.kind)
        self.precision = None
        if precision is not None:
            self.precision = np.asarray(precision)[self.observed.row_numbers]

    @property
    def points(self):
        """All points with the weights of the tests."""
        observed = self.observed
        weights = observed.weights
        if self.precision is not None:
            weights = weights * self.precision
        return NumberedPoints.of(observed, weights, observed.row_numbers)

    def tests_of(self, points):
        """Tests of points in their own fit."""
        fit = self.fit_of(points)
        tests = fitted_tests(fit, points)
        if self.covariances is None:
            return tests
        return tested_again(tests, fit, points, self.covariances, self.significance)

    def tests_beside(self, in_tests, out):
        """Tests of points that were taken out, by those that were not."""
        fit = self.fit_of(in_tests)
        tests = other_tests(fit, in_tests, out.model, out)
        if self.covariances is None:
            return tests
        return tested_beside(tests, fit, in_tests, out, self.covariances)

    def table(self, fit, observed, tested):
        """Residuals of a fit, with the tests of the same points in their own fit."""
        in_tests = None
        if self.precision is not None or self.covariances is not None:
            in_tests = self.tests_of(tested)
        return residual_table(fit, observed, self.significance, in_tests)

    def without(self, is_out):
        """The same with fewer points, fitted again."""
        kept = _without(self.observed, is_out)
        fitted = replace(
            self.transformation, fit=self.fit_of(kept.points), observed=kept
        )
        fewer = _Tested(fitted, self.significance, None, self.covariances)
        if self.precision is not None:
            fewer.precision = self.precision[~is_out]
        return fewer


def _that_can_be_spared(transformation, is_gross):
    """Fitted points that are gross errors and leave enough points to their model."""
    observed = transformation.observed
    if is_gross is None:
        return np.zeros(len(observed.row_numbers), dtype=bool)
    is_out = is_gross[observed.row_numbers]
    n_left = segment_sum((~is_out).astype(np.int64), observed.start)
    is_enough = n_left >= TRANSFORMATION_KINDS[transformation.kind].least_points
    return is_out & np.repeat(is_enough, np.diff(observed.start))


def _only_name(tested):
    transformation, observed = tested.transformation, tested.observed
    residuals = tested.table(transformation.fit, observed, tested.points)
    return _rebuilt(transformation, transformation.fit, observed, residuals)


def _rebuilt(transformation, fit, observed, residuals):
    kind, has_coverages = transformation.kind, transformation.has_coverages
    return transformation_of(
        fit, observed, kind, residuals, has_coverages=has_coverages
    )


def _take_out(tested):
    """Data snooping."""
    snooped, transformation = _Snooped(tested), tested.transformation
    kept = snooped.table[~snooped.is_out]
    screened = _rebuilt(transformation, snooped.fit, snooped.kept, kept)
    is_usable = screened.models["is_usable"].to_numpy()[snooped.points.model]
    residuals = snooped.table[is_usable].reset_index(drop=True)
    return replace(screened, residuals=residuals)


class _Snooped:
    """Gross errors that data snooping finds.

    ``points`` are all points with the weights of the tests, ``is_out`` the gross errors
    among them, ``kept`` the others; ``fit`` is of these, ``table`` has residuals and
    tests of all.
    """

    def __init__(self, tested):
        self.points = tested.points
        self.is_out = snoop(self.points, tested.tests_of, tested.significance)
        self.kept, self.fit = tested.observed, tested.transformation.fit
        if self.is_out.any():
            self.kept = _without(tested.observed, self.is_out)
            self.fit = tested.fit_of(self.kept.points)
        in_tests = self.points.chosen(~self.is_out)
        self.table = tested.table(self.fit, self.kept, in_tests)
        if self.is_out.any():
            out = _rows_of_others(tested, self.fit, in_tests, self.is_out)
            self.table = _in_order(self.table, out, ~self.is_out, self.is_out)


def _with_rows_of(screened, tested, is_out):
    """A flight that was screened without known gross errors, with their residuals."""
    is_usable = screened.models["is_usable"].to_numpy()[tested.points.model]
    is_kept, is_out = ~is_out & is_usable, is_out & is_usable
    is_good = is_kept.copy()
    is_good[is_kept] = ~screened.residuals["is_suspect"].to_numpy()
    in_tests = tested.points.chosen(is_good)
    out = _rows_of_others(tested, screened.fit, in_tests, is_out)
    residuals = _in_order(screened.residuals, out, is_kept, is_out)
    return replace(screened, residuals=residuals)


def _rows_of_others(tested, fit, in_tests, is_out):
    """Rows of the residual table for points that were taken out."""
    out = tested.points.chosen(is_out)
    tests = tested.tests_beside(in_tests, out)
    residuals = fit.apply(out.model, out.source) - out.target
    table = tested.observed.rows[is_out].reset_index(drop=True)
    table[list(RESIDUAL_NAMES[: residuals.shape[1]])] = residuals
    return table.assign(
        leverage=0.0,
        redundancy_number=1.0,
        w=tests.w,
        p_value=tests.p_value,
        is_suspect=True,
    )


def _in_order(kept, out, is_kept, is_out):
    """Two parts of a table in the order of the rows that they are."""
    rows = np.concatenate([np.flatnonzero(is_kept), np.flatnonzero(is_out)])
    return pd.concat([kept, out]).iloc[np.argsort(rows)].reset_index(drop=True)


def _fit_of(kind):
    def fit(points):
        return TRANSFORMATION_KINDS[kind].fit(
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


def _weigh_less(norms, start_norms=None):
    """Screening by a robust norm, begun with another one."""

    def screen(tested):
        transformation, observed = tested.transformation, tested.observed
        points, d = observed.points, observed.source.shape[1]
        fit_all = fit_plane_robustly if d == 2 else fit_robustly
        begun = None
        if start_norms is not None:
            begun = fit_all(points, tested.fit_of, start_norms[d]).weights
        robust = fit_all(points, tested.fit_of, norms[d], begun)
        weighted = replace(observed, weights=robust.weights)
        table = residual_table(robust.fit, weighted, tested.significance)
        snooped = _Snooped(tested).table
        residuals = table.assign(**{name: snooped[name] for name in TESTS})
        return _rebuilt(transformation, robust.fit, weighted, residuals)

    return screen


_SCREENS = {
    "keep": _only_name,
    "snoop": _take_out,
    "huber": _weigh_less(HUBER),
    "tukey": _weigh_less(TUKEY, HUBER),
}
