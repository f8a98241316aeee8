"""Columns of Parquet files, read side by side on all cores, and how each is stored."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from einschalt.foundations.batches import n_cores
from einschalt.foundations.key_columns import MANY
from einschalt.interfaces.files.parquet_batches import (
    has_deltas,
    in_batches,
    require_sound,
)
from einschalt.interfaces.files.parquet_pages import texts_of
from einschalt.interfaces.files.parquet_values import Bound

TEXT_OF_PARQUET = "BYTE_ARRAY"
FEWEST_REPEATED = 8  # rows of a name, from which codes are read faster than names
WHOLE_GROUP = 2**31 - 1  # rows


@dataclass(frozen=True)
class StoredColumn:
    """Where a column stands in a file, and how it is read."""

    name: str
    place: int
    bound: Bound
    is_coded: bool  # read as codes of a dictionary
    is_slow: bool  # texts that cannot be, and might fill the memory


def stored_columns(data, metadata, bounds, places, geometry):
    """See how columns are to be read.

    ``bounds``: of each by its name; ``geometry``: name of one whose values may be huge.
    Damaged ones raise an OSError.
    """
    texts = [name for name in bounds if _is_stored_text(metadata, places[name])]
    require_sound(data, metadata, texts)
    found = []
    for name, bound in bounds.items():
        place = places[name]
        is_coded = name == geometry or (
            name in texts and not _is_text(data, metadata, place, bound)
        )
        is_slow = is_coded and has_deltas(metadata, place)
        found.append(
            StoredColumn(name, place, bound, is_coded and not is_slow, is_slow)
        )
    return found


def _is_stored_text(metadata, place):
    return metadata.schema.column(place).physical_type == TEXT_OF_PARQUET


def read_columns(data, metadata, columns, understand):
    """Read columns and understand each as a whole, on all cores.

    ``understand`` takes a StoredColumn and its values. What it gives is returned in
    lists by the names of columns: those that a file has twice have one name.
    """
    n_groups = metadata.num_row_groups
    n_parts = min(n_cores(), n_groups) or 1
    edges = np.linspace(0, n_groups, n_parts + 1).astype(int).tolist()
    with ThreadPoolExecutor(n_cores()) as pool:
        parts = {
            column: [
                pool.submit(_groups_of, data, metadata, column, range(*part))
                for part in pairwise(edges)
            ]
            for column in columns
        }

        def whole(column):
            # begun before, all of them: nothing here waits for what does not run
            batches = chain.from_iterable(part.result() for part in parts[column])
            table = pa.Table.from_batches(batches, _schema_of(data, metadata, column))
            return [understand(column, values) for values in table.columns]

        found = {column.name: pool.submit(whole, column) for column in columns}
        return {name: values.result() for name, values in found.items()}


def _groups_of(data, metadata, column, groups):
    """Batches of a column in some groups of rows."""
    if column.is_slow:
        return _bounded(data, metadata, column) if 0 in groups else []
    options = {"columns": [column.name], "use_threads": False}
    stored = _opened(data, metadata, column)
    return list(stored.iter_batches(WHOLE_GROUP, row_groups=list(groups), **options))


def _opened(data, metadata, column):
    coded = [column.name] if column.is_coded else []
    return parquet.ParquetFile(
        pa.BufferReader(data), metadata=metadata, read_dictionary=coded
    )


def _schema_of(data, metadata, column):
    return _opened(data, metadata, column).read_row_groups([], [column.name]).schema


def _bounded(data, metadata, column):
    """Read a column in batches, as long as all of it is no monster."""
    batches, n_bytes, bound = [], 0, column.bound
    most = bound.most(metadata.num_rows)
    for batch in in_batches(data, metadata, column.place, most):
        batches.append(batch)
        n_bytes += batch.nbytes
        bound.refuse(n_bytes, metadata.num_rows)
    return batches


def _is_text(data, metadata, place, bound):
    """Whether texts are read faster as they are than as codes, and not too long."""
    if metadata.num_rows < MANY or not metadata.num_row_groups:
        return False
    groups = range(metadata.num_row_groups)
    chunks = [metadata.row_group(group).column(place) for group in groups]
    if _are_repeated(texts_of(data, chunks[0])):  # as they are in the others, then
        return False
    found = [texts_of(data, chunk) for chunk in chunks]
    if None in found:
        return False
    n_bytes = sum(texts.most_bytes for texts in found)
    return n_bytes <= bound.most(metadata.num_rows)


def _are_repeated(texts):
    """Whether so many rows have each name that codes are read faster."""
    return (
        texts is not None
        and not texts.n_written_out
        and texts.n_names * FEWEST_REPEATED < texts.n_coded
    )
