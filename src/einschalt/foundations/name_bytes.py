"""Long columns of names, looked at byte by byte where they lie in memory.

A million names are sound, as a rule, and no two rows alike. That is seen here without
making a text, a copy or a dictionary of them; only where it is not so, the names are
looked at again, one by one, to say what is wrong.
"""

import numpy as np
import pyarrow as pa

from einschalt.foundations.kernels import compiled

MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)  # odd, its bits without pattern
FIRST_SIGN, LAST_SIGN = 0x21, 0x7E  # of ASCII, without blanks


def are_tidy(names):
    """Whether no name is missing or empty, or begins or ends with a blank.

    ``names`` is an Arrow array of text. False also where a name begins or ends with a
    letter beyond ASCII: it may be a blank of Unicode.

    >>> are_tidy(pa.array(["7/8", "0012"])), are_tidy(pa.array(["7/8", " 0012"]))
    (True, False)
    """
    texts = _texts(names)
    return names.null_count == 0 and all(_are_tidy(*_buffers(text)) for text in texts)


def may_repeat(columns):
    """Whether two rows could have the same names in all columns.

    False is certain: equal rows have equal sums of 64 bits. True is not, two rows of
    10^6 share a sum by chance with a probability of 3e-8.

    >>> may_repeat([pa.array(["1", "1"]), pa.array(["A", "B"])])
    False
    >>> may_repeat([pa.array(["1", "1"]), pa.array(["A", "A"])])
    True
    """
    sums = np.zeros(len(columns[0]), dtype=np.uint64)
    for column in columns:
        start = 0
        for text in _texts(column):
            _add(sums[start : start + len(text)], *_buffers(text))
            start += len(text)
    sums.sort()
    return bool((sums[1:] == sums[:-1]).any())


def _texts(names):
    return names.chunks if isinstance(names, pa.ChunkedArray) else [names]


def _buffers(names):
    """Places where each name begins, one more for the end, and the bytes of all."""
    _, places, data = names.buffers()
    kind = np.int64 if pa.types.is_large_string(names.type) else np.int32
    if places is None or not len(names):
        return np.zeros(1, dtype=kind), np.zeros(0, dtype=np.uint8)
    places = np.frombuffer(places, dtype=kind)
    places = places[names.offset : names.offset + len(names) + 1]
    return places, np.frombuffer(data or b"", dtype=np.uint8)


@compiled
def _are_tidy(places, data):
    for row in range(len(places) - 1):
        start, end = places[row], places[row + 1]
        if start == end:
            return False
        first, last = data[start], data[end - 1]
        if not (FIRST_SIGN <= first <= LAST_SIGN and FIRST_SIGN <= last <= LAST_SIGN):
            return False
    return True


@compiled
def _add(sums, places, data):
    for row in range(len(places) - 1):
        total = (sums[row] ^ np.uint64(places[row + 1] - places[row])) * MULTIPLIER
        for k in range(places[row], places[row + 1]):
            total = (total ^ np.uint64(data[k])) * MULTIPLIER
            total ^= total >> np.uint64(32)
        sums[row] = total
