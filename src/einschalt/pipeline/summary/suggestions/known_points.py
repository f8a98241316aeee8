"""What to say of known points that do not agree with the claimed figure."""

from einschalt.foundations.typesetting import count, factor, length, names
from einschalt.pipeline.summary.suggestion import Suggestion

MOST_NAMED = 3
REMEDIES = {
    "trust_check_points": (
        "Trust them more than the budget; part of it is their own error"
    ),
    "give_smaller_errors": (
        "The claim is too cautious: m_g_um or the standard errors given are large"
    ),
    "look_for_wrong_control": (
        "Look for wrong control points, or for strain in their network"
    ),
    "look_at_reference_system": (
        "Look at the reference system and the age of the given coordinates"
    ),
}


def check_points(finding):
    """Their differences beside the claim."""
    return Suggestion(_differences(finding, "check point"), REMEDIES[finding.remedy])


def control_points_beyond_claim(finding):
    """Their differences beside the claim, and where they are largest."""
    worst = names(finding.names[:MOST_NAMED])
    return Suggestion(
        f"{_differences(finding, 'control point')}; largest at {worst}",
        REMEDIES[finding.remedy],
    )


def _differences(finding, point):
    facts = finding.facts
    return (
        f"The differences at {count(facts['n_points'], point)} are "
        f"{length(facts['rms'])} (total, RMS), {factor(facts['ratio'])} the "
        f"{length(facts['claimed'])} claimed for them"
    )


def shifted_block(finding):
    """The mean difference."""
    facts = finding.facts
    points = count(facts["n_points"], f"{facts['role']} point")
    return Suggestion(
        f"The block is shifted: the mean difference at {points} is easting "
        f"{length(facts['easting'])}, northing {length(facts['northing'])}",
        REMEDIES[finding.remedy],
    )


WORDS = {
    "check_points_beyond_claim": check_points,
    "check_points_better_than_claim": check_points,
    "control_points_beyond_claim": control_points_beyond_claim,
    "shifted_block": shifted_block,
}
