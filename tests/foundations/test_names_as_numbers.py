"""Names of which a workbook has made numbers, and those of text files."""

import pytest

from einschalt.foundations.names_as_numbers import (
    made_or_typed,
    number_made_of,
    pair_made_or_typed,
    remedy,
    remedy_of_two,
)

TYPED, MADE = ["1.10", "2.10", "2.3"], ["1.1", "2.1", "2.3"]


@pytest.mark.parametrize(
    ("names", "others", "files", "found"),
    [
        (MADE, TYPED, ("a.xlsx", "b.csv"), {"1.1": "1.10", "2.1": "2.10"}),
        (TYPED, MADE, ("a.csv", "b.ods"), {"1.10": "1.1", "2.10": "2.1"}),
        (TYPED, MADE, ("a.csv", "b.csv"), {}),
        # the workbook has the zeros: none was lost
        (TYPED, MADE, ("a.xlsx", "b.csv"), {}),
        (MADE, TYPED, ("a.csv", "b.ods"), {}),
        (["1.1"], ["1.10", "1.100"], ("a.xlsx", "b.csv"), {}),
        (["7.1"], ["007.10"], ("a.xlsx", "b.csv"), {"7.1": "007.10"}),
        (["P1.1"], ["P1.10"], ("a.xlsx", "b.xlsx"), {}),
    ],
)
def test_only_a_workbook_makes_the_shorter_name(names, others, files, found):
    assert made_or_typed(names, others, files) == found


def test_a_pair_stands_for_many_names():
    files = "a.xlsx", "b.csv"
    assert pair_made_or_typed(["1.1", "8", "9"], ["1.10"], files) == ("1.1", "1.10")
    assert pair_made_or_typed(["1.1", "7", "8", "9"], ["1.10"], files) is None


@pytest.mark.parametrize(
    ("name", "made"),
    [
        ("007.10", "7.1"),
        ("0.50", "0.5"),
        ("000.5", "0.5"),
        ("10.0", "10"),
        ("07", "07"),
    ],
)
def test_a_number_keeps_no_zeros_at_either_end(name, made):
    assert number_made_of(name) == made


def test_remedies_name_the_points():
    assert remedy("1.20", "1.2") == remedy("1.2", "1.20")
    assert remedy("1.20", "1.2").startswith("A spreadsheet makes '1.2' of '1.20':")
    said = "If one of the two was '1.20', of which a spreadsheet makes '1.2':"
    assert remedy_of_two("1.2", "t.xlsx").startswith(said)
    assert remedy_of_two("1.2", "t.csv") is remedy_of_two("P2", "t.xlsx") is None
