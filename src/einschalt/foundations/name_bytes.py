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
MULTIPLIERS = (MULTIPLIER, np.uint64(0xC2B2AE3D27D4EB4F))
FIRST_SIGN, LAST_SIGN = 0x21, 0x7E  # of ASCII, without blanks
ONE, BYTE, WORD = np.uint64(1), np.uint64(8), np.uint64(64)  # in bits
BITS_OF_WORD, LAST_BIT = np.uint64(6), np.uint64(63)
BYTES_OF_WORD = np.uint64(8)
FEWEST_PLACES = 64
BITS_OF_MET = 5
BITS_OF_SUM = 4  # as many bits more than rows have: few sums meet by chance


def look_over(columns):
    """Sums of the names of each row, and of which columns all names are tidy.

    ``columns`` are Arrow arrays of text. Tidy: no name is missing or empty, or begins
    or ends with a blank, or with a letter beyond ASCII, which may be one of Unicode.

    >>> look_over([pa.array(["7/8", "0012"]), pa.array(["7/8", " 0012"])])[1]
    [True, False]
    """
    sums = np.zeros(len(columns[0]), dtype=np.uint64)

    def look(part):
        tidy = []
        for column in columns:
            start, is_tidy = part.start, True
            for text in _texts(column[part]):
                own = sums[start : start + len(text)]
                is_tidy &= _add(own, *_buffers(text))
                start += len(text)
            tidy.append(is_tidy)
        return tidy

    parts = zip(*_on_all_cores(look, len(sums)), strict=True)
    tidy = [
        column.null_count == 0 and all(found)
        for column, found in zip(columns, parts, strict=True)
    ]
    return sums, tidy


def may_repeat(sums):
    """Whether two rows with such sums could have the same names in all columns.

    False is certain: equal rows have equal sums of 64 bits. True is not, two rows of
    10^6 share a sum by chance with a probability of 3e-8.

    >>> may_repeat(look_over([pa.array(["1", "1"]), pa.array(["A", "B"])])[0])
    False
    >>> may_repeat(look_over([pa.array(["1", "1"]), pa.array(["A", "A"])])[0])
    True
    """
    for multiplier in MULTIPLIERS:  # those that meet by chance do so once
        sums = _meeting(sums, _bits_of_places(len(sums)), multiplier)
    sums.sort()
    return bool((sums[1:] == sums[:-1]).any())


def _bits_of_places(n_sums):
    return max(n_sums, FEWEST_PLACES).bit_length() + BITS_OF_SUM


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
def _add(sums, places, data):
    """Add names to the sums of their rows; whether all of them are tidy."""
    start = np.uint64(places[0])  # unsigned: no place is looked for from the end
    is_tidy = True
    for row in range(len(places) - 1):
        end = np.uint64(places[row + 1])
        total = (sums[row] ^ (end - start)) * MULTIPLIER
        if start == end:
            is_tidy = False
        else:
            first, last = data[start], data[end - ONE]
            is_tidy &= FIRST_SIGN <= first <= LAST_SIGN
            is_tidy &= FIRST_SIGN <= last <= LAST_SIGN
        while start < end:
            total = (total ^ _word(data, start, end)) * MULTIPLIER
            total ^= total >> np.uint64(32)
            start += BYTES_OF_WORD
        start = end
        sums[row] = total
    return is_tidy


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
def _meeting(sums, n_bits, multiplier):
    """Return the sums that share one of 2^n_bits places, and some of their neighbours.

    Equal ones are among them. A place that is met is kept with 31 others in one bit, so
    that what the second pass looks at stays in the caches.
    """
    shift = WORD - np.uint64(n_bits)
    taken = np.zeros(1 << (n_bits - 6), dtype=np.uint64)
    met = np.zeros(1 << (n_bits - 6 - BITS_OF_MET), dtype=np.uint64)
    for total in sums:
        place = (total * multiplier) >> shift
        word, bit = place >> BITS_OF_WORD, ONE << (place & LAST_BIT)
        if taken[word] & bit:
            place >>= np.uint64(BITS_OF_MET)
            met[place >> BITS_OF_WORD] |= ONE << (place & LAST_BIT)
        else:
            taken[word] |= bit
    kept, n_kept = np.empty_like(sums), 0
    for total in sums:
        place = ((total * multiplier) >> shift) >> np.uint64(BITS_OF_MET)
        kept[n_kept] = total
        n_kept += (met[place >> BITS_OF_WORD] >> (place & LAST_BIT)) & ONE != 0
    return kept[:n_kept]
