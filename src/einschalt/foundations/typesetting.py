"""Numbers, lengths, names and tables as text: every printed number passes here.

Within :func:`one_unit` lengths of the size of errors are all written in one unit.

What to use when: :func:`length` for one length in a sentence, :func:`lengths` for a
column, :func:`round_by_error` where a value stands beside its error, :func:`count`
for "3 models", :func:`table` for aligned columns, :func:`wrapped` for prose.
"""

import math
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple

import numpy as np
from rich.cells import cell_len

from einschalt.foundations.display_names import all_shortened, printable
from einschalt.foundations.language import figure, mark, numbers_set, translated
from einschalt.foundations.units import METRES_PER_UNIT

MISSING = "–"
WIDTH = 88
NUMBER_WORDS = (
    *(mark("no"), mark("one"), mark("two"), mark("three"), mark("four")),
    *(mark("five"), mark("six"), mark("seven"), mark("eight"), mark("nine")),
    *(mark("ten"), mark("eleven"), mark("twelve")),
)
# smallest length that is said in the unit
SMALLEST_IN_UNIT = (("km", 1e4), ("m", 1.0), ("cm", 1e-2), ("mm", 1e-4), ("um", 0.0))
UNIT_TEXT = {"um": "µm"}
METRES_PER = {**METRES_PER_UNIT, "km": 1e3}
# lengths of the size of errors on the ground: those of the image are smaller
SIZE_OF_ERRORS = (5e-4, 10.0)
_only_unit: ContextVar[str | None] = ContextVar("only_unit", default=None)


class Rounded(NamedTuple):
    """A value and its error with the same number of decimals, as text."""

    value: str
    error: str


def decimals_for(number, significant=2):
    """Decimals with which a number shows so many significant digits.

    Negative where digits before the point must be rounded away.

    >>> decimals_for(0.0996), decimals_for(12.3), decimals_for(1234.0)
    (2, 0, -2)
    """
    if not math.isfinite(number) or number == 0.0:
        return 0
    # the exponent after rounding: 0.0996 becomes 0.10, which has its digits elsewhere
    exponent = int(f"{abs(number):.{significant - 1}e}".split("e")[1])
    return significant - 1 - exponent


def fixed(number, decimals):
    """Write a number with fixed decimals; a dash where there is none.

    >>> fixed(3.14159, 2), fixed(1234.0, -2), fixed(float("nan"), 1), fixed(-0.01, 1)
    ('3.14', '1200', '–', '0.0')
    """
    if number is None or not math.isfinite(number):
        return MISSING
    rounded = round(float(number), decimals) + 0.0  # + 0.0 turns -0.0 into 0.0
    return figure(rounded, f".{max(decimals, 0)}f")


def number(value, significant=2):
    """Write a number with so many significant digits.

    >>> number(1.469), number(0.0034), number(152.0)
    ('1.5', '0.0034', '150')
    """
    if value is None or not math.isfinite(value):
        return MISSING
    return fixed(value, decimals_for(value, significant))


def round_by_error(value, error):
    """Round a value by its error: two digits of the error, as many decimals in both.

    After the Particle Data Group, whose third step (one digit where the error starts
    with 355 to 949) is left out: in a column the errors then keep equal digits. Without
    a usable error the value keeps six significant digits.

    >>> round_by_error(5326127.48213, 0.0371)
    Rounded(value='5326127.482', error='0.037')
    >>> round_by_error(12.3456, 0.0996)
    Rounded(value='12.35', error='0.10')
    """
    if error is None or not math.isfinite(error) or error <= 0.0:
        return Rounded(number(value, 6), MISSING)
    decimals = decimals_for(error)
    return Rounded(fixed(value, decimals), fixed(error, decimals))


def length(metres):
    """Write a length with two significant digits, in the unit that suits it.

    >>> length(0.0371), length(0.0042), length(1.43), length(float("nan"))
    ('3.7 cm', '4.2 mm', '1.4 m', '–')
    """
    if metres is None or not math.isfinite(metres):
        return MISSING
    if metres == 0.0:
        return "0"
    # the unit of the rounded length: 9.96 mm is written 1.0 cm
    unit = _unit_for(float(f"{metres:.1e}"))
    return f"{number(metres / METRES_PER[unit])} {UNIT_TEXT.get(unit, unit)}"


def _unit_for(metres):
    least, most = SIZE_OF_ERRORS
    if (only := _only_unit.get()) and least <= abs(metres) < most:
        return only
    return next(unit for unit, least in SMALLEST_IN_UNIT if abs(metres) >= least)


@contextmanager
def one_unit(metres: float) -> Iterator[str]:
    """Write lengths of the size of errors in the unit that suits one of them.

    For a page on which errors are compared: what is larger than 10 m, or smaller than
    half a millimetre, keeps the unit that suits it.

    >>> with one_unit(0.04) as unit:
    ...     unit, length(0.0042), length(1.43), length(2000.0), length(3e-6)
    ('cm', '0.42 cm', '140 cm', '2000 m', '3.0 µm')
    """
    unit = _unit_for(metres) if math.isfinite(metres) and metres > 0.0 else "cm"
    before = _only_unit.set(unit)
    try:
        yield unit
    finally:
        _only_unit.reset(before)


