"""What surveyors call the columns of their tables, and the kinds of their points.

Names are compared folded: ``Pkt.-Nr.`` is ``pktnr``, ``Höhe`` is ``hoehe``.
"""

import re
import unicodedata
from dataclasses import dataclass, field
from functools import lru_cache

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.header_units import (
    ABOVE,
    is_in,
    is_length,
    is_unit,
    may_be_in,
    parted_unit,
)
from einschalt.foundations.number_parsing import DEGREES
from einschalt.foundations.words_of_countries import (
    EASTING_IS_X,
    LETTERED,
    NORTHING_IS_X,
    SOUTHING_IS_X,
)
from einschalt.foundations.words_of_surveyors import KINDS, WORDS

WEAK_NAMES = WORDS["point_id"][""].split()
FIRST_NAME = WEAK_NAMES.index("name")  # before it are numbers
WEIGHT = WEAK_NAMES.index("p")  # a code as well; behind it is no name
# a Y and an X on the ground: which of them points to the east depends on the country
LETTERS = {
    letter: {letter.lower(), *(one.format(letter.lower()) for one in LETTERED)}
    for letter in "YX"
}
PLANE = ("easting", "northing")
GEODETIC = {"Y": "easting", "X": "northing"}
MATHEMATICAL = {"Y": "northing", "X": "easting"}
# what Y and X are to the surveyors of a language, where all of them agree
PRACTICE = dict.fromkeys(NORTHING_IS_X, GEODETIC)
PRACTICE |= dict.fromkeys(EASTING_IS_X, MATHEMATICAL)
ENGLISH = "en"  # its words stand in lists of all countries
LONGEST_NAME = 60
# systems and ways of measuring that programs write behind E, N and H
SYSTEM = (
    r"(?:gnss|gps|rtk|utm\d*[a-z]?|gk\d*|m(?:28|31|34)|mgi|dhdn|bmn|lv(?:03|95)"
    r"|ch1903\+?|lambert\s?\d*|l93|rgf93|ngf|etrs\d*|adria|nhn|dhhn\d*|ln02|evrf\d*"
    r"|rd(?:new)?|nap|taw|eov|eoma|d48|d96|htrs96|hdks|hvrs71|pl-?(?:1992|2000)"
    r"|sweref\s?99\w*|rt90|rh\s?2000|nn\s?(?:1954|2000)|dvr90|n2000|n60|kron\w*"
    r"|s-?jtsk|bpv|pt-?tm06|datum73|wgs\s?84|ahd|aod|m?aod|odn|asl|mba|amsl)"
)
ENDING = re.compile(rf"[\s_.,:/(\[-]+{SYSTEM}[)\]]?$", re.IGNORECASE)
BEGINNING = re.compile(rf"^{SYSTEM}[\s_.:/-]+(?=\S)", re.IGNORECASE)
METRES_ABOVE = re.compile(rf"[\s,]+m\s*{ABOVE}$", re.IGNORECASE)
NUMERO = re.compile(r"\bn\.?[°º]")  # and not the N of northing
# a letter beside a word, in brackets or behind a stroke: Rechtswert (Y), X (North)
BETWEEN = r"\s*[(\[/_]\s*"
WITH_LETTER = (
    re.compile(
        rf"\s*(?P<word>[^()\[\]/_]+?){BETWEEN}(?P<letter>[a-z])\s*[)\]]?\s*",
        re.IGNORECASE,
    ),
    re.compile(
        rf"\s*(?P<letter>[a-z]){BETWEEN}(?P<word>[^()\[\]/_]+?)\s*[)\]]?\s*",
        re.IGNORECASE,
    ),
)
AXES = {"easting": "xye", "northing": "xyn", "height": "zh"}
PLACES = tuple(AXES)
UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "æ": "ae"})
UMLAUTS |= str.maketrans({"ø": "oe", "ł": "l", "đ": "d", "ı": "i"})  # have no parts


def folded(word):
    """Fold a word: small letters and digits alone, umlauts written out.

    >>> folded("Pkt.-Nr."), folded("Höhe"), folded("Numéro"), folded("Paßpunkt")
    ('pktnr', 'hoehe', 'numero', 'passpunkt')
    >>> folded("Współrzędna X"), folded("Høyde"), folded("Ｘ座標"), folded("σ E")
    ('wspolrzednax', 'hoeyde', 'x座標', 'σe')
    """
    return _folded(str(word))


@lru_cache(maxsize=4096)  # each name of a header is asked for by every column
def _folded(word):
    small = unicodedata.normalize("NFC", word).casefold().translate(UMLAUTS)
    small = NUMERO.sub("no ", small)
    plain = unicodedata.normalize("NFKD", small)
    return "".join(char for char in plain if char.isalnum())


