"""What to say of known points that do not agree with the claimed figure."""

from einschalt.foundations.display_names import all_shortened
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import names
from einschalt.pipeline.summary.suggestion import filled

MOST_NAMED = 3
MOST_PLACES = 4
REMEDIES = mark_each(
    {
        "trust_check_points": (
            "Rely on them rather than on the budget; part of it is their own error"
        ),
        "check_far_points": (
            "Check the coordinates, names and measurements of those that are far off; "
            "if they are right, the block is as wrong there"
        ),
        "check_lone_point": (
            "Check its coordinates, its name and its measurements first; until then "
            "the block may be as wrong there"
        ),
        "correct_check_name": (
            "Their names are exchanged in all measurements, or the list gives the "
            "coordinates of the other one: correct it and compute again; until then "
            "the new point may be as wrong"
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
        "exchange_control_names": (
            "Exchange their names in the list of control, or in all measurements, "
            "whichever is wrong, and compute again"
        ),
        "put_control_names_right": (
            "Put their names right in the list of control, or in all measurements, "
            "whichever is wrong, and compute again"
        ),
        "correct_control_name": (
            "Their names are exchanged in all measurements, or the list of control "
            "gives the coordinates of the other one: correct it and compute again"
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
BEYOND = mark(
    "The differences at {n_points:count check point} are {rms:length} (total, RMS; "
    "median {median:length}), {ratio:factor} the expected {claimed:length}; largest at "
    "{worst} ({largest:length})"
)
SEVERAL_BEYOND = mark(
    "The differences at {n_points:count check point} are {rms:length} (total, RMS; "
    "median {median:length}), {ratio:factor} the expected {claimed:length}; far off "
    "are {worst} ({largest:length} at the first)"
)
LONE = mark(
    "Check point {point} differs by {largest:length}: without it the differences at "
    "{n_others:count check point} are {rms_of_others:length} (total, RMS), with it "
    "{rms:length}, expected {claimed:length}"
)
SUSPECT = mark(
    "Check point {worst} differs by {largest:length}, which its standard error does "
    "not explain; all check points together differ by {rms:length} (total, RMS), "
    "expected {claimed:length}"
)
SEVERAL_SUSPECT = mark(
    "Check points {worst} differ by up to {largest:length}, which their standard "
    "errors do not explain; all check points together differ by {rms:length} (total, "
    "RMS), expected {claimed:length}"
)
LONE_UNDER_ANOTHER_NAME = mark(
    "Check point {point} differs by {largest:length}, and new point {other} lies where "
    "it is given, {away:length} away: without it the differences at {n_others:count "
    "check point} are {rms_of_others:length} (total, RMS), with it {rms:length}, "
    "expected {claimed:length}"
)
EXCHANGED = mark(
    "Points {one} and {other} of the control list lie where the other one is given, "
    "{apart:length} apart: with both names exchanged the differences at control and "
    "check points are {rms_exchanged:length} (total, RMS) instead of {rms:length}"
)
EXCHANGED_MOVES = mark(
    "Points {one} and {other} of the control list lie where the other one is given, "
    "{apart:length} apart: with both names exchanged the differences at control and "
    "check points are {rms_exchanged:length} (total, RMS) instead of {rms:length}, and "
    "the new points move by {moved:length}"
)
NAMES_MIXED = mark(
    "{n_points:count point} of the control list lie where others of them are given, up "
    "to {apart:length} away ({places}): with the names put right the differences at "
    "control and check points are {rms_exchanged:length} (total, RMS) instead of "
    "{rms:length}"
)
NAMES_MIXED_MOVES = mark(
    "{n_points:count point} of the control list lie where others of them are given, up "
    "to {apart:length} away ({places}): with the names put right the differences at "
    "control and check points are {rms_exchanged:length} (total, RMS) instead of "
    "{rms:length}, and the new points move by {moved:length}"
)
PLACE = mark("{name} where {given} is given")
SLIPPED = mark(
    "names of the list have slipped by {n:row|rows}: {first} lies where {given} is "
    "given, and so on to {last}"
)
LOST = mark(
    "no coordinates of {lost} are given, and those of {nameless} are of another point"
)
UNDER_ANOTHER_NAME = mark(
    "Control point {control} lies {miss:length} from where it is given, and new point "
    "{other} lies there, {away:length} away"
)
SEVERAL_UNDER_ANOTHER_NAME = mark(
    "{n_points:count control point} lie elsewhere than given, and new points lie "
    "there: {control} is {miss:length} off, and {other} {away:length} from it"
)
OF_CONTROL = mark(
    "The differences at {n_points:count control point} are {rms:length} (total, RMS), "
    "{ratio:factor} the expected {claimed:length}; largest at {worst}"
)
FAR_CONTROL = mark(
    "The differences at {n_points:count control point} are {rms:length} (total, RMS), "
    "{ratio:factor} the expected {claimed:length}; far off: {worst}; of the others "
    "they are {rms_of_others:length}"
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


def check_points_beyond_claim(finding):
    """Their differences beside the claim, and those that are far off."""
    n_far = finding.facts["n_far"]
    if n_far < 2:
        return filled(BEYOND, finding, worst=names(finding.names[:1]))
    return filled(SEVERAL_BEYOND, finding, worst=names(finding.names[:n_far]))


def suspect_check_points(finding):
    """Which they are, beside what all of them say."""
    n_points = finding.facts["n_points"]
    words = SUSPECT if n_points == 1 else SEVERAL_SUSPECT
    return filled(words, finding, worst=names(finding.names, n_all=n_points))


def control_under_another_name(finding):
    """The first pair of points, and how many more there are."""
    control, other = (names([name]) for name in finding.names[:2])
    message = UNDER_ANOTHER_NAME
    if finding.facts["n_points"] > 1:
        message = SEVERAL_UNDER_ANOTHER_NAME
    return filled(message, finding, control=control, other=other)


def exchanged_control(finding):
    """Which they are, and what is gone with their names put right."""
    moves = finding.facts["moved"] > 0.0
    if finding.facts["n_points"] == 2:
        one, other = all_shortened(finding.names)
        words = EXCHANGED_MOVES if moves else EXCHANGED
        return filled(words, finding, one=one, other=other)
    words = NAMES_MIXED_MOVES if moves else NAMES_MIXED
    return filled(words, finding, places=_places(finding))


def _places(finding):
    """Where the first of some points lie, and how many more there are."""
    facts, told = finding.facts, []
    places = zip(finding.names, facts["given_as"], strict=False)
    whole = [name for pair in places for name in pair]
    *short, last = all_shortened([*whole, facts["last"]])
    pairs = list(zip(short[::2], short[1::2], strict=True))
    n_more = facts["n_points"] - MOST_PLACES
    if facts["slipped_rows"]:
        first, given = pairs[0]
        slip = {"first": first, "given": given, "last": last}
        told.append(translated(SLIPPED, n=facts["slipped_rows"], **slip))
    else:
        told += [
            translated(PLACE, name=name, given=given)
            for name, given in pairs[:MOST_PLACES]
        ]
        if n_more > 0:
            told.append(translated("and {n:further point|further points}", n=n_more))
    if facts["lost"]:
        lost, nameless = all_shortened([facts["lost"], facts["nameless"]])
        told.append(translated(LOST, lost=lost, nameless=nameless))
    return "; ".join(told)


def lone_wrong_check_point(finding):
    """Which check point it is, what lies where it is given, and what the others say."""
    if len(finding.names) == 1:
        return filled(LONE, finding, point=names(finding.names))
    point, other = all_shortened(finding.names)
    return filled(LONE_UNDER_ANOTHER_NAME, finding, point=point, other=other)


def control_points_beyond_claim(finding):
    """Their differences beside the claim, and those that are far off or largest."""
    n_far = finding.facts["n_far"]
    if n_far:
        return filled(FAR_CONTROL, finding, worst=names(finding.names[:n_far]))
    return filled(OF_CONTROL, finding, worst=names(finding.names[:MOST_NAMED]))


def shifted_block(finding):
    """The mean difference."""
    return filled(SHIFTS[finding.facts["role"]], finding)


WORDS = {
    "check_points_beyond_claim": check_points_beyond_claim,
    "lone_wrong_check_point": lone_wrong_check_point,
    "suspect_check_points": suspect_check_points,
    "control_under_another_name": control_under_another_name,
    "exchanged_control": exchanged_control,
    "check_points_better_than_claim": OF_CHECK,
    "control_points_beyond_claim": control_points_beyond_claim,
    "shifted_block": shifted_block,
}
