"""How far what is wrong moves the new points: lower bounds of what is not known.

Every measure looks at the same errors from another side, so that the largest counts:
what wrong control does through the operators of the propagation; how far suspects lie
from where another flight or coverage has them; how far both ways of densification come
apart; what a doubt of the whole frame means for the coordinates.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import columns_of, values_of
from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.assessment.evidence.claim import LEFT_OUT
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.control.suspects import (
    LARGE_SPREAD,
    suspects_by_chance,
)
from einschalt.theory.adjustment.point_operator import GROUND_NAMES, N_PLAN
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE

# of the claimed figure: what must come to it, so that chance in single points does
# not make a claim fall (1.25 in all)
LEAST_ADDED = 0.75
HEIGHT_ERROR = "standard_error_height"
LEAST_VALUES = 3  # of a point, whose median one wrong value does not decide
# quarter of χ² by its mean, for two coordinates and for one
LOW_OF_PLAN, LOW_OF_HEIGHT = 0.2877, 0.1015
# beyond it errors are not only larger than given: something is wrong
LARGEST_S_0 = 2.0
# a figure is enlarged from here on: as the sizes of single errors are said to be larger
LEAST_ENLARGEMENT = 1.10


@dataclass(frozen=True)
class Displacement:
    """Of the new points, RMS [m]; 0 where nothing shows."""

    plan: float  # TOTAL
    height: float


NOTHING = Displacement(0.0, 0.0)


def where_it_matters(moved, claimed, *, is_refuted):
    """What counts of a displacement beside a claim [m]: 0 where chance may make it.

    Where the claim is refuted anyway, everything counts.
    """
    is_large = moved > LEAST_ADDED * claimed or not claimed > 0.0
    return moved if is_refuted or is_large else 0.0


def largest(*found) -> Displacement:
    """The largest of several, in plan and in height."""
    return Displacement(
        *(max(getattr(d, a) for d in found) for a in ("plan", "height"))
    )


def control_contradicts(examined) -> bool:
    """Whether control is wrong together in plan, be it named or not.

    A test of all patterns, or of strain, has shown that chance does not make it: that
    refutes what is stated of control, however little it moves the new points. Of a
    single point the test is one of many.
    """
    patterns, strain = examined.control_patterns, examined.strain
    if strain is not None and strain.is_significant:
        return True
    if examined.network_step is not None:
        return True
    if patterns.plan is None:  # errors that are all larger explain it as well
        return patterns.moved_plan > 0.0
    return patterns.plan.kind is Kind.BEND


def heights_contradict(examined) -> bool:
    """Whether heights of control that take part are wrong, together or one of them."""
    patterns = examined.control_patterns
    is_known = examined.is_effect_known(patterns.height)
    return not is_known and patterns.p_height <= SYSTEMATIC_SIGNIFICANCE


def displacement_of(examined) -> Displacement:
    """What is wrong moves the new points by so much."""
    return largest(examined.displaced_together, moved_by_suspects(examined))


def displacement_of_all(examined) -> Displacement:
    """What is wrong with control moves the new points by so much, and not suspects."""
    patterns, is_known = examined.control_patterns, examined.is_effect_known
    step = examined.network_step  # which of an adjustment is that of the two steps
    of_step = 0.0 if step is None or is_known(step) else step.moved
    # a step or a bend that is part of a strain moves points no further than it does
    in_plan = 0.0 if examined.smooth_strain else max(patterns.moved_plan, of_step)
    in_plan = of_step if is_known(patterns.plan) else in_plan
    in_height = 0.0 if is_known(patterns.height) else patterns.moved_height
    return largest(
        examined.moved_by_left_out,
        examined.moved_by_suspect_control,
        Displacement(in_plan, in_height),
    )


def moved_by_suspect_control(adjusted) -> Displacement:
    """What one control point that contradicts an adjustment and takes part does to it.

    Of several the measurements of a model may be wrong, and not they.
    """
    if not adjusted.knows_wrong_control:
        return NOTHING
    without, points = adjusted.adjustment.without_suspects, adjusted.points
    return _of_new(adjusted, points["point_id"], apart_from(points, without))


def moved_by_left_out_control(two_step) -> Displacement:
    """What control that the others contradict does to the new points.

    Each contradicted point is taken to be as wrong as its prediction from the others
    says; all points where together they are worse than given.
    """
    left_out, model = two_step.left_out_control, two_step.error_model
    if left_out is None:
        return NOTHING
    table, axes = two_step.control_left_out, model.axes
    errors = np.zeros((len(two_step.block.control_points), len(axes.names)))
    names = two_step.block.control_points["point_id"].to_numpy(dtype=object)
    place = {name: row for row, name in enumerate(names)}
    rows = np.array([place[name] for name in left_out.point_ids])
    is_wrong = table["is_suspect"].to_numpy(dtype=bool) | _falls(two_step.claim)
    errors[rows, :2] = -left_out.differences * is_wrong[:, None]
    if left_out.has_heights and _falls(two_step.height_claim):
        errors[rows, 2] = -left_out.of_heights[0]
    if not errors.any():
        return NOTHING
    packed = axes.packed(errors).reshape(-1, 1)
    moved = axes.unpacked(model.from_control.apply(packed)[:, 0])
    return _of_new(two_step, two_step.means.points["point_id"], moved)


def _falls(claim):
    return any(test.name == LEFT_OUT for test in claim.rejected)


def moved_by_suspects(examined) -> Displacement:
    """How far suspects among the new points lie from their other values.

    From the approximate coordinates, or from what their models say if one of them is
    wrong, beyond what is usual in the block. Suspects that chance makes in a block with
    many models do not count.
    """
    two_step = examined.two_step
    if not two_step.is_possible:
        return NOTHING
    residuals = examined.residuals
    suspects = examined.suspects.union(
        examined.points.loc[examined.points["is_suspect"], "point_id"],
        residuals.loc[residuals["is_suspect"].astype(bool), "point_id"],
    )
    suspects -= suspects_by_chance(examined) - examined.suspects
    points = examined.points
    rows = np.flatnonzero(is_among(points["point_id"], suspects))
    if not len(rows):
        return NOTHING
    known = _approximations(two_step, suspects)
    if two_step is not examined:  # which has not followed them
        known = _that_agree(known, two_step)
    squares = apart_from(points, known) ** 2
    spread = points["spread_total"].to_numpy(dtype=float) ** 2
    of_plan = squares[:, :2].sum(axis=1)
    pulled = _pulled_by_one(examined, points.iloc[rows]) ** 2
    plan = np.fmax(
        _beyond_usual(of_plan[rows], of_plan, LOW_OF_PLAN),
        _beyond_usual(pulled, spread, LOW_OF_PLAN),
    )
    height = [
        _beyond_usual(column[rows], column, LOW_OF_HEIGHT)
        for column in squares[:, 2:].T
    ]
    # half of it in either coordinate
    apart = np.sqrt(np.column_stack([plan / 2.0, plan / 2.0, *height]))
    return _of_new(examined, points["point_id"].iloc[rows], apart)


def _pulled_by_one(examined, points):
    """How far one wrong value may have moved points, (n_points,) [m]; NaN without.

    Of three and more values in two steps the median holds: the rest is what pulls the
    point. Of two nothing tells which is wrong, so half of their distance.
    """
    if examined.two_step is not examined:
        return _pulled_in_adjustment(examined.residuals, points["point_id"])
    names, means, two_step = points["point_id"], examined.means, examined
    median = _medians(means, names)
    apart = apart_from(points, pd.concat([median, means.points]))[:, :2]
    known = two_step.points.drop_duplicates("point_id").set_index("point_id")
    known = known.reindex(names)
    half = np.where(known["n_models"] == 2, known["spread_total"] / np.sqrt(2.0), 0.0)
    return np.hypot(np.hypot(*apart.T), half)


def _pulled_in_adjustment(residuals, names):
    """The same of an adjustment, whose residuals lead from a point to its values.

    Two values that nothing refuses confirm each other: the point is pulled away from
    the median of such. Where no more than one is left it is wrong as often as not, and
    then the point lies no nearer than the nearest of the others.
    """
    axes = ["residual_easting", "residual_northing"]
    rows = residuals.loc[is_among(residuals["point_id"], names)]
    good = rows[~rows["is_suspect"].astype(bool)].groupby("point_id")[axes]
    median = good.median().reindex(names).to_numpy()
    n_good = good.size().reindex(names, fill_value=0).to_numpy()
    away = np.hypot(*rows[axes].to_numpy(dtype=float).T)
    away = pd.Series(away, index=rows["point_id"].to_numpy()).sort_values()
    second = away[away.groupby(level=0).cumcount().to_numpy() == 1]
    nearest = second.reindex(names).to_numpy() / np.sqrt(2.0)
    return np.where(n_good > 1, np.hypot(*median.T), nearest)


def _approximations(two_step, suspects):
    """Approximate coordinates, of suspects the median of their values in the flight."""
    points = two_step.approximations
    if two_step.high is None:
        return points
    median = _medians(two_step.high.means, suspects)
    return pd.concat([median, points])  # of which the first counts


def _that_agree(known, two_step):
    """Approximate coordinates of two values and more that confirm each other.

    Of two that lie far apart either may be wrong, and a single one is among the values
    that the adjustment has of the point.
    """
    if two_step.high is None:
        return known
    spread = two_step.approximations["spread_total"].to_numpy(dtype=float)
    n_models = two_step.approximations["n_models"].to_numpy()
    usual = np.nanmedian(spread) if np.isfinite(spread).any() else 0.0
    is_bare = (n_models < LEAST_VALUES) & ~(spread <= LARGE_SPREAD * usual)
    names = two_step.approximations.loc[is_bare, "point_id"]
    return known[~is_among(known["point_id"], names)]


def _medians(means, names):
    """Median of the values of points that have three and more: point_id and axes [m].

    Their mean where they have been averaged with weights is no guide: it may lean on
    the wrong one.
    """
    used = means.used[is_among(means.used["point_id"], names)]
    code = encode(used["point_id"]).codes
    used = used[np.bincount(code)[code] >= LEAST_VALUES]
    axes = [name for name in GROUND_NAMES if name in used]
    return used.groupby("point_id", sort=False)[axes].median().reset_index()


def _beyond_usual(squares, all_squares, low):
    """What squares exceed those of most points by; 0 below.

    The lowest quarter tells what is usual, also where most points are wrong.
    """
    if not np.isfinite(all_squares).any():
        return np.zeros(len(squares))
    usual = np.nanquantile(all_squares, 0.25) / low
    return np.nan_to_num(np.maximum(squares - usual, 0.0))


def moved_between_ways(adjusted, two_step) -> Displacement:
    """How far one adjustment lies from two steps, beyond the errors of both.

    These are enlarged by s_0, but not by one that gross errors make. What given
    approximate points do that are wrong does not count: an adjustment follows control.
    """
    if not two_step.is_possible:
        return NOTHING
    # regions of the adjustment are those that control follows too
    if two_step.is_put_off and not adjusted.displaced_regions:
        two_step = two_step.corrected
    apart = apart_from(adjusted.points, _as_told(two_step))
    moved = _of_new(adjusted, adjusted.points["point_id"], apart)
    s_0 = float(np.clip(np.nan_to_num(adjusted.adjustment.s_0), 1.0, LARGEST_S_0))
    plan = np.hypot(adjusted.figures.mean_within, _by_what_was_stated(two_step))
    return Displacement(
        _beyond(moved.plan, s_0 * plan),
        _beyond_in_height(adjusted, two_step, apart[:, N_PLAN:], s_0),
    )


def _beyond_in_height(adjusted, two_step, apart, s_0):
    """What heights of both ways lie apart beyond their errors, new points, RMS [m].

    Models on three control points almost in line tilt by metres, as they are told to.
    So points whose heights are known worse than those of most weigh less.
    """
    points = adjusted.points
    is_new = (points["role"] == "new").to_numpy()
    names = points["point_id"][is_new]
    both = [_height_errors(each.points, names) for each in (adjusted, two_step)]
    squares = np.sum(apart[is_new] ** 2, axis=1)
    chance = s_0**2 * np.sum(np.square(both), axis=0)
    is_known = np.isfinite(squares + chance)
    if not is_known.any():
        return 0.0
    squares, chance = squares[is_known], chance[is_known]
    usual = np.median(chance)
    is_worse = chance > usual
    weights = np.divide(usual, chance, out=np.ones(len(chance)), where=is_worse)
    excess = np.average(squares, weights=weights) - np.average(chance, weights=weights)
    # over all new points: of the others nothing is known
    return float(np.sqrt(max(excess, 0.0) * np.mean(is_known)))


def _height_errors(points, names):
    """Standard errors of heights of points, (n_names,) [m]; 0 where none is known."""
    if HEIGHT_ERROR not in points:
        return np.zeros(len(names))
    known = points.drop_duplicates("point_id").set_index("point_id")[HEIGHT_ERROR]
    return np.nan_to_num(known.reindex(names).to_numpy(dtype=float))


def _as_told(two_step):
    """Points of the two steps without what their own values contradict.

    Where these lie far apart, the mean leans on one that is wrong: it is their median,
    and of two values neither tells where the point is.
    """
    points, is_far = two_step.points, two_step.far_apart
    if not is_far.any():
        return points
    medians = _medians(two_step.means, points.loc[is_far, "point_id"])
    return pd.concat([medians, points[~is_far]])


def _by_what_was_stated(two_step):
    """Error of two steps in plan, if nothing is wrong, TOTAL [m]."""
    figures = two_step.figures
    if np.isfinite(figures.mean_within):
        return figures.mean_within
    # with what approximate points may share, unless measurements have enlarged it
    credible = two_step.credible
    return figures.mean_paper if credible.is_lower_bound else credible.value


def _beyond(found, expected):
    expected = float(np.nan_to_num(expected))
    return float(np.sqrt(max(found**2 - expected**2, 0.0)))


def new_points_apart(examined, others) -> Displacement:
    """How far the new points lie from where other points of their names do."""
    points = examined.points
    return _of_new(examined, points["point_id"], apart_from(points, others))


def moved_beyond_chance(examined, again) -> Displacement:
    """How far the new points lie from where they do in a block that is computed again.

    In plan and in height, nothing that its own errors explain.
    """
    moved = new_points_apart(examined, again.points)
    both = (moved.plan, again.credible.value), (moved.height, again.stated_height)
    return Displacement(*(where_it_matters(*of, is_refuted=False) for of in both))


def apart_from(points, others):
    """Coordinates of points less those that others have, (n_points, 2 or 3) [m].

    Of several rows of a point in ``others`` the first counts.
    """
    axes = [name for name in GROUND_NAMES if name in points and name in others]
    there = others.drop_duplicates("point_id").set_index("point_id")
    there = columns_of(there, axes).reindex(points["point_id"]).to_numpy(dtype=float)
    return values_of(points, axes) - there


def _of_new(examined, point_ids, moved):
    """RMS over all new points of what some points are moved by, (n, 2 or 3)."""
    points = examined.solution.points
    new = points.loc[points["role"] == "new", "point_id"]
    if new.empty:
        return NOTHING
    squares = np.nan_to_num(moved[is_among(point_ids, new)]) ** 2
    sums = np.zeros(3)
    sums[: squares.shape[1]] = squares.sum(axis=0)
    mean = sums / len(new)
    return Displacement(float(np.sqrt(mean[:2].sum())), float(np.sqrt(mean[2])))