def _by_word(table):
    """Canonical name of each word: the languages that have it, and its rank.

    A word that stands among the weak ones is of no language.
    """
    found = {}
    for name, languages in table.items():
        for language, words in languages.items():
            for rank, word in enumerate(words.split()):
                known, first = found.get((name, folded(word)), (frozenset(), rank))
                found[name, folded(word)] = known | {language}, min(rank, first)
    return {
        key: (frozenset() if "" in known else known, rank)
        for key, (known, rank) in found.items()
    }


COLUMN_WORDS = _by_word(WORDS)
WORDS_OF_ALL = {word for _, word in COLUMN_WORDS}.union(*LETTERS.values())
KIND_WORDS = {word: kind for kind, word in _by_word(KINDS)}


def kind_of(word):
    """Role that a word for a kind of point means; None where it is not known.

    >>> kind_of("Paßpunkt"), kind_of("Kontrollpunkt"), kind_of("Bolzen")
    ('control', 'check', None)
    """
    return KIND_WORDS.get(folded(word))


def is_word_of_a_table(name):
    """Whether a word names a column in any table, its unit aside.

    >>> is_word_of_a_table("Höhe [m]"), is_word_of_a_table("Ã")
    (True, False)
    """
    word = parted_unit(_without_letter(_without_ending(name)), is_plain=True)[0]
    return folded(word) in WORDS_OF_ALL


@dataclass(frozen=True)
class Meant:
    """What the names of a header mean."""

    names: tuple[str, ...]  # as the schema calls them, the others as they are
    translated: dict  # name of the schema: name in the header
    # what Y and X are to those who speak the language of the other names, and its code
    practice: dict | None = None
    language: str = ""
    # a Y and an X stand in the header, called northing and easting for the time being
    letters: tuple[str, str] | None = None
    is_by_place: bool = False  # there are no names; the letters are positions
    units: dict = field(default_factory=dict)  # of lengths, by the schema's names
    angles: dict = field(default_factory=dict)  # units of angles, likewise


def columns_meant(names, schema, given=None, *, source="", row=None) -> Meant:
    """Understand the names of a header.

    ``given`` says by the schema's name what a column is called; it goes before all
    words. A name that is the schema's own is never translated. A TableError where two
    columns could be meant, or ``given`` names none.
    """
    where = {"file": source, "row": row}
    taken = _given(names, schema, given or {}, where)
    free = [n for n in schema.names if n not in taken and n not in names]
    own = set(schema.names) - set(taken)
    rest = [k for k, n in enumerate(names) if n not in own and k not in taken.values()]
    languages = []  # of each word
    for name in free:
        found = _candidates(names, rest, schema, name)
        if len(found) > 1:
            raise _two_meant(name, [names[k] for _, k, _ in found], where)
        for language, place, _ in found:
            taken[name] = place
            rest.remove(place)
            languages.append(language)
    letters = _letters(names, rest, schema, taken)
    if letters is not None:
        taken |= {MATHEMATICAL[letter]: place for letter, place in letters.items()}
    _untangle_h(names, schema, taken)
    _untangle_p(names, schema, taken)
    # a column that another one was named for keeps no name of the schema
    meant = [
        f"{n} (not used)" if taken.get(n, k) != k else n for k, n in enumerate(names)
    ]
    for name, place in taken.items():
        meant[place] = name
    return Meant(
        tuple(meant),
        {name: names[place] for name, place in sorted(taken.items(), key=_place)},
        practice=PRACTICE.get(language := _language(languages)),
        language=language,
        letters=None if letters is None else tuple(names[letters[k]] for k in "YX"),
        units=_units(names, taken, given or {}, schema, is_length),
        angles=_units(names, taken, given or {}, schema, DEGREES.__eq__),
    )


def columns_by_place(names, usual, schema, given=None, *, source="") -> Meant:
    """Understand a list of points whose columns have no names.

    ``names`` are made of their positions, ``usual`` has what is no coordinate on the
    ground, and ``given`` goes before it. Two numbers follow the name of a ground point:
    which of them is the easting is open.
    """
    given = given or {}
    taken = {n: said for n, said in usual.items() if said not in given.values()}
    meant = columns_meant(names, schema, taken | given, source=source)
    if set(PLANE) & set(given) or not set(PLANE) <= set(schema.names):
        return meant
    places = dict(zip(PLANE, names[1:3], strict=True))
    renamed = {said: name for name, said in places.items()}
    return Meant(
        tuple(renamed.get(name, name) for name in meant.names),
        meant.translated | places,
        letters=(places["northing"], places["easting"]),
        is_by_place=True,
    )


