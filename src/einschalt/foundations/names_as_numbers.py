"""Names of which a spreadsheet makes numbers: 1.1 of 1.10, and the remedies.

The zeros that end the decimals of a number are gone, and no cell tells any more that
they were typed.
"""

import re
from pathlib import PurePath

WORKBOOKS = (".xlsx", ".ods")
A_DECIMAL = re.compile(r"\d+\.\d+")
REMEDY = (
    "A spreadsheet makes 1.1 of 1.10: give the column of names the format Text, and "
    "type the names again"
)
REMEDY_OF_TWO = (
    "If one of the two was 1.10, of which a spreadsheet makes 1.1: give the column of "
    "names the format Text, and type the names again; otherwise delete one of them"
)


def is_of_workbook(file):
    """Whether a file is a workbook, by its name."""
    return PurePath(str(file)).suffix.lower() in WORKBOOKS


def remedy_of_two(name, file):
    """Remedy of two rows of one name, where a spreadsheet may have made them alike."""
    is_likely = is_of_workbook(file) and is_decimal(name or "")
    return REMEDY_OF_TWO if is_likely else None


def is_decimal(name):
    """Whether a name is a number with decimals.

    >>> is_decimal("1.1"), is_decimal("11"), is_decimal("P1.1")
    (True, False, False)
    """
    return A_DECIMAL.fullmatch(name) is not None


def lacks_zeros(one, other):
    """Whether the first name is the other without the zeros that end its decimals.

    So a spreadsheet makes a number of a name that it takes for one.

    Not where no decimal is left, as of the 7.0 that programs write for 7.

    >>> lacks_zeros("1.1", "1.10"), lacks_zeros("7", "7.0"), lacks_zeros("1.10", "1.1")
    (True, False, False)
    >>> lacks_zeros("P1.1", "P1.10"), lacks_zeros("1", "10")
    (False, False)
    """
    return is_decimal(one) and one != other and one == number_made_of(other)


def number_made_of(name):
    """A name as a spreadsheet shows it that has made a number of it; else itself.

    >>> number_made_of("1.10"), number_made_of("2.00"), number_made_of("P1.10")
    ('1.1', '2', 'P1.10')
    """
    if not is_decimal(name):
        return name
    return name.rstrip("0").rstrip(".")
