import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from einschalt.foundations.names import encode, encode_pairs

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
