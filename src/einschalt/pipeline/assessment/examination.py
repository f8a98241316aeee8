"""What the measurements of a block say of its solution, each computed once.

An examination computes when it is asked; :func:`einschalt.pipeline.assessment.assess`
judges what comes out. Each way of densification is examined in its own way.
"""

from dataclasses import dataclass, fields
from functools import cached_property
from operator import attrgetter

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.forwarding import forwarding
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.credibility import (
    PAPER,
    TOTAL,
    claimed_column,
    figure_of_adjustment,
    figure_of_two_steps,
)
from einschalt.pipeline.assessment.credible_heights import COLUMN as HEIGHT
from einschalt.pipeline.assessment.credible_heights import (
    control_height_parts,
    credible_heights,
)
from einschalt.pipeline.assessment.evidence.claim import UNTESTED, examine_claim
from einschalt.pipeline.assessment.evidence.control.displacements import (
    NOTHING,
    displacement_of,
    displacement_of_all,
    moved_by_left_out_control,
)
from einschalt.pipeline.assessment.evidence.control.heights import (
    examine_adjusted_heights,
    examine_height_claim,
    find_lone_height,
    known_heights,
)
from einschalt.pipeline.assessment.evidence.control.other_targets import (
    find_other_targets,
)
from einschalt.pipeline.assessment.evidence.control.patterns import (
    NO_PATTERNS,
    wrong_control,
)
from einschalt.pipeline.assessment.evidence.control.shown_heights import ShownHeights
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.control.suspect_control import (
    SuspectControl,
)
from einschalt.pipeline.assessment.evidence.control.suspects import points_far_apart
from einschalt.pipeline.assessment.evidence.copies import find_copies
from einschalt.pipeline.assessment.evidence.exchanged_names import find_exchanged_names
from einschalt.pipeline.assessment.evidence.fits import adjusted_heights
from einschalt.pipeline.assessment.evidence.fits.high_flight_misfit import (
    high_flight_misfit,
)
from einschalt.pipeline.assessment.evidence.ground.displaced_region import (
    BesideDisplacedRegion,
)
from einschalt.pipeline.assessment.evidence.ground.frame import frame_of
from einschalt.pipeline.assessment.evidence.ground.given_heights import given_heights
from einschalt.pipeline.assessment.evidence.image_precision import find_image_tails
from einschalt.pipeline.assessment.evidence.images.exchanged_image_names import (
    find_exchanged_image_names,
)
from einschalt.pipeline.assessment.evidence.leave_one_out import (
    leave_out_control,
    left_out_heights,
)
from einschalt.pipeline.assessment.evidence.precision_tables import PrecisionTables
from einschalt.pipeline.assessment.evidence.repeated_settings import (
    m_g_of_repeated_settings,
)
from einschalt.pipeline.assessment.evidence.systematic_errors import (
    SystematicPatterns,
    find_patterns,
    strain_without,
)
from einschalt.pipeline.assessment.evidence.variance_components import (
    can_tell_components,
    estimate_components,
)
from einschalt.pipeline.assessment.evidence.without_gross_errors import (
    excluded_control,
    internal_of_good_points,
)
from einschalt.pipeline.assessment.facts.model_deformation import (
    FOR_TWO_STEPS,
    deformation_facts,
)
from einschalt.pipeline.assessment.known_points import (
    DIFFERENCES,
    check_points,
    check_points_confirmed_by_two,
    confirmed_check_points,
    confirmed_control_points,
    contradicting_points,
    control_points,
    find_lone_points,
)
from einschalt.pipeline.assessment.tolerance import (
    checked_figure_of_adjustment,
    checked_figure_of_two_steps,
    judged_points,
)
from einschalt.pipeline.densification.iteration import assumed_after_iteration
from einschalt.pipeline.densification.one_adjustment import SimultaneousSolution
from einschalt.pipeline.densification.result_tables import of_transformed_flights
from einschalt.pipeline.densification.solution import Solution
from einschalt.pipeline.densification.two_steps import TwoStepSolution, WithoutTwoSteps
from einschalt.stages.error_propagation.error_model import (
    LOW,
    errors_are_stated,
    model_of_block,
)
from einschalt.stages.error_propagation.given_points import (
    CONTROL_POINTS,
    GROUPS,
    PLAN,
    control_shares_errors,
)
from einschalt.stages.stage4_error_propagation import propagate_model
from einschalt.theory.adjustment.least_squares import SQRT2

