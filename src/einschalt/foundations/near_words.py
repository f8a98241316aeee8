"""The word, or the name of a point, that may be meant by one written wrongly."""

import re
import unicodedata
from collections import defaultdict
from difflib import get_close_matches

from einschalt.foundations.value_descriptions import described

ALIKE = 0.6  # share of letters that two words have in common
SEPARATORS, LEADING_ZEROS = re.compile(r"[\W_]+"), re.compile(r"(?<!\d)0+(?=\d)")
BLANKS, NOTHING = re.compile(r"\s+"), re.compile(r"(?!)")
IN_THOUSANDS, FEWEST_OF_A_HABIT = re.compile(r"[1-9]\d{0,2}(\s\d{3})+"), 3
NOT_BETWEEN_DIGITS = re.compile(r"(?<!\d)/|/(?!\d)")
DECIMALS_OF_NONE = re.compile(r"(?<=\d)[.,]0+$")  # as programs write a whole number
# letters of other scripts that look Latin as capitals: Greek, then Cyrillic
OTHER_SCRIPTS = (
    "\u03b1\u03b2\u03b5\u03b6\u03b7\u03b9\u03ba\u03bc\u03bd\u03bf"
    "\u03c1\u03c4\u03c5\u03c7"
    "\u0430\u0432\u0441\u0435\u04bb\u0456\u0458\u043a\u043c\u043d"
    "\u043e\u0440\u0455\u0442\u0443\u0445"
)
LATIN = "abezhikmnoptyxabcehijkmhopstyx"
LOOKALIKES = str.maketrans(OTHER_SCRIPTS + OTHER_SCRIPTS.upper(), LATIN + LATIN.upper())
O_BESIDE_DIGITS = re.compile(r"(?<=\d)o+|o+(?=\d)")
# share of right names that look misspelt as well: beyond it that is chance
MOST_BY_CHANCE = 0.05
# names of a table that are compared with another one, and the share to be found there
MOST_COMPARED, LEAST_MEANT = 10_000, 0.3


def nearest(value, known, *, alike=ALIKE):
    """Give the known word that is most like a value; None where none is.

    Words in capitals and in small letters are the same.

    >>> nearest("Korner", ("mid_edge", "corner")), nearest(3, ("mid_edge", "corner"))
    ('corner', None)
    """
    words = {word.casefold(): word for word in reversed(list(known)) if word}
    # of any kind and length
    said = described(value).strip("'\"").casefold()
    near = get_close_matches(said, words, n=1, cutoff=alike)
    return words[near[0]] if near else None


def names_meant(strange, right, others):
    """Tell which of other names may be meant by strange ones, a dict.

    The same but for capitals, separators, zeros that lead a number, the decimals of a
    whole number (1001.0), accents as characters of their own, Greek or Cyrillic letters
    that look Latin, and the letter O for a zero; or with two neighbouring letters
    exchanged, unless ``right`` names turn into others so as well, as numbers without
    gaps do. Separators between digits part numbers: 1-12 is not 11-2; but for blanks
    before thousands, or in many names. Where several names fit, none is meant. For
    zeros that end decimals see :mod:`einschalt.foundations.names_as_numbers`.

    >>> names_meant(["P-007", "1032", "48"], ["1001"], ["p7", "1302", "50"])
    {'P-007': 'p7', '1032': '1302'}
    >>> names_meant(["1oo1"], ["1002"], ["1001"])
    {'1oo1': '1001'}
    >>> names_meant(["1032"], ["1012"], ["1302", "1102"])
    {}
    >>> names_meant(["1 032", "1 12"], ["1012"], ["1032", "112"])
    {'1 032': '1032'}
    """
    exact, fitting = set(others), _written_alike(strange, others)
    by_chance = sum(bool(_exchanged(name, exact)) for name in right)
    if by_chance <= MOST_BY_CHANCE * len(right):
        fitting = {n: same | _exchanged(n, exact) for n, same in fitting.items()}
    return _without_blanks(strange, others) | _only_ones(fitting)


def _without_blanks(strange, others):
    """Other names that strange ones are without blanks between digits, a dict.

    Such a blank may part two numbers: that it does not, groups of thousands say, or
    many names.
    """
    found = _only_ones(_written_alike(strange, others, without=BLANKS))
    is_habit = FEWEST_OF_A_HABIT <= len(found) > LEAST_MEANT * len(strange)
    return {n: o for n, o in found.items() if is_habit or IN_THOUSANDS.fullmatch(n)}


def _written_alike(strange, others, *, without=NOTHING):
    """Other names that are each strange one but for how they are written, sets."""
    alike = defaultdict(set)
    for name in set(others):
        alike[_plain(without.sub("", name))].add(name)
    plain = {name: _plain(without.sub("", name)) or None for name in strange}
    return {name: alike.get(word, set()) for name, word in plain.items()}


def _only_ones(fitting):
    return {name: min(same) for name, same in fitting.items() if len(same) == 1}


def pair_meant(strange, others):
    """First of strange names that is another name written otherwise, and that one.

    None where most of the names are not. For names of two tables that share none.

    >>> pair_meant(["01001", "01002"], ["1001", "1002", "1003"])
    ('01001', '1001')
    >>> pair_meant(["7", "8", "9", "10"], ["07", "1", "2"]) is None
    True
    """
    strange = list(dict.fromkeys(strange))[:MOST_COMPARED]
    meant = _only_ones(_written_alike(strange, others))
    meant = _without_blanks(strange, others) | meant
    if len(meant) <= LEAST_MEANT * len(strange):
        return None
    return next(iter(meant.items()))


def told_apart(one, other):
    r"""Two names as text in which they differ: with codes where they look the same.

    >>> told_apart("01", "1"), told_apart("M\u00fc", "Mu\u0308")
    (('01', '1'), ('M\\xfc', 'Mu\\u0308'))
    """
    if not looks_the_same(one, other):
        return one, other
    return ascii(one)[1:-1], ascii(other)[1:-1]


def looks_the_same(one, other):
    r"""Whether names that differ look the same where they are shown.

    >>> looks_the_same("\u0410 1", "A 1"), looks_the_same("A01", "A1")
    (True, False)
    """
    return one != other and _as_seen(one) == _as_seen(other)


def _as_seen(name):
    """A name in the Latin letters as which others are seen, with accents joined."""
    return unicodedata.normalize("NFKC", name).translate(LOOKALIKES)


def _plain(name):
    seen = DECIMALS_OF_NONE.sub("", _as_seen(name)).casefold()
    digits = O_BESIDE_DIGITS.sub(lambda found: "0" * len(found[0]), seen)
    numbers = LEADING_ZEROS.sub("", SEPARATORS.sub("/", digits))
    return NOT_BETWEEN_DIGITS.sub("", numbers)


def _exchanged(name, others):
    """The other names that two neighbouring letters make when exchanged."""
    found = set()
    for k in range(len(name) - 1):
        turned = name[:k] + name[k + 1] + name[k] + name[k + 2 :]
        if turned != name and turned in others and name[k : k + 2].isalnum():
            found.add(turned)
    return found
