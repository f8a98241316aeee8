"""Regions whose given approximate coordinates are displaced, and what follows.

Where no high flight makes them, a part of a network, a strip or a photograph may have
put the approximate coordinates of neighbours off together, and control with them. Each
model lies where its points are, so that residuals show it at the rim only; all models
adjusted at once, with the given points as observations, show it as clearly as can be.
Under a high flight it is control that is displaced: see ``displaced_control``.

The block is computed once more with the regions where the others have them: what moves
is what they do to the points, and what is left is what the others are worth.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.assessment.evidence.control.exchanged_control import (
    adjusted_in_plan,
    find_exchanged_control,
)
from einschalt.pipeline.assessment.evidence.exchanged_names import (
    put_measured_names_right,
)
from einschalt.pipeline.assessment.evidence.ground.displaced_control import (
    scan_control,
)
from einschalt.pipeline.assessment.evidence.ground.given_region import (
    GivenRegion,
    KnownPoints,
    by_known_points,
    exceeds_stated,
    told_region,
)
from einschalt.pipeline.assessment.evidence.ground.network_step import (
    network_step,
    smooth_strain,
)
from einschalt.pipeline.assessment.evidence.ground.onto_given_points import (
    first_pass,
    observations,
    says_what_is_shared,
)
from einschalt.pipeline.assessment.evidence.ground.wrong_given_points import (
    look_for_wrong_points,
    points_beside,
    together,
)
from einschalt.pipeline.assessment.evidence.without_gross_errors import gross_rows
from einschalt.pipeline.block.block import with_errors_as_shown
from einschalt.pipeline.densification.one_adjustment import solve_in_one_adjustment
from einschalt.pipeline.densification.two_steps import (
    TwoStepSolution,
    solve_in_two_steps,
)
from einschalt.stages.error_propagation.error_model import LOW
from einschalt.stages.error_propagation.given_points import (
    PLAN,
    control_among_approximations,
)
from einschalt.theory.adjustment.detectable_shift import DetectableShift
from einschalt.theory.adjustment.displaced_regions import find_displaced_regions
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.block_adjustment.control_information import control_checks

# of larger blocks the test takes longer than everything else
MOST_GIVEN = 20_000
# measured points of a block that is computed once more, to tell what that gives: one
# adjustment takes some 0.5 s beside two steps of 0.7 s
MOST_TRIED = 20_000
# of the shift of control: what moves less is not of its region
MOVED_WITH_CONTROL = 0.1


@dataclass(frozen=True)
class GivenScan:
    """What was looked for among given approximate points, and what was found."""

    regions: tuple[GivenRegion, ...] = ()  # the clearest first
    n_points: int = 0
    n_tried: int = 0  # regions, 0 where nothing was looked for
    # shift over its standard error, of the clearest; and its probability, of all
    clearest: float = np.nan
    p_value: float = np.nan
    # where nothing is seen: how far regions may be displaced all the same
    detectable: DetectableShift | None = None
    # why nothing was looked for, where that might have been: orientations, too_many
    untested: str = ""


# of an examination with regions moved back, in which none are looked for again
NO_MORE_REGIONS = {"region_scan": GivenScan(), "control_regions": ()}


class BesideDisplacedRegion:
    """What can be asked of an examination about given points that are wrong.

    Regions are looked for without the single points that are wrong.
    """

    is_with_regions_back = False
    n_times_put_right = 0  # that names of measurements were
    network_step = cached_property(network_step)
    smooth_strain = cached_property(smooth_strain)
    adjusted_in_plan = cached_property(adjusted_in_plan)
    exchanged_control = cached_property(find_exchanged_control)
    measured_names = cached_property(put_measured_names_right)

    @property
    def names_put_right(self):
        """What the block is with names put right, given or measured ones, or None."""
        return self.exchanged_control or self.measured_names

    @property
    def is_small(self):
        """Whether a block is so small that it is computed once more."""
        models = self.all_in_two_steps.model_points
        return sum(map(len, models.values())) <= MOST_TRIED

    def computed_again(self, block, settings=None, flights=None, gross=None):
        """Examination of a block that is computed in the same way, in silence.

        With the settings and the orientations of this one, unless others are given.
        ``gross`` are the gross measurements that these settings find in the block.
        """
        is_in_two_steps = isinstance(self.solution, TwoStepSolution)
        solve = solve_in_two_steps if is_in_two_steps else solve_in_one_adjustment
        if settings is None:
            settings = self.solution.settings
        elif settings.outliers != self.solution.settings.outliers:
            given, block = block, with_errors_as_shown(block, settings.outliers)
            gross = gross if block is given else None  # by other errors of images
        before = self.all_in_two_steps.solution
        if flights is None:  # models that were given up may be held then
            flights = before.flights
        known = {"before": before, "gross": gross}
        return type(self)(solve(block, settings, flights, _in_silence, **known))

    @cached_property
    def _wrong_points(self):
        """Each WrongGivenPoint, and the examination of the block without them."""
        if self.two_step is not self:
            return (), None  # an adjustment does not follow given points
        return look_for_wrong_points(self, self._examined_without)

    @cached_property
    def wrong_given_points(self):
        """Each WrongGivenPoint that puts the points off, the largest first."""
        points, _ = self._wrong_points
        beside = self._with_regions_back
        if beside is None or beside.two_step is not beside:
            return points
        return together(self.block, points, beside.wrong_given_points)

    @property
    def is_put_off(self):
        """Whether given points that are wrong, together or alone, put points off."""
        return bool(self.displaced_regions or self.wrong_given_points)

    def _examined_without(self, block):
        """Examination of two steps of a block without some points."""
        again = self.computed_again(block)
        vars(again)["_wrong_points"] = (), None  # they are looked for
        if self.is_with_regions_back:  # and so are these
            vars(again).update(NO_MORE_REGIONS, is_with_regions_back=True)
        return again

    @cached_property
    def region_scan(self) -> GivenScan:
        """The scan of the given approximate points, of an examination of two steps."""
        _, without = self._wrong_points
        return scan_given_points(self) if without is None else without.region_scan

    @cached_property
    def largest_region(self):
        """Shift of the largest region that is found, or may be there, 0 without [m].

        Errors of orientations may make one, which is not told then.
        """
        scan = self.region_scan
        if scan.untested != "orientations":
            return max((each.size for each in scan.regions), default=0.0)
        return _largest_that_may_be(self)

    @cached_property
    def control_regions(self):
        """Regions of control that are displaced, of an examination of two steps."""
        return scan_control(self)

    @cached_property
    def displaced_regions(self):
        """Each GivenRegion that puts the points off, the clearest first."""
        two_step = self.two_step
        if not two_step.is_possible:
            return ()
        if two_step is self:
            return self.region_scan.regions or self.control_regions
        # an adjustment follows control alone
        return tuple(
            region
            for region in two_step.displaced_regions
            if region.is_of_control or (region.control_ids and region.control_is_alike)
        )

    @property
    def displaced_part_is_told(self):
        """Whether it is told of every region that it is off, and not the others."""
        return not any(region.may_be_the_others for region in self.displaced_regions)

    @cached_property
    def corrected(self):
        """Examination of the block with the regions where the others have them.

        And without single points that are wrong, those too that the regions hid; None
        where there is nothing of it.
        """
        beside = self._with_regions_back
        if beside is None:
            return self._wrong_points[1]
        return beside.corrected or beside

    @cached_property
    def _with_regions_back(self):
        """The same with single points that nothing but the regions hides, or None.

        Without regions None.
        """
        _, without = self._wrong_points
        if not self.displaced_regions:
            return None
        block = (self if without is None else without).solution.block
        for region in self.two_step.displaced_regions:
            block = with_region_back(block, region)
        again = self.computed_again(block)
        vars(again.two_step).update(NO_MORE_REGIONS, is_with_regions_back=True)
        return again

    @cached_property
    def moved_by_region(self):
        """How far what is wrong puts each point off, TOTAL (n_points,) [m].

        Where nothing tells which part is off, as far as any explanation has it. Single
        points as far as they lie from where they are given: the models may all show
        another target.
        """
        return np.maximum(self._moved_by_each.max(axis=0), self._away_from_given)

    @cached_property
    def moved_at_once(self):
        """RMS of that of the new points by one explanation, the largest [m]."""
        is_new = (self.solution.points["role"] == "new").to_numpy()
        moved = self._moved_by_each[:, is_new]
        return float(np.sqrt(np.mean(moved**2, axis=1).max())) if is_new.any() else 0.0

    @cached_property
    def _moved_by_each(self):
        """By each explanation, (n_explanations, n_points) [m]."""
        points = self.solution.points
        if not self.is_put_off:
            return np.zeros((1, len(points)))
        there = self.corrected.solution.points.set_index("point_id")[PLAN]
        there = there.reindex(points["point_id"]).to_numpy(dtype=float)
        moved = np.nan_to_num(values_of(points, PLAN) - there)
        others = [
            each.shift for each in self.displaced_regions if each.may_be_the_others
        ]
        moved = [np.hypot(*(moved - s).T) for s in ((0.0, 0.0), *others)]
        if any(each.exchanged_with for each in self.wrong_given_points):
            # in the list, or in all measurements: nothing tells
            moved.append(np.maximum(moved[0], self._away_from_given))
        return np.stack(moved)

    @property
    def _away_from_given(self):
        """How far wrong points lie from where they are given, 0 of others, (n,) [m]."""
        points, known = self.solution.points, self.block.approximate_points
        wrong = [each.point_id for each in self.wrong_given_points]
        is_wrong = is_among(points["point_id"], wrong)
        if not is_wrong.any():
            return np.zeros(len(points))
        there = known.drop_duplicates("point_id").set_index("point_id")[PLAN]
        there = there.reindex(points["point_id"]).to_numpy(dtype=float)
        apart = np.nan_to_num(values_of(points, PLAN) - there)
        return np.where(is_wrong, np.hypot(*apart.T), 0.0)

    @cached_property
    def is_displaced(self):
        """Which points lie in a region that is displaced, (n_points,).

        Of control: those that it moves by more than a tenth of its shift.
        """
        points = self.solution.points
        is_inside = np.zeros(len(points), dtype=bool)
        for region in self.displaced_regions:
            is_inside |= is_among(points["point_id"], region.point_ids)
        sizes = [each.size for each in self.displaced_regions if each.is_of_control]
        least = MOVED_WITH_CONTROL * min(sizes, default=np.inf)
        return is_inside | (self.moved_by_region > least)

    @cached_property
    def moved_outside(self):
        """RMS of that of the new points outside the regions [m].

        And outside models of single points that are wrong. NaN without anything of it,
        or where nothing tells which part is off.
        """
        is_inside = self.is_displaced
        if self.wrong_given_points:
            beside = points_beside(self, self.wrong_given_points)
            is_inside = is_inside | is_among(self.solution.points["point_id"], beside)
        is_new = (self.solution.points["role"] == "new").to_numpy()
        moved = self.moved_by_region[~is_inside & is_new]
        is_known = self.displaced_part_is_told and len(moved)
        return float(np.sqrt(np.mean(moved**2))) if is_known else np.nan


def _in_silence(_stage):
    """Report nothing: the work is done."""


def scan_given_points(two_step) -> GivenScan:
    """Look for regions of given approximate points that are displaced.

    None where chance explains everything, or an error as large as is stated of each
    point, which neighbours may share. Nothing is looked for where there is a high
    flight, where groups or a correlation length say what points share, and how much, or
    where errors of orientations bend models.
    """
    block, known = two_step.block, two_step.block.approximate_points
    if known is None or says_what_is_shared(two_step):
        return GivenScan()
    if block.low_flight.is_oriented_numerically:
        return GivenScan(untested="orientations")
    if len(known) > MOST_GIVEN:
        return GivenScan(untested="too_many")
    if two_step.error_model is None:
        return GivenScan()
    is_out = gross_rows(two_step, LOW, first_pass(two_step))
    places, errors, flight, given = observations(two_step, is_out)
    if not len(flight.model):
        return GivenScan()
    known = known.iloc[places]
    scan = _scanned(two_step, flight, given, values_of(known, PLAN))
    shared = errors[places] * scan.enlargement
    found = scan.regions if exceeds_stated(scan.regions, shared) else ()
    regions = _told(block, known, found, errors[places])
    clearest = float(np.sqrt(scan.square)), float(scan.p_value)
    return GivenScan(regions, len(known), scan.n_tried, *clearest, scan.detectable)


def _largest_that_may_be(two_step):
    """Shift of the largest region, by orientations without errors, 0 without [m]."""
    known = two_step.block.approximate_points
    if len(known) > MOST_GIVEN or two_step.error_model is None:
        return 0.0
    is_out = gross_rows(two_step, LOW, first_pass(two_step))
    places, _, flight, given = observations(two_step, is_out)
    if not len(flight.model):
        return 0.0
    found = _scan(flight, given, values_of(known.iloc[places], PLAN)).regions
    return max((float(np.hypot(*each.shift)) for each in found), default=0.0)


def _told(block, known, found, errors):
    """GivenRegion of each that was found, or of all others where these are off."""
    control = block.control_points

    def beside(region, roles=(True, False)):
        """Control, and check points."""
        return [_beside(known, region, control, errors, held) for held in roles]

    found, is_decided = by_known_points(found, len(known), beside)
    n_elsewhere = len(known) - sum(len(region.rows) for region in found)
    how = {"is_of_control": False, "is_decided": is_decided}
    held = [beside(region, (True,))[0] for region in found]
    how["usual"] = _missed_elsewhere(held)
    return tuple(
        told_region(known, region, n_elsewhere, others, **how)
        for region, others in zip(found, held, strict=True)
    )


def _missed_elsewhere(held):
    """How far control in none of the regions is missed, in the mean, (2,).

    It need not be given where the others are: of strips with a shift each, control that
    is right may agree with one of them, and seem to be displaced as that is.
    """
    if not held:
        return np.zeros(2)
    is_elsewhere = ~np.any([each.is_inside for each in held], axis=0)
    misses = held[0].misses[is_elsewhere]
    return misses.mean(axis=0) if len(misses) else np.zeros(2)


def _beside(known, region, control, errors, is_held):
    """Control points, or check points, with given approximate coordinates."""
    if control is None:
        none = np.zeros(0)
        return KnownPoints(none, none.astype(bool), np.zeros((0, 2)), none)
    is_wanted = ((control["role"] != "check") == is_held).to_numpy()
    is_wanted = is_wanted & is_among(control["point_id"], known["point_id"])
    control = control[is_wanted]
    rows = encode(known["point_id"]).locate(encode(control["point_id"]))
    own = np.zeros(len(control))
    if "standard_error_m" in control:
        own = np.nan_to_num(control["standard_error_m"].to_numpy(dtype=float))
    return KnownPoints(
        control["point_id"].to_numpy(dtype=object),
        np.isin(rows, region.rows),
        values_of(known, PLAN)[rows] - values_of(control, PLAN),
        np.hypot(errors[rows], own / SQRT2),
    )


def _scanned(two_step, flight, given, xy):
    """The scan; by larger errors of given points where these leave nothing clear.

    With errors that are as large as m_0 says, models follow a region less than with the
    stated ones: what all points have by themselves must not pass for shared.
    """
    scan = _scan(flight, given, xy)
    if scan.regions or scan.p_value > FINDING_SIGNIFICANCE:
        return scan
    larger = _larger_by_m_0(two_step, flight, given)
    again = scan if larger is None else _scan(flight, larger, xy)
    if again.regions or again.p_value <= FINDING_SIGNIFICANCE:
        return scan
    return replace(again, detectable=None)  # by errors that nobody stated


def _scan(flight, given, xy):
    checks = control_checks([flight], given)
    return find_displaced_regions(checks, given.weight, xy)


def _larger_by_m_0(two_step, flight, given):
    """Given points with errors that explain m_0; None where the stated ones do."""
    low = first_pass(two_step)
    of_given = np.mean(1.0 / given.weight)
    left = low.m_0_plan**2 / 2.0 - np.mean(1.0 / flight.weight)
    if not left > of_given:
        return None
    return replace(given, weight=given.weight * of_given / left)


def with_region_back(block, region):
    """A block with the region where all others have it."""
    with_it = region.control_ids if region.control_is_alike else ()
    if region.is_of_control:
        names = {"control_points": (*region.point_ids, *with_it)}
        given = control_among_approximations(block)
        if len(given):  # onto which models go as well
            inside = given[is_among(given, names["control_points"])]
            names["approximate_points"] = tuple(inside)
    else:
        names = {"approximate_points": region.point_ids}
        if with_it:
            names["control_points"] = with_it
    return replace(
        block,
        **{
            table: _moved_back(getattr(block, table), inside, region.shift)
            for table, inside in names.items()
        },
    )


def _moved_back(points, inside, shift):
    is_inside = is_among(points["point_id"], list(inside))
    moved = values_of(points, PLAN) - np.outer(is_inside, shift)
    return points.assign(easting=moved[:, 0], northing=moved[:, 1])
