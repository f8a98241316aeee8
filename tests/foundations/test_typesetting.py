"""Numbers, lengths, names and tables as text."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from einschalt.foundations import typesetting as ts

SENSIBLE = st.floats(1e-4, 1e5)


@pytest.mark.parametrize(
    ("value", "error", "expected"),
    [
        # Particle Data Group, Review of Particle Physics, section 5.3 of the
        # introduction, but always two digits of the error
        (0.827, 0.119, ("0.83", "0.12")),
        (0.827, 0.367, ("0.83", "0.37")),
        (5326127.48213, 0.0371, ("5326127.482", "0.037")),
        (12.3456, 0.0996, ("12.35", "0.10")),
        (12.3456, 0.996, ("12.3", "1.0")),
        (-0.0001, 0.12, ("0.00", "0.12")),
        (123456.0, 2345.0, ("123500", "2300")),
    ],
)
def test_round_by_error_keeps_two_digits_of_the_error(value, error, expected):
    assert ts.round_by_error(value, error) == expected


@pytest.mark.parametrize("error", [0.0, -1.0, math.nan, math.inf, None])
def test_round_by_error_without_an_error_keeps_six_digits(error):
    assert ts.round_by_error(3.14159265, error) == ("3.14159", "–")


@given(SENSIBLE, SENSIBLE)
def test_rounding_stays_within_half_a_unit_of_the_second_digit(value, error):
    rounded = ts.round_by_error(value, error)
    half_unit = 0.5 * 10.0 ** -ts.decimals_for(error)
    assert abs(float(rounded.value) - value) <= half_unit * (1.0 + 1e-9)
    # at 9.95 the unit of the rounded error is ten times that of its digits
    assert abs(float(rounded.error) - error) <= 0.051 * error


@pytest.mark.parametrize(
    ("metres", "expected"),
    [
        (0.0371, "3.7 cm"),
        (0.00996, "1.0 cm"),
        (0.0042, "4.2 mm"),
        (0.00042, "0.42 mm"),
        (0.0000042, "4.2 µm"),
        (0.996, "1.0 m"),
        (0.154, "15 cm"),
        (-0.0371, "-3.7 cm"),
        (152.0, "150 m"),
        (12_000.0, "12 km"),
        (0.0, "0"),
        (math.nan, "–"),
        (math.inf, "–"),
        (None, "–"),
    ],
)
def test_length_takes_the_unit_that_suits(metres, expected):
    assert ts.length(metres) == expected


@given(st.floats(1e-6, 1e6))
def test_length_can_be_read_back_to_two_digits(metres):
    text, unit = ts.length(metres).split(" ")
    per = {"µm": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3}[unit]
    assert float(text) * per == pytest.approx(metres, rel=0.0501)


def test_lengths_of_a_column_share_unit_and_decimals():
    assert ts.lengths([0.052, 0.0428, math.nan]) == ["5.2 cm", "4.3 cm", "–"]
    assert ts.lengths([0.0, 0.0042]) == ["0.0 mm", "4.2 mm"]


def test_a_column_in_metres_goes_to_millimetres():
    assert ts.length_column([272.0, 0.0421]) == ("m", ["272.000", "0.042"])
    assert ts.length_column([3.0, 1e-6]) == ("m", ["3.000", "0.000"])


def test_a_few_small_lengths_do_not_add_decimals_to_a_long_column():
    unit, texts = ts.length_column([0.1, 0.052, 0.043, 0.038, 0.0007])
    assert (unit, texts) == ("cm", ["10.0", "5.2", "4.3", "3.8", "0.1"])


@pytest.mark.parametrize("metres", [[], [math.nan], [0.0, math.nan]])
def test_a_column_without_lengths_does_not_fail(metres):
    assert len(ts.lengths(metres)) == len(metres)


def test_numbers_and_ratios():
    assert ts.number(152.4) == "150"
    assert ts.number(math.nan) == "–"
    assert ts.factor(1.469) == "1.5 times"
    assert ts.scale(8000.0) == "1:8000"


@pytest.mark.parametrize(
    ("duration", "expected"),
    [
        (0.0432, "0.043 s"),
        (12.3, "12 s"),
        (59.99, "1 min 0 s"),
        (75.0, "1 min 15 s"),
        (3599.8, "60 min 0 s"),
    ],
)
def test_durations(duration, expected):
    assert ts.seconds(duration) == expected


def test_counts_know_their_plural():
    assert ts.count(0, "point") == "0 points"
    assert ts.count(1, "point") == "1 point"
    assert ts.count(2, "axis", "axes") == "2 axes"
    assert ts.number_word(2) == "two"
    assert ts.number_word(13) == "13"


def test_long_lists_of_names_say_how_many_more_there_are():
    ids = [f"{k}" for k in range(12)]
    assert ts.names(ids) == "0, 1, 2, 3, 4 and 7 more"
    assert ts.names(ids[:5]) == "0, 1, 2, 3, 4"
    assert ts.names([]) == ""


def test_columns_of_a_table_are_aligned():
    text = ts.table([["high", "1:15000"], ["low", "1:8000"]], header=["", "scale"])
    lines = text.split("\n")
    assert len({len(line) for line in lines}) == 1
    assert not any(line.endswith(" ") for line in lines)


def test_wide_characters_count_twice():
    text = ts.table([["東京", "1"], ["abcd", "2"], ["e\u0301bcd", "3"]])
    assert text.split("\n") == ["  東京  1", "  abcd  2", "  e\u0301bcd  3"]


def test_a_ragged_table_is_a_fault_of_the_program():
    with pytest.raises(ValueError, match="shorter than"):
        ts.table([["a", "b"], ["c"]])


def test_a_table_without_rows_is_empty():
    assert ts.table([]) == ""


def test_wrapping_never_breaks_names():
    name = "x" * 120
    text = ts.wrapped(f"a {name} b", first="  - ", indent="    ", width=40)
    assert name in text
    assert text.startswith("  - a")