RELIABILITY_COLUMNS = [
    *("flight", "coverage", "model_id", "point_id"),
    *("redundancy_number", "minimal_detectable_bias", "external_reliability"),
]


# of a solution, and of one in two steps
SOLVED = (*(f.name for f in fields(Solution)), "approximations", "coverages")
SOLVED_IN_TWO_STEPS = (
    *("errors", "propagation", "high", "low", "means", "model_points"),
    *("own_deformation", "iteration", "screening"),
)


@forwarding("solution", *SOLVED)
@dataclass(frozen=True, eq=False, repr=False)
class Examination(PrecisionTables, BesideDisplacedRegion, ShownHeights):
    """What can be asked of a solution, whichever way it was computed."""

    solution: TwoStepSolution | SimultaneousSolution

    moved_by_suspect_control = NOTHING

    def is_effect_known(self, _pattern):
        """Whether what a pattern does to the points is known without its operators."""
        return False

    frame = cached_property(frame_of)
    copies = cached_property(find_copies)
    far_apart = cached_property(points_far_apart)
    misfit = cached_property(high_flight_misfit)
    image_tails = cached_property(find_image_tails)
    exchanged_image_names = cached_property(find_exchanged_image_names)
    credible_heights = cached_property(credible_heights)
    known_check = cached_property(check_points)
    known_control = cached_property(control_points)
    lone_points = cached_property(find_lone_points)
    known_heights = cached_property(known_heights)
    lone_height = cached_property(find_lone_height)
    displaced = cached_property(displacement_of)
    displaced_together = cached_property(displacement_of_all)
    judged = cached_property(judged_points)

    @cached_property
    def suspects(self):
        """Names of points that more than the solution itself contradicts: a set.

        Check points by themselves, known points that are far off with the new point
        that lies where one is given, control points that were left out, points that
        were measured under each other's name, and those whose models lie far apart.
        """
        left_out = self.control_left_out
        patterns = (self.control_patterns.plan, self.control_patterns.height)
        alone = (p.point_ids for p in patterns if p and p.kind is Kind.POINT)
        lone = {name for p in self.lone_points for name in (p.point_id, p.found_there)}
        return set(contradicting_points(self)).union(
            lone - {""},
            left_out.loc[left_out["is_suspect"].astype(bool), "point_id"],
            self.points.loc[self.far_apart, "point_id"],
            *(*(pair.points for pair in self.exchanged_names), *alone),
        )

    @property
    def shares_control_errors(self):
        """Whether it is said that errors of control points have something in common."""
        return control_shares_errors(self.block)

    @property
    def stated_height(self):
        """Error of the new points' heights as it is propagated, RMS [m], or NaN."""
        points = self.solution.points
        if HEIGHT not in points:
            return np.nan
        new = points.loc[points["role"] == "new", HEIGHT].to_numpy(dtype=float)
        return float(np.sqrt(np.mean(new**2))) if len(new) else np.nan

    @cached_property
    def repeated_settings(self):
        """m_g from points that were set several times, a DataFrame."""
        return m_g_of_repeated_settings(self)


