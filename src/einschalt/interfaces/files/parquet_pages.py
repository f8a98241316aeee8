"""How much text the pages of a Parquet file unpack to, told before they are unpacked.

A few bytes may be the codes of a thousand million names, and their dictionary may hold
one name of a gigabyte. Names are therefore read as codes, unless the pages show that
they can be written out: the headers of all pages (Thrift's compact protocol, as
parquet.thrift of Apache Parquet has them), and the longest name of the dictionary.
"""

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from einschalt.foundations.kernels import compiled

# parquet.thrift: kinds of pages, encodings, and the numbers of fields
DATA_PAGE, DICTIONARY_PAGE, DATA_PAGE_V2 = 0, 2, 3
WRITTEN_OUT = {0, 6}  # PLAIN, DELTA_LENGTH_BYTE_ARRAY
CODES = {2, 8}  # PLAIN_DICTIONARY, RLE_DICTIONARY
KIND, UNPACKED, PACKED = 1, 2, 3
FACTS = {DATA_PAGE: 5, DICTIONARY_PAGE: 7, DATA_PAGE_V2: 8}
N_VALUES = 1
ENCODING = {DATA_PAGE: 2, DICTIONARY_PAGE: 2, DATA_PAGE_V2: 4}
# Thrift: kinds of fields
STOP, TRUE, FALSE, I32, I64, BINARY, STRUCT = 0, 1, 2, 5, 6, 8, 12
DEEPEST = 4  # a header holds facts, which hold statistics
LARGEST_DICTIONARY = 2**24
CODECS = {"ZSTD": "zstd", "SNAPPY": "snappy", "GZIP": "gzip", "BROTLI": "brotli"}


@dataclass(frozen=True)
class Texts:
    """The texts of one column in one group of rows."""

    n_names: int  # of the dictionary
    n_coded: int  # rows that have a code of the dictionary
    n_written_out: int  # and those that have none
    most_bytes: int  # to which all of them can unpack


def texts_of(data, chunk):
    """Sum up the pages of a column; None where they do not tell it for certain.

    ``chunk``: its metadata, as pyarrow gives them.
    """
    try:
        return _summed_up(data, chunk)
    except (LookupError, ValueError, TypeError, OSError, pa.ArrowException):
        return None


def largest_page(data, chunk):
    """Bytes of the largest page of a column, unpacked; None where pages do not tell it.

    No text of the column is longer.
    """
    try:
        pages = _pages(data, chunk)
        return max((header[UNPACKED] for _, header, _ in pages), default=0)
    except (LookupError, ValueError, TypeError):
        return None


def _summed_up(data, chunk):
    n_codes = n_written_out = n_names = longest = n_bytes = 0
    for kind, header, body in _pages(data, chunk):
        facts = header[FACTS[kind]]
        encoding = facts[ENCODING[kind]]
        if kind == DICTIONARY_PAGE:
            n_names = facts[N_VALUES]
            longest = _longest_name(body, header[UNPACKED], n_names, chunk.compression)
        elif encoding in CODES:
            n_codes += facts[N_VALUES]
        elif encoding in WRITTEN_OUT:
            n_written_out += facts[N_VALUES]
            n_bytes += header[UNPACKED]
        else:
            return None
    return Texts(n_names, n_codes, n_written_out, n_bytes + n_codes * longest)


def _pages(data, chunk):
    """Kind, header and packed bytes of each page, as Arrow reads them, and no more."""
    place = chunk.data_page_offset
    if chunk.has_dictionary_page and 0 < chunk.dictionary_page_offset < place:
        place = chunk.dictionary_page_offset
    end = min(place + chunk.total_compressed_size, len(data))
    n_left, is_first = chunk.num_values, True
    while n_left > 0:
        header, place = _fields(data, place)
        kind, start, place = header[KIND], place, place + header[PACKED]
        n_values = header[FACTS[kind]][N_VALUES]
        if place > end or min(header[PACKED], header[UNPACKED], n_values) < 0:
            raise ValueError
        if kind != DICTIONARY_PAGE:
            n_left -= n_values
        elif not is_first:
            raise ValueError
        yield kind, header, data[start:place]
        is_first = False
    if n_left < 0:
        raise ValueError


def _longest_name(body, n_bytes, n_names, compression):
    """Bytes of the longest name of a dictionary."""
    if n_bytes > LARGEST_DICTIONARY:
        raise ValueError
    if compression != "UNCOMPRESSED":
        body = pa.decompress(body, n_bytes, CODECS[compression])
    longest = _longest(np.frombuffer(body, np.uint8), n_names)
    if longest < 0:
        raise ValueError
    return longest


@compiled
def _longest(data, n_names):
    """Longest of names that follow each other, each after its length; -1 if cut off."""
    place, longest = 0, 0
    for _ in range(n_names):
        if place + 4 > len(data):
            return -1
        length = 0
        for k in range(4):
            length |= np.int64(data[place + k]) << (8 * k)
        place += 4 + length
        longest = max(longest, length)
    return longest if place <= len(data) else -1


def _fields(data, place, depth=0):
    """Fields of a structure by their numbers, and where it ends."""
    if depth > DEEPEST:
        raise ValueError
    found, number = {}, 0
    while (sign := data[place]) != STOP:
        step, kind = sign >> 4, sign & 0x0F
        if step == 0:  # legal, but no program writes it
            raise ValueError
        number, place = number + step, place + 1
        if kind in {TRUE, FALSE}:
            found[number] = kind == TRUE
        elif kind == STRUCT:
            found[number], place = _fields(data, place, depth + 1)
        elif kind in {I32, I64, BINARY}:
            value, place = _whole(data, place)
            is_number = kind == I32 and value < 2**32
            found[number] = (value >> 1) ^ -(value & 1) if is_number else None
            place += value if kind == BINARY else 0
        else:
            raise ValueError
    return found, place + 1


def _whole(data, place):
    """Read a whole number of seven bits a byte, and where it ends."""
    value = 0
    for shift in range(0, 64, 7):
        byte = data[place]
        value |= (byte & 0x7F) << shift
        place += 1
        if byte < 0x80:
            return value, place
    raise ValueError
