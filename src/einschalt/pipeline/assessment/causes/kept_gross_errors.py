"""Gross errors that take part, as the cause of what else is found.

With ``outliers = "keep"`` a single wrong measurement spoils the residuals of its model,
the differences of its coverages, every figure of the block. So a small block in which
something is found is computed once more without what contradicts the other models of
its flight: findings that are gone by then follow from it. So is one in which single
control points are wrong, or points that the flights have measured in different places,
without these.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.special import chdtrc

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.key_columns import rows_among
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.causes.ranked import SHARED, with_consequences
from einschalt.pipeline.assessment.credibility import TOTAL
from einschalt.pipeline.assessment.credible_heights import COLUMN as HEIGHT
from einschalt.pipeline.assessment.evidence.ground.displaced_region import (
    with_region_back,
)
from einschalt.pipeline.assessment.evidence.ground.network_step import region_of_step
from einschalt.pipeline.assessment.evidence.ground.wrong_given_points import (
    without_given,
)
from einschalt.pipeline.assessment.findings.catalogue import findings_of, in_order
from einschalt.pipeline.assessment.findings.heights import height_as_without_it
from einschalt.pipeline.assessment.findings.kinds import OBSERVATION, finding, row_keys
from einschalt.pipeline.assessment.findings.suspects import (
    largest_residual,
    undecided_points,
)
from einschalt.pipeline.assessment.known_points import given_errors
from einschalt.pipeline.densification.gross_errors import (
    HIGH,
    find_gross_measurements,
)
from einschalt.pipeline.densification.result_tables import LOW
from einschalt.theory.adjustment.multiple_testing import any_significant
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

OF_MODEL = ("flight", "coverage", "model_id")
CODE = "kept_gross_measurements"
EXCHANGED, EXCHANGED_NAMES = "exchanged_control", "exchanged_names"
OTHER_TARGETS, WRONG_HEIGHT = "other_targets", "wrong_control_height"
CLAIM = "claim_that_does_not_stand"
# the block is computed without them: the first of them explains what is gone then
PUT_OFF = ("wrong_approximate_points", "displaced_region")
BROKEN = "broken_network"
# what shows that control is more than broken in two
OF_NETWORK = {BROKEN, "strained_network", "contradicting_control", *PUT_OFF}
OF_CONTROL = {"control_that_contradicts", "control_against_block", "control_set_aside"}
# what no gross error makes, what is a cause itself, or a matter of single models and of
# reading
NEVER_FOLLOW = {
    *("no_check_points", "figure_left_out", "note_of_reading"),
    *("measurements_given_twice", "points_in_one_model"),
}
NO_CONSEQUENCES = NEVER_FOLLOW | {
    *(EXCHANGED_NAMES, EXCHANGED, "failed_models"),
    *("models_without_redundancy", "points_in_one_coverage"),
}
# what comes from too little control, and from no error
OF_GEOMETRY = {"imprecise_points"}


def with_kept_gross_errors(examined, judges, findings):
    """Put gross errors that take part before the findings that follow from them.

    ``judges`` are those of the examination. As they were where nothing is kept, the
    block is large, or no finding is gone without them; but they are told where all that
    is found is weak geometry: nothing doubts the errors by which they are gross.
    """
    may_follow = [found for found in findings if can_follow(found)]
    snooped = _snooped(examined) if may_follow else None
    gross = None if snooped is None else _kept(examined, snooped.table)
    if gross is None:
        return findings
    try:
        settings = _snooping(examined)
        again = examined.computed_again(examined.block, settings, gross=snooped)
    except EinschaltError:  # the rest does not hold together
        return findings
    if not _is_confirmed(again, _of_control_measured_once(examined, gross)):
        return findings  # given coordinates may be wrong, and not their measurements
    remaining = {
        found.code
        for found in findings_of(again, judges)
        if found.remedy != "measure_excluded_again"  # these are out
    }
    explained = [found for found in may_follow if found.code not in remaining]
    if not explained and any(found.code not in OF_GEOMETRY for found in may_follow):
        return findings
    marked = tuple(
        replace(found, explained_by=CODE) if found in explained else found
        for found in findings
    )
    return in_order((*marked, _finding(examined.all_in_two_steps, gross, explained)))


def with_wrong_names(examined, judges, findings):
    """Put what is gone with names put right, given or measured ones, under these.

    It spoils whatever is near: names that seem exchanged in measurements, or control
    that seems to be a new point, follow from it as well. What is left is told as it is
    without it.
    """
    right = examined.names_put_right
    is_control = right is examined.exchanged_control
    code = EXCHANGED if is_control else EXCHANGED_NAMES
    cause = next((found for found in findings if found.code == code), None)
    if right is None or cause is None:
        return findings
    left = {found.code: found for found in findings_of(right.corrected, judges)}
    kept = {code, *NEVER_FOLLOW}
    explained = tuple(
        found.code for found in findings if found.code not in {*kept, *left}
    )
    free = tuple(
        found
        if found.code in kept
        else replace(left.get(found.code, found), explained_by="")
        for found in findings
    )
    return with_consequences(cause, free, explained)


def with_wrong_height(examined, judges, findings):
    """Put what is gone without a control point of a wrong height under that height.

    One that is wrong by hundreds of metres tilts its models, so that points in plan
    look wrong as well, and good control with them.
    """
    cause = next((found for found in findings if found.code == WRONG_HEIGHT), None)
    may_follow = [
        found.code
        for found in findings
        if can_follow(found) and found.code != WRONG_HEIGHT
    ]
    if cause is None or cause.explained_by or not may_follow:
        return findings
    if not is_small(examined.two_step):
        return findings
    again, explained = _without_control(examined, judges, may_follow, cause.names)
    if not explained:
        return findings
    told = height_as_without_it(cause, examined, again)
    findings = tuple(told if found is cause else found for found in findings)
    return with_consequences(told, findings, explained)


def with_wrong_control(examined, judges, findings):
    """Put what follows from single wrong control points under these.

    As they were where none is wrong by itself, or no finding is gone without them.
    """
    causes = [found for found in findings if found.code in OF_CONTROL]
    may_follow = [
        found.code
        for found in findings
        if can_follow(found) and found.code not in OF_CONTROL
    ]
    if not (causes and may_follow) or causes[0].explained_by:
        return findings
    explained, names = (), ()
    for wrong in _wrong_control(examined):
        gone = _gone_without_control(examined, judges, may_follow, wrong)
        if len(gone) > len(explained):
            explained, names = gone, wrong
    return (
        with_consequences(causes[0], findings, explained, names)
        if explained
        else findings
    )


def _gone_without_control(examined, judges, codes, wrong):
    """Codes of findings that are gone without some control points."""
    return _without_control(examined, judges, codes, wrong)[1]


def _without_control(examined, judges, codes, wrong):
    """The examination without some control points, and codes of findings then gone.

    Where there is no high flight, without them among the approximate points as well.
    """
    try:
        again = examined.computed_again(without_given(examined.block, wrong))
        remaining = {found.code for found in findings_of(again, judges)}
    except EinschaltError:  # the rest does not determine the block
        return None, ()
    return again, tuple(code for code in codes if code not in remaining)


def with_other_targets(examined, judges, findings):
    """Put what follows from points that were measured elsewhere under these."""
    causes = [found for found in findings if found.code == OTHER_TARGETS]
    may_follow = [
        found.code
        for found in findings
        if can_follow(found) and found.code != OTHER_TARGETS
    ]
    others = None
    if causes:
        others = _without_points(examined, examined.other_targets)
    if others is None or causes[0].explained_by or not may_follow:
        return findings
    try:
        block, flights = others
        again = examined.computed_again(block, flights=flights)
        remaining = {found.code for found in findings_of(again, judges)}
    except EinschaltError:  # the rest does not hold together
        return findings
    explained = tuple(code for code in may_follow if code not in remaining)
    return with_consequences(causes[0], findings, explained)


def with_points_put_off(examined, judges, findings):
    """Put what is gone without displaced regions, and wrong points, under these."""
    causes = [found for found in findings if found.code in PUT_OFF]
    if not causes:
        return findings
    left = {found.code: found for found in findings_of(examined.corrected, judges)}
    explained = tuple(
        found.code
        for found in findings
        if can_follow(found) and found.code not in {*PUT_OFF, *left}
    )
    beside = tuple(
        _rejected_elsewhere_too(found, left[CLAIM])
        if found.code == CLAIM and CLAIM in left
        else found
        for found in findings
    )
    return with_consequences(causes[0], beside, explained)


def with_broken_network(examined, judges, findings):
    """Put what is gone where both parts of control lie alike under what parts them.

    Only where chance surely does not, and where nothing else is wrong with the network
    then: the other part may be off instead, but one of them is.
    """
    cause = next((found for found in findings if found.code == BROKEN), None)
    step = examined.network_step
    if cause is None or cause.explained_by or step is None:
        return findings
    if step.p_value > FINDING_SIGNIFICANCE or not is_small(examined.two_step):
        return findings
    try:
        region = region_of_step(examined.two_step, step)
        block = with_region_back(examined.block, region)
        again = examined.computed_again(block)
        remaining = {found.code for found in findings_of(again, judges)}
    except EinschaltError:  # the rest does not hold together
        return findings
    if remaining & OF_NETWORK:
        return findings
    explained = tuple(
        found.code
        for found in findings
        if can_follow(found) and found.code not in {BROKEN, *remaining}
    )
    return with_consequences(cause, findings, explained)


def _rejected_elsewhere_too(claim, left):
    """A claim that does not stand without the region either: by what is not of that.

    Errors that neighbours share are doubted only where residuals of neighbours are
    still alike.
    """
    quantities = {test["quantity"] for test in left.facts["rejected"]}
    tests = claim.facts["rejected"]
    tests = tuple(test for test in tests if test["quantity"] in quantities)
    if not tests:  # what the region has hidden
        return left
    kinds = {test["kind"] for test in left.facts["rejected"]}
    is_shared = left.remedy in SHARED and "correlation" not in kinds
    worst = min(tests, key=lambda test: test["p_value"])
    return replace(
        claim,
        statistic=worst["quantity"],
        observed=worst["observed"],
        expected=worst["predicted"],
        probability=worst["p_value"],
        remedy="doubt_sizes_of_errors" if is_shared else left.remedy,
        facts={**claim.facts, "rejected": tests},
    )


def _without_points(examined, targets):
    """A small block without the measurements of other targets, and its flights.

    Without those of the low flight where nothing tells which flight it is. None of
    large blocks, and of flights with orientations, whose errors belong to rows of
    measurements.
    """
    block, flights = examined.block, dict(examined.all_in_two_steps.solution.flights)
    if not is_small(examined.all_in_two_steps):
        return None
    for flight in (HIGH, LOW):
        names = [each.point_id for each in targets if (each.flight or LOW) == flight]
        measured = block.flights[flight]
        if names and measured.is_oriented_numerically:
            return None
        control = block.control_points
        if flight == HIGH:  # which is control of this flight
            control = control[~control["point_id"].isin(names)]
        others = {flight: _without(measured, names), "control_points": control}
        try:
            block = replace(block, **others)
        except EinschaltError:  # nothing is left of a model
            return None
        flights[flight] = _without(flights[flight], names)
    return block, flights


def _without(measured, names):
    """A flight, or its orientation, without some points."""
    points = measured.model_points
    if not names:
        return measured
    is_other = ~points["point_id"].isin(names)
    return replace(measured, model_points=points[is_other].reset_index(drop=True))


def _wrong_control(examined):
    """What control may be wrong, each by itself: sets of names; of small blocks.

    What patterns name; and the point that the others miss by most, since one that is
    far off bends the models around it, and is in no pattern then.
    """
    two_step = examined.two_step
    if not is_small(two_step):
        return []
    found = [examined.wrong_control] if examined.wrong_control else []
    left_out = two_step.control_left_out
    missed = np.hypot(left_out["difference_easting"], left_out["difference_northing"])
    if np.isfinite(missed).any():
        worst = frozenset([left_out["point_id"].iloc[int(np.nanargmax(missed))]])
        found += [worst] if worst not in found else []
    return found


def can_follow(found):
    """Whether a finding may be what another one makes."""
    is_free = not (found.explained_by or found.facts.get("explains"))
    return is_free and found.code not in NO_CONSEQUENCES


def is_small(two_step):
    """Whether a block is so small that it is computed once more."""
    return two_step.is_possible and two_step.is_small


def _snooped(examined):
    """What data snooping would take out of a small block that keeps everything."""
    two_step = examined.all_in_two_steps
    if examined.settings.outliers != "keep" or not is_small(two_step):
        return None
    flights = two_step.solution.flights
    return find_gross_measurements(examined.block, flights, _snooping(examined))


def _kept(examined, table):
    """Gross measurements that take part, the worst first; None without.

    Without those of models in which names are exchanged: these are told by themselves.
    """
    exchanged = pd.DataFrame(
        [(e.flight, e.coverage, e.model_id) for e in examined.exchanged_names],
        columns=list(OF_MODEL),
    )
    table = table[~rows_among(table, exchanged, list(OF_MODEL))]
    p_value = table["p_value"].to_numpy(dtype=float)
    n_tested = len(examined.residuals)
    if not any_significant(p_value, FINDING_SIGNIFICANCE, n_tested):
        return None
    return table.sort_values("p_value", kind="stable")


def _of_control_measured_once(examined, table):
    """Names of control points whose only measurement in the high flight is gross.

    Where others agree with the given coordinates, these are not wrong.
    """
    high = examined.all_in_two_steps.model_points.get(HIGH)
    if high is None:
        return np.empty(0, dtype=object)
    control = examined.block.control_points["point_id"]
    others = high["point_id"][high["point_id"].duplicated(keep=False)]
    names = table.loc[table["flight"] == HIGH, "point_id"]
    is_alone = is_among(names, control) & ~is_among(names, others)
    return names[is_alone].to_numpy(dtype=object)


def _is_confirmed(again, names):
    """Whether the low flight finds control points where they are given.

    Without their measurement in the high flight nothing has drawn it there: what was
    wrong then is the measurement.
    """
    two_step = again.all_in_two_steps
    if not len(names) or not two_step.is_possible:
        return not len(names)
    points = two_step.points.set_index("point_id").reindex(names)
    if TOTAL not in points:
        return False
    given = given_errors(two_step, names) ** 2 / 2.0
    variance = points[TOTAL] ** 2 / 2.0 + given
    squares = points["difference_easting"] ** 2 + points["difference_northing"] ** 2
    p_values = [np.exp(-squares / variance / 2.0)]
    if HEIGHT in points:
        variance = points[HEIGHT] ** 2 + given
        of_height = chdtrc(1, points["difference_height"] ** 2 / variance)
        # nothing is known where control has no height
        p_values.append(of_height.where(points["difference_height"].notna(), 1.0))
    n_tested = len(p_values) * len(names)
    return bool((np.stack(p_values) * n_tested > FINDING_SIGNIFICANCE).all())


def _snooping(examined):
    return examined.settings.updated({"outliers": "snoop"})


def _finding(two_step, gross, explained):
    undecided = undecided_points(two_step, gross)
    largest = largest_residual(gross)
    return finding(
        "kept_gross_measurements",
        names=gross["point_id"],
        statistic="residual",
        observed=largest,
        probability=gross["p_value"].iloc[0],
        remedy="measure_again_or_snoop",
        facts={
            "n_observations": len(gross),
            "observations": row_keys(gross, OBSERVATION),
            "largest": largest,
            "n_undecided": len(undecided),
            "undecided": undecided,
            "explains": tuple(found.code for found in explained),
        },
    )
