"""What to say of known points that do not agree with the claimed figure."""

from einschalt.foundations.language import mark, mark_each
from einschalt.foundations.typesetting import names
from einschalt.pipeline.summary.suggestion import filled

MOST_NAMED = 3
REMEDIES = mark_each(
    {
        "trust_check_points": (
            "Rely on them rather than on the budget; part of it is their own error"
        ),
        "give_smaller_errors": (
            "The stated precision is too cautious: m_g_um or the stated standard "
            "errors are too large"
        ),
        "look_for_wrong_control": (
            "Look for wrong control points, or for strain in their network"
        ),
        "state_control_errors": (
            "State standard_error_m of the control points: no errors of their own are "
            "expected so far"
        ),
        "look_at_reference_system": (
            "Check the reference system and the epoch of the given coordinates"
        ),
    }
)
OF_CHECK = mark(
    "The differences at {n_points:count check point} are {rms:length} (total, RMS), "
    "{ratio:factor} the expected {claimed:length}"
)
OF_CONTROL = mark(
    "The differences at {n_points:count control point} are {rms:length} (total, RMS), "
    "{ratio:factor} the expected {claimed:length}; largest at {worst}"
)
SHIFTS = mark_each(
    {
        "check": (
            "The block is shifted: the mean difference at {n_points:count check point} "
            "is easting {easting:length}, northing {northing:length}"
        ),
        "control": (
            "The block is shifted: the mean difference at {n_points:count control "
            "point} is easting {easting:length}, northing {northing:length}"
        ),
    }
)


def control_points_beyond_claim(finding):
    """Their differences beside the claim, and where they are largest."""
    return filled(OF_CONTROL, finding, worst=names(finding.names[:MOST_NAMED]))


def shifted_block(finding):
    """The mean difference."""
    return filled(SHIFTS[finding.facts["role"]], finding)


WORDS = {
    "check_points_beyond_claim": OF_CHECK,
    "check_points_better_than_claim": OF_CHECK,
    "control_points_beyond_claim": control_points_beyond_claim,
    "shifted_block": shifted_block,
}
