"""What is wrong with a text that should be a number, and how it should be written."""

import re
from operator import index

from einschalt.foundations.display_names import shortened
from einschalt.foundations.sexagesimal import degrees_and_side

LARGEST_NUMBER = 1e30  # nothing measured is larger, and its square is a number
MOST_BITS = 1000
MOST_SHOWN = 60
MEND = "Give a value or delete the row"
MEND_OR_NONE = "Give a value, or leave the cell empty"
# as tables have them; where a spreadsheet has times alone, they have its first day
DATE = re.compile(r"\d{4}[-/]\d\d[-/]\d\d([ T].*)?|\d{1,2}:\d\d(:\d\d.*)?")
CLOCK = re.compile(r"1899[-/]12[-/]3[01]([ T].*)?")
OF_A_DATE = "Give the value as a number, in a spreadsheet with the format Number"
THOUSANDS = re.compile(r"[+-]?\d{1,3}(([,.'\u2019 \xa0\u2009\u202f_])\d{3})(\2\d{3})*")

DEGREES = "degrees"


def describe_fault(value, unit, *, is_positive=False):
    """Say why a value of a table is no usable number: found, expected, remedy.

    ``unit`` is what the number measures, in the plural.

    >>> describe_fault("1.234,5", "metres")
    ("'1.234,5' has separators of thousands", 'metres', 'Write 1234.5')
    """
    expected = f"{unit}, above 0" if is_positive else unit
    text = "" if value is None else _said(value)
    text = shortened(text, MOST_SHOWN) if len(text) > MOST_SHOWN else text
    if not isinstance(value, str) and text in ("nan", "NaT"):  # how pandas leaves out
        text = ""
    found, remedy = _sexagesimal(text, unit) or _fault(text)
    return found, expected, remedy


def _said(value):
    """What stands in a cell; long whole numbers are none that Python would write."""
    if isinstance(value, int) and value.bit_length() > MOST_BITS:
        return f"{'-' if value < 0 else ''}1e{round(0.30103 * value.bit_length())}"
    return str(value).strip().replace("<NA>", "")


def _fault(text):
    if text == "":
        return "is missing", MEND
    if text.lower() == "nan":
        return f"{text!r} is missing", MEND
    if text.lower().lstrip("+-") in ("inf", "infinity"):
        return f"{text!r} is infinite", MEND
    if is_number(text):
        is_small = abs(float(text)) <= LARGEST_NUMBER
        fault = f"{text!r} is not above 0" if is_small else f"{text!r} is too large"
        return fault, MEND
    if CLOCK.fullmatch(text):
        return "is a time of day, and no number", OF_A_DATE
    if DATE.fullmatch(text):
        return f"{text!r} is a date or a time, and no number", OF_A_DATE
    return _separators(text) or (f"{text!r} is not a number", MEND)


def _sexagesimal(text, unit):
    """Tell degrees, minutes and seconds from other text."""
    angle = degrees_and_side(text)
    if angle is None:
        return None
    plain = f"{angle[0]:.10f}".rstrip("0").rstrip(".")
    found = f"{text!r} has degrees and minutes"
    if unit == DEGREES:
        return found, f"Write {plain}"
    geographic = "call the columns longitude and latitude"
    return found, f"Write {plain}, {geographic}, and name their geographic system"


def is_number(text):
    """Whether a text is a number as the tables write it, with a decimal point."""
    try:
        float(text)
    except ValueError:
        return False
    # 1_000, and digits of other scripts, are numbers to Python alone
    return "_" not in text and text.strip().isascii()


def _separators(text):
    """Tell a decimal comma and separators of thousands from other text."""
    point = text.replace(",", ".", 1)
    grouped = THOUSANDS.match(text)
    rest = text[grouped.end() :] if grouped else ""
    if grouped and not rest and grouped.group(2) == "," and not grouped.group(3):
        plain = text.replace(",", "")
        mend = f"Write {point}, or {plain} where the comma separates thousands"
        return f"{text!r} has a comma", mend
    if text.count(",") == 1 and is_number(point):
        return f"{text!r} has a decimal comma", f"Write {point}"
    if grouped and re.fullmatch(r"([.,]\d*)?", rest):
        plain = grouped.group().replace(grouped.group(2), "") + rest.replace(",", ".")
        return f"{text!r} has separators of thousands", f"Write {plain}"
    return None


def plain_integer(value):
    """Take a whole number of numpy as one of Python; anything else stays as it is.

    >>> import numpy as np
    >>> plain_integer(np.int64(2)), plain_integer(True), plain_integer(2.0)
    (2, True, 2.0)
    """
    if isinstance(value, bool):  # an integer to Python
        return value
    try:
        return index(value)
    except TypeError:
        return value
