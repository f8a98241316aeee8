"""Tables of pandas as tables of Arrow, on their way into a file."""

import pyarrow as pa

from einschalt.foundations.names import arrow_inside


def table_as_arrow(frame):
    """Turn a table into one of Arrow, without its index; one that is such stays.

    So a table that goes into several files is turned once. Every column is one piece.
    """
    if isinstance(frame, pa.Table):
        return frame
    columns = [column_as_arrow(series) for _, series in frame.items()]
    return pa.table(columns, names=[str(name) for name in frame.columns])


def column_as_arrow(series):
    """Turn a column into one Arrow array; missing is null, mixed kinds are text."""
    try:
        values = pa.array(arrow_inside(series), from_pandas=True)
    except (pa.ArrowInvalid, pa.ArrowTypeError):
        values = pa.array(series.map(str, na_action="ignore"), pa.string())
    if isinstance(values, pa.ChunkedArray):
        values = values.combine_chunks()
    if pa.types.is_dictionary(values.type):
        values = values.dictionary_decode()
    return values.cast(pa.string()) if pa.types.is_null(values.type) else values
