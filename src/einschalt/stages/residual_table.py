"""The table of residuals of all models, and which of them are too large."""

import numpy as np

from einschalt.foundations.frame_columns import with_columns
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.reliability import redundancy_numbers
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.transformation.point_tests import fitted_tests

RESIDUAL_NAMES = ("residual_easting", "residual_northing", "residual_height")


def residual_table(fit, observed, significance=GROSS_ERROR_SIGNIFICANCE, tests=None):
    """Residuals of all points that were fitted, with the test of each point.

    coverage, model_id, point_id, residual_easting, residual_northing [,
    residual_height] [m], leverage, redundancy_number (means of easting and northing),
    w, p_value, is_suspect; row for row as ``observed``. ``significance`` is the
    probability with which a model without gross errors has a suspect; ``tests`` are
    those of the fit itself where left out.
    """
    leverage = fit.leverage[:, :2].mean(axis=1)
    if tests is None:
        tests = fitted_tests(fit, observed.points)
    return with_columns(
        observed.rows.reset_index(drop=True),
        # of two or three axes
        **dict(zip(RESIDUAL_NAMES, fit.residuals.T, strict=False)),
        leverage=leverage,
        redundancy_number=redundancy_numbers(leverage),
        w=tests.w,
        p_value=tests.p_value,
        is_suspect=is_rejected_by_holm(tests.p_value, significance, observed.start),
    )


def of_usable_models(table, models, observed):
    """Leave out the residuals of models that are not usable."""
    is_usable = np.repeat(models["is_usable"].to_numpy(), np.diff(observed.start))
    return table if is_usable.all() else table[is_usable].reset_index(drop=True)
