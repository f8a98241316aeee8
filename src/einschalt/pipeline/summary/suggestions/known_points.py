"""What to say of known points that do not agree with the claimed figure."""

from einschalt.foundations.typesetting import names
from einschalt.pipeline.summary.suggestion import filled

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
DIFFERENCES = (
    "The differences at {{n_points:count {} point}} are {{rms:length}} (total, RMS), "
    "{{ratio:factor}} the {{claimed:length}} claimed for them"
)


def control_points_beyond_claim(finding):
    """Their differences beside the claim, and where they are largest."""
    differences = filled(DIFFERENCES.format("control"), finding)
    return f"{differences}; largest at {names(finding.names[:MOST_NAMED])}"


def shifted_block(finding):
    """The mean difference."""
    role = finding.facts["role"]
    return filled(
        f"The block is shifted: the mean difference at {{n_points:count {role} point}} "
        "is easting {easting:length}, northing {northing:length}",
        finding,
    )


WORDS = {
    "check_points_beyond_claim": DIFFERENCES.format("check"),
    "check_points_better_than_claim": DIFFERENCES.format("check"),
    "control_points_beyond_claim": control_points_beyond_claim,
    "shifted_block": shifted_block,
}
