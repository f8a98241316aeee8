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
        ("1.2.3", "'1.2.3' is not a number", MEND),
        ("1,2,3", "'1,2,3' is not a number", MEND),
        ("1,5", "'1,5' has a decimal comma", "Write 1.5"),
        ("-0,25", "'-0,25' has a decimal comma", "Write -0.25"),
        ("1,5e3", "'1,5e3' has a decimal comma", "Write 1.5e3"),
        ("1234,567", "'1234,567' has a decimal comma", "Write 1234.567"),
        (
            "12,345",
            "'12,345' has a comma",
            "Write 12.345, or 12345 where the comma parts thousands",
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
        "'-1' is not positive",
        "positive metres",
        MEND,
    )


@pytest.mark.parametrize("text", ["1", "-1.5", "+2e-3", " 4 ", ".5"])
def test_numbers(text):
    assert is_number(text)


@pytest.mark.parametrize("text", ["", "1_000", "0x10", "1,5", "one", "1 000"])
def test_other_texts(text):
    assert not is_number(text)
