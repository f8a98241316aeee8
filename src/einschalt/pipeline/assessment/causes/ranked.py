"""Causes before consequences: what explains other findings is told first, and once.

A pair of exchanged names spoils residuals, coverage differences, control and every
figure of a block. Each of these is a finding; the pair explains them.
"""

from collections import Counter
from dataclasses import asdict, replace

from einschalt.pipeline.assessment.evidence.claim import KNOWN
from einschalt.pipeline.assessment.finding import Finding
from einschalt.pipeline.assessment.findings.kinds import MOST_NAMED, finding

MOST_EXCHANGES = 100
# what a gross error in a model makes of the points that it holds
OF_POINTS = {
    "suspect_observations",
    "gross_measurements",
    "coverages_that_differ",
    "points_that_differ",
    "control_that_contradicts",
    "control_against_block",
    "control_set_aside",
}
# and of a block as a whole
OF_BLOCK = {
    "adjustment_that_misfits",
    "claim_that_does_not_stand",
    "deformed_models",
    "lone_wrong_check_point",
    "check_points_beyond_claim",
    "control_points_beyond_claim",
    "contradicted_propagation",
    "contradicted_budget",
    "broken_network",
    "broken_heights",
    "heights_beyond_claim",
}
# and of the flight that the model belongs to
OF_FLIGHT = {"wrong_measuring_errors", "high_flight_that_misfits"}

# what a model whose corrections have another unit than its coordinates makes
OF_UNITS = OF_POINTS | OF_BLOCK | OF_FLIGHT
OF_UNITS |= {"corrections_that_spoil", "models_with_large_m_0", "contradicting_control"}

# what two names exchanged in a photograph make, of its models and of the block
OF_ORIENTATIONS = {
    "orientations_without_convergence",
    "orientations_with_large_sigma_0",
    "ambiguous_orientations",
}
OF_IMAGES = OF_UNITS | {
    "image_points_worse_than_given",
    "heavy_tails_of_image_points",
    "wrong_control_height",
    "points_in_one_coverage",
    "points_in_one_model",
    "strained_network",
}

# what copies make: sizes of errors, and tests that rest on them
OF_COPIES = {
    "wrong_measuring_errors",
    "coverages_that_agree_too_well",
    "strained_network",
    "broken_network",
    "contradicting_control",
}
# remedies where given approximate coordinates are not as independent as was assumed
SHARED = {
    "doubt_independence",
    "shared_errors_as_stated",
    "shared_errors_beyond_stated",
}
WHOLE_CAUSES = {
    "models_in_another_unit": OF_UNITS,
    "measurements_given_twice": OF_COPIES,
}


def with_causes(findings, exchanges, *, is_coupled) -> tuple[Finding, ...]:
    """Put causes before findings, and mark those that they explain: ``explained_by``.

    Where ``is_coupled``, every model reaches every point, as in one adjustment that
    keeps gross errors: consequences are then not bound to the points of the model.
    """
    findings = _with_mirrored_models(_with_exchanged_image_names(findings))
    findings = _with_lone_point(_with_whole_causes(findings))
    if not exchanges:
        return findings
    points = {point for exchange in exchanges for point in exchange.model_points}
    models = {(exchange.flight, exchange.model_id) for exchange in exchanges}
    marked = tuple(
        replace(each, explained_by="exchanged_names")
        if not each.explained_by
        and _follows(each, points, models, is_coupled=is_coupled)
        else each
        for each in findings
    )
    explained = tuple(f.code for f in marked if f.explained_by)
    return (_exchanged_names(exchanges, explained), *marked)


def ranked_causes(findings) -> tuple[str, ...]:
    """Codes of the findings that explain others, the one that explains most first.

    Of two that explain as much the graver one, which is told first.
    """
    explained = Counter(found.explained_by for found in findings if found.explained_by)
    causes = [found.code for found in findings if found.code in explained]
    return tuple(sorted(causes, key=lambda code: -explained[code]))


def with_consequences(cause, findings, explained, first=()):
    """Give findings, of which those of some codes follow from one of them.

    ``first`` are the names that make them: of those of the cause they are told first.
    """
    facts = {**cause.facts, "explains": explained}
    names = tuple(sorted(cause.names, key=lambda name: name not in first))
    return tuple(
        replace(cause, facts=facts, names=names)
        if found is cause
        else replace(found, explained_by=cause.code)
        if found.code in explained and not found.explained_by
        else found
        for found in findings
    )


