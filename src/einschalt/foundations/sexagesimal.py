"""Degrees, minutes and seconds as people write them, with the side of the equator."""

import re

# with signs, perhaps without seconds; or three numbers parted by the same sign
SIGNED = re.compile(
    r"""(?P<before>[NSEW+-]?)\s*(?P<degrees>\d{1,3})\s*[°º]
    \s*(?P<minutes>\d{1,2}([.,]\d*)?)\s*['\u2019\u2032]
    \s*((?P<seconds>\d{1,2}([.,]\d*)?)\s*("|''|\u201d|\u2033))?
    \s*(?P<after>[NSEW]?)""",
    re.VERBOSE | re.IGNORECASE,
)
PARTED = re.compile(
    r"""(?P<before>[NSEW+-]?)\s*(?P<degrees>\d{1,3})(?P<sign>[ -])
    (?P<minutes>\d\d?)(?P=sign)(?P<seconds>\d\d?([.,]\d*)?)\s*(?P<after>[NSEW]?)""",
    re.VERBOSE | re.IGNORECASE,
)
AGAINST, SIGNS = ("S", "W", "-"), {"+", "-"}
BASE = 60.0


def degrees_and_side(text):
    """Degrees of a text, and the letters of its side; None where it is no such angle.

    An O is east in German and west in French and Spanish: nobody knows.

    >>> degrees_and_side("48°12'36.0''S"), degrees_and_side("E16 30 0,0")
    ((-48.21, 'S'), (16.5, 'E'))
    >>> [degrees_and_side(text) for text in ("16-22-61.0", "16.37", "16 22", "16°22'O")]
    [None, None, None, None]
    >>> [degrees_and_side(text) for text in ("-48°12'N", "48°12.5'30''N")]
    [None, None]
    """
    parts = SIGNED.fullmatch(text) or PARTED.fullmatch(text)
    if parts is None:
        return None
    minutes, seconds = (
        float((parts[name] or "0").replace(",", ".")) for name in ("minutes", "seconds")
    )
    has_both = parts["seconds"] is not None and not parts["minutes"].isdigit()
    if minutes >= BASE or seconds >= BASE or has_both:
        return None
    size = int(parts["degrees"]) + minutes / BASE + seconds / BASE**2
    sides = {parts["before"].upper(), parts["after"].upper()} - {""}
    letters, signs = sides - SIGNS, sides & SIGNS
    if len(letters) > 1 or (letters and signs):
        return None
    is_negative = not sides.isdisjoint(AGAINST)
    return -size if is_negative else size, "".join(letters)
