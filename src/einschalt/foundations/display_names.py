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


def all_shortened(texts, width=40):
    """Shorten names that stand beside each other, so that they remain different.

    Names which their ends do not tell apart keep what differs between them, or are
    left whole where that would be too long.

    >>> all_shortened(["Hauptdreieckspunkt_07_Nord", "Hauptdreieckspunkt_08_Nord"], 12)
    ['Haupt…7…Nord', 'Haupt…8…Nord']
    """
    whole = [printable(text) for text in texts]
    short = [shortened(text, width) for text in whole]
    alike = {}
    for text, name in zip(whole, short, strict=True):
        alike.setdefault(name, []).append(text)
    apart = {}
    for group in alike.values():
        differ = list(dict.fromkeys(group))
        if len(differ) > 1:
            apart |= zip(differ, _with_difference(differ, width), strict=True)
    shown = [apart.get(text, name) for text, name in zip(whole, short, strict=True)]
    is_clear = len(set(shown)) == len(set(whole))
    # a part may be what another name is as a whole
    return shown if is_clear else whole


def _with_difference(names, width):
    """Names about the characters in which they differ; whole where these are many."""
    begin = _n_shared(names)
    end = _n_shared([name[begin:][::-1] for name in names])
    parts = [name[begin : len(name) - end] for name in names]
    room = width - max(map(len, parts)) - 2
    if room < 2:
        return names
    head = room - room // 2
    before = names[0][:head] if begin > head else names[0][:begin]
    tail = names[0][len(names[0]) - room // 2 :] if end > room // 2 else ""
    after = f"…{tail}" if tail else names[0][len(names[0]) - end :]
    gap = "…" if begin > head else ""
    return [f"{before}{gap}{part}{after}" for part in parts]


def _n_shared(names):
    """How many characters all names begin with."""
    least, most = min(names), max(names)
    for k, char in enumerate(least):
        if k == len(most) or char != most[k]:
            return k
    return len(least)
