"""Columns of names compared as a whole, by their integer codes."""

from functools import cached_property

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from einschalt.foundations.names import Coded, arrow_inside, encode

LARGEST_CODE = 2**62
MANY = 50_000  # rows from which compiled code is worth its start
TIDY = r"(?s)\A[!-~](.*[!-~])?\z"  # begins and ends as in name_bytes


def rows_among(table, others, names):
    """Whether the names of each row stand together in a row of another table.

    >>> first = {"coverage": ["1", "2"], "model_id": ["7", "7"]}
    >>> rows_among(first, {"coverage": ["2"], "model_id": ["7"]}, first).tolist()
    [False, True]
    """
    columns = [encode(table[name]) for name in names]
    sought = [_codes_in(own, others[n]) for own, n in zip(columns, names, strict=True)]
    is_there = np.all([codes >= 0 for codes in sought], axis=0)
    if not is_there.any():
        return np.zeros(len(columns[0].codes), dtype=bool)
    n_own = len(columns[0].codes)
    rows = row_codes(
        [
            Coded(np.concatenate([own.codes, codes[is_there]]), own.dictionary)
            for own, codes in zip(columns, sought, strict=True)
        ]
    )
    return np.isin(rows[:n_own], rows[n_own:])


def _codes_in(own, names):
    """Codes of names as those of another column; -1 where they are not in it."""
    coded = encode(names)
    return own.locate(coded)[coded.codes]


def row_codes(columns):
    """Code each distinct row of some columns of names, coded or not, by one integer.

    >>> row_codes([["1", "1", "2"], ["A", "A", "A"]]).tolist()
    [0, 0, 1]
    """
    coded = [c if isinstance(c, Coded) else encode(c) for c in columns]
    codes = np.zeros(len(coded[0].codes), dtype=np.int64)
    for part in coded:
        n_names = max(len(part), 1)
        if codes.max(initial=0) >= LARGEST_CODE // n_names:
            codes = np.unique(codes, return_inverse=True)[1]
        codes = codes * n_names + part.codes
    return codes


class SeenNames:
    """Columns of text, by name; long ones are looked at byte by byte, and once only.

    >>> SeenNames({"point_id": ["7/8", " 0012"]}).is_tidy("point_id")
    False
    """

    def __init__(self, columns):
        self._columns = columns
        self._sums, self._tidy = None, {}
        if columns and len(next(iter(columns.values()))) >= MANY:
            # compiled code takes its time to load
            from einschalt.foundations import name_bytes  # noqa: PLC0415

            texts = [_as_text(column) for column in columns.values()]
            self._sums, tidy = name_bytes.look_over(texts)
            self._tidy = dict(zip(columns, tidy, strict=True))

    @property
    def names(self):
        """Names of the columns."""
        return self._columns.keys()

    @cached_property
    def may_repeat(self):
        """Whether two rows could have the same names in all columns.

        False is certain; True is said of short columns without looking.
        """
        from einschalt.foundations import name_bytes  # noqa: PLC0415

        return self._sums is None or name_bytes.may_repeat(self._sums)

    def is_tidy(self, name):
        """Whether no name of a column is missing, or has blanks around it.

        True is certain; False is also said of names with letters beyond ASCII.
        """
        if name not in self._tidy:
            text = _as_text(self._columns[name])
            is_tidy = pc.all(pc.match_substring_regex(text, TIDY)).as_py()
            self._tidy[name] = text.null_count == 0 and bool(is_tidy)
        return self._tidy[name]


def are_tidy(names):
    """Whether no name of a column of text is missing, or has blanks around it.

    True is certain; False is also said of names with letters beyond ASCII.

    >>> are_tidy(["7/8", "0012"]), are_tidy(["7/8", " 0012"])
    (True, False)
    """
    return SeenNames({"": names}).is_tidy("")


def _as_text(names):
    """A column of text as Arrow has it, in one of the two forms with plain places."""
    is_arrow = isinstance(names, (pa.Array, pa.ChunkedArray))
    column = names if is_arrow else pa.array(arrow_inside(names), from_pandas=True)
    is_plain = pa.types.is_string(column.type) or pa.types.is_large_string(column.type)
    return column if is_plain else column.cast(pa.large_string())
