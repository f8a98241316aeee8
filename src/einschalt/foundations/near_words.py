"""The word, or the name of a point, that may be meant by one written wrongly."""

import re
from collections import defaultdict
from difflib import get_close_matches

from einschalt.foundations.value_descriptions import described

ALIKE = 0.6  # share of letters that two words have in common
SEPARATORS, LEADING_ZEROS = re.compile(r"[\W_]+"), re.compile(r"(?<!\d)0+(?=\d)")
NOT_BETWEEN_DIGITS = re.compile(r"(?<!\d)/|/(?!\d)")
O_BESIDE_DIGITS = re.compile(r"(?<=\d)o+|o+(?=\d)")
# share of right names that look misspelt as well: beyond it that is chance
MOST_BY_CHANCE = 0.05


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

    The same but for capitals, separators, zeros that lead a number, and the letter O
    for a zero; or with two neighbouring letters exchanged, unless ``right`` names turn
    into others so as well, as numbers without gaps do. Separators between digits part
    numbers: 1-12 is not 11-2. Where several names fit, none is meant.

    >>> names_meant(["P-007", "1032", "48"], ["1001"], ["p7", "1302", "50"])
    {'P-007': 'p7', '1032': '1302'}
    >>> names_meant(["1oo1"], ["1002"], ["1001"])
    {'1oo1': '1001'}
    >>> names_meant(["1032"], ["1012"], ["1302", "1102"])
    {}
    """
    exact, alike = set(others), defaultdict(set)
    for name in exact:
        alike[_plain(name)].add(name)
    fitting = {name: alike.get(_plain(name) or None, set()) for name in strange}
    by_chance = sum(bool(_exchanged(name, exact)) for name in right)
    if by_chance <= MOST_BY_CHANCE * len(right):
        fitting = {n: same | _exchanged(n, exact) for n, same in fitting.items()}
    return {name: min(same) for name, same in fitting.items() if len(same) == 1}


def _plain(name):
    digits = O_BESIDE_DIGITS.sub(lambda found: "0" * len(found[0]), name.casefold())
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
