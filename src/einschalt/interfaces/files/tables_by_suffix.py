"""Tables in the format that the suffix of their file names."""

from functools import partial
from pathlib import Path

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files import point_layers, workbooks
from einschalt.interfaces.files.arrow_columns import table_as_arrow
from einschalt.interfaces.files.csv_tables import understand_csv, write_csv
from einschalt.interfaces.files.flights_apart import chosen_rows
from einschalt.interfaces.files.parquet_tables import understand_parquet, write_parquet
from einschalt.interfaces.files.understood_tables import NOTHING_SAID, ReadTable

CSV_SUFFIXES = (".csv", ".txt", ".tsv")
PARQUET_SUFFIXES = (".parquet", ".pq")
WRITTEN_SUFFIXES = (".csv", ".parquet")
READ_SUFFIXES = (
    *(CSV_SUFFIXES + PARQUET_SUFFIXES),
    *(workbooks.SUFFIXES + point_layers.SUFFIXES),
)
AS_TABLE = "Save the table as CSV UTF-8 or as Parquet"
AS_TEXT = (
    "Save the table as CSV UTF-8 or as Parquet; a list of plain text only needs the "
    "suffix .txt"
)

# of total stations and survey programs, which measurements and codes fill as well
BOOKS = (".rw5", ".are", ".job", ".idx", ".dc", ".fbk", ".crd")
AS_LIST = (
    "Export the points from the instrument or its program as a list of plain text: "
    "name, easting, northing, height, below a line of these names"
)


def read_table(path, schema, *, source=None):
    """Read a table as :func:`read_csv` or :func:`read_parquet` does."""
    return understand_table(path, schema, source=source).frame


def understand_table(
    path, schema, said=NOTHING_SAID, *, source=None, beside=()
) -> ReadTable:
    """Read a table of any known kind, and say how it was understood.

    ``said``: what is known of it beside its name, and which of its rows are meant;
    ``beside``: the files that belong to a shapefile.
    """
    source = source or Path(path).name
    suffix = _known_suffix(path, source, READ_SUFFIXES)
    _refuse_part_of_another_kind(suffix, said, source)
    if suffix in point_layers.SUFFIXES:
        read = partial(point_layers.understand_layer, beside=beside)
    elif suffix in workbooks.SUFFIXES:
        read = workbooks.understand_workbook
    else:
        read = understand_csv if suffix in CSV_SUFFIXES else understand_parquet
    found = read(path, schema, said, source=source)
    return chosen_rows(found, said.where, source) if said.where else found


def _refuse_part_of_another_kind(suffix, said, source):
    """A layer of a table that has none was meant of another file."""
    for key, kinds in (("layer", point_layers.SUFFIXES), ("sheet", workbooks.SUFFIXES)):
        name = getattr(said, key)
        if name is not None and suffix not in kinds:
            raise FileError(
                f"{key} = {name!r} is said of a {suffix} file, which has none",
                expected=f"{key} of {' or '.join(kinds)} alone",
                remedy=f"Leave {key} out, or name another file",
                file=source,
            )


def write_table(frame, path):
    """Write a table as .csv or .parquet, every number with all its digits."""
    suffix = require_written_suffix(path)
    (write_csv if suffix == ".csv" else write_parquet)(frame, path)


def require_written_suffix(path):
    """Give the suffix of a table that is to be written, if it can be."""
    return _known_suffix(path, Path(path).name, WRITTEN_SUFFIXES)


def write_in_both_formats(tables, folder, *, decimals=None):
    """Write each table by its name, as .csv with so many decimals and as .parquet."""
    for name, frame in tables.items():
        table = table_as_arrow(frame)
        write_csv(table, folder / f"{name}.csv", decimals=decimals)
        write_parquet(table, folder / f"{name}.parquet")


def _known_suffix(path, source, known):
    suffix = Path(path).suffix.lower()
    if suffix not in known:
        remedy = AS_TABLE
        if known is READ_SUFFIXES:
            remedy = AS_LIST if suffix in BOOKS else AS_TEXT
        raise FileError(
            f"suffix {suffix!r} is unknown" if suffix else "the suffix is missing",
            expected=", ".join(known),
            remedy=remedy,
            file=source,
        )
    return suffix