class LengthColumn(NamedTuple):
    """Lengths as text in one unit, which stands in the head of their column."""

    unit: str
    texts: list[str]


def length_column(metres: Sequence[float]) -> LengthColumn:
    """Write the lengths of a column in one unit with equal decimals.

    The unit suits the largest. In metres the smallest keeps two significant digits as
    far as millimetres go; in smaller units three quarters of the lengths do, of few
    lengths all, with at most two decimals.

    >>> length_column([0.052, 0.0043, float("nan"), 0.37])
    LengthColumn(unit='cm', texts=['5.20', '0.43', '–', '37.00'])
    """
    values = np.asarray(metres, dtype=float)
    sizes = np.abs(values[np.isfinite(values) & (values != 0.0)])
    unit = _unit_for(float(f"{sizes.max():.1e}")) if sizes.size else "cm"
    decimals = 0
    if sizes.size:
        part, most = (0.0, 3) if unit == "m" else (0.25, 2)
        small = np.quantile(sizes, part, method="lower") / METRES_PER[unit]
        decimals = min(max(decimals_for(small), 0), most)
    texts = [fixed(value / METRES_PER[unit], decimals) for value in values]
    return LengthColumn(UNIT_TEXT.get(unit, unit), texts)


def lengths(metres: Sequence[float]) -> list[str]:
    """Write the lengths of a column, each with the unit.

    >>> lengths([0.052, 0.0043, float("nan")])
    ['5.20 cm', '0.43 cm', '–']
    """
    unit, texts = length_column(metres)
    return [text if text == MISSING else f"{text} {unit}" for text in texts]


def per_cent(share, decimals=0):
    """Write a share.

    >>> per_cent(0.124)
    '12 %'
    """
    return numbers_set(f"{100.0 * share:.{decimals}f} %")


def seconds(duration):
    """Write a duration.

    >>> seconds(0.432), seconds(75.0)
    ('0.43 s', '1 min 15 s')
    """
    if duration < 59.5:
        return f"{number(duration)} s"
    minutes, rest = divmod(round(duration), 60)
    return f"{minutes} min {rest} s"


def scale(scale_number):
    """Write an image scale.

    >>> scale(8000.0)
    '1:8000'
    """
    return f"1:{figure(scale_number, '.0f')}"


def factor(value):
    """Write a ratio as it stands in a sentence.

    >>> factor(1.469)
    '1.5 times'
    """
    return translated("{ratio} times", ratio=number(value))


def count(amount, noun, plural=None):
    """Write a number of things.

    >>> count(1, "point"), count(1061, "point"), count(2, "axis", "axes")
    ('1 point', '1061 points', '2 axes')
    """
    return f"{amount:d} {noun if amount == 1 else plural or noun + 's'}"


def number_word(amount):
    """Write a small number as a word, others in digits.

    >>> number_word(2), number_word(35)
    ('two', '35')
    """
    if 0 <= amount < len(NUMBER_WORDS):
        return translated(NUMBER_WORDS[amount])
    return figure(amount, "d")


def at_least(metres):
    """Write a height that must not be undercut: rounded up to ten metres.

    >>> at_least(1324.2)
    '1330'
    """
    return figure(10 * math.ceil(metres / 10.0), "d")


def names(ids: Iterable[str], most: int = 5, *, n_all: int | None = None) -> str:
    """Write a list of names, shortened to the first few.

    ``n_all`` is how many there are, where ``ids`` are but the first of them.

    >>> names(["7/8", "8/9", "9/10"], most=2)
    '7/8, 8/9 and 1 more'
    >>> names(["7/8", "8/9"])
    '7/8, 8/9'
    """
    ids = list(ids)
    shown = ", ".join(all_shortened(ids[:most]))
    rest = (len(ids) if n_all is None else n_all) - most
    if rest <= 0:
        return shown
    return translated("{names} and {rest} more", names=shown, rest=rest)


def table(rows: Sequence[Sequence[str]], *, header=(), align="", indent=2) -> str:
    """Align columns of text, in lines without trailing blanks; empty without rows.

    ``align`` has one letter per column, ``l`` or ``r``; the default is left for the
    first column and right for the others. Raises ValueError where rows differ in length
    (a fault of the program, not of its user).

    >>> print(table([["high", "1:15000"], ["low", "1:8000"]], header=["", "scale"]))
              scale
      high  1:15000
      low    1:8000
    """
    # names from files must neither break a line nor steer a terminal
    lines = [
        list(map(printable, line)) for line in ((header, *rows) if header else rows)
    ]
    if not lines:
        return ""
    align = align or "l" + "r" * (len(lines[0]) - 1)
    widths = [max(map(cell_len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        " " * indent
        + "  ".join(
            _padded(cell, width, side)
            for cell, width, side in zip(line, widths, align, strict=True)
        ).rstrip()
        for line in lines
    )


def _padded(cell, width, side):
    blank = " " * (width - cell_len(cell))
    return cell + blank if side == "l" else blank + cell


def wrapped(text, *, first="", indent="", width=WIDTH):
    """Wrap prose to lines; words, so names and paths, are never broken.

    ``first`` and ``indent`` are what the first line and the other lines start with.
    """
    return textwrap.fill(
        text,
        width,
        initial_indent=first,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
