import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from einschalt.foundations import names as names_module
from einschalt.foundations.names import (
    encode,
    encode_pairs,
    is_among,
    rows_of_names,
)

examples = settings(max_examples=50, deadline=None, derandomize=True)
some_names = st.lists(st.sampled_from(["7/8", "0012", "12", " ", "ä", "x"]))
some_pairs = st.lists(
    st.tuples(st.sampled_from("12"), st.sampled_from(["7", "8/9", "0"]))
)


@pytest.mark.parametrize(
    "column",
    [
        ["7/8", "0012", "12", "7/8"],
        np.array(["7/8", "0012", "12", "7/8"], dtype=object),
        np.array(["7/8", "0012", "12", "7/8"]),
        pd.Series(["7/8", "0012", "12", "7/8"], index=[9, 3, 3, 1]),
        pd.Series(["7/8", "0012", "12", "7/8"], dtype="category"),
        pa.chunked_array([["7/8", "0012"], ["12", "7/8"]]),
    ],
    ids=["list", "object", "numpy text", "series", "category", "chunked"],
)
def test_names_stay_as_given(column):
    coded = encode(column)
    assert coded.codes.tolist() == [0, 1, 2, 0]
    assert coded.names.tolist() == ["7/8", "0012", "12"]
    assert len(coded) == 3


@pytest.mark.parametrize(
    "column",
    [
        *([], np.array([]), pd.Series(dtype=float), pd.Series(dtype=int)),
        *(pa.array([], pa.float64()), pa.chunked_array([], pa.int64()), pa.nulls(0)),
    ],
    ids=["list", "numpy", "float", "int", "Arrow", "chunked", "nulls"],
)
def test_an_empty_column_of_any_kind_holds_no_names(column):
    coded = encode(column)
    assert coded.codes.tolist() == coded.names.tolist() == []
    assert encode(["7/8"]).locate(coded).tolist() == []
    assert is_among(["7/8"], column).tolist() == [False]
    assert is_among(column, ["7/8"]).tolist() == []


@pytest.mark.parametrize("missing", [None, np.nan])
def test_a_missing_name_has_no_code(missing):
    with pytest.raises(ValueError, match="1 of 2 names are missing"):
        encode(["7/8", missing])
    with pytest.raises(ValueError, match="1 of 2 names are missing"):
        encode_pairs(["1", "1"], pd.Series([missing, "7/8"], dtype="category"))


@examples
@given(some_names)
def test_names_come_back(column):
    coded = encode(column)
    assert coded.names[coded.codes].tolist() == column
    assert len(set(coded.names)) == len(coded)
    # in order of first appearance
    assert coded.names.tolist() == list(dict.fromkeys(column))


@examples
@given(some_pairs)
def test_pairs_come_back(pairs):
    coded = encode_pairs([one for one, _ in pairs], [two for _, two in pairs])
    assert coded.names[coded.codes].tolist() == pairs
    assert coded.names.tolist() == list(dict.fromkeys(pairs))


def test_model_of_one_name_in_two_coverages():
    coded = encode_pairs(["1", "2", "1"], ["7/8", "7/8", "7/8"])
    assert coded.codes.tolist() == [0, 1, 0]
    assert coded.names.tolist() == [("1", "7/8"), ("2", "7/8")]
    assert coded.first.tolist() == ["1", "2"]
    assert coded.second.tolist() == ["7/8", "7/8"]


def test_locate_text():
    coded = encode(["7/8", "0012"])
    asked = encode(["0012", "12", "7/8", "0012"])
    assert coded.locate(asked).tolist() == [1, -1, 0]
    assert coded.locate(encode([])).tolist() == []
    assert encode([]).locate(asked).tolist() == [-1, -1, -1]


def test_locate_pairs():
    coded = encode_pairs(["1", "2", "2", "1"], ["a", "a", "b", "a"])
    asked = encode_pairs(["2", "1", "1", "2"], ["b", "b", "a", "b"])
    assert coded.locate(asked).tolist() == [2, -1, 0]
    assert coded.locate(encode_pairs([], [])).tolist() == []
    assert encode_pairs([], []).locate(asked).tolist() == [-1, -1, -1]


def test_pairs_do_not_run_together():
    coded = encode_pairs(["1", "11"], ["12", "2"])
    assert len(coded) == 2
    assert coded.locate(encode_pairs(["11"], ["12"])).tolist() == [-1]


@pytest.mark.parametrize(
    ("names", "known", "rows"),
    [
        (["b", "a", "b", "c"], ["a", "b"], [1, 0, 1, -1]),
        ([], ["a"], []),
        (["a", "a"], [], [-1, -1]),
    ],
)
def test_rows_of_names_are_those_of_what_is_known(names, known, rows):
    assert rows_of_names(names, known).tolist() == rows
    assert rows_of_names(pd.Series(names, dtype="str"), known).tolist() == rows


def test_codes_of_a_long_column_are_kept_as_long_as_it_is():
    n_kept = len(names_module._kept)
    table = pd.DataFrame({"point_id": ["7/8", "0012"] * names_module.MANY})
    first, again = encode(table["point_id"]), encode(table.copy()["point_id"])
    assert first.dictionary is again.dictionary
    assert first.codes.tolist() == again.codes.tolist() == [0, 1] * names_module.MANY
    assert len(names_module._kept) == n_kept + 1
    again.codes[:] = 7  # of the caller: what is kept stays
    assert encode(table["point_id"]).codes.max() == 1
    table.loc[0, "point_id"] = "13"
    assert encode(table["point_id"]).names.tolist() == ["13", "0012", "7/8"]
    del table
    assert len(names_module._kept) == n_kept


def test_a_long_column_with_a_missing_name_is_refused_each_time():
    table = pd.DataFrame({"point_id": ["7/8", None] * names_module.MANY}, dtype="str")
    for _ in range(2):
        with pytest.raises(ValueError, match="10000 of 20000 names are missing"):
            encode(table["point_id"])
