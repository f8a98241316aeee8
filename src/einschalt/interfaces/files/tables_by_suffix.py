"""Tables in the format that the suffix of their file names."""

from pathlib import Path

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.csv_tables import read_csv, write_csv
from einschalt.interfaces.files.parquet_tables import read_parquet, write_parquet

CSV_SUFFIXES = (".csv", ".txt", ".tsv")
PARQUET_SUFFIXES = (".parquet", ".pq")
WRITTEN_SUFFIXES = (".csv", ".parquet")


def read_table(path, schema, *, source=None):
    """Read a table as :func:`read_csv` or :func:`read_parquet` does."""
    source = source or Path(path).name
    suffix = _known_suffix(path, source, CSV_SUFFIXES + PARQUET_SUFFIXES)
    read = read_csv if suffix in CSV_SUFFIXES else read_parquet
    return read(path, schema, source=source)


def write_table(frame, path):
    """Write a table as .csv or .parquet, every number with all its digits."""
    suffix = _known_suffix(path, Path(path).name, WRITTEN_SUFFIXES)
    (write_csv if suffix == ".csv" else write_parquet)(frame, path)


def write_in_both_formats(tables, folder, *, decimals=None):
    """Write each table by its name, as .csv with so many decimals and as .parquet."""
    for name, table in tables.items():
        write_csv(table, folder / f"{name}.csv", decimals=decimals)
        write_parquet(table, folder / f"{name}.parquet")


def _known_suffix(path, source, known):
    suffix = Path(path).suffix.lower()
    if suffix not in known:
        raise FileError(
            f"suffix {suffix!r} is unknown" if suffix else "the suffix is missing",
            expected=", ".join(known),
            remedy="Save the table as CSV UTF-8 or as Parquet",
            file=source,
        )
    return suffix
