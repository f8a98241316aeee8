"""Words for known points that do not agree, of findings made by hand."""

from einschalt.foundations.language import written_in
from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of

COMPARED = {"n_points": 6, "rms": 0.2, "claimed": 0.08, "ratio": 2.5}


def test_check_points_better_than_the_claim():
    code, remedy = "check_points_better_than_claim", "give_smaller_errors"
    found = Finding(code, Subject.BLOCK, remedy=remedy, facts=COMPARED)
    said = suggestion_of(found)
    assert said.problem == (
        "The differences at 6 check points are 20 cm (total, RMS), 2.5 times the "
        "expected 8.0 cm"
    )
    assert "too cautious" in said.remedy


def test_check_points_beyond_the_claim_have_a_median_and_a_worst():
    found = Finding(
        "check_points_beyond_claim",
        Subject.BLOCK,
        names=("d", "c"),
        remedy="trust_check_points",
        facts={**COMPARED, "median": 0.05, "largest": 0.47, "n_far": 0},
    )
    said = suggestion_of(found)
    assert said.problem == (
        "The differences at 6 check points are 20 cm (total, RMS; median 5.0 cm), 2.5 "
        "times the expected 8.0 cm; largest at d (47 cm)"
    )
    assert "Rely on them" in said.remedy


def test_all_check_points_that_are_far_off_are_named_and_none_is_relied_on():
    found = Finding(
        "check_points_beyond_claim",
        Subject.BLOCK,
        names=("d", "c", "b", "a"),
        remedy="check_far_points",
        facts={**COMPARED, "median": 0.05, "largest": 0.47, "n_far": 2},
    )
    said = suggestion_of(found)
    assert said.problem.endswith("; far off are d, c (47 cm at the first)")
    assert said.remedy.startswith("Check the coordinates, names and measurements of")
    with written_in("de"):
        said = suggestion_of(found)
    assert said.problem.endswith("weit ab liegen d, c (47 cm beim ersten)")


def test_a_lone_check_point_is_named_with_and_without():
    facts = {"largest": 1.02, "rms": 0.29, "n_others": 11, "rms_of_others": 0.07}
    found = Finding(
        "lone_wrong_check_point",
        Subject.POINT,
        names=("1166",),
        remedy="check_lone_point",
        facts={**facts, "n_points": 12, "claimed": 0.06},
    )
    said = suggestion_of(found)
    assert said.problem == (
        "Check point 1166 differs by 1.0 m: without it the differences at 11 check "
        "points are 7.0 cm (total, RMS), with it 29 cm, expected 6.0 cm"
    )
    assert "the block may be as wrong there" in said.remedy


def test_the_three_worst_control_points_are_named():
    found = Finding(
        "control_points_beyond_claim",
        Subject.CONTROL,
        names=("d", "c", "b", "a"),
        remedy="look_for_wrong_control",
        facts={**COMPARED, "n_far": 0, "rms_of_others": 0.2},
    )
    said = suggestion_of(found)
    assert said.problem.endswith("the expected 8.0 cm; largest at d, c, b")


def test_control_points_far_off_are_named_with_what_the_others_say():
    found = Finding(
        "control_points_beyond_claim",
        Subject.CONTROL,
        names=("d", "c", "b", "a"),
        remedy="check_far_points",
        facts={**COMPARED, "n_far": 1, "rms_of_others": 0.07},
    )
    said = suggestion_of(found)
    assert said.problem.endswith(
        "the expected 8.0 cm; far off: d; of the others they are 7.0 cm"
    )


def test_a_shift_has_a_direction():
    facts = {"role": "check", "n_points": 6, "easting": 0.02, "northing": -0.5}
    found = Finding(
        "shifted_block",
        Subject.BLOCK,
        remedy="look_at_reference_system",
        facts=facts,
    )
    assert str(suggestion_of(found)) == (
        "The block is shifted: the mean difference at 6 check points is easting "
        "2.0 cm, northing -50 cm. Check the reference system and the epoch of the "
        "given coordinates."
    )
