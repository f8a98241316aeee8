"""Errors in the language of who reads them; they themselves stay English."""

from einschalt.foundations.errors import BlockError, shortened_name, spread
from einschalt.foundations.kept_texts import place_text, retold
from einschalt.foundations.language import ENGLISH, language, mark, translated


def told(error) -> str:
    """Write an error in the active language, as far as its sentences are known there.

    >>> from einschalt.foundations.errors import TableError
    >>> told(TableError("easting 'n/a' is not a number", file="a.csv", row=7))
    "a.csv, row 7: easting 'n/a' is not a number."
    """
    if language() == ENGLISH or not hasattr(error, "found"):
        return retold(str(error))
    if isinstance(error, BlockError):
        return _several(error.problems)
    found, where = retold(error.found), where_of(error)
    found = f"{where}: {found}" if where else found
    if error.expected:
        expected = retold(error.expected)
        message = mark("{found}; expected {expected}")
        found = translated(message, found=found, expected=expected)
    return " ".join(_sentence(part) for part in (found, retold(error.remedy)) if part)


def where_of(error) -> str:
    """File, row, point and model, as far as they are known."""
    places = {"row": error.row, "point": error.point, "model": error.model}
    known = [
        place_text(kind, shortened_name(place))
        for kind, place in places.items()
        if place is not None
    ]
    return ", ".join([*filter(None, [error.file]), *known])


def _several(problems):
    shown = spread(problems)
    total = sum(problem.stands_for for problem in problems)
    rest = total - sum(problem.stands_for for problem in shown)
    lines = [translated("{n:problem|problems}:", n=total)]
    lines += [f"  {told(problem)}" for problem in shown]
    return "\n".join(lines + ([translated("  and {n} more", n=rest)] if rest else []))


def _sentence(text):
    return text if text.endswith("?") else f"{text.rstrip('.')}."
