"""English texts that results and errors keep, in the language of who reads them.

Why a model failed, what was noted while a file was read, what an error says: such a
text is English wherever it is kept, so that results are the same in every language. It
is recognised where it is read, by the sentence of the source that it fills: as it
stands there, or with ``{0}``, ``{1}`` … for the places of an f-string.
"""

import re
import string
from functools import cache, lru_cache
from itertools import chain, islice

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
# two systems, as they label themselves, and an operation between them
SYSTEMS = re.compile(r"(?P<source>.+ \([\w+:]+\)) to (?P<target>.+ \([\w+:]+\))")
OPERATION = re.compile(r"(?P<name>.+) \((?P<worth>([\d.e-]+ m|PROJ states no).*)\)")
# words that may be chosen, as " or ".join writes
CHOICE = re.compile(r"(\S+(?: or \S+|, \S+)*) or (\S+)")
SEVERAL = re.compile(r"(\S+(?: and \S+|, \S+)*) and ([^\s\d]\S*)")
# where a text was put together of messages; it is told itself
EXPECTED, OTHERWISE = mark("; expected "), mark("Or")
SENTENCES = re.compile(r"(?<=[.?]) |\.$")
JOINTS = re.compile(rf": |{EXPECTED}|; |, (?=of |point |model |row |\d)")
MOST_JOINTS = 8  # of which a text is put together anew
# by which a message is recognised: in one whose places have numbers alone, and others
LETTERS = {True: 4, False: 12}
TYPED = "Write "
LENGTH = re.compile(r"\d+(\.\d+)? (km|m|cm|mm|µm)")
# what is quoted stands in a file as it is written, or is to be typed as it is read, or
# it is a name
AS_TYPED = re.compile(
    r"""(?:['"]|EPSG:|--[\w-]+ |= """
    r"""|\b(?:point|image|name|block|column|row|version) )\{(\w+)\}"""
)
# an amount by the words beside it, and not a name of digits
COUNTED = re.compile(
    r"\b(?:at most|at least|more than|fewer than) \{(\w+)\}"
    r"|(?<!model )(?<!point )(?<!image )(?<!row )\{(\w+)\} "
    r"(?:models|points|plans|images|photographs|combinations|characters)\b"
)
WORD = re.compile(r"[^\W\d_]{2,}")
# names, paths, columns, options
QUOTED = re.compile(r"""'[^']*'|"[^"]*"|„[^“]*“|--[\w-]+|\S*[\w.][/_.=\d]\w\S*""")
PLACE_IN_BRACES = re.compile(r"\{.*?\}")
QUANTITY = re.compile(r"[+-]?\d+(\.\d+)?( (km|m|cm|mm|µm|%))?|1:\d+")


# that fill places; any other single word is a name
SINGLE_WORDS = {
    mark("commas"),
    mark("semicolons"),
    mark("tabs"),
    mark("bars"),
    mark("blanks"),
    mark("metres"),
    mark("millimetres"),
    mark("degree"),
    mark("degrees"),
    mark("radian"),
    mark("radians"),
    mark("foot"),
    mark("feet"),
    mark("inches"),
    mark("US survey feet"),
    mark("US survey foot"),
    mark("decimetres"),
    mark("centimetres"),
    mark("kilometres"),
    mark("nothing"),
    mark("ellipsoidal"),
}


def kept(message: str, **values) -> str:
    """Write a message in English, whatever the language.

    >>> kept("{n:common point|common points}, but {kind} needs 3", n=1, kind="affine")
    '1 common point, but affine needs 3'
    """
    with written_in(ENGLISH):
        return translated(message, **values)


def retold(text: str) -> str:
    """Write a kept English text in the active language, as far as it is known there.

    The text is that of a message, filled; or put together of such. Of several readings
    the one that leaves fewest words in English.
    """
    name = language()
    return text if name == ENGLISH or not text else _retold(name, text)


@lru_cache(maxsize=10_000)
def _retold(name, text):
    if (told := catalogue(name).gettext(text)) != text:
        return told
    readings = (
        _joined(SENTENCES, name, text),
        _readings(name, text),
        _joined(JOINTS, name, text),
        (numbers_set(text) if LENGTH.fullmatch(text) else text,),
    )
    return _least_english(name, chain(*readings))


def _least_english(name, readings):
    """The first of the readings that leaves fewest English words; None of none."""
    best, fewest = None, None
    for told in readings:
        rest = _n_english(name, told)
        if best is None or rest < fewest:
            best, fewest = told, rest
        if not fewest:
            break
    return best


def _joined(joints, name, text):
    """The text as it may have been put together of two messages, which may be too."""
    for joint in islice(joints.finditer(text), MOST_JOINTS):
        before, after = text[: joint.start()], text[joint.end() :]
        told = catalogue(name).gettext(joint[0])
        yield f"{retold(before)}{told}{retold(after)}"


def _n_english(name, told):
    """How many words of a text are those of English messages alone."""
    words = WORD.findall(QUOTED.sub(" ", told))
    return sum(word in _english_words(name) for word in words)


