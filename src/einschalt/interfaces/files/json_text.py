"""JSON of other programs: its numbers are floats, however they are written."""

import json

from einschalt.foundations.number_parsing import LARGEST_NUMBER


def parsed_json(text):
    """Parse JSON as ``json.loads`` does; integers that no float holds are infinite.

    What is infinite is refused where numbers are looked at. Python would keep such an
    integer, and fail where it is computed with.

    >>> parsed_json("[12, 1" + 400 * "0" + "]")
    [12, inf]
    """
    return json.loads(text, parse_int=_integer)


def _integer(digits):
    value = int(digits)
    return value if abs(value) <= LARGEST_NUMBER else float(digits)
