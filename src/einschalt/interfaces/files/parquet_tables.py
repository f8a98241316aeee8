"""Parquet tables: what other programs read, with every digit.

Read: names may be text, codes of a dictionary, or whole numbers, which become text;
numbers may be of any kind. The row that messages name is counted from 1.

Written: Zstandard, dictionaries only where values repeat, no index, nothing that tells
of the writing program's environment; equal tables give equal bytes.
"""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
from pyarrow import parquet

from einschalt.foundations.batches import n_cores
from einschalt.foundations.coded_names import CodedNames, can_be_written_out
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.foundations.key_columns import MANY
from einschalt.foundations.names import TEXT
from einschalt.interfaces.files import unpacked_sizes
from einschalt.interfaces.files.arrow_columns import table_as_arrow
from einschalt.interfaces.files.atomic import replacing
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.json_text import parsed_json
from einschalt.interfaces.files.parquet_batches import (
    has_deltas,
    in_batches,
    require_sound,
)
from einschalt.interfaces.files.parquet_pages import texts_of
from einschalt.interfaces.files.point_layers import (
    WGS_84,
    PointLayer,
    points_of,
    points_of_wkb,
)
from einschalt.interfaces.files.understood_tables import (
    NOTHING_SAID,
    ReadTable,
    meant_header,
    understood,
)

MAGIC = b"PAR1"
TEXT_OF_PARQUET = "BYTE_ARRAY"
LONGEST_SAID = 200
FEWEST_REPEATED = 8  # rows of a name, from which codes are read faster than names
# so many that the dictionary of their names fits into a page and the caches
ROWS_OF_A_GROUP = 2**15


def read_parquet(path, schema, *, source=None):
    """Read all columns of a Parquet table; its index is the row, counted from 1.

    Names are text, numbers float, columns that the schema does not know have no values.
    A file that would unpack to a table too large to be one of points is refused.
    """
    return understand_parquet(path, schema, source=source).frame


def understand_parquet(path, schema, said=NOTHING_SAID, *, source=None) -> ReadTable:
    """Read a Parquet table as :func:`read_parquet` does, and say how.

    ``said``: what is known of it beside its name. Points that stand in a column of
    geometries (GeoParquet) are read as those of a layer.
    """
    source = source or Path(path).name
    data = read_once(path, source).data
    try:
        columns, names, meant, place = _read_columns(data, schema, said, source)
        table = pa.table(columns, names=names)
    except MemoryError:  # Arrow's is an ArrowException as well; the file is sound
        raise
    except (pa.ArrowException, OSError, ValueError) as error:
        raise _unreadable(data, source) from error
    nulls = {pa.null(): pd.ArrowDtype(pa.null())}
    frame = table.to_pandas(types_mapper=nulls.get)
    frame.index = pd.RangeIndex(1, len(frame) + 1, name="row")
    if place is not None:
        layer = _layer_of(frame, place, source)
        return points_of(layer, schema, said, source)
    frame.columns = list(meant.names)
    return understood(frame, schema, said, meant, source)


def _layer_of(frame, place, source):
    """Points of GeoParquet, as a layer; ``place``: column and system."""
    name, crs = place
    geometry = points_of_wkb(frame[name].to_list(), source)
    return PointLayer(frame.drop(columns=name), geometry, crs)


def _geometry_of(metadata, names):
    """Column of geometries of GeoParquet, and its system; None where there is none."""
    facts = (metadata.metadata or {}).get(b"geo")
    if facts is None:
        return None
    try:
        given = parsed_json(facts)
        name = given["primary_column"]
        column = given["columns"][name]
        is_binary = column["encoding"] == "WKB" and name in names
        crs = column.get("crs", WGS_84)  # the default of the format
        crs = json.dumps(crs) if isinstance(crs, dict) else crs
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return (name, crs) if is_binary else None