def _language(words):
    """Language of all the words of a header; empty where it is open what Y and X are.

    ``words``: for each of them the languages that have it, none of a weak one. English
    words stand in lists of all countries.
    """
    known = [one for one in words if one and ENGLISH not in one]
    common = frozenset.intersection(*known) if known else frozenset()
    told = [one for one in (*PRACTICE, *SOUTHING_IS_X) if one in common]
    if "de" in told:
        return "de"
    is_agreed = len({str(PRACTICE.get(one)) for one in common}) == 1
    return told[0] if told and is_agreed else ""


def _place(item):
    return item[1]


def _given(names, schema, given, where):
    """Positions of the columns that were named."""
    taken = {}
    for name, said in given.items():
        if name not in schema.names:
            raise TableError(
                f"columns: {shortened(name)!r} is no column of {schema.name}",
                expected=", ".join(schema.names),
                remedy='Write them as in columns = {easting = "Rechtswert"}',
                file=where["file"],
            )
        if said not in names:
            raise TableError(
                f"column '{shortened(said)}', named for {name}, is missing, found "
                f"{name_some(names, 8)}",
                remedy="Correct columns in block.toml",
                **where,
            )
        _require_own_unit(said, name, schema, where)
        taken[name] = list(names).index(said)
    return taken


def _require_own_unit(said, name, schema, where):
    """Refuse a column that was named for another one, and has a unit of its own."""
    expected = next(column.unit for column in schema.columns if column.name == name)
    unit = parted_unit(said)[1]
    if not expected or unit is None or not is_unit(unit) or may_be_in(unit, expected):
        return
    raise TableError(
        f"column '{shortened(said)}', named for {name}, is in {unit}",
        expected=expected,
        remedy=f"Give it in {expected}, or correct its name if that is wrong",
        **where,
    )


def _candidates(names, rest, schema, name):
    """Columns that may be one of the schema's; the strongest words alone."""
    unit = next(column.unit for column in schema.columns if column.name == name)
    words = {place: _word_in(names[place], unit) for place in rest}
    found = _fitting(words, name)
    if not found:  # only then the system behind the word is left out
        plain = {place: _word_in(names[place], unit, is_plain=True) for place in rest}
        found = _fitting(plain, name)
    strong = [one for one in found if one[0]]
    best = min((rank for _, _, rank in found), default=0)
    if not strong and name == "point_id" and 0 < best < FIRST_NAME:
        # a number and a name: which of them do the other tables have? An id tells
        named = [one for one in found if FIRST_NAME <= one[2] < WEIGHT]
        return [one for one in found if one[2] == best] + named
    return strong or [one for one in found if one[2] == best]


def _fitting(words, name):
    """Language, position and rank of the words that mean one of the schema's names."""
    found = []
    for place, word in words.items():
        if word is None:
            continue
        key = (name, word)
        if key in COLUMN_WORDS:
            found.append((COLUMN_WORDS[key][0], place, COLUMN_WORDS[key][1]))
        elif word == folded(name):
            found.append((frozenset({ENGLISH}), place, 0))
    return found


def _without_ending(name):
    """Name without the system that some programs write behind it.

    Nor what heights are counted from, in metres.

    >>> _without_ending("Y GK M34"), _without_ending("E_GNSS"), _without_ending("GNSS")
    ('Y', 'E', 'GNSS')
    >>> _without_ending("EOV Y"), _without_ending("Z (NAP)")
    ('Y', 'Z')
    >>> _without_ending("Höhe m ü. A.")
    'Höhe'
    """
    if len(name) > LONGEST_NAME:  # of a column; what is longer is none
        return name
    name = METRES_ABOVE.sub("", unicodedata.normalize("NFC", name))
    while (plain := ENDING.sub("", name)) != name:
        name = plain
    return BEGINNING.sub("", name)


def _without_letter(name):
    """Name without the letter of its axis, where a word beside that tells more.

    >>> _without_letter("Rechtswert (Y)"), _without_letter("X (Nord)")
    ('Rechtswert', 'Nord')
    >>> _without_letter("N (X)"), _without_letter("y (H)")
    ('N', 'y (H)')
    """
    if len(name) > LONGEST_NAME:
        return name
    for pattern in WITH_LETTER:
        found = pattern.fullmatch(name)
        if found is not None and _tells_more(folded(found["word"]), found):
            return found["word"]
    return name


