"""Long columns of names, looked at byte by byte where they lie in memory.

A million names are sound, as a rule, and no two rows alike. That is seen here without
making a text, a copy or a dictionary of them; only where it is not so, the names are
looked at again, one by one, to say what is wrong.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pyarrow as pa

from einschalt.foundations.batches import n_cores
from einschalt.foundations.kernels import compiled

MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)  # odd, its bits without pattern
FIRST_SIGN, LAST_SIGN = 0x21, 0x7E  # of ASCII, without blanks
ONE, BYTE, WORD = np.uint64(1), np.uint64(8), np.uint64(64)  # in bits
BYTES_OF_WORD = np.uint64(8)
FEWEST_PLACES = 64
BITS_OF_SUM = 4  # as many bits more than rows have: few sums meet by chance


def are_tidy(names):
    """Whether no name is missing or empty, or begins or ends with a blank.

    ``names`` is an Arrow array of text. False also where a name begins or ends with a
    letter beyond ASCII: it may be a blank of Unicode.

    >>> are_tidy(pa.array(["7/8", "0012"])), are_tidy(pa.array(["7/8", " 0012"]))
    (True, False)
    """

    def look(part):
        return all(_are_tidy(*_buffers(text)) for text in _texts(names[part]))

    return names.null_count == 0 and all(_on_all_cores(look, len(names)))


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

    def add_up(part):
        for column in columns:
            start = part.start
            for text in _texts(column[part]):
                _add(sums[start : start + len(text)], *_buffers(text))
                start += len(text)

    _on_all_cores(add_up, len(sums))
    n_bits = max(len(sums), FEWEST_PLACES).bit_length() + BITS_OF_SUM
    meeting = _meeting(sums, n_bits)
    meeting.sort()
    return bool((meeting[1:] == meeting[:-1]).any())


def _on_all_cores(work, n_rows):
    """Results of work on ranges of rows, one for each core."""
    n_parts = n_cores()
    edges = [n_rows * k // n_parts for k in range(n_parts + 1)]
    with ThreadPoolExecutor(n_parts) as pool:
        return list(pool.map(work, map(slice, edges[:-1], edges[1:])))


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
    start = np.uint64(places[0])  # unsigned: no place is looked for from the end
    for row in range(len(places) - 1):
        end = np.uint64(places[row + 1])
        total = (sums[row] ^ (end - start)) * MULTIPLIER
        while start < end:
            total = (total ^ _word(data, start, end)) * MULTIPLIER
            total ^= total >> np.uint64(32)
            start += BYTES_OF_WORD
        start = end
        sums[row] = total


@compiled
def _word(data, start, end):
    """Return up to 8 bytes as one number, in the same bits wherever they lie."""
    word = np.uint64(0)
    n_bytes = min(end - start, BYTES_OF_WORD)
    n_free = BYTES_OF_WORD - n_bytes
    if start + BYTES_OF_WORD <= np.uint64(len(data)):
        for k in range(8):  # which the compiler makes one load
            word |= np.uint64(data[start + np.uint64(k)]) << np.uint64(8 * k)
        return word << (BYTE * n_free)
    for k in range(n_bytes):
        word |= np.uint64(data[start + k]) << (BYTE * (n_free + k))
    return word


@compiled
def _meeting(sums, n_bits):
    """Return the sums that share one of 2^n_bits places; equal ones always do."""
    shift = WORD - np.uint64(n_bits)
    taken, met = np.zeros((2, 1 << (n_bits - 6)), dtype=np.uint64)
    for total in sums:
        place = (total * MULTIPLIER) >> shift
        word, bit = place // WORD, ONE << (place % WORD)
        met[word] |= taken[word] & bit
        taken[word] |= bit
    kept, n_kept = np.empty_like(sums), 0
    for total in sums:
        place = (total * MULTIPLIER) >> shift
        kept[n_kept] = total
        n_kept += (met[place // WORD] >> (place % WORD)) & ONE != 0
    return kept[:n_kept]