@cache
def _english_words(name):
    """Words of messages that none of the language has."""
    known = catalogue(name)._catalog
    messages = (message for message in known if isinstance(message, str))
    english = {word for message in messages for word in words_of(message)}
    return english - {word for text in known.values() for word in words_of(text)}


def words_of(message: str) -> list[str]:
    """Words of a message, without its places and what it quotes."""
    return WORD.findall(QUOTED.sub(" ", PLACE_IN_BRACES.sub(" ", message)))


def place_text(kind: str, name: object) -> str:
    """Write in which row, at which point or in which model something is."""
    return translated(WHERE[kind], name=str(name))


def _recognised(name, text):
    """The text in a language, or None where it fills no message."""
    return _least_english(name, _readings(name, text))


def _readings(name, text):
    """The text in a language, as each of the messages that it may fill."""
    told = catalogue(name).gettext(text)
    if told != text:
        yield told
        return
    if place := PLACE.fullmatch(text):
        yield place_text(*place.groups())
        return
    if placed := SECTION.fullmatch(text):
        rest = retold(placed[2])
        if rest != placed[2]:
            yield f"{placed[1]} {rest}"
    filled = _as_typed_or_chosen if text.startswith(TYPED) else _again
    for words, pattern, message, (typed, counted) in _patterns(name):
        if words in text and (found := pattern.fullmatch(text)):
            parts = {
                place: part
                if place in typed
                else numbers_set(part)
                if place in counted and part.isdecimal()
                else filled(part)
                for place, part in found.groupdict().items()
            }
            numbered = sorted(place for place in parts if place.startswith("_"))
            yield message.format(*map(parts.get, numbered), **parts)
    if limits := RANGE.fullmatch(text):
        yield _range_text(**limits.groupdict())
    if way := SYSTEMS.fullmatch(text):
        yield translated(mark("{source} to {target}"), **way.groupdict())
    if found := OPERATION.fullmatch(text):
        yield f"{retold(found['name'])} ({retold(found['worth'])})"
    if (listed := _listed_text(text)) is not None:
        yield listed


def _listed_text(text):
    """Words that are joined by or, or by and; None of any other text."""
    if words := CHOICE.fullmatch(text):
        message = mark("{names} or {last}")
    elif words := SEVERAL.fullmatch(text):
        message = mark("{names} and {last}")
    else:
        return None
    # a single word is that of a column or a setting
    names = retold(words[1]) if " " in words[1] else words[1]
    return translated(message, names=names, last=words[2])


def _as_typed_or_chosen(part):
    """What is to be typed, as the program reads it in whatever language."""
    return _listed_text(part) or part


def _range_text(whole, low, high, unit):
    message = (
        mark("a whole number, {low} to {high}") if whole else mark("{low} to {high}")
    )
    text = translated(message, low=numbers_set(low), high=numbers_set(high))
    if not unit:
        return text
    told = retold(unit[1:])
    if told == unit[1:] and told.startswith("("):
        told = f"({retold(told[1:-1])})"
    return f"{text} {told}"


class _Digits(str):
    """Digits: the number of what is counted, or a name, which stays as it is given."""

    __slots__ = ()

    def __format__(self, spec):
        """Write them; with two forms of a noun, parted by ``|``, as their number."""
        return format(Amount(self), spec) if "|" in spec else str(self)


def _again(part):
    """What fills a place: a number, a quantity, or words that are messages too."""
    if part.isdecimal():
        return _Digits(part)
    if QUANTITY.fullmatch(part):
        return numbers_set(part)
    if found := AND_MORE.fullmatch(part):
        return translated("{names} and {rest} more", names=found[1], rest=int(found[2]))
    if " " not in part:
        return translated(part) if part in SINGLE_WORDS else part
    listed = [_recognised(language(), one) for one in part.split(", ")]
    return ", ".join(listed) if all(listed) else retold(part)


@cache
def _patterns(name):
    """Messages with places as patterns of their English text, the longest first.

    Before each the longest of its words in a row, which are looked for in less time.
    """
    known = [
        (
            max((part[0] for part in _parsed(english)), key=len),
            _pattern(english),
            german,
            (_as_typed(english), _counted(english)),
            len(re.sub(r"\{.*?\}", "", english)),
        )
        for english, german in catalogue(name)._catalog.items()
        if isinstance(english, str) and "{" in english and _is_told_by_text(english)
    ]
    known.sort(key=lambda entry: -entry[-1])
    return [entry[:-1] for entry in known]


def _as_typed(message):
    return {_group(place) for place in AS_TYPED.findall(message)}


def _counted(message):
    found = COUNTED.findall(message)
    return {_group(place) for places in found for place in places if place}


def _group(place):
    return f"_{place}" if place.isdecimal() else place


def _parsed(message):
    return string.Formatter().parse(message)


def _places(message):
    return [part for part in _parsed(message) if part[1] is not None]


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
    for literal, place, spec, _ in _parsed(message):
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
