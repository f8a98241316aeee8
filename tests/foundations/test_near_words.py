"""Names that may be meant by others: what parts numbers, and chance, are no slips."""

import pytest

from einschalt.foundations.near_words import names_meant


@pytest.mark.parametrize("strange", ["P7", "p-7", "P 7", "P.007", "p_07"])
def test_separators_beside_letters_carry_no_meaning(strange):
    assert names_meant([strange], ["x"], ["P/7"]) == {strange: "P/7"}


def test_separators_between_digits_part_numbers():
    right = ["1-1", "1-2", "2-1"]
    assert names_meant(["1-12"], right, ["11-2"]) == {}
    assert names_meant(["112"], right, ["11-2"]) == {}
    assert names_meant(["1/012"], right, ["1-12"]) == {"1/012": "1-12"}


def test_none_is_meant_where_several_fit():
    assert names_meant(["P 07"], ["x"], ["P7", "p-7"]) == {}
    assert names_meant(["1234"], ["x"], ["2134", "1324"]) == {}
    assert names_meant(["A12", "P 07"], ["x"], ["a12", "P7", "p7"]) == {"A12": "a12"}


def test_signs_alone_are_no_name():
    assert names_meant(["--"], ["x"], [".."]) == {}
