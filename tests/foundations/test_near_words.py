"""Names that may be meant by others: what parts numbers, and chance, are no slips."""

import pytest

from einschalt.foundations.near_words import names_meant, pair_meant


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


@pytest.mark.parametrize(
    ("strange", "name"),
    [
        ("1001.0", "1001"),
        ("1001,00", "1001"),
        ("Mu\u0308hle 7", "M\u00fchle 7"),
        ("\u0410\u0415 7", "AE 7"),
        ("a\u03a1 7", "ap 7"),
        ("TP\u00a07", "TP 7"),
    ],
)
def test_names_are_the_same_however_programs_write_them(strange, name):
    assert names_meant([strange], ["x"], [name, "8"]) == {strange: name}


def test_a_pair_is_told_where_most_names_have_one():
    names = [str(number) for number in range(1001, 1041)]
    assert pair_meant([f"0{name}" for name in names], names) == ("01001", "1001")
    assert pair_meant(["01001", "7", "8", "9"], names) is None
    # numbers without gaps turn into others when letters are exchanged
    assert pair_meant(["1102", "1203", "1304"], ["1012", "1023", "1034"]) is None


def test_blanks_between_digits_of_many_names_part_nothing():
    strange, others = ["10 01", "10 02", "10 03"], ["1001", "1002", "1003"]
    assert names_meant(strange, [], others) == dict(zip(strange, others, strict=True))
    assert names_meant(strange[:1], ["7"], others) == {}
    assert names_meant(["1 001"], ["7"], others) == {"1 001": "1001"}
    assert pair_meant(strange, others) == ("10 01", "1001")
    # of two that fit none is meant
    assert names_meant(["1 001"], [], ["1001", "01001"]) == {}


def test_zeros_that_end_decimals_make_another_name():
    """Stations have points 1.1 to 1.10; only a workbook makes one name of them."""
    assert pair_meant(["1.1", "2.1", "3.1"], ["1.10", "2.10"]) is None
    assert names_meant(["1.20", "1.10"], ["2.1"], ["1.1", "1.2"]) == {}
    assert names_meant(["10"], ["x"], ["100"]) == {}