@forwarding("solution", *SOLVED_IN_TWO_STEPS)
class TwoStepExamination(Examination):
    """What can be asked of a solution in two steps."""

    solution: TwoStepSolution

    credible = cached_property(figure_of_two_steps)
    checked = cached_property(checked_figure_of_two_steps)
    is_possible = True
    unexplained_control = cached_property(confirmed_control_points)
    confirmed_check = cached_property(confirmed_check_points)
    # five control points of a high-flight model cannot spare one
    snooped_flights = ("low_flight",)
    deformation = None
    apart_from_two_steps = NOTHING
    moved_by_left_out = cached_property(moved_by_left_out_control)
    internal_of_good = cached_property(internal_of_good_points)
    excluded_control = cached_property(excluded_control)

    @property
    def two_step(self):
        """Itself: what stands beside one adjustment of all models."""
        return self

    all_in_two_steps = two_step

    # that have a finding of their own
    named_measurements = property(attrgetter("solution.gross_measurements"))

    @property
    def oriented_high_points(self):
        """Model points of the high flight as they were transformed, or None."""
        return self.model_points.get("high_flight")

    oriented_on_control = oriented_high_points

    @property
    def control_takes_part(self):
        """Whether control has any part in the points."""
        return self.high is not None or self.iteration is not None

    @cached_property
    def error_model(self):
        """The model of errors that the figure rests on, ErrorModel or None.

        That of the propagation; without one, a model in which nothing is shared that
        it cannot know of: given approximate coordinates are independent, orientations
        without errors. None where sizes of errors are not known.
        """
        if self.propagation is not None:
            return self.propagation
        return assumed_after_iteration(self.solution)

    @property
    def group_error(self):
        """Shift that control points of a group share, TOTAL [m]; 0 without."""
        known = self.block.group_errors_m.get(CONTROL_POINTS, 0.0)
        if known or self.propagation is None:
            return known
        sizes = self.propagation.standard_errors.get(GROUPS[CONTROL_POINTS], [0.0])
        return float(SQRT2 * sizes[0])

    @cached_property
    def errors_of_one_pass(self):
        """Propagated errors after the first of several passes, or None."""
        if self.iteration is None or self.errors is None:
            return None
        first, found = self.iteration.passes[0], self.solution
        model = model_of_block(
            *(found.block, found.model_points, found.high, first.low),
            found.orientation_errors,
            found.own_deformation,
        ).with_means(first.means)
        return propagate_model(model, first.means)

    @property
    def total_of_one_pass(self):
        """Error of the new points after the first pass, TOTAL, RMS [m], or NaN."""
        errors = self.errors_of_one_pass
        if errors is None:
            return np.nan
        new = self.points.loc[self.points["role"] == "new", "point_id"]
        is_new = is_among(errors.point_ids, new)
        variance = np.trace(errors.covariance[:, :2, :2], axis1=1, axis2=2)[is_new]
        return float(np.sqrt(np.mean(variance))) if len(variance) else np.nan

    @property
    def held_control(self):
        """Control points that the result holds: all of them, rows of ``points``."""
        return self.points[self.points["role"] == "control"]

    @property
    def has_untold_groups(self):
        """Whether given points share shifts whose size neither data nor user tells."""
        if np.isfinite(self.figures.mean_total):
            return False
        if self.block.high_flight is None:
            return errors_are_stated(self.block)
        return self.shares_control_errors

    @property
    def lacks_control_errors(self):
        """Whether control that the points follow has errors that no figure holds."""
        control = self.block.control_points
        is_followed = self.control_takes_part and control is not None
        return is_followed and "standard_error_m" not in control

    claimed_column = property(claimed_column)

    @cached_property
    def claim(self):
        """Tests of the claimed figure against the measurements: Claim."""
        return examine_claim(self)

    height_claim = cached_property(examine_height_claim)
    control_height_parts = cached_property(control_height_parts)

    @cached_property
    def components(self):
        """Sizes of errors that the measurements show, BlockComponents or None.

        None where the errors cannot be propagated, or the block is too small to tell.
        """
        if self.errors is None or not can_tell_components(self):
            return None
        first = self.low if self.iteration is None else self.iteration.passes[0].low
        return estimate_components(self, first)

    @cached_property
    def patterns(self):
        """Affinity of film and strain of control: SystematicPatterns."""
        return find_patterns(self)

    @cached_property
    def left_out_control(self):
        """Every control point predicted without itself, LeftOutControl or None."""
        return leave_out_control(self)

    @property
    def left_out_differences(self):
        """Control points as all others predict them less as given, (easting, northing).

        DataFrame by point_id, of those that are no suspects.
        """
        table = self.control_left_out.set_index("point_id")
        is_good = ~table["is_suspect"].astype(bool)
        return table.loc[is_good, DIFFERENCES].set_axis(PLAN, axis=1)

    left_out_heights = property(left_out_heights)
    is_of_result = False  # and not of what is tried beside it
    adjusted_beside = cached_property(adjusted_heights.adjusted_beside)
    control_patterns = cached_property(adjusted_heights.patterns_of_two_steps)

    @cached_property
    def strain(self):
        """Strain of control beside single points that are wrong: NetworkStrain."""
        return strain_without(self, self.wrong_control)

    @cached_property
    def wrong_control(self):
        """Names of the control points that are wrong, each by itself."""
        return frozenset(wrong_control(self.control_patterns))

    @cached_property
    def exchanged_names(self):
        """Pairs of points measured under each other's name: tuple of ExchangedNames."""
        return find_exchanged_names(self.solution)

    other_targets = cached_property(find_other_targets)
    given_heights = cached_property(given_heights)

    @cached_property
    def reliability(self):
        """How large a gross error must be to be found, in each model by itself."""
        table = of_transformed_flights(self.high, self.low, attrgetter("reliability"))
        return table[RELIABILITY_COLUMNS]


