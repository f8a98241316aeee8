"""Words for known points that do not agree, of findings made by hand."""

import pytest

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of

COMPARED = {"n_points": 6, "rms": 0.2, "claimed": 0.08, "ratio": 2.5}


@pytest.mark.parametrize(
    ("code", "remedy", "says"),
    [
        ("check_points_beyond_claim", "trust_check_points", "Rely on them"),
        ("check_points_better_than_claim", "give_smaller_errors", "too cautious"),
    ],
)
def test_check_points_beside_the_claim(code, remedy, says):
    found = Finding(code, Subject.BLOCK, remedy=remedy, facts=COMPARED)
    said = suggestion_of(found)
    assert said.problem == (
        "The differences at 6 check points are 20 cm (total, RMS), 2.5 times the "
        "expected 8.0 cm"
    )
    assert says in said.remedy


def test_the_three_worst_control_points_are_named():
    found = Finding(
        "control_points_beyond_claim",
        Subject.CONTROL,
        names=("d", "c", "b", "a"),
        remedy="look_for_wrong_control",
        facts=COMPARED,
    )
    said = suggestion_of(found)
    assert said.problem.endswith("the expected 8.0 cm; largest at d, c, b")


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
