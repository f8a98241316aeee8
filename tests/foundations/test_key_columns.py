"""Names compared and coded by columns."""

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations import key_columns, name_bytes
from einschalt.foundations.key_columns import row_codes
from einschalt.foundations.names import is_among

COLUMN = ["0012", "7/8", "12", "7/8", "Ö"]


def may_repeat(columns):
    return key_columns.SeenNames(dict(enumerate(columns))).may_repeat


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


@pytest.mark.parametrize("kind", ["str", "string[python]", "large_string[pyarrow]"])
@pytest.mark.parametrize("n_chunks", [1, 3])
def test_long_columns_say_the_same_byte_by_byte(monkeypatch, kind, n_chunks):
    """Repeated rows are never overlooked, and blanks around names neither."""
    monkeypatch.setattr(key_columns, "MANY", 1)

    def column(names):
        series = pd.Series(names, dtype=kind)
        parts = np.array_split(np.arange(len(names)), n_chunks)
        chunks = [pd.Series(series.iloc[part]) for part in parts]
        return pd.concat(chunks)[1:]  # its first name lies before it in memory

    ids = column(["x", "0012", "7/8", "12", "7/", "Öl"])
    models = column(["x", "8", "1", "8", "81", "8"])
    assert not may_repeat([ids, models])  # 7/8|1 is not 7/|81
    assert may_repeat([column(["x", "a", "b", "a"]), column(list("xyzy"))])
    # and short ones by a pattern
    for least in (1, 50_000):
        monkeypatch.setattr(key_columns, "MANY", least)
        assert key_columns.are_tidy(column(["x", "0012", "7 8", "7\n8", "a"]))
        for odd in (" a", "a\t", "a\n", "", "\xa0a", "\u2003a", "a\u2003", "a\0", None):
            assert not key_columns.are_tidy(column(["x", "a", odd, "b"])), odd


@pytest.mark.slow
@pytest.mark.parametrize("n_cores", [1, 2, 5])
def test_bytes_of_every_name_count_wherever_they_lie(monkeypatch, n_cores):
    """Names of all lengths around the eight bytes that are taken at once."""
    monkeypatch.setattr(key_columns, "MANY", 1)
    monkeypatch.setattr(name_bytes, "n_cores", lambda: n_cores)
    names = ["a" * length for length in range(1, 30)]
    names += [
        name[:k] + "b" + name[k + 1 :] for name in names for k in range(len(name))
    ]
    assert not may_repeat([names])
    for place, name in enumerate(names):
        others = names[:place] + names[place + 1 :]
        assert not may_repeat([[name, *others]])
        assert may_repeat([[*names, name]])


def test_a_repeated_row_is_found_among_many(monkeypatch):
    monkeypatch.setattr(key_columns, "MANY", 1)
    names = np.arange(200_000).astype(str)
    assert not may_repeat([pd.Series(names, dtype="str")])
    names[7] = names[150_000]
    assert may_repeat([pd.Series(names, dtype="str")])