@forwarding("two_step", "other_targets", "components", "patterns")
@forwarding("two_step", "control_height_parts")
@forwarding("all_in_two_steps", "exchanged_names")  # which models are given up for
class SimultaneousExamination(SuspectControl, Examination):
    """What can be asked of one adjustment of all models.

    Covariances between its points are not kept: tables that need them have no rows.
    Ellipses, which need those of single points, it has.
    """

    solution: SimultaneousSolution

    snooped_flights = ("high_flight", "low_flight")
    screening = property(attrgetter("solution.two_step.screening"))
    errors = iteration = propagation = None
    left_out_control = None
    claim = UNTESTED
    adjustment = property(attrgetter("solution.adjustment"))
    deformation = cached_property(deformation_facts)
    credible = cached_property(figure_of_adjustment)
    checked = cached_property(checked_figure_of_adjustment)
    confirmed_check = cached_property(check_points_confirmed_by_two)
    control_takes_part = True

    def _require_errors(self):
        raise SettingsError(
            "a simultaneous adjustment keeps no covariances between points",
            expected='method = "two_step" for them',
        )

    @property
    def named_measurements(self):
        """None: what an adjustment has taken out is told with its residuals."""
        return self.solution.gross_measurements.iloc[:0]

    @cached_property
    def two_step(self):
        """Examination in two steps of the models, and the control, that it holds."""
        return self._without_set_aside or self._with_all_control

    @cached_property
    def _with_all_control(self):
        held, whole = self.solution.two_step, self.solution.all_in_two_steps
        return self.all_in_two_steps if held is whole else examine(held)

    @cached_property
    def all_in_two_steps(self):
        """Examination of all models of the block in two steps."""
        return examine(self.solution.all_in_two_steps)

    oriented_high_points = property(attrgetter("two_step.oriented_high_points"))

    @property
    def oriented_on_control(self):
        """Points of the models that control holds directly, or None."""
        two_step = self.two_step
        if not two_step.is_possible:
            return None
        high = two_step.oriented_high_points
        return two_step.model_points[LOW] if high is None else high

    @cached_property
    def height_claim(self):
        """Heights of the adjustment; without control where some was set aside."""
        is_without = self.two_steps_keep_set_aside
        return examine_adjusted_heights(self, is_without_control=is_without)

    @cached_property
    def lone_height(self):
        """As of two steps; without control where some was set aside."""
        return find_lone_height(self, is_without_control=self.two_steps_keep_set_aside)

    @property
    def claimed_column(self):
        """Standard error that is claimed for single points, a column of ``points``."""
        # the paper's budget is that of two steps
        return TOTAL if np.isfinite(self.figures.mean_total) else PAPER

    @property
    def group_error(self):
        """Shift that control points of a group share, TOTAL [m]; 0 without."""
        shared = self.adjustment.tables.observations.shared_control
        return 0.0 if shared is None else float(SQRT2 * np.sqrt(shared.variance.max()))

    @property
    def is_deformed(self):
        """Whether models are deformed in a way that the adjustment accumulates."""
        found = self.deformation
        return found is not None and found.belief in FOR_TWO_STEPS

    @property
    def reliability(self):
        """How large a gross error must be to be found, in the whole block."""
        return self.adjustment.residuals[RELIABILITY_COLUMNS]


@dataclass(frozen=True, eq=False, repr=False)
class NothingExamined:
    """What can be asked where the two steps are not possible: nothing shows."""

    solution: WithoutTwoSteps

    is_possible = False
    components = oriented_high_points = None
    patterns = SystematicPatterns((), None)
    exchanged_names = other_targets = ()
    control_patterns = NO_PATTERNS
    height_claim = UNTESTED
    control_height_parts = (np.nan, np.nan)
    moved_by_left_out = NOTHING


EXAMINATIONS = {
    TwoStepSolution: TwoStepExamination,
    SimultaneousSolution: SimultaneousExamination,
    WithoutTwoSteps: NothingExamined,
}


def examine(solution, two_step=None):
    """Examination of a solution, of the kind that fits the way it was computed.

    ``two_step``: that of the two steps beside one adjustment, if there is one already.
    """
    examined = EXAMINATIONS[type(solution)](solution)
    if two_step is not None:  # as a cached property keeps it
        vars(examined)["all_in_two_steps"] = two_step
    return examined
