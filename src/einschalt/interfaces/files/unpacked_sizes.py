"""What a small Parquet file would unpack to, refused before it fills the memory."""

from einschalt.foundations.errors import FileError

MOST_COLUMNS = 1000
MOST_GROUPS = 10**5
NUMBER_BYTES = 8
# measurements are packed ten times at most, by rows that repeat each other some more
MOST_PACKED = 100
HARMLESS_BYTES = 2**27  # 16 million rows
HARMLESS_TEXT = 2**22  # in a column of numbers, which is then quoted
LONGEST_NUMBER = 100  # characters, in the mean of a column


def most_unpacked(n_bytes):
    """Bytes that a file of some bytes may unpack to."""
    return max(HARMLESS_BYTES, MOST_PACKED * n_bytes)


def most_text_of_numbers(n_rows):
    """Bytes that numbers may have that are written as text."""
    return max(HARMLESS_TEXT, LONGEST_NUMBER * n_rows)


def refuse_size(metadata, names, n_bytes, source):
    """Refuse a table of too many columns or groups, or groups that tell of a monster.

    Returns the number of rows.
    """
    if len(names) > MOST_COLUMNS:
        raise FileError(
            f"the table has {len(names)} columns",
            expected=f"at most {MOST_COLUMNS}",
            remedy="Leave out the columns that are no part of the table",
            file=source,
        )
    if metadata.num_row_groups > MOST_GROUPS:
        raise FileError(
            f"the table has {metadata.num_row_groups} groups of rows",
            expected=f"at most {MOST_GROUPS}",
            remedy="Export it with more rows in each group",
            file=source,
        )
    groups = [metadata.row_group(k) for k in range(metadata.num_row_groups)]
    packed = sum(group.total_byte_size for group in groups)
    n_rows = count_rows(metadata, groups)
    refuse_unpacked(max(packed, n_rows * NUMBER_BYTES), n_bytes, source)
    return n_rows


def count_rows(metadata, groups):
    """Count the rows of a file, as it tells of them, or of its groups of rows."""
    return max(metadata.num_rows, sum(group.num_rows for group in groups))


def refuse_columns(columns, known, n_rows, n_bytes, source):
    """Refuse what the known columns of a table would unpack to.

    ``columns``: those of the file without structures, by name. All values of one may be
    a few bytes: codes of one name, or none.
    """
    for name in known:
        column = columns.get(name)
        if column is None or column.max_repetition_level:
            raise FileError(
                f"column '{name}' holds lists or structures",
                expected="one value in each row",
                remedy="Export each value in a column of its own",
                file=source,
            )
    sizes = [max(columns[name].length, NUMBER_BYTES) for name in known]
    refuse_unpacked(n_rows * sum(sizes), n_bytes, source)


def refuse_unpacked(unpacked, n_bytes, source):
    """Refuse what is packed as no table is."""
    if unpacked > most_unpacked(n_bytes):
        raise FileError(
            f"{n_bytes} bytes would unpack to {unpacked} bytes",
            expected=f"a table that is packed at most {MOST_PACKED} times",
            remedy="Check where the file comes from, or give the table as CSV",
            file=source,
        )


def refuse_text_of_numbers(name, n_bytes, n_rows, source):
    """Refuse texts that are too long to be numbers."""
    most = most_text_of_numbers(n_rows)
    if n_bytes > most:
        raise FileError(
            f"column '{name}' holds more than {most} bytes of text in {n_rows} rows",
            expected=f"numbers, of at most {LONGEST_NUMBER} characters in the mean",
            remedy="Export the column as numbers, or leave it out",
            file=source,
        )
