"""The language of what users read: messages from one catalogue, figures in its form.

A message is its English sentence with named places, which the call fills:
``translated("{a} of {b}", a=…, b=…)``. It is looked up when it is called, in
``languages/<language>.mo``; without an entry, and in English, it stands as written.
Words that are data (column names, JSON keys, codes, settings, file names) are no
messages.

Whole numbers choose the form of their noun: ``translated("{n:point|points}", n=…)``.

A text that a result keeps, or an error, stays English; see ``kept_texts``.

The language is a context variable: threads and workers start in English.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, wraps
from gettext import GNUTranslations
from numbers import Integral
from pathlib import Path
from typing import TypeVar

from einschalt.foundations.display_names import GROUP_SPACE
from einschalt.foundations.errors import SettingsError

_Key, _Words = TypeVar("_Key"), TypeVar("_Words")
ENGLISH = "en"
LANGUAGES = (ENGLISH, "de")
CATALOGUES = Path(__file__).with_name("languages")
# of the variables of POSIX the first that is set decides
LOCALE_VARIABLES = ("LC_ALL", "LC_MESSAGES", "LANG")
DECIMAL_SIGN = {"de": ","}
# DIN 1333 groups by a space; it must not break, and four digits need none. The same
# space stands before a per cent sign
GROUP_SIGN = {"de": GROUP_SPACE}
FEWEST_GROUPED = 5
MINUS_SIGN = {"de": "\N{MINUS SIGN}"}
# before a number, and not between the parts of a name or behind an exponent
_MINUS = re.compile(r"(?<![^\s(±])-(?=\d)")
_PER_CENT = re.compile(r"(?<=\d) ?%")
_PLAIN_NUMBER = re.compile(r"(\d+)(?:\.(\d+))?")
_active: ContextVar[str] = ContextVar("language", default=ENGLISH)


def language() -> str:
    """Language of what is written now."""
    return _active.get()


@contextmanager
def written_in(name: str) -> Iterator[None]:
    r"""Write summaries and reports in a language, within a ``with``.

    Parameters
    ----------
    name : str
        "en" or "de".

    Raises
    ------
    SettingsError
        There is no such language.

    Examples
    --------
    >>> with written_in("de"):
    ...     figure(12345.678, ".2f")
    '12\u202f345,68'
    """
    if name not in LANGUAGES:
        raise SettingsError(f"language = {name!r}", expected=" or ".join(LANGUAGES))
    before = _active.set(name)
    try:
        yield
    finally:
        _active.reset(before)


def language_of_locale(environment: Mapping[str, str]) -> str:
    """Language that the variables of POSIX ask for; English where there is none.

    >>> language_of_locale({"LANG": "de_AT.UTF-8"})
    'de'
    >>> language_of_locale({"LC_ALL": "C", "LANG": "de_DE.UTF-8"})
    'en'
    """
    asked = next(filter(None, map(environment.get, LOCALE_VARIABLES)), ENGLISH)
    name = re.split(r"[_.@-]", asked, maxsplit=1)[0].lower()
    return name if name in LANGUAGES else ENGLISH


class Amount(int):
    """A whole number, which is written with the form of its noun that it asks for.

    >>> f"{Amount(1):point|points}, {Amount(3):point|points}, {Amount(3)}"
    '1 point, 3 points, 3'
    """

    def __format__(self, spec):
        """Write the number; with two forms of a noun, parted by ``|``, one of them."""
        one, separator, many = spec.partition("|")
        if not separator:
            return figure(int(self), spec or "d")
        return f"{figure(int(self), 'd')} {one if self == 1 else many}"


def translated(message: str, **values) -> str:
    """Write a message in the active language, its places filled.

    >>> translated("{names} and {rest} more", names="P 1, P 2", rest=3)
    'P 1, P 2 and 3 more'
    """
    if (name := _active.get()) != ENGLISH:
        message = catalogue(name).gettext(message)
    return _filled(message, values) if values else message


def _filled(message, values):
    return message.format(
        **{
            name: Amount(value)
            if isinstance(value, Integral) and not isinstance(value, bool)
            else value
            for name, value in values.items()
        }
    )


def in_english(function: _Words) -> _Words:
    """Let a function compute and raise in English: what is kept knows no language."""

    @wraps(function)
    def computed(*arguments, **options):
        with written_in(ENGLISH):
            return function(*arguments, **options)

    return computed


def mark(message: str) -> str:
    """Name a message for the catalogue, which is looked up where it is written."""
    return message


def mark_each(messages: dict[_Key, _Words]) -> dict[_Key, _Words]:
    """Name the texts of a table for the catalogue, as :func:`mark` does with one."""
    return messages


def figure(value, spec: str = "") -> str:
    """Format a number, with the decimal sign and the groups of the active language.

    >>> figure(12345.678, ".2f")
    '12345.68'
    """
    return numbers_set(format(value, spec))


def numbers_set(text: str) -> str:
    """Set the numbers of a text, which have a decimal point, as the language has them.

    A hyphen before a number is a minus sign.

    >>> with written_in("de"):
    ...     numbers_set("3.7 cm")
    '3,7 cm'
    >>> with written_in("de"):
    ...     numbers_set("95%")
    '95\u202f%'
    """
    if (name := _active.get()) == ENGLISH:
        return text
    text = _PLAIN_NUMBER.sub(lambda found: _set_in(name, *found.groups()), text)
    text = _MINUS.sub(MINUS_SIGN[name], text)
    return _PER_CENT.sub(f"{GROUP_SIGN[name]}%", text)


def _set_in(name, whole, decimals):
    if len(whole) >= FEWEST_GROUPED:
        whole = f"{int(whole):,}".replace(",", GROUP_SIGN[name])
    return whole if decimals is None else f"{whole}{DECIMAL_SIGN[name]}{decimals}"


@cache
def catalogue(name: str) -> GNUTranslations:
    """Messages of a language."""
    with CATALOGUES.joinpath(f"{name}.mo").open("rb") as compiled:
        return GNUTranslations(compiled)
