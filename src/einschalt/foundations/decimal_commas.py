"""Whether the commas in a table of numbers are decimal commas.

``13000,25`` and ``13.000,25`` can be nothing else, ``1,234`` may also be 1234. One
number that can be nothing else speaks for its table, since a program writes all of them
alike; a decimal point in its own column speaks against.
"""

import re
from dataclasses import dataclass

import pyarrow.compute as pc

from einschalt.foundations.number_parsing import is_number

# also with points between thousands, which leave the comma one meaning
DECIMAL = r"^[+-]?(\d+,\d*|,\d+|[1-9]\d{0,2}(\.\d{3})+,\d*)([eE][+-]?\d+)?$"
MEASURE = re.compile(DECIMAL)
OF_TWO_MEANINGS = r"^[+-]?[1-9]\d{0,2},\d{3}$"
PARTED = r"^[+-]?[1-9]\d{0,2}\.\d{3}$"  # by a decimal point, or into thousands
# thousands parted by blanks or apostrophes, or by commas before a decimal point
GROUPED = (
    r"^[+-]?[1-9]\d{0,2}((['\x{2019} \x{a0}\x{2009}\x{202f}]\d{3})+([.,]\d*)?"
    r"|(,\d{3})+\.\d*)$"
)
GROUP_BLANKS = r"['\x{2019} \x{a0}\x{2009}\x{202f}]"
MINUS = "\u2212"
POINT = r"^[+-]?[\d,]*\.\d*([eE][+-]?\d+)?$"


@dataclass(frozen=True)
class Commas:
    """What the commas of a table are: ``decimal``, ``open``, ``mixed`` or ``none``."""

    meaning: str
    # where the first comma of two meanings stands, or the first of a few points
    column: str = ""
    place: int = 0
    text: str = ""
    n_points: int = 0  # numbers with a decimal point in a column of decimal commas


def meaning_of_commas(columns) -> Commas:
    """Tell what commas mean in columns of numbers as text.

    ``columns``: arrow arrays of text, without blanks around it, by name. ``none`` where
    there are no decimal commas, or more points in the same column: single values are
    faults then. ``mixed`` where a few points stand in a column of decimal commas.
    Points in another column speak only against commas of two meanings.

    >>> import pyarrow as pa
    >>> meaning_of_commas({"x": pa.array(["12,5", "7,250"])}).meaning
    'decimal'
    >>> meaning_of_commas({"x": pa.array(["1,234", "7"])}).meaning
    'open'
    >>> meaning_of_commas({"x": pa.array(["12,5", "7,25", "3.5"])}).text
    '3.5'
    """
    first = None
    is_proven = has_points = False
    for name, texts in columns.items():
        is_comma = pc.match_substring_regex(texts, DECIMAL)
        has_commas = pc.any(is_comma, min_count=0).as_py()
        has_own = _has_points(texts)
        has_points |= has_own
        is_open = pc.match_substring_regex(texts, OF_TWO_MEANINGS)
        is_certain = pc.and_not(is_comma, is_open)
        if has_commas and has_own:
            return _of_most(name, texts, is_certain)
        is_proven |= bool(pc.any(is_certain, min_count=0).as_py())
        if first is None and pc.any(is_open, min_count=0).as_py():
            place = pc.index(is_open, True).as_py()
            first = Commas("open", name, place, texts[place].as_py())
    if is_proven:
        return Commas("decimal")
    return Commas("none") if has_points or first is None else first


def _of_most(name, texts, is_certain):
    """Which sign is the exception in a column that has both."""
    is_point = pc.match_substring_regex(texts, POINT)
    n_points = pc.sum(is_point).as_py()
    if pc.sum(is_certain).as_py() <= n_points:
        return Commas("none")
    place = pc.index(is_point, True).as_py()
    return Commas("mixed", name, place, texts[place].as_py(), n_points)


def point_of_two_meanings(columns):
    """Column, place and text of a point that may separate thousands; None without one.

    ``columns`` as :func:`meaning_of_commas` takes them, of a table with decimal commas.
    Another number of the column that only a decimal point can part, such as ``0.5``,
    speaks for the column.

    >>> import pyarrow as pa
    >>> point_of_two_meanings({"x": pa.array(["7,5"]), "y": pa.array(["13.000"])})
    ('y', 0, '13.000')
    >>> point_of_two_meanings({"y": pa.array(["13.000", "0.5"])})
    """
    for name, texts in columns.items():
        if not _has_points(texts):
            continue
        is_parted = pc.match_substring_regex(texts, PARTED)
        is_point = pc.match_substring_regex(texts, POINT)
        if not pc.any(pc.and_not(is_point, is_parted), min_count=0).as_py():
            place = pc.index(is_parted, True).as_py()
            return name, place, texts[place].as_py()
    return None


def with_points(texts):
    """Numbers as text with decimal points in place of decimal commas.

    >>> import pyarrow as pa
    >>> with_points(pa.array(["12,5", "1.310.009,370", "3"])).to_pylist()
    ['12.5', '1310009.370', '3']
    """
    is_comma = pc.match_substring_regex(texts, DECIMAL)
    whole = pc.replace_substring(texts, ".", "")
    return pc.if_else(is_comma, pc.replace_substring(whole, ",", "."), texts)


def without_groups(texts):
    """Numbers as text without signs between thousands that can be nothing else.

    >>> import pyarrow as pa
    >>> without_groups(pa.array(["1'310'009.37", "5 009,2", "1,310,009.3"])).to_pylist()
    ['1310009.37', '5009,2', '1310009.3']
    >>> without_groups(pa.array(["1,310", "1.310", "7 8"])).to_pylist()
    ['1,310', '1.310', '7 8']
    >>> without_groups(pa.array(["\u221213,5"])).to_pylist()  # the sign of typesetters
    ['-13,5']
    """
    texts = pc.replace_substring(texts, MINUS, "-")
    is_grouped = pc.match_substring_regex(texts, GROUPED)
    if not pc.any(is_grouped, min_count=0).as_py():
        return texts
    has_point = pc.match_substring(texts, ".")
    plain = pc.replace_substring_regex(texts, GROUP_BLANKS, "")
    plain = pc.if_else(has_point, pc.replace_substring(plain, ",", ""), plain)
    return pc.if_else(is_grouped, plain, texts)


def is_measure(text):
    """Whether a text is a number, with a decimal point or a decimal comma.

    >>> is_measure("13082.674"), is_measure("1.310.009,37"), is_measure("7/8")
    (True, True, False)
    """
    return is_number(text) or MEASURE.match(text) is not None


def _has_points(texts):
    """Whether there is a number with a decimal point."""
    if not pc.any(pc.match_substring(texts, "."), min_count=0).as_py():
        return False
    return pc.any(pc.match_substring_regex(texts, POINT), min_count=0).as_py()