def with_shared_errors(findings) -> tuple[Finding, ...]:
    """Put a budget that coverages exceed under errors that approximate points share.

    Models follow smooth errors each in its own way, so that coverages come apart; no
    measuring error makes residuals of neighbours alike, and a larger m_g mends nothing.
    """
    code = "claim_that_does_not_stand"
    cause = next((found for found in findings if found.code == code), None)
    if cause is None or cause.explained_by or cause.remedy not in SHARED:
        return findings
    kinds = {test["kind"] for test in cause.facts["rejected"]}
    explained = tuple(
        found.code
        for found in findings
        if found.code == "contradicted_budget" and not found.explained_by
    )
    if not kinds & {"correlation", "region"} or not explained:
        return findings
    return with_consequences(cause, findings, explained)


def _with_exchanged_image_names(findings):
    """Put what follows from names exchanged in photographs under these.

    Where data snooping has taken the points out, only what is said of these.
    """
    code = "exchanged_image_names"
    cause = next((found for found in findings if found.code == code), None)
    if cause is None:
        return findings
    models = {
        (each["flight"], model_id)
        for each in cause.facts["exchanges"]
        for _, model_id in each["models"]
    }
    reach = OF_IMAGES if cause.facts["takes_part"] else frozenset()
    explained = tuple(
        found.code
        for found in findings
        if found.code in reach or _is_of_orientations(found, models)
    )
    return with_consequences(cause, findings, explained)


def _with_mirrored_models(findings):
    """Put what models upside down make under these: heights and plan bend with them."""
    code = "models_upside_down"
    cause = next((found for found in findings if found.code == code), None)
    if cause is None:
        return findings
    explained = tuple(
        found.code
        for found in findings
        if found.code in OF_IMAGES and not found.explained_by
    )
    return with_consequences(cause, findings, explained)


def _is_of_orientations(found, models):
    """Whether a finding is about the orientations of these models only."""
    if found.code == "failed_models":
        return set(found.names) <= {model_id for _, model_id in models}
    if found.code == "image_points_that_contradict":
        named = {tuple(point[:2]) for point in found.facts["image_points"]}
        return named <= models
    if found.code in OF_ORIENTATIONS:
        return set(found.facts["models"]) <= models
    return False


def _with_whole_causes(findings):
    """Mark what causes make that reach the whole block, the first of them first."""
    for cause, consequences in WHOLE_CAUSES.items():
        if any(found.code == cause for found in findings):
            findings = [
                replace(found, explained_by=cause)
                if found.code in consequences and not found.explained_by
                else found
                for found in findings
            ]
    return tuple(findings)


def _with_lone_point(findings):
    """Mark what check points say against the claim where a single one makes it."""
    cause = "lone_wrong_check_point"
    if all(found.code != cause for found in findings):
        return findings
    return tuple(
        replace(found, explained_by=cause)
        if _is_of_check_points(found) and not found.explained_by
        else found
        for found in findings
    )


def _is_of_check_points(found):
    """Whether a finding rests on nothing else."""
    if found.code == "claim_that_does_not_stand":
        tests = {test["quantity"] for test in found.facts["rejected"]}
        return tests == {KNOWN["check"]}
    return found.code == "check_points_beyond_claim"


def _follows(found, points, models, *, is_coupled):
    if found.code in OF_BLOCK:
        return True
    if found.code == "models_with_large_m_0":
        return is_coupled or set(found.facts["models"]) <= models
    if found.code in OF_FLIGHT:
        return is_coupled or set(found.names) <= {flight for flight, _ in models}
    if found.code not in OF_POINTS:
        return False
    # a list that was cut says nothing of the names that it leaves out
    is_whole = len(found.names) < MOST_NAMED
    return is_coupled or (is_whole and set(found.names) <= points)


def _exchanged_names(exchanges, explained):
    worst = exchanges[0]
    return finding(
        "exchanged_names",
        names=worst.points[:MOST_NAMED],
        statistic="distance from where the other flight has the two points, as "
        "measured and with the names put right"
        if worst.is_by_other_flight
        else "m_0 of the model, as measured and with the names put right",
        observed=worst.m_0,
        expected=worst.m_0_exchanged,
        remedy="compare_names_of_both_flights"
        if worst.is_everywhere
        else "put_the_names_right",
        facts={
            "n_exchanges": len(exchanges),
            "exchanges": tuple(map(_facts, exchanges[:MOST_EXCHANGES])),
            "explains": explained,
        },
    )


def _facts(exchange):
    facts = asdict(exchange)
    del facts["model_points"]  # which may be many
    n_points = len(exchange.points)
    for name in ("points", "measured_as"):
        facts[name] = facts[name][:MOST_NAMED]
    return {**facts, "n_points": n_points, "last": exchange.points[-1]}
