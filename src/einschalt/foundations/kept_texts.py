"""English texts that results and errors keep, in the language of who reads them.

Why a model failed, what was noted while a file was read, what an error says: such a
text is English wherever it is kept, so that results are the same in every language. It
is recognised where it is read, by the sentence of the source that it fills: as it
stands there, or with ``{0}``, ``{1}`` … for the places of an f-string.
"""

import re
import string
from functools import cache

from einschalt.foundations.language import (
    ENGLISH,
    Amount,
    catalogue,
    language,
    mark,
    numbers_set,
    translated,
    written_in,
)

# where a fault lies
WHERE = {
    "row": mark("row {name}"),
    "point": mark("point {name}"),
    "model": mark("model {name}"),
}
PLACE = re.compile(rf"({'|'.join(WHERE)}) (\S+)")
# as errors.name_some writes
AND_MORE = re.compile(r"(.+) and (\d+) more")
# as value_ranges.Range writes itself
RANGE = re.compile(
    r"(?P<whole>a whole number, )?"
    r"(?P<low>[-+\d.e]+) to (?P<high>[-+\d.e]+)(?P<unit> .+)?"
)
# a section of block.toml, and what is said of it
SECTION = re.compile(r"(\[\w+\]) (.+)", re.DOTALL)
# words that may be chosen, as " or ".join writes
CHOICE = re.compile(r"(\S+(?: or \S+|, \S+)*) or (\S+)")
SEVERAL = re.compile(r"(\S+(?: and \S+|, \S+)*) and ([^\s\d]\S*)")
# where a text was put together of messages; it is told itself
EXPECTED = mark("; expected ")
JOINTS = re.compile(rf"(: |{EXPECTED}|; |, (?=of |point |model |row )|(?<=[.?]) |\.$)")
# by which a message is recognised: in one whose places have numbers alone, and others
LETTERS = {True: 4, False: 12}
TYPED = "Write "
LENGTH = re.compile(r"\d+(\.\d+)? (km|m|cm|mm|µm)")
# what is quoted stands in a file as it is written, or is to be typed as it is read, or
# it is a name
AS_TYPED = re.compile(
    r"""(?:['"]|EPSG:|--[\w-]+ |= |\b(?:point|image|name|block|column|row) )\{(\w+)\}"""
)
QUANTITY = re.compile(r"[+-]?\d+(\.\d+)?( (km|m|cm|mm|µm|%))?|1:\d+")


def kept(message: str, **values) -> str:
    """Write a message in English, whatever the language.

    >>> kept("{n:common point|common points}, but {kind} needs 3", n=1, kind="affine")
    '1 common point, but affine needs 3'
    """
    with written_in(ENGLISH):
        return translated(message, **values)


def retold(text: str) -> str:
    """Write a kept English text in the active language, as far as it is known there.

    The text is that of a message, filled; or put together of such.
    """
    name = language()
    if name == ENGLISH or not text:
        return text
    return _recognised(name, text) or "".join(
        _recognised(name, part) or _quantity(part)
        for part in JOINTS.split(text)
        if part
    )


def _quantity(part):
    """A part that is no message: a length in the form of the language, or itself."""
    return numbers_set(part) if LENGTH.fullmatch(part) else part


def place_text(kind: str, name: object) -> str:
    """Write in which row, at which point or in which model something is."""
    return translated(WHERE[kind], name=str(name))


def _recognised(name, text):
    """The text in a language, or None where it fills no message."""
    told = catalogue(name).gettext(text)
    if told != text:
        return told
    if place := PLACE.fullmatch(text):
        return place_text(*place.groups())
    if placed := SECTION.fullmatch(text):
        rest = retold(placed[2])
        if rest != placed[2]:
            return f"{placed[1]} {rest}"
    filled = _as_typed_or_chosen if text.startswith(TYPED) else _again
    for pattern, message, typed in _patterns(name):
        if found := pattern.fullmatch(text):
            parts = {
                place: part if place in typed else filled(part)
                for place, part in found.groupdict().items()
            }
            numbered = sorted(place for place in parts if place.startswith("_"))
            return message.format(*map(parts.get, numbered), **parts)
    if limits := RANGE.fullmatch(text):
        return _range_text(**limits.groupdict())
    return _listed_text(text)


def _listed_text(text):
    """Words that are joined by or, or by and; None of any other text."""
    if words := CHOICE.fullmatch(text):
        message = mark("{names} or {last}")
    elif words := SEVERAL.fullmatch(text):
        message = mark("{names} and {last}")
    else:
        return None
    return translated(message, names=retold(words[1]), last=words[2])


def _as_typed_or_chosen(part):
    """What is to be typed, as the program reads it in whatever language."""
    return _listed_text(part) or part


def _range_text(whole, low, high, unit):
    message = (
        mark("a whole number, {low} to {high}") if whole else mark("{low} to {high}")
    )
    text = translated(message, low=numbers_set(low), high=numbers_set(high))
    return f"{text} {retold(unit[1:])}" if unit else text


def _again(part):
    """What fills a place: a number, a quantity, or words that are messages too."""
    if part.isdecimal():
        return Amount(part)
    if QUANTITY.fullmatch(part):
        return numbers_set(part)
    if found := AND_MORE.fullmatch(part):
        return translated("{names} and {rest} more", names=found[1], rest=int(found[2]))
    if " " not in part:  # a name
        return part
    listed = [_recognised(language(), one) for one in part.split(", ")]
    return ", ".join(listed) if all(listed) else retold(part)


@cache
def _patterns(name):
    """Messages with places as patterns of their English text, the longest first."""
    known = [
        (
            _pattern(english),
            german,
            _as_typed(english),
            len(re.sub(r"\{.*?\}", "", english)),
        )
        for english, german in catalogue(name)._catalog.items()
        if isinstance(english, str) and "{" in english and _is_told_by_text(english)
    ]
    known.sort(key=lambda entry: -entry[-1])
    return [entry[:-1] for entry in known]


def _as_typed(message):
    return {_group(place) for place in AS_TYPED.findall(message)}


def _group(place):
    return f"_{place}" if place.isdecimal() else place


def _places(message):
    return [part for part in string.Formatter().parse(message) if part[1] is not None]


def _is_told_by_text(message):
    """Whether a text tells that it fills this message.

    Its places are texts and numbers, which the facts of findings are not, and it has
    some words of its own.
    """
    places = _places(message)
    if not all(place.isidentifier() or place.isdecimal() for _, place, _, _ in places):
        return False  # braces of another language, such as TOML
    is_kept = all(place.isdecimal() or "|" in spec for _, place, spec, _ in places)
    letters = len(re.sub(r"\{\w*\}|[^a-z]", "", message))
    return letters >= LETTERS[is_kept] and all(
        "|" in spec or not spec for _, _, spec, _ in places
    )


def _pattern(message):
    """A pattern whose groups are the places; that of a number is named ``_0``."""
    parts, seen = [], set()
    for literal, place, spec, _ in string.Formatter().parse(message):
        parts.append(re.escape(literal))
        if place is None:
            continue
        group = _group(place)
        if group in seen:
            parts.append(f"(?P={group})")
        elif spec:
            one, _, many = map(re.escape, spec.partition("|"))
            parts.append(rf"(?P<{group}>\d+) (?:{one}|{many})")
        else:
            parts.append(f"(?P<{group}>.+?)")
        seen.add(group)
    return re.compile("".join(parts), re.DOTALL)
