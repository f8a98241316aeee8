"""The word that may be meant by one that is written wrongly."""

from difflib import get_close_matches

from einschalt.foundations.value_descriptions import described

ALIKE = 0.6  # share of letters that two words have in common


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
