import numpy as np
import pytest

from einschalt.foundations.value_ranges import Range


@pytest.mark.parametrize("value", [0, 0.5, 1, np.float64(1.0), np.int64(0)])
def test_range_takes_numbers_within_it(value):
    assert value in Range(0, 1)


@pytest.mark.parametrize(
    "value", [-0.1, 1.1, np.nan, np.inf, True, "1", None, np.array([0.5])]
)
def test_range_refuses_what_is_no_number_within_it(value):
    assert value not in Range(0, 1)


def test_whole_range_takes_whole_numbers_only():
    assert 2.0 in Range(0, 9, is_whole=True)
    assert 2.5 not in Range(0, 9, is_whole=True)


def test_range_reads_as_it_stands_in_a_message():
    assert str(Range(1, 4, is_whole=True)) == "a whole number, 1 to 4"
    assert str(Range(0.1, 1000, "metres")) == "0.1 to 1000 metres"
