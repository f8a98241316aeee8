"""Given heights against those of models, where no high flight lies between them.

Spatial models that go straight onto given points leave residuals in their heights. What
one wrong height makes of these is known from the operators of the propagation, and so
is what heights of models make of them that are all too large: those of a wrong
principal distance. So are the covariances. Control, each point of which is left out,
needs a high flight.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd
from scipy.special import chdtrc

from einschalt.pipeline.assessment.evidence.claim import RESIDUALS
from einschalt.pipeline.assessment.evidence.control.signatures import (
    HEIGHT,
    PLAN,
    covariance_of,
)
from einschalt.pipeline.assessment.evidence.fits.mean_residuals import (
    fits_without,
    mean_residuals,
)
from einschalt.stages.error_propagation.error_model import (
    LOW,
    ErrorModel,
    add_flight_sources,
)
from einschalt.stages.error_propagation.given_points import approximations_are_control
from einschalt.stages.stage4_error_propagation import propagate_model
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    selection,
)

# of more points the covariance would be too large: these stand for all
MOST_GIVEN = 500
LEAST_VARIANCE = 1e-9  # of the largest: below it the fits leave nothing
# residuals in plan, as many times as predicted: beyond it places contradict each other
LEAST_CONTRADICTED = 1.25
# of the standard errors of given heights: what is known worse than by so many
LARGEST_UNKNOWN = 30.0
# of the models of a point: with more of them it is the point that they contradict
LARGEST_SHARE_OF_SUSPECTS = 0.5


@dataclass(frozen=True, eq=False)
class GivenHeights:
    """Residuals in height at given points, the mean of the models of each.

    What patterns make of them has the names that it has where control is left out
    (``signatures``). Residuals are numbers of unit variance and independent of each
    other: as many as the fits leave.
    """

    examined: object
    model: ErrorModel
    control: pd.DataFrame  # the given points
    point_ids: np.ndarray  # of those that have residuals
    residuals: np.ndarray  # shape (n_points,) [m]
    of_values: PointOperator  # to the residuals, from errors of the values
    of_ground: PointOperator  # the same from those of the given points

    @property
    def are_control(self):
        """Whether the given points are control points, with errors of their own."""
        return approximations_are_control(self.examined.block)

    @cached_property
    def variances(self):
        """Covariance matrix of the residuals [m²].

        With given places as bad in plan as their residuals show: models on three or
        four points tilt by what is wrong there, and some residuals in height come of
        nothing else.
        """
        return covariance_of(self._chains, self._sizes, HEIGHT)

    @property
    def _sizes(self):
        """Sizes of the errors of all sources."""
        sizes = dict(self.model.standard_errors)
        for source in self.model.ground:
            each = np.array(self.model.axes.each(sizes[source]))
            each[:, list(PLAN)] *= self._larger_in_plan
            sizes[source] = each
        return sizes

    @property
    def _larger_in_plan(self):
        """How many times larger than predicted residuals in plan are; 1 at least."""
        plan = self.examined.claim.of(RESIDUALS)
        if plan is None or not plan.observed > plan.predicted > 0.0:
            return 1.0
        return plan.observed / plan.predicted

    def are_told(self, patterns):
        """Which patterns residuals can tell, (n_patterns,) of bool.

        Where places contradict each other in plan, they leave something in height that
        a pattern of metres would explain which these hardly show: one that is known
        worse than by some times the errors of given heights says nothing then.
        """
        if not self._larger_in_plan > LEAST_CONTRADICTED:
            return np.ones(len(patterns), dtype=bool)
        sizes, axes = self.model.standard_errors, self.model.axes
        stated = [axes.each(sizes[name])[:, HEIGHT[0]] for name in self.model.ground]
        largest = LARGEST_UNKNOWN * np.sqrt(np.mean(np.concatenate(stated) ** 2))
        return np.linalg.norm(self.of(patterns)[:, :, 0], axis=1) * largest > 1.0

    @property
    def _chains(self):
        """From all sources of errors to the residuals."""
        model = self.model
        chains = {n: self.of_values @ c for n, c in model.chains_to_values.items()}
        return add_flight_sources(chains, -self.of_ground, model.ground)

    @cached_property
    def _whitening(self):
        """To independent numbers of unit variance, (n, n_points)."""
        sizes, vectors = np.linalg.eigh(self.variances)
        is_left = sizes > LEAST_VARIANCE * sizes.max(initial=0.0)
        return (vectors[:, is_left] / np.sqrt(sizes[is_left])).T

    def observed(self, _axes=HEIGHT):
        """Residuals, independent and of unit variance, (n,)."""
        return self._whitening @ self.residuals

    def covariance(self, _axes=HEIGHT):
        """Their covariance."""
        return np.eye(len(self._whitening))

    @property
    def p_value(self):
        """Probability of squares as large as theirs, if errors are as large as told."""
        squares = float(np.sum(self.observed() ** 2))
        return float(chdtrc(len(self._whitening), squares))

    def of(self, patterns, _axes=HEIGHT):
        """What each pattern makes of them for an amplitude of one, (n_patterns, n, 1).

        Patterns of heights of models, or of given ones.
        """
        errors = np.stack([pattern.of_control for pattern in patterns], axis=1)
        through = self.of_values @ self.model.low.ground
        shown = self._heights_through(through, errors)
        shown = shown - self._heights_through(self.of_ground, errors)
        of_scale = self._of_scale
        for place, pattern in enumerate(patterns):
            if pattern.flights:
                shown[:, place] = of_scale
        return (self._whitening @ shown).T[:, :, None]

    def scale_of_errors(self, _flights):
        """How far out of scale heights seem to be by their errors alone."""
        shown = np.mean(self._of_scale**2)
        variance = np.trace(self.variances) / len(self.residuals)
        return float(variance / shown) if shown > 0.0 else np.inf

    def moved(self, pattern, amplitude, _axes=HEIGHT):
        """What a pattern does to the new points, in height, RMS [m]."""
        if pattern.flights:
            return abs(float(amplitude[0])) * self.moved_by_one
        return self.moved_by(np.outer(pattern.of_control, amplitude))

    def moved_by(self, errors, _axes=HEIGHT):
        """What errors of given heights, (n_given, 1) [m], do to new points, RMS [m]."""
        through = self.model.final @ self.model.low.ground
        return self._of_new(self._heights_through(through, errors)[:, 0])

    @cached_property
    def moved_by_one(self):
        """Heights of new points above those that a scale of heights leaves, RMS [m]."""
        through = self.model.final @ self.model.low.measured
        return self._of_new(self._heights_through(through, self._heights)[:, 0])

    @cached_property
    def predicted(self):
        """Error of the new points' heights by the model of errors, RMS [m].

        Also where that is only assumed, and no figure is stated.
        """
        return self._of_new(self._propagated)

    @cached_property
    def moved_by_plan(self):
        """What places that are worse in plan than stated add to heights, RMS [m].

        0 where residuals in plan do not contradict them.
        """
        if not self._larger_in_plan > LEAST_CONTRADICTED:
            return 0.0
        shown = replace(self.model, standard_errors=self._sizes)
        errors = propagate_model(shown, self.examined.means)
        height = self._of_new(np.sqrt(errors.covariance[:, HEIGHT[0], HEIGHT[0]]))
        return float(np.sqrt(max(height**2 - self.predicted**2, 0.0)))

    def predicted_at(self, point_ids):
        """That of some points, (n_points,) [m]; NaN where they have no heights."""
        known = pd.Series(self._propagated, self.examined.means.points["point_id"])
        return known.reindex(point_ids).to_numpy()

    @cached_property
    def _propagated(self):
        """Error of the height of each point by the model of errors, (n_means,) [m]."""
        errors = propagate_model(self.model, self.examined.means)
        return np.sqrt(errors.covariance[:, HEIGHT[0], HEIGHT[0]])

    @cached_property
    def _of_scale(self):
        """Residuals where heights of models are too large by themselves."""
        through = self.of_values @ self.model.low.measured
        return self._heights_through(through, self._heights)[:, 0]

    @cached_property
    def _heights(self):
        """Heights of the model points above their mean, (n_model_points, 1) [m]."""
        low, points = self.examined.low, self.examined.model_points[LOW]
        height = low.values(points)["height"].to_numpy(dtype=float)
        return np.nan_to_num(height - np.nanmean(height))[:, None]

    def _heights_through(self, operator, errors):
        """Errors of heights, (n_sources, n), carried to heights elsewhere."""
        axes = self.model.axes
        packed = np.zeros((len(errors) * axes.value, errors.shape[1]))
        packed[HEIGHT[0] :: axes.value] = errors
        return operator.apply(packed)[HEIGHT[0] :: axes.value]

    def _of_new(self, heights):
        points = self.examined.points
        new = points.loc[points["role"] == "new", "point_id"]
        is_new = self.examined.means.points["point_id"].isin(new).to_numpy()
        if not is_new.any():
            return np.nan
        return float(np.sqrt(np.nanmean(heights[is_new] ** 2)))


def given_heights(two_step) -> GivenHeights | None:
    """Residuals in height at the given points, or None.

    None where a high flight lies between, models are not spatial, or the sizes of
    errors are not known. Of many points some stand for all.
    """
    if two_step.block.high_flight is not None or two_step.error_model is None:
        return None
    low, model = two_step.low, two_step.error_model
    is_good = _is_good(low)
    if model.axes is not Axes.SPACE or not is_good.any():
        return None
    means = mean_residuals(low, model, is_good)
    n_points, axes = len(means.places), model.axes
    few = np.linspace(0, n_points - 1, min(n_points, MOST_GIVEN)).astype(int)
    pick = selection(few, n_points, axes)
    known = two_step.block.approximate_points
    return GivenHeights(
        examined=two_step,
        model=model,
        control=known,
        point_ids=known["point_id"].to_numpy(dtype=object)[means.places[few]],
        residuals=means.vectors[few, HEIGHT[0]],
        of_values=(pick @ means.of_values).formed(),
        of_ground=(pick @ means.of_ground).formed(),
    )


def _is_good(low):
    """Fitted points of usable models with redundancy, without gross measurements.

    Where most models of a point contradict it, it is the point that is wrong.
    """
    residuals = low.residuals
    is_suspect = residuals["is_suspect"].astype(bool)
    share = is_suspect.groupby(residuals["point_id"]).transform("mean")
    is_gross = is_suspect & (share <= LARGEST_SHARE_OF_SUSPECTS)
    return fits_without(low, residuals[is_gross])