def _tells_more(word, found):
    """Whether a word means one place on the ground, and no other than its letter.

    H may be Hochwert or a height, and E_N a covariance.
    """
    letter = found["letter"].casefold()
    meant = [place for place in PLACES if (place, word) in COLUMN_WORDS]
    if len(meant) != 1:
        return False
    if len(word) == 1:
        return word in "en" and letter in "xy" and "_" not in found[0]
    return letter in AXES[meant[0]] or letter == word[0]


def _word_in(name, unit, *, is_plain=False):
    """Folded word before the unit; None where that is another kind of unit.

    ``is_plain``: units without brackets and systems behind the word are left out too.
    """
    if is_plain:
        name = _without_ending(name)
    word, said = parted_unit(_without_letter(name), is_plain=is_plain)
    word = _without_letter(word)
    if is_plain:
        word = _without_ending(word)
    return folded(word) if said is None or may_be_in(said, unit) else None


def in_other_unit(names, schema, name):
    """Column that is called as one of the schema's, but has another unit.

    Its name and that unit; None where there is none.

    >>> from einschalt.foundations.tables import CONTROL_POINTS
    >>> in_other_unit(["Nr", "Rechtswert [ft]"], CONTROL_POINTS, "easting")
    ('Rechtswert [ft]', 'ft')
    """
    unit = next(column.unit for column in schema.columns if column.name == name)
    for one in names:
        word, said = parted_unit(one, is_plain=True)
        if said is None or not unit or is_in(said, unit):
            continue
        word = folded(word)
        if word == folded(name) or (name, word) in COLUMN_WORDS:
            return one, said
    return None


def _units(names, taken, given, schema, is_meant):
    """Units that stand behind the names of columns, by the schema's names.

    ``is_meant``: whether it is one of a column with the unit of the schema.
    """
    of_column = {column.name: column.unit for column in schema.columns}
    said = {
        name: parted_unit(names[place], is_plain=name not in given)[1]
        for name, place in taken.items()
        if is_meant(of_column[name])
    }
    # what else stands in brackets, such as a year, is a part of a name that was given
    return {n: u for n, u in said.items() if u is not None and is_unit(u)}


def _letters(names, rest, schema, taken):
    """Positions of a Y and an X that stand for the plane coordinates."""
    has_plane = any(name in names or name in taken for name in PLANE)
    if has_plane or not set(PLANE) <= set(schema.names):
        return None
    unit = next(c.unit for c in schema.columns if c.name in PLANE)
    for is_plain in (False, True):
        shown = {k: _word_in(names[k], unit, is_plain=is_plain) for k in rest}
        found = {
            letter: [k for k in rest if shown[k] in words]
            for letter, words in LETTERS.items()
        }
        if all(len(places) == 1 for places in found.values()):
            return {letter: places[0] for letter, places in found.items()}
    return None


def _untangle_h(names, schema, taken):
    """R and H are Rechtswert and Hochwert, and H is no height then."""
    unit = next((c.unit for c in schema.columns if c.name in PLANE), "")
    words = [_word_in(name, unit) for name in names]
    if "easting" in taken or "northing" in taken or "r" not in words:
        return
    if "h" in words and set(PLANE) <= set(schema.names) and not set(PLANE) & {*names}:
        if taken.get("height") == words.index("h"):
            del taken["height"]
            if "z" in words:
                taken["height"] = words.index("z")
        taken |= {"easting": words.index("r"), "northing": words.index("h")}


def _untangle_p(names, schema, taken):
    """M and P are distances to the meridian and its perpendicular in Portugal."""
    unit = next((c.unit for c in schema.columns if c.name in PLANE), "")
    words = [_word_in(name, unit) for name in names]
    is_pair = words.count("m") == words.count("p") == 1
    has_plane = any(name in names or name in taken for name in PLANE)
    if not is_pair or has_plane or not set(PLANE) <= set(schema.names):
        return
    pair = {"easting": words.index("m"), "northing": words.index("p")}
    if "point_id" in taken and taken["point_id"] not in pair.values():
        taken |= pair


def _two_meant(name, found, where):
    both = " and ".join(repr(shortened(one)) for one in found)
    return TableError(
        f"columns {both} could both be {name}",
        expected="one column for each",
        remedy=f'Say which: columns = {{{name} = "{found[0]}"}} in block.toml, or '
        "rename the other",
        **where,
    )


def translation_note(meant, source, hidden=()):
    """Say which column was understood as which; None where nothing was translated."""
    shown = {n: said for n, said in meant.translated.items() if n not in hidden}
    parts = [f"{said!r} = {name}" for name, said in shown.items()]
    return f"{source}: column {', '.join(parts)}" if parts else None
