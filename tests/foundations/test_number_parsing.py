"""Texts that should be numbers."""

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.number_parsing import describe_fault, is_number

MEND = "Give a value or delete the row"


@pytest.mark.parametrize(
    ("value", "found", "remedy"),
    [
        ("", "is missing", MEND),
        (None, "is missing", MEND),
        (np.nan, "is missing", MEND),
        (pd.NA, "is missing", MEND),
        (pd.NaT, "is missing", MEND),
        (" NaN ", "'NaN' is missing", MEND),
        ("-Infinity", "'-Infinity' is infinite", MEND),
        (np.inf, "'inf' is infinite", MEND),
        ("1e999", "'1e999' is too large", MEND),
        ("abc", "'abc' is not a number", MEND),
        ("1_000", "'1_000' has separators of thousands", "Write 1000"),
        (True, "'True' is not a number", MEND),
        ("12.5 m", "'12.5 m' is not a number", MEND),
        ("\u0663", "'\u0663' is not a number", MEND),
        ("1.2.3", "'1.2.3' is not a number", MEND),
        ("1,2,3", "'1,2,3' is not a number", MEND),
        ("1,5", "'1,5' has a decimal comma", "Write 1.5"),
        ("-0,25", "'-0,25' has a decimal comma", "Write -0.25"),
        ("1,5e3", "'1,5e3' has a decimal comma", "Write 1.5e3"),
        ("1234,567", "'1234,567' has a decimal comma", "Write 1234.567"),
        (
            "12,345",
            "'12,345' has a comma",
            "Write 12.345, or 12345 where the comma separates thousands",
        ),
        ("12,345.6", "'12,345.6' has separators of thousands", "Write 12345.6"),
        ("1,234,567", "'1,234,567' has separators of thousands", "Write 1234567"),
        ("12.345,6", "'12.345,6' has separators of thousands", "Write 12345.6"),
        ("5.212.345", "'5.212.345' has separators of thousands", "Write 5212345"),
        ("12 345.6", "'12 345.6' has separators of thousands", "Write 12345.6"),
        ("12\u202f345,6", "'12\\u202f345,6' has separators", "Write 12345.6"),
        ("12\u2019345.6", "'12\u2019345.6' has separators", "Write 12345.6"),
    ],
)
def test_fault_and_remedy(value, found, remedy):
    said, expected, mend = describe_fault(value, "metres")
    assert said.startswith(found)
    assert (expected, mend) == ("metres", remedy)


def test_positive_numbers():
    assert describe_fault("-1", "metres", is_positive=True) == (
        "'-1' is not above 0",
        "metres, above 0",
        MEND,
    )


@pytest.mark.parametrize("text", ["1", "-1.5", "+2e-3", " 4 ", ".5"])
def test_numbers(text):
    assert is_number(text)


@pytest.mark.parametrize("text", ["", "1_000", "0x10", "1,5", "one", "1 000"])
def test_other_texts(text):
    assert not is_number(text)


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("48°12'30\"", "48.2083333333"),
        ("13°22'54.58181\"", "13.3818282806"),
        ("N 48° 12′ 30,0″", "48.2083333333"),
        ("73° 30.0' W", "-73.5"),
        ("-0°30'0''", "-0.5"),
    ],
)
def test_degrees_and_minutes_are_told_with_what_to_write(text, plain):
    said, expected, mend = describe_fault(text, "degrees")
    assert (said, expected) == (f"{text!r} has degrees and minutes", "degrees")
    assert mend == f"Write {plain}"
    assert "call the columns longitude" in describe_fault(text, "metres")[2]


# O is Ost, and Ouest
@pytest.mark.parametrize(
    "text", ["12'30", "48°", '1°2"', "4812'30\"", "16°30'O", "x48°12'"]
)
def test_other_signs_are_no_degrees_and_minutes(text):
    assert "degrees and" not in describe_fault(text, "degrees")[0]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("2023/08/08", "'2023/08/08' is a date or a time, and no number"),
        ("2023-08-08 07:30:00", "'2023-08-08 07:30:00' is a date or a time, and no"),
        ("08:07:00", "'08:07:00' is a date or a time, and no number"),
        # of a spreadsheet, which has no day for it
        ("1899/12/30 08:07:00", "is a time of day, and no number"),
        ("1899/12/30", "is a time of day, and no number"),
    ],
)
def test_dates_and_times_are_told(text, found):
    said = describe_fault(text, "metres")
    assert said[0].startswith(found)
    assert said[2].startswith("Give the value as a number")
