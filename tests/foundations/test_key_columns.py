"""Names compared and coded by columns."""

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations import key_columns
from einschalt.foundations.key_columns import is_among, row_codes

COLUMN = ["0012", "7/8", "12", "7/8", "Ö"]


@pytest.mark.parametrize(
    "kind", [list, np.array, pd.Series, pd.Index, lambda x: pd.Series(x, dtype=object)]
)
def test_names_among_others(kind):
    known = kind(["7/8", "Ö", "8"])
    assert is_among(kind(COLUMN), known).tolist() == [False, True, False, True, True]


def test_none_among_none():
    assert is_among([], ["A"]).tolist() == []
    assert is_among(["A"], []).tolist() == [False]


def codes_by_pandas(*columns):
    frame = pd.DataFrame(dict(enumerate(columns)))
    return frame.groupby(list(frame.columns), sort=False).ngroup().to_numpy()


@pytest.mark.parametrize("largest", [key_columns.LARGEST_CODE, 10])
def test_rows_are_told_apart_as_by_pandas(monkeypatch, largest):
    """Also where the codes of all combinations would not fit into an integer."""
    monkeypatch.setattr(key_columns, "LARGEST_CODE", largest)
    random = np.random.default_rng(2)
    columns = [random.choice(["a", "b", "7/8", ""], size=200) for _ in range(3)]
    codes = row_codes(columns)
    expected = codes_by_pandas(*columns)
    assert len(np.unique(codes)) == expected.max() + 1
    pairs = set(zip(codes.tolist(), expected.tolist(), strict=True))
    assert len(pairs) == expected.max() + 1


def test_rows_of_an_empty_table():
    assert row_codes([[], []]).tolist() == []
