"""Codes of dictionaries written out as text, against Arrow's own."""

import numpy as np
import pyarrow as pa
import pytest

from einschalt.foundations.coded_names import CodedNames, can_be_written_out

NAMES = ["", "a", "Ö 7", "12345678", "123456789", "x" * 23, "7/8"]


def parts_of(names, n_parts, n_rows=500):
    """A column of some parts, each with a dictionary in an order of its own."""
    random = np.random.default_rng(3)
    chunks = []
    for _ in range(n_parts):
        own = pa.array(random.permutation(names).tolist(), pa.string())
        codes = pa.array(random.integers(0, len(own), n_rows).astype(np.int32))
        chunks.append(pa.DictionaryArray.from_arrays(codes, own))
    return pa.chunked_array(chunks)


@pytest.mark.parametrize("n_parts", [1, 2, 7])
@pytest.mark.parametrize("names", [NAMES, [""], ["a"], ["x" * 9]])
def test_names_are_written_out_as_by_arrow(n_parts, names):
    column = parts_of(names, n_parts)
    coded = CodedNames(column)
    expected = column.cast(pa.large_string()).combine_chunks()
    assert coded.n_bytes == sum(len(name.encode()) for name in expected.to_pylist())
    written = coded.written_out()
    written.validate(full=True)
    assert written.equals(expected)


def test_parts_of_parts_are_written_out():
    column = parts_of(NAMES, 3).slice(100, 900)
    expected = column.cast(pa.large_string()).combine_chunks()
    assert CodedNames(column).written_out().equals(expected)


def test_a_column_without_rows():
    column = pa.chunked_array([], pa.dictionary(pa.int32(), pa.string()))
    assert CodedNames(column).written_out().to_pylist() == []


@pytest.mark.parametrize("code", [-1, 2, 2**31 - 1])
def test_a_code_without_a_name_is_damage(code):
    codes = pa.array([0, 1, code], pa.int32())
    names = pa.array(["a", "b"])
    damaged = pa.DictionaryArray.from_arrays(codes, names, safe=False)
    with pytest.raises(ValueError, match="a code has no name"):
        CodedNames(pa.chunked_array([damaged]))


def test_missing_names_and_other_kinds_are_left_to_arrow():
    with_gap = pa.chunked_array([pa.array(["a", None]).dictionary_encode()])
    numbers = pa.chunked_array([pa.array([1, 2]).dictionary_encode()])
    text = pa.chunked_array([pa.array(["a"])])
    for column in (with_gap, numbers, text):
        assert not can_be_written_out(column)
    assert can_be_written_out(parts_of(NAMES, 2))
