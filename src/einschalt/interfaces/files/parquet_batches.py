"""Columns of Parquet files a few rows at a time, none of which can fill the memory.

Texts of the DELTA encodings cannot be read as codes, and a name may be a megabyte that
it has in common with the one before it, in every row. No name is longer than its page.
"""

from concurrent.futures import ThreadPoolExecutor

import pyarrow as pa
from pyarrow import parquet

from einschalt.foundations.batches import n_cores
from einschalt.interfaces.files.parquet_pages import largest_page

DELTAS = {"DELTA_BYTE_ARRAY", "DELTA_LENGTH_BYTE_ARRAY"}
MOST_ROWS = 2**15


def require_sound(data, metadata, names):
    """Read a row of each group of rows, so that damaged columns raise an OSError.

    What a group tells of a column is not asked for before: where that is damaged,
    pyarrow raises out of code that nothing may leave so, which ends the process.
    """

    def read_one(group):
        stored = parquet.ParquetFile(pa.BufferReader(data), metadata=metadata)
        options = {"row_groups": [group], "use_threads": False}
        next(stored.iter_batches(1, columns=names, **options), None)

    with ThreadPoolExecutor(n_cores()) as pool:
        for _ in pool.map(read_one, range(metadata.num_row_groups)):
            pass  # what it raised is raised here


def has_deltas(metadata, place):
    """Whether a column has texts in any group of rows that cannot be read as codes."""
    groups = range(metadata.num_row_groups)
    return any(
        DELTAS.intersection(metadata.row_group(group).column(place).encodings)
        for group in groups
    )


def in_batches(data, metadata, place, most_bytes):
    """Read the columns of a name in batches of at most so many bytes, or of one row.

    ``place``: where the column stands that tells the size of pages.
    """
    name = metadata.schema.column(place).path
    groups = range(metadata.num_row_groups)
    chunks = [metadata.row_group(group).column(place) for group in groups]
    sizes = [largest_page(data, chunk) for chunk in chunks]
    longest = most_bytes if None in sizes else max(sizes, default=1)
    n_rows = min(max(most_bytes // max(longest, 1), 1), MOST_ROWS)
    stored = parquet.ParquetFile(pa.BufferReader(data), metadata=metadata)
    yield from stored.iter_batches(n_rows, columns=[name], use_threads=False)
