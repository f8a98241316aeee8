"""Names on one line."""

import pytest

from einschalt.foundations.display_names import printable, shortened


def test_long_names_keep_both_ends():
    short = shortened("x" * 50 + "0001", 12)
    assert len(short) == 12
    assert short.endswith("0001")


@pytest.mark.parametrize("char", ["\n", "\r", "\x1b", "\u202e", "\u2028", "\x00"])
def test_names_cannot_break_lines_or_steer_a_terminal(char):
    assert char not in printable(f"a{char}b")
