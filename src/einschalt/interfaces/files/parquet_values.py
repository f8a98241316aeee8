"""Values of a column of Parquet as they are understood: numbers, and names as text."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from einschalt.foundations import cell_values
from einschalt.foundations.coded_names import CodedNames, can_be_written_out
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.foundations.key_columns import MANY
from einschalt.foundations.names import TEXT
from einschalt.interfaces.files import unpacked_sizes

LONGEST_SAID = 200


@dataclass(frozen=True)
class Bound:
    """What a column may unpack to."""

    name: str
    is_number: bool
    n_bytes: int  # of the file
    source: str

    def most(self, n_rows):
        """Bytes that its text may have in so many rows."""
        if self.is_number:
            return unpacked_sizes.most_text_of_numbers(n_rows)
        return unpacked_sizes.most_unpacked(self.n_bytes)

    def refuse(self, n_bytes, n_rows):
        """Refuse a column whose text has more."""
        if self.is_number:
            unpacked_sizes.refuse_text_of_numbers(
                self.name, n_bytes, n_rows, self.source
            )
        unpacked_sizes.refuse_unpacked(n_bytes, self.n_bytes, self.source)


def as_pandas(column):
    """An array of a column, numbers in memory of its own, which may be written to."""
    if pa.types.is_float64(column.type):
        return _as_numbers(column)
    if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
        return cell_values.TEXT.__from_arrow__(column)
    nulls = {pa.null(): pd.ArrowDtype(pa.null())}
    return column.to_pandas(types_mapper=nulls.get).array


def _as_numbers(column):
    numbers, start = np.empty(len(column)), 0
    for chunk in column.chunks:
        numbers[start : start + len(chunk)] = chunk.to_numpy(zero_copy_only=False)
        start += len(chunk)
    return numbers


def understood_values(column, bound):
    """Numbers as float, anything else as text."""
    is_checked = _is_of_texts(column)
    is_number = bound.is_number
    column = plain_values(column, bound)
    kind = column.type
    is_measure = pa.types.is_integer(kind) or pa.types.is_floating(kind)
    if is_number and (is_measure or pa.types.is_decimal(kind)):
        return column.cast(pa.float64(), safe=False)
    if pa.types.is_floating(kind):
        return _whole_as_text(column)
    is_bytes = pa.types.is_binary(kind) or pa.types.is_large_binary(kind)
    if pa.types.is_null(kind) or (is_number and is_bytes):
        return _said(column)
    try:
        text = column.cast(TEXT)
        if not is_checked:
            text.validate(full=True)  # reading does not look at the bytes of a text
    except pa.ArrowNotImplementedError:
        return _said(column)
    except pa.ArrowInvalid as error:
        raise FileError(
            f"column '{bound.name}' holds bytes that are no UTF-8 text",
            expected="names as UTF-8 text",
            remedy="Export the column as text",
            file=bound.source,
        ) from error
    return text


def _is_of_texts(column):
    """Whether the codes of a column are those of texts that are UTF-8."""
    if not (
        pa.types.is_dictionary(column.type)
        and pa.types.is_string(column.type.value_type)
    ):
        return False
    try:
        for chunk in column.chunks:
            chunk.dictionary.validate(full=True)
    except pa.ArrowInvalid:  # said where all of it is looked at
        return False
    return True


def plain_values(column, bound):
    """The column without codes."""
    is_coded = pa.types.is_dictionary(column.type)
    return _decoded(column, bound) if is_coded else column


def _decoded(column, bound):
    """Write out the codes of a dictionary, where that gives no monster."""
    if len(column) >= MANY and can_be_written_out(column):
        names = CodedNames(column)
        bound.refuse(names.n_bytes, len(column))
        return pa.chunked_array([names.written_out()])
    chunks = column.chunks
    n_bytes = sum(map(_n_bytes, chunks))
    bound.refuse(n_bytes, len(column))
    decoded = [chunk.dictionary_decode() for chunk in chunks]
    return pa.chunked_array(decoded, column.type.value_type)


def _n_bytes(chunk):
    """Bytes of the texts of codes, written out; of numbers they are known."""
    kind = chunk.type.value_type
    if not (pa.types.is_string(kind) or pa.types.is_binary(kind)):
        return 0
    lengths = pc.binary_length(chunk.dictionary).take(chunk.indices)
    return pc.sum(lengths, min_count=0).as_py()


def _said(column):
    texts = (
        None if v is None else shortened(v, LONGEST_SAID) for v in column.to_pylist()
    )
    return pa.chunked_array([list(texts)], pa.string())


def _whole_as_text(column):
    """Write 12.0 as 12: pandas makes whole numbers with a gap in them float."""
    column = column.cast(pa.float64())
    is_whole = pc.all(pc.equal(pc.floor(column), column), min_count=0).as_py()
    is_small = pc.all(pc.less(pc.abs(column), 2.0**53), min_count=0).as_py()
    return (column.cast(pa.int64()) if is_whole and is_small else column).cast(
        pa.string()
    )
