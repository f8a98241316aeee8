"""Names on one line."""

import pytest

from einschalt.foundations.display_names import all_shortened, printable, shortened


def test_long_names_keep_both_ends():
    short = shortened("x" * 50 + "0001", 12)
    assert len(short) == 12
    assert short.endswith("0001")


@pytest.mark.parametrize("char", ["\n", "\r", "\x1b", "\u202e", "\u2028", "\x00"])
def test_names_cannot_break_lines_or_steer_a_terminal(char):
    assert char not in printable(f"a{char}b")


LONG = "DJI_20240501103012_{:04d}_V_DJI_20240501103017_{:04d}_V"


@pytest.mark.parametrize("width", [16, 20, 40])
@pytest.mark.parametrize(
    "names",
    [
        [f"Baulos_Nord_2024_Streifen_{n:02d}_Modell_links_Mitte" for n in range(20)],
        [LONG.format(n, 8) for n in range(30)],
        [LONG.format(n, n + 1) for n in range(3)],
        ["A" * 50 + "1" + "B" * 50, "A" * 50 + "B" * 50, "A" * 50 + "1", "A…B"],
        [f"{left}{'x' * 60}{right}" for left in "ab" for right in "cd"],
    ],
)
def test_names_beside_each_other_stay_different(names, width):
    short = all_shortened(names, width)
    assert len(set(short)) == len(names)


def test_what_differs_is_kept_within_the_width():
    names = [f"Baulos_Nord_2024_Streifen_{n:02d}_Modell_links" for n in (7, 8)]
    assert len({shortened(name, 20) for name in names}) == 1
    short = all_shortened(names, 20)
    assert max(map(len, short)) <= 20
    assert "7" in short[0]
    assert "8" in short[1]


def test_names_that_are_told_apart_by_their_ends_are_shortened_as_alone():
    names = ["Hauptdreieckspunkt_0001", "Hauptdreieckspunkt_0002", "7"]
    assert all_shortened(names, 12) == [shortened(name, 12) for name in names]


def test_a_name_that_stands_twice_stays_one():
    assert all_shortened(["x" * 50] * 2, 12) == ["xxxxxx…xxxxx"] * 2
