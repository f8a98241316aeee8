"""Long columns of names that are codes of dictionaries, written out as text.

Arrow does it name by name; here eight bytes at a time go into one array for all parts
of a column.
"""

import numpy as np
import pyarrow as pa

from einschalt.foundations.kernels import compiled

WORD = 8  # bytes that are copied at once, over the end of a name


def can_be_written_out(column):
    """Whether this is done for a column: codes of texts in every row."""
    kind = column.type
    return (
        pa.types.is_dictionary(kind)
        and pa.types.is_string(kind.value_type)
        and kind.index_type == pa.int32()
        and not column.null_count
        and not any(chunk.dictionary.null_count for chunk in column.chunks)
    )


class CodedNames:
    """The parts of a column: codes, places of the names, and the bytes of these.

    A ValueError where a code has no name, as in a damaged file.
    """

    def __init__(self, column):
        self._parts = [_part(chunk) for chunk in column.chunks if len(chunk)]
        sizes = [_n_bytes(codes, places) for codes, places, _ in self._parts]
        if min(sizes, default=0) < 0:
            raise ValueError("a code has no name")
        self.n_bytes = sum(sizes)  # of all names, written out

    def written_out(self) -> pa.Array:
        """All names as text.

        >>> column = pa.chunked_array([pa.array(["7/8", "0012"]).dictionary_encode()])
        >>> CodedNames(column).written_out().to_pylist()
        ['7/8', '0012']
        """
        n_rows = sum(len(codes) for codes, _, _ in self._parts)
        ends = np.zeros(n_rows + 1, dtype=np.int64)
        letters = np.empty(self.n_bytes + WORD, dtype=np.uint8)
        row = 0
        for codes, places, names in self._parts:
            part = ends[row : row + len(codes) + 1]
            _write_out(part, letters, codes, places, names)
            row += len(codes)
        parts = [None, pa.py_buffer(ends), pa.py_buffer(letters[: self.n_bytes])]
        return pa.Array.from_buffers(pa.large_string(), n_rows, parts)


def _part(chunk):
    """Codes of a part, where each name begins and the last one ends, and the bytes."""
    names = chunk.dictionary
    _, places, letters = names.buffers()
    if places is None or letters is None:  # no name, or all of them empty
        return (
            chunk.indices.to_numpy(),
            np.zeros(len(names) + 1, np.int32),
            _padded(b""),
        )
    places = np.frombuffer(places, np.int32)[names.offset :][: len(names) + 1]
    letters = np.frombuffer(letters, np.uint8)[places[0] : places[-1]]
    return chunk.indices.to_numpy(), places - places[0], _padded(letters)


def _padded(letters):
    return np.concatenate([np.frombuffer(letters, np.uint8), np.zeros(WORD, np.uint8)])


@compiled
def _n_bytes(codes, places):
    """Bytes of all names that are written out; -1 where a code has none."""
    n_bytes, n_names = 0, len(places) - 1
    for code in codes:
        if not 0 <= code < n_names:
            return -1
        n_bytes += np.int64(places[code + 1] - places[code])
    return n_bytes


@compiled
def _write_out(ends, letters, codes, places, names):
    """Write names one after the other, and where each ends, from ends[0] on."""
    end = np.uint64(ends[0])
    for row in range(len(codes)):
        code = codes[row]
        start, stop = np.uint64(places[code]), np.uint64(places[code + 1])
        place = end
        end += stop - start
        while start < stop:
            for k in range(WORD):  # which the compiler makes one load and one store
                letters[place + np.uint64(k)] = names[start + np.uint64(k)]
            place += np.uint64(WORD)
            start += np.uint64(WORD)
        ends[row + 1] = end
