"""Fitted models as results of statsmodels: with its diagnostics, tests and summaries.

Only :meth:`ModelTransformation.to_statsmodels` and those who ask for it import this
module: statsmodels takes longer to import than most blocks take to be computed.
"""

import numpy as np
import pandas as pd
from statsmodels.regression.linear_model import (
    OLS,
    WLS,
    RegressionResults,
    RegressionResultsWrapper,
)
from statsmodels.stats.outliers_influence import OLSInfluence

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.errors import GeometryError
from einschalt.stages.results import row_of_model
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.theory.transformation.linear_model import linear_model

FLIGHTS = ("low_flight", "high_flight")
SAME = 1e-9


class ModelRegression(RegressionResults):
    """Weighted least squares of one model, in coordinates reduced to its centroids.

    All of statsmodels' results, and what they lack: influence with weights, and the
    parameters about the origins of the coordinates.
    """

    @property
    def params_at_origin(self):
        """Parameters about the origins of the coordinates: those of our own tables."""
        equations = self.model.equations
        step = equations.to_origin @ (np.asarray(self.params) - equations.reference)
        return pd.Series(equations.at_origin + step, index=list(equations.names))

    @property
    def cov_params_at_origin(self):
        """Their covariance matrix, a DataFrame."""
        equations, names = self.model.equations, list(self.model.equations.names)
        matrix = equations.to_origin @ self.cov_params() @ equations.to_origin.T
        return pd.DataFrame(np.asarray(matrix), index=names, columns=names)

    @property
    def centroid_model(self):
        """Weighted centroid of the model coordinates, a Series."""
        return self._named(self.model.equations.centroid_model, "source")

    @property
    def centroid_ground(self):
        """Weighted centroid of the ground coordinates [m], a Series."""
        return self._named(self.model.equations.centroid_ground, "target")

    def _named(self, values, frame):
        return pd.Series(
            values, index=list(getattr(TRANSFORMATION_KINDS[self.model.kind], frame))
        )

    def get_influence(self) -> OLSInfluence:
        """Influence of the single equations, a coordinate of a point each.

        Of the equations times the roots of their weights; residuals are weighted as
        well. Its scale is that of these results.
        """
        model, labels = self.model, self.model.data.row_labels
        whitened = OLS(
            pd.Series(model.wendog, index=labels, name=model.endog_names),
            pd.DataFrame(model.wexog, index=labels, columns=model.exog_names),
        )
        influence = OLSInfluence(whitened.fit())
        # of a robust fit it is not the mean of the weighted squares
        influence.scale = self.scale
        return influence


def regression_of_model(transformation, model_id, coverage=None):
    """Fit one model of a flight with statsmodels, as it was fitted here.

    As :meth:`ModelTransformation.to_statsmodels` describes it.
    """
    row = row_of_model(transformation.models, model_id, coverage)
    _require_usable(transformation, row)
    observed = transformation.observed
    own = slice(*observed.start[row : row + 2])
    source, target = observed.source[own], observed.target[own]
    equations = linear_model(transformation.fit, row, source, target)
    axes = TRANSFORMATION_KINDS[transformation.kind].target
    labels = pd.MultiIndex.from_product(
        [axes, observed.rows["point_id"].iloc[own]], names=["coordinate", "point_id"]
    )
    design = np.concatenate(list(np.moveaxis(equations.design, 1, 0)))
    model = WLS(
        pd.Series(equations.observed.T.ravel(), index=labels, name="ground"),
        pd.DataFrame(design, index=labels, columns=list(equations.names)),
        weights=np.tile(observed.weights[own], len(axes)),
    )
    model.equations, model.kind = equations, transformation.kind
    return _with_scale(model, float(transformation.fit.s_0[row]) ** 2)


def regression_of_flight(
    high, low, model_id, coverage=None, flight="low_flight"
) -> RegressionResultsWrapper:
    """Fit one model of either flight of a densification with statsmodels.

    ``high`` and ``low`` are stages 1 and 3; GeometryError where the models of the
    flight were not transformed by themselves.
    """
    require_choice("flight", flight, FLIGHTS)
    fitted = {
        "low_flight": low,
        "high_flight": None if high is None else high.transformation,
    }[flight]
    if fitted is None:
        raise GeometryError(
            f"no model of the {flight.replace('_', ' ')} was transformed by itself",
            expected="a block that can be densified in two steps, with this flight",
        )
    return regression_of_model(fitted, model_id, coverage)


def _require_usable(transformation, row):
    model = transformation.models.iloc[row]
    if model["is_usable"]:
        return
    failures = transformation.failures
    names = ["coverage", "model_id"]
    is_it = (failures[names] == model[names]).all(axis=1)
    raise GeometryError(
        f"it has no transformation: {model['reason']}",
        remedy=failures.loc[is_it, "remedy"].iloc[0],
        model=model["model_id"],
    )


def _with_scale(model, variance):
    """Results with our variance of unit weight, where theirs would be another one."""
    plain = model.fit()
    options = {}
    # of a robust fit, or without redundancy
    is_theirs = bool(plain.df_resid) and np.isclose(
        plain.scale, variance, rtol=SAME, atol=0.0
    )
    if not is_theirs:
        options = {"cov_type": "fixed scale", "cov_kwds": {"scale": variance}}
    results = ModelRegression(
        model,
        np.asarray(plain.params),
        normalized_cov_params=model.normalized_cov_params,
        # of Student's t, the scale being estimated in any case
        use_t=True,
        **options,
    )
    return RegressionResultsWrapper(results)
