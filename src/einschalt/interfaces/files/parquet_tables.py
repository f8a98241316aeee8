"""Parquet tables: what other programs read, with every digit.

Read: names may be text, codes of a dictionary, or whole numbers, which become text;
numbers may be of any kind. The row that messages name is counted from 1.

Written: Zstandard, no index, nothing that tells of the writing program's environment;
equal tables give equal bytes.
"""

from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
from pyarrow import parquet

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.arrow_columns import column_as_arrow
from einschalt.interfaces.files.atomic import replacing
from einschalt.interfaces.files.input_files import require_file

MAGIC = b"PAR1"


def read_parquet(path, schema, *, source=None):
    """Read a Parquet table.

    Parameters
    ----------
    path : str or Path
    schema : Schema
        Tells numbers from names; the values are checked by ``check_table``.
    source : str, optional
        What the file is called in messages.

    Returns
    -------
    DataFrame
        All columns of the file, names as text, numbers as float. The index is the row,
        counted from 1.

    Raises
    ------
    FileError
        The file is missing, truncated or no Parquet file.
    """
    source = source or Path(path).name
    path = require_file(path, source)
    try:
        table = parquet.ParquetFile(path).read()
    except MemoryError:  # Arrow's is an ArrowException as well; the file is sound
        raise
    except (pa.ArrowException, OSError) as error:
        raise _unreadable(path, source) from error
    columns = [
        _understood(column, name in schema.number_names)
        for name, column in zip(table.column_names, table.columns, strict=True)
    ]
    frame = pa.table(columns, names=table.column_names).to_pandas()
    frame.index = pd.RangeIndex(1, len(frame) + 1, name="row")
    return frame


def _unreadable(path, source):
    data = path.read_bytes()
    if data.startswith(MAGIC) and not data.endswith(MAGIC):
        found, remedy = "the file is truncated", "Copy or export it again"
    elif data.startswith(MAGIC):
        found, remedy = "the file is damaged", "Copy or export it again"
    else:
        start = data[:12].decode("utf-8", errors="replace")
        found = f"is no Parquet file, it begins with {start!r}" if data else "is empty"
        remedy = "Export it as Parquet, or give it the suffix .csv"
    return FileError(found, expected="a Parquet file", remedy=remedy, file=source)


def _understood(column, is_number):
    kind = column.type
    if pa.types.is_dictionary(kind):
        column = pa.chunked_array(
            [chunk.dictionary_decode() for chunk in column.chunks], kind.value_type
        )
        kind = column.type
    is_measure = pa.types.is_integer(kind) or pa.types.is_floating(kind)
    if is_number and (is_measure or pa.types.is_decimal(kind)):
        return column.cast(pa.float64())
    if pa.types.is_floating(kind):
        return _whole_as_text(column)
    if pa.types.is_null(kind) or pa.types.is_nested(kind) or pa.types.is_binary(kind):
        said = [None if value is None else str(value) for value in column.to_pylist()]
        return pa.chunked_array([said], pa.string())
    return column.cast(pa.string())


def _whole_as_text(column):
    """Write 12.0 as 12: pandas makes whole numbers with a gap in them float."""
    column = column.cast(pa.float64())
    is_whole = pc.all(pc.equal(pc.floor(column), column), min_count=0).as_py()
    is_small = pc.all(pc.less(pc.abs(column), 2.0**53), min_count=0).as_py()
    return (column.cast(pa.int64()) if is_whole and is_small else column).cast(
        pa.string()
    )


def write_parquet(frame, path):
    """Write a table as Parquet, whole or not at all.

    Parameters
    ----------
    frame : DataFrame
        The index is not written.
    path : str or Path

    Raises
    ------
    FileError
        The file cannot be written.
    """
    table = pa.table(
        [column_as_arrow(frame.iloc[:, place]) for place in range(frame.shape[1])],
        names=[str(name) for name in frame.columns],
    )
    with replacing(path) as hidden:
        parquet.write_table(table, hidden, compression="zstd")
