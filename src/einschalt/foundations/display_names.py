"""Names as they are shown: on one line, without control characters, not too long.

It imports nothing, since every error message passes here and help should come at once.
"""

# between groups of digits; no name is harmed by it
GROUP_SPACE = "\N{NARROW NO-BREAK SPACE}"


def printable(text):
    r"""Replace what would break a line or steer a terminal, so that it can be seen.

    >>> print(printable("two\nlines"))
    two\nlines
    """
    return "".join(
        char if char.isprintable() or char == GROUP_SPACE else _code(char)
        for char in str(text)
    )


def _code(char):
    return char.encode("unicode_escape").decode("ascii")


def as_unicode(text):
    r"""Write out what is no Unicode in the name of a file, so that it can be written.

    >>> print(as_unicode("Vöckla\udcff"))
    Vöckla\udcff
    """
    return str(text).encode("utf-8", "backslashreplace").decode("utf-8")


def shortened(text, width=40):
    """Shorten a long name in its middle, since names differ at their ends.

    >>> shortened("Hauptdreieckspunkt_0001", 12)
    'Hauptd…_0001'
    """
    text = printable(text)
    if len(text) <= width:
        return text
    tail = (width - 1) // 2
    return f"{text[: width - 1 - tail]}…{text[len(text) - tail :]}"
