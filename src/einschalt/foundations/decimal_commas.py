"""Whether the commas in a table of numbers are decimal commas.

``13000,25`` and ``13.000,25`` can be nothing else, ``1,234`` may also be 1234. One
number that can be nothing else speaks for its table, since a program writes all of them
alike; a decimal point in its own column speaks against. So do ``2,345.5`` and
``1,234,567``, whose commas separate thousands: in their table ``1,234`` is 1234.
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
BY_COMMAS = r"^[+-]?[1-9]\d{0,2}((,\d{3})+\.\d*|(,\d{3}){2,})$"
BY_COMMAS_OR_APOSTROPHES = re.compile(
    r"^[+-]?[1-9]\d{0,2}((,\d{3})+\.\d*|(,\d{3}){2,}|(['\u2019]\d{3})+([.,]\d*)?)$"
)
GROUP_BLANKS = r"['\x{2019} \x{a0}\x{2009}\x{202f}]"
MINUS = "\u2212"
GROUPED_BEFORE_COMMA = r"^[+-]?[1-9]\d{0,2}(\.\d{3})+,\d*$"
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
    Points of two meanings beside ``10.009,37`` may part thousands, and are no faults.
    Points in another column speak only against commas of two meanings.

    >>> import pyarrow as pa
    >>> meaning_of_commas({"x": pa.array(["12,5", "7,250"])}).meaning
    'decimal'
    >>> meaning_of_commas({"x": pa.array(["1,234", "7"])}).meaning
    'open'
    >>> meaning_of_commas({"x": pa.array(["12,5", "7,25", "3.5"])}).text
    '3.5'
    >>> meaning_of_commas({"x": pa.array(["10.009,37", "10.100"])}).meaning
    'decimal'
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
        if has_commas and has_own and not _are_thousands(texts):
            return _of_most(name, texts, is_certain)
        is_proven |= bool(pc.any(is_certain, min_count=0).as_py())
        if first is None and pc.any(is_open, min_count=0).as_py():
            place = pc.index(is_open, True).as_py()
            first = Commas("open", name, place, texts[place].as_py())
    if is_proven:
        return Commas("decimal")
    return Commas("none") if has_points or first is None else first


def _are_thousands(texts):
    """Whether points part thousands before a comma, and none must be a decimal one."""
    is_point = pc.match_substring_regex(texts, POINT)
    is_parted = pc.match_substring_regex(texts, PARTED)
    if pc.any(pc.and_not(is_point, is_parted), min_count=0).as_py():
        return False
    return pc.any(pc.match_substring_regex(texts, GROUPED_BEFORE_COMMA)).as_py()


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


def commas_of_thousands(columns):
    """Column, place and text of commas that can only separate thousands, or None.

    ``columns`` as :func:`meaning_of_commas` takes them.

    >>> import pyarrow as pa
    >>> commas_of_thousands({"x": pa.array(["1,234", "2,345.5"])})
    ('x', 1, '2,345.5')
    >>> commas_of_thousands({"x": pa.array(["1,234", "1,234.5678e2"])})
    """
    return _first_of(columns, lambda texts: pc.match_substring_regex(texts, BY_COMMAS))


def certain_decimal_comma(columns):
    """Column, place and text of a comma that can only be a decimal one, or None.

    >>> import pyarrow as pa
    >>> certain_decimal_comma({"x": pa.array(["1,234", "0,411"])})
    ('x', 1, '0,411')
    """

    def are_certain(texts):
        is_open = pc.match_substring_regex(texts, OF_TWO_MEANINGS)
        return pc.and_not(pc.match_substring_regex(texts, DECIMAL), is_open)

    return _first_of(columns, are_certain)


def comma_of_two_meanings(columns):
    """Column, place and text of the first comma of two meanings, or None.

    >>> import pyarrow as pa
    >>> comma_of_two_meanings({"x": pa.array(["7", "1,234"])})
    ('x', 1, '1,234')
    """
    return _first_of(
        columns, lambda texts: pc.match_substring_regex(texts, OF_TWO_MEANINGS)
    )


def _first_of(columns, look):
    for name, texts in columns.items():
        place = pc.index(look(texts), True).as_py()
        if place >= 0:
            return name, place, texts[place].as_py()
    return None


def without_commas(texts):
    """Numbers as text without the commas that separate, or may separate, thousands.

    >>> import pyarrow as pa
    >>> without_commas(pa.array(["1,234", "-2,345.5", "1,234,567", "12,5"])).to_pylist()
    ['1234', '-2345.5', '1234567', '12,5']
    """
    is_parted = pc.or_(
        pc.match_substring_regex(texts, BY_COMMAS),
        pc.match_substring_regex(texts, OF_TWO_MEANINGS),
    )
    return pc.if_else(is_parted, pc.replace_substring(texts, ",", ""), texts)


def with_points(texts):
    """Numbers as text with decimal points in place of decimal commas.

    >>> import pyarrow as pa
    >>> with_points(pa.array(["12,5", "1.310.009,370", "3"])).to_pylist()
    ['12.5', '1310009.370', '3']
    """
    is_comma = pc.match_substring_regex(texts, DECIMAL)
    whole = pc.replace_substring(texts, ".", "")
    return pc.if_else(is_comma, pc.replace_substring(whole, ",", "."), texts)


def with_hyphens(texts):
    """Numbers as text with a hyphen for the minus of typesetters."""
    if not pc.any(pc.match_substring(texts, MINUS), min_count=0).as_py():
        return texts  # a look takes a third of the time of a copy
    return pc.replace_substring(texts, MINUS, "-")


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
    texts = with_hyphens(texts)
    is_grouped = pc.match_substring_regex(texts, GROUPED)
    if not pc.any(is_grouped, min_count=0).as_py():
        return texts
    has_point = pc.match_substring(texts, ".")
    plain = pc.replace_substring_regex(texts, GROUP_BLANKS, "")
    plain = pc.if_else(has_point, pc.replace_substring(plain, ",", ""), plain)
    return pc.if_else(is_grouped, plain, texts)


def is_measure(text):
    """Whether a text is a number, with a decimal sign and thousands of any country.

    >>> is_measure("13082.674"), is_measure("1.310.009,37"), is_measure("7/8")
    (True, True, False)
    >>> is_measure("2,345.5"), is_measure("326'844.209")
    (True, True)
    """
    is_parted = BY_COMMAS_OR_APOSTROPHES.match(text) is not None
    return is_parted or is_number(text) or MEASURE.match(text) is not None


def _has_points(texts):
    """Whether there is a number with a decimal point."""
    if not pc.any(pc.match_substring(texts, "."), min_count=0).as_py():
        return False
    return pc.any(pc.match_substring_regex(texts, POINT), min_count=0).as_py()
