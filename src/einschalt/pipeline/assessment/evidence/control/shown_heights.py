"""Control heights that are all worse than stated: what that does in plan.

Heights of control that are wrong tilt models, which moves points in plan as well: that
looks like a pattern in control, or makes differences in plan larger than they should
be. So where control points, each left out, differ in height by more than is predicted,
their heights are taken to be as bad as most of them show, and errors in plan are
propagated from these.

See docs/theory/claim.md.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.evidence.claim import LEFT_OUT
from einschalt.pipeline.assessment.evidence.control.displacements import (
    LEAST_ENLARGEMENT,
)
from einschalt.pipeline.assessment.evidence.control.signatures import (
    HEIGHT,
    covariance_of,
)
from einschalt.stages.stage4_error_propagation import propagate_model

MEDIAN_OF_SQUARE = 0.4549  # of χ² with one degree of freedom


class ShownHeights:
    """What can be asked of an examination about heights of control."""

    @cached_property
    def model_with_shown_heights(self):
        """The model of errors of two steps with control heights as they are shown."""
        return _shown_in(self)

    @cached_property
    def moved_by_shown_heights(self) -> float:
        """What control heights that are worse than stated add in plan, TOTAL, RMS [m].

        To what is propagated for the new points; 0 where it adds hardly anything. An
        adjustment, which has the same heights, has what the two steps have.
        """
        two_step = self.two_step
        if two_step is not self:
            return two_step.moved_by_shown_heights if two_step.is_possible else 0.0
        stated, shown = self.error_model, self.model_with_shown_heights
        if shown is stated:
            return 0.0
        before, larger = (_of_new(self, model) for model in (stated, shown))
        if not larger > LEAST_ENLARGEMENT * before:
            return 0.0
        return float(np.sqrt(larger**2 - before**2))


def _shown_in(two_step):
    """The model of errors with control heights as bad as they show themselves.

    As it is where chance explains their differences, or there are no heights. One that
    is far off by itself does not count for all others: the median does.
    """
    model, claim = two_step.error_model, two_step.height_claim
    if not any(test.name == LEFT_OUT for test in claim.rejected):
        return model
    factor = _factor(two_step.left_out_control, model)
    if not factor > 1.0:
        return model
    sizes = dict(model.standard_errors)
    for source in model.high.control.chains:
        each = np.array(model.axes.each(sizes[source]))
        each[:, HEIGHT[0]] *= factor
        sizes[source] = each
    return replace(model, standard_errors=sizes)


def _factor(left_out, model):
    """By how much control heights are worse than stated, by their left-out values.

    By all differences or by the median of them, whichever is less.
    """
    sizes = model.standard_errors
    variance = np.diag(covariance_of(left_out.chains, sizes, HEIGHT))
    of_control = {name: left_out.chains[name] for name in model.high.control.chains}
    given = np.diag(covariance_of(of_control, sizes, HEIGHT))
    if not (given > 0.0).all():
        return 1.0
    squares = left_out.of_heights[0] ** 2
    middle = np.median(squares / variance) / MEDIAN_OF_SQUARE
    ratio = min(float(middle), float(squares.sum() / variance.sum()))
    # only control is worse: other errors have their part
    excess = (ratio - 1.0) * variance.sum() / given.sum()
    return float(np.sqrt(1.0 + max(excess, 0.0)))


def _of_new(two_step, model):
    """Error of the new points in plan, TOTAL, RMS [m]."""
    errors = propagate_model(model, two_step.means)
    points = two_step.points
    new = points.loc[points["role"] == "new", "point_id"]
    is_new = is_among(errors.point_ids, new)
    variance = np.trace(errors.covariance[is_new, :2, :2], axis1=1, axis2=2)
    return float(np.sqrt(np.mean(variance))) if len(variance) else np.nan
