"""The language of what users read: messages from one catalogue, figures in its form.

A message is its English sentence with named places, which the call fills:
``translated("{a} of {b}", a=…, b=…)``. It is looked up when it is called, in
``languages/<language>.mo``; without an entry, and in English, it stands as written.
Words that are data (column names, JSON keys, codes, settings, file names) are no
messages.

The language is a context variable: threads and workers start in English.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from gettext import GNUTranslations
from pathlib import Path

ENGLISH = "en"
LANGUAGES = (ENGLISH, "de")
CATALOGUES = Path(__file__).with_name("languages")
# of the variables of POSIX the first that is set decides
LOCALE_VARIABLES = ("LC_ALL", "LC_MESSAGES", "LANG")
DECIMAL_SIGN = {"de": ","}
# DIN 1333 groups by a space; it must not break, and four digits need none
GROUP_SIGN = {"de": "\N{NARROW NO-BREAK SPACE}"}
FEWEST_GROUPED = 5
_PLAIN_NUMBER = re.compile(r"(\d+)(?:\.(\d+))?")
_active: ContextVar[str] = ContextVar("language", default=ENGLISH)


def language() -> str:
    """Language of what is written now."""
    return _active.get()


@contextmanager
def written_in(name: str) -> Iterator[None]:
    r"""Write in a language, within a ``with``; ValueError where there is none such.

    >>> with written_in("de"):
    ...     figure(12345.678, ".2f")
    '12\u202f345,68'
    """
    if name not in LANGUAGES:
        raise ValueError(f"language {name!r} is none of {', '.join(LANGUAGES)}")
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


def translated(message: str, **values) -> str:
    """Write a message in the active language, its places filled.

    >>> translated("{names} and {rest} more", names="P 1, P 2", rest=3)
    'P 1, P 2 and 3 more'
    """
    if (name := _active.get()) != ENGLISH:
        message = _catalogue(name).gettext(message)
    return message.format(**values) if values else message


def plural(one: str, many: str, n: int, **values) -> str:
    """Write the form that a number asks for; ``{n}`` is the number, as a figure.

    >>> plural("{n} second", "{n} seconds", 1), plural("{n} second", "{n} seconds", 2)
    ('1 second', '2 seconds')
    """
    if (name := _active.get()) != ENGLISH:
        message = _catalogue(name).ngettext(one, many, n)
    else:
        message = one if n == 1 else many
    return message.format(n=figure(n, "d"), **values)


def mark(message: str) -> str:
    """Name a message for the catalogue, which is looked up where it is written."""
    return message


def figure(value, spec: str = "") -> str:
    """Format a number, with the decimal sign and the groups of the active language.

    >>> figure(12345.678, ".2f")
    '12345.68'
    """
    text = format(value, spec)
    if (name := _active.get()) == ENGLISH:
        return text
    return _PLAIN_NUMBER.sub(lambda found: _set_in(name, *found.groups()), text)


def _set_in(name, whole, decimals):
    if len(whole) >= FEWEST_GROUPED:
        whole = f"{int(whole):,}".replace(",", GROUP_SIGN[name])
    return whole if decimals is None else f"{whole}{DECIMAL_SIGN[name]}{decimals}"


@cache
def _catalogue(name):
    with CATALOGUES.joinpath(f"{name}.mo").open("rb") as compiled:
        return GNUTranslations(compiled)