def _read_columns(data, schema, said, source):
    """Columns of the schema as they are understood, the others without values.

    Also the names of all in the file, what they mean, and the column of geometries.
    """
    file = pa.BufferReader(data)
    metadata = parquet.read_metadata(file)
    columns = [metadata.schema.column(k) for k in range(metadata.num_columns)]
    places = {column.path: k for k, column in enumerate(columns)}
    names = metadata.schema.to_arrow_schema().names
    n_rows = unpacked_sizes.refuse_size(metadata, names, len(data), source)
    meant = meant_header(names, schema, said, source)
    meaning = dict(zip(names, meant.names, strict=True))
    place = _geometry_of(metadata, names)
    known = [name for name in dict.fromkeys(names) if meaning[name] in schema.names]
    known += [place[0]] if place else []
    by_name = {name: columns[k] for name, k in places.items()}
    unpacked_sizes.refuse_columns(by_name, known, n_rows, len(data), source)
    numbers = {name for name in known if meaning[name] in schema.number_names}
    bounds = {n: _Bound(n, n in numbers, len(data), source) for n in known}
    texts = [n for n in known if by_name[n].physical_type == TEXT_OF_PARQUET]
    require_sound(data, metadata, texts)
    texts = [n for n in texts if place is None or n != place[0]]
    coded = [n for n in texts if not _is_text(data, metadata, places[n], bounds[n])]
    coded += [place[0]] if place else []  # may be huge, in all rows
    slow = {n: places[n] for n in coded if has_deltas(metadata, places[n])}
    table = _stored(data, metadata, known, coded, slow, bounds)

    def understand(name, column):
        if place is not None and name == place[0]:
            return _plain(column, bounds[name])
        return _understood(column, name in numbers, bounds[name])

    found = {name: [] for name in table.column_names}
    with ThreadPoolExecutor(n_cores()) as pool:
        columns = pool.map(understand, table.column_names, table.columns)
        for name, column in zip(table.column_names, columns, strict=True):
            found[name].append(column)
    empty = pa.nulls(metadata.num_rows)
    columns = [found[name].pop(0) if found.get(name) else empty for name in names]
    return columns, names, meant, place


@dataclass(frozen=True)
class _Bound:
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


def _stored(data, metadata, names, coded, slow, bounds):
    """Read columns, some of them as codes: the groups of rows on all cores.

    ``slow``: places of those that are no codes and might fill the memory.
    """
    names, coded = ([n for n in those if n not in slow] for those in (names, coded))
    n_parts = min(n_cores(), metadata.num_row_groups) or 1
    edges = np.linspace(0, metadata.num_row_groups, n_parts + 1).astype(int).tolist()

    def read(groups):
        stored = parquet.ParquetFile(
            pa.BufferReader(data), metadata=metadata, read_dictionary=coded
        )
        return stored.read_row_groups(groups, names, use_threads=n_parts == 1)

    with ThreadPoolExecutor(n_parts) as pool:
        parts = pool.map(read, [list(range(a, b)) for a, b in pairwise(edges)])
        table = pa.concat_tables(list(parts))
    tables = [table, *(_bounded(data, metadata, k, bounds[n]) for n, k in slow.items())]
    return pa.table(
        [column for table in tables for column in table.itercolumns()],
        names=[name for table in tables for name in table.column_names],
    )


def _bounded(data, metadata, place, bound):
    """Read a column in batches, as long as all of it is no monster."""
    batches, n_bytes = [], 0
    for batch in in_batches(data, metadata, place, bound.most(metadata.num_rows)):
        batches.append(batch)
        n_bytes += batch.nbytes
        bound.refuse(n_bytes, metadata.num_rows)
    return pa.Table.from_batches(batches)


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


def _unreadable(data, source):
    if data.startswith(MAGIC) and not data.endswith(MAGIC):
        found, remedy = "the file is truncated", "Copy or export it again"
    elif data.startswith(MAGIC):
        found, remedy = "the file is damaged", "Copy or export it again"
    else:
        start = data[:12].decode("utf-8", errors="replace")
        found = f"is no Parquet file, it begins with {start!r}" if data else "is empty"
        remedy = "Export it as Parquet, or give it the suffix .csv"
    return FileError(found, expected="a Parquet file", remedy=remedy, file=source)


def _understood(column, is_number, bound):
    """Numbers as float, anything else as text."""
    is_checked = _is_of_texts(column)
    column = _plain(column, bound)
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


def _plain(column, bound):
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


def write_parquet(frame, path):
    """Write a table without its index as Parquet, whole or not at all."""
    table = table_as_arrow(frame)
    # pyarrow takes names of files only where they are Unicode
    with replacing(path) as hidden, hidden.open("wb") as file:
        parquet.write_table(
            table,
            file,
            compression="zstd",
            row_group_size=ROWS_OF_A_GROUP,
            use_dictionary=[n for n in table.column_names if _repeats(table[n])],
        )


def _repeats(column):
    """Whether a dictionary makes a column smaller: by its first group of rows."""
    head = column.slice(0, ROWS_OF_A_GROUP)
    return 2 * pc.count_distinct(head, mode="all").as_py() <= len(head)
