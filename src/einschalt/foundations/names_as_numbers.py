"""Names of which a spreadsheet makes numbers: 1.1 of 1.10, and the remedies.

The zeros that end the decimals of a number are gone, and no cell tells any more that
they were typed. In a text file 1.1 and 1.10 are two points, as stations have them.
"""

import re
from collections import defaultdict
from pathlib import PurePath

from einschalt.foundations.near_words import LEAST_MEANT, MOST_COMPARED

WORKBOOKS = (".xlsx", ".ods")
A_DECIMAL = re.compile(r"\d+\.\d+")


def is_of_workbook(file):
    """Whether a file is a workbook, by its name."""
    return PurePath(str(file)).suffix.lower() in WORKBOOKS


def remedy(one, other):
    """Remedy of two names of which one is the number that was made of the other."""
    made, typed = sorted((one, other), key=len)
    return (
        f"A spreadsheet makes '{made}' of '{typed}': give the column of names the "
        "format Text, and type the names again"
    )


def remedy_of_two(name, file):
    """Remedy of two rows of one name, where a spreadsheet may have made them alike."""
    if not (is_of_workbook(file) and is_decimal(name or "")):
        return None
    return (
        f"If one of the two was '{name}0', of which a spreadsheet makes '{name}': give "
        "the column of names the format Text, and type the names again; otherwise "
        "delete one of them"
    )


def is_decimal(name):
    """Whether a name is a number with decimals.

    >>> is_decimal("1.1"), is_decimal("11"), is_decimal("P1.1")
    (True, False, False)
    """
    return A_DECIMAL.fullmatch(name) is not None


def lacks_zeros(one, other):
    """Whether the first name is a number with decimals that was made of the other.

    Not where no decimal is left, as of the 7.0 that programs write for 7.

    >>> lacks_zeros("1.1", "1.10"), lacks_zeros("7", "7.0"), lacks_zeros("1.10", "1.1")
    (True, False, False)
    >>> lacks_zeros("P1.1", "P1.10"), lacks_zeros("7.1", "007.10")
    (False, True)
    """
    return is_decimal(one) and one != other and one == number_made_of(other)


def number_made_of(name):
    """A name with decimals as a spreadsheet shows the number of it; else itself.

    Neither the zeros that end the decimals nor those that lead are left.

    >>> number_made_of("1.10"), number_made_of("2.00"), number_made_of("P1.10")
    ('1.1', '2', 'P1.10')
    >>> number_made_of("007.10"), number_made_of("00.50")
    ('7.1', '0.5')
    """
    if not is_decimal(name):
        return name
    whole, _, decimals = name.partition(".")
    return f"{whole.lstrip('0') or '0'}.{decimals.rstrip('0')}".rstrip(".")


def made_or_typed(names, others, files):
    """Other names that names were typed as, or were made of: a dict.

    Only a workbook makes numbers of names. Where several fit, there is none.

    Parameters
    ----------
    names, others : iterable of str
        Of two tables.
    files : tuple of str
        Names of both files.

    Examples
    --------
    >>> made_or_typed(["1.1", "1.20"], ["1.10", "1.2"], ("a.xlsx", "b.csv"))
    {'1.1': '1.10'}
    >>> made_or_typed(["1.1", "1.20"], ["1.10", "1.2"], ("a.csv", "b.csv"))
    {}
    """
    names, others, alike = [*names], {*others}, defaultdict(set)
    if is_of_workbook(files[0]):
        for other in others:
            alike[number_made_of(other)].add(other)
    fitting = {
        name: {other for other in alike.get(name, ()) if lacks_zeros(name, other)}
        for name in names
    }
    if is_of_workbook(files[1]):
        for name in names:
            made = number_made_of(name)
            if made in others and lacks_zeros(made, name):
                fitting[name].add(made)
    return {name: min(found) for name, found in fitting.items() if len(found) == 1}


def pair_made_or_typed(names, others, files):
    """First of names that a workbook has changed so, and the other; None of few.

    For names of two tables that share none.

    >>> pair_made_or_typed(["1.1", "2.1"], ["1.10", "2.10"], ("a.xlsx", "b.csv"))
    ('1.1', '1.10')
    """
    names = list(dict.fromkeys(names))[:MOST_COMPARED]
    meant = made_or_typed(names, others, files)
    if len(meant) <= LEAST_MEANT * len(names):
        return None
    return next(iter(meant.items()))
