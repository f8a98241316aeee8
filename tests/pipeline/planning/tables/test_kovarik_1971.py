"""The printed numbers of 1971 beside ours."""

import numpy as np
import pytest

from einschalt.pipeline.planning.tables.kovarik_1971 import (
    compare_conclusions,
    compare_with_print,
)

# an independent computation with twice the middle on 138 x 161 mm
# (statement, printed, ours)
EXPECTED = [
    ("diagram 1", 0.18, 0.1826),
    ("1:6000, 200 m, m_0 10", 5.0, 4.47),
    ("1:6000, 300 m", 7.0, 6.71),
    ("1:6000, 400 m, m_0 20", 16.0, 17.9),
    ("1:12000, 200 m", 2.0, 2.24),
    ("1:12000, 300 m", 3.0, 3.35),
    ("1:12000, 400 m", 9.0, 8.95),
    ("4a: M, 1:6000, 200 m, middle", 6.0, 6.40),
    ("4a: M, 1:6000, 200 m, edge", 8.0, 7.48),
    ("4a: M, 1:6000, 200 m, mean", 5.0, 4.92),
    ("4d", 10.0, 8.71),
    ("footnote 4: plan", 0.02, 0.018),
    ("footnote 4: the same", 0.01, 0.0072),
    ("diagram 4c (1:7500, 300 m): middle", 5.0, 4.61),
    ("diagram 4c (1:7500, 300 m): edge", 7.0, 6.55),
    ("at 1:8000: mean of two coverages", 4.5, 3.89),
]
OUTSIDE = [16.0, 10.0, 4.5, 5.0, 8.0]


@pytest.fixture(scope="module")
def compared():
    return compare_with_print()


@pytest.mark.parametrize(("statement", "printed", "ours"), EXPECTED)
def test_each_number_beside_an_independent_computation(
    statement, printed, ours, compared
):
    (row,) = compared[
        compared["where"].str.contains(statement, regex=False)
    ].itertuples()
    assert row.printed == printed
    # the last digit of the independent figure
    assert row.ours == pytest.approx(ours, rel=4e-3)
    assert row.difference == pytest.approx(row.ours - row.printed)


def test_what_leaves_the_print_is_said_with_the_reason(compared):
    outside = compared[compared["outside"] > 0]
    assert sorted(outside["printed"]) == sorted(OUTSIDE)
    assert (outside["why"].str.len() > 40).all()
    assert (compared.loc[compared["outside"] == 0, "why"] == "").all()
    by_size = outside.sort_values("outside")["printed"]
    assert by_size.iloc[-1] == 16.0
    # all others are marginal
    assert outside["outside"].to_numpy()[outside["printed"] != 16].max() < 0.4


def test_limits_hold_the_printed_number(compared):
    assert (compared["low"] <= compared["printed"]).all()
    assert (compared["printed"] <= compared["high"]).all()


def test_the_paper_contradicts_itself_under_every_rule(compared):
    ours = compared.set_index("where")["ours"]
    at_6000 = ours[ours.index.str.contains("1:6000, 400 m, m_0 20")].item()
    at_12000 = ours[ours.index.str.contains("1:12000, 400 m, m_0 20")].item()
    np.testing.assert_allclose(at_6000, 2 * at_12000)


def test_conclusions_hold():
    conclusions = compare_conclusions()
    assert len(conclusions) == 5
    assert conclusions["holds"].all()
