"""Parquet tables: what other programs read, with every digit.

Read: names may be text, codes of a dictionary, or whole numbers, which become text;
numbers may be of any kind. The row that messages name is counted from 1.

Written: Zstandard, dictionaries only where values repeat, no index, nothing that tells
of the writing program's environment; equal tables give equal bytes.
"""

import json
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
from pyarrow import parquet

from einschalt.foundations.errors import FileError, TableError
from einschalt.interfaces.files import unpacked_sizes
from einschalt.interfaces.files.arrow_columns import table_as_arrow
from einschalt.interfaces.files.atomic import replacing
from einschalt.interfaces.files.flights_apart import tells_flights
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.json_text import parsed_json
from einschalt.interfaces.files.parquet_columns import read_columns, stored_columns
from einschalt.interfaces.files.parquet_values import (
    Bound,
    as_pandas,
    plain_values,
    understood_values,
)
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
# so many that the dictionary of their names fits into a page and the caches
ROWS_OF_A_GROUP = 2**15


def read_parquet(path, schema, *, source=None):
    """Read all columns of a Parquet table; its index is the row, counted from 1.

    Names are text, numbers float, columns that the schema does not know have no values,
    but for those that tell flights apart.
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
        frame = _framed(columns)
    except MemoryError:  # Arrow's is an ArrowException as well; the file is sound
        raise
    except (pa.ArrowException, OSError, ValueError) as error:
        raise _unreadable(data, source) from error
    frame.columns = names
    if place is not None:
        layer = _layer_of(frame, place, source)
        return points_of(layer, schema, said, source)
    frame.columns = list(meant.names)
    return understood(frame, schema, said, meant, source)


def _framed(columns):
    """Table of columns without names; its index is the row, counted from 1."""
    n_rows = len(columns[0]) if columns else 0
    rows = pd.RangeIndex(1, n_rows + 1, name="row")
    return pd.DataFrame(dict(enumerate(columns)), index=rows, copy=False)


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
    _refuse_no_texts(metadata.schema.to_arrow_schema(), meant, schema, source)
    place = _geometry_of(metadata, names)
    known = [name for name in dict.fromkeys(names) if meaning[name] in schema.names]
    known += _of_rows(metadata.schema.to_arrow_schema(), known, said)
    known += [place[0]] if place else []
    by_name = {name: columns[k] for name, k in places.items()}
    unpacked_sizes.refuse_columns(by_name, known, n_rows, len(data), source)
    geometry = place[0] if place else None
    numbers = {name for name in known if meaning[name] in schema.number_names}
    bounds = {n: Bound(n, n in numbers, len(data), source) for n in known}
    stored = stored_columns(data, metadata, bounds, places, geometry)

    def understand(column, values):
        if column.name == geometry:
            return as_pandas(plain_values(values, column.bound))
        return as_pandas(understood_values(values, column.bound))

    found = read_columns(data, metadata, stored, understand)
    nothing = pa.chunked_array([pa.nulls(metadata.num_rows)])
    columns = [
        found[name].pop(0) if found.get(name) else as_pandas(nothing) for name in names
    ]
    return columns, names, meant, place


def _of_rows(stored, known, said):
    """Further columns with values: by which rows are chosen, or flights told apart."""
    plain = {field.name for field in stored if _is_plain(field.type)}
    wanted = [n for n in dict.fromkeys(stored.names) if n in plain and n not in known]
    return [name for name in wanted if name in said.where or tells_flights(name)]


def _is_plain(kind):
    """Whether values are whole numbers or texts, perhaps as categories."""
    kind = kind.value_type if pa.types.is_dictionary(kind) else kind
    is_text = pa.types.is_string(kind) or pa.types.is_large_string(kind)
    return is_text or pa.types.is_integer(kind)


def _refuse_no_texts(stored, meant, schema, source):
    """Refuse names that a program keeps as dates, times or truth values."""
    names = {column.name for column in schema.columns if column.kind == "id"}
    for name, kind in zip(meant.names, stored.types, strict=True):
        is_other = pa.types.is_temporal(kind) or pa.types.is_boolean(kind)
        if name in names and is_other:
            raise TableError(
                f"the names in column {name} are of the type {kind}",
                expected="names as text",
                remedy="Write the column as text, as the names were given",
                file=source,
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
