"""Meanings of names, as they stand in tables: with the unit in brackets behind."""

import re

# a list such as [flight, model_id] is no unit
WITH_UNIT = re.compile(r"(.*?)(?: \[([^\],\s]+)\])?")


def unit_and_meaning(said) -> tuple[str, str]:
    """Unit, empty where there is none, and meaning.

    >>> unit_and_meaning("displacement, TOTAL [m]"), unit_and_meaning("name")
    (('m', 'displacement, TOTAL'), ('', 'name'))
    """
    meaning, unit = WITH_UNIT.fullmatch(said).groups("")
    return unit, meaning
