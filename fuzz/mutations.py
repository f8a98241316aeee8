"""Mutations of files: what an editor, a spreadsheet, a bad disk or an enemy does."""

MOST_BYTES = 1 << 16
TOKENS = (
    b"",
    b"\0",
    b"\r",
    b"\n",
    b"\r\n",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\xff",
    b"\x1b[2J",
    b'"',
    b'""',
    b"'",
    b",",
    b";",
    b"\t",
    b"=",
    b"[",
    b"[[",
    b"]",
    b"{",
    b"}",
    b"\\",
    b"#",
    b"..",
    b"../../etc/passwd",
    b"/dev/zero",
    b"/etc/hostname",
    b"nan",
    b"inf",
    b"-inf",
    b"1e308",
    b"1e999",
    b"-0",
    b"0x10",
    b"1_000",
    b"1.234,5",
    b"9223372036854775808",
    b"18446744073709551616",
    b"9" * 400,
    b"9" * 5000,
    b"1979-05-27",
    b"1979-05-27T07:32:00Z",
    b"07:32",
    b"true",
    b"none",
    b"=cmd|'/c calc'!A0",
    b"<script>alert(1)</script>",
    b"{{7*7}}",
    "\u202e".encode(),
    "\u2028".encode(),
    "\x85".encode(),
    "\ud7ff".encode(),
    b"\xed\xa0\x80",
    b"%s%n",
    b"point_id",
    b"model_id",
    b"x",
    b"[block]",
    b"[low_flight]",
    b"[low_flight.camera]",
    b"EPSG:4326",
    b"EPSG:99999999",
    b"+proj=longlat",
    b"a." * 200 + b"b = 1\n",
    b"[" * 2000,
    b"A" * 5000,
)


def mutated(data, random, others):
    """Change a file in one to six ways.

    Parameters
    ----------
    data : bytes
    random : random.Random
    others : sequence of bytes
        Files of which parts may be taken.

    Returns
    -------
    bytes
        At most 64 KiB.
    """
    data = bytearray(data)
    for _ in range(random.choice((1, 1, 1, 2, 3, 6))):
        random.choice(WAYS)(data, random, others)
        del data[MOST_BYTES:]
    return bytes(data)


def _flip(data, random, _others):
    for _ in range(random.choice((1, 1, 4, 16))):
        if data:
            data[random.randrange(len(data))] ^= 1 << random.randrange(8)


def _set(data, random, _others):
    if data:
        data[random.randrange(len(data))] = random.choice((0, 1, 9, 34, 127, 128, 255))


def _put(data, random, _others):
    place = random.randrange(len(data) + 1)
    data[place:place] = random.choice(TOKENS)


def _replace(data, random, _others):
    start, end = _part(data, random)
    data[start:end] = random.choice(TOKENS)


def _delete(data, random, _others):
    start, end = _part(data, random)
    del data[start:end]


def _repeat(data, random, _others):
    start, end = _part(data, random)
    data[end:end] = data[start:end] * random.choice((1, 2, 50))


def _truncate(data, random, _others):
    del data[random.randrange(len(data) + 1) :]


def _splice(data, random, others):
    other = random.choice(others)
    start, end = _part(other, random)
    place = random.randrange(len(data) + 1)
    data[place:place] = other[start:end]


def _line(data, random, _others):
    """Repeat, drop or move whole lines: what editing by hand does."""
    lines = bytes(data).split(b"\n")
    place = random.randrange(len(lines))
    line = lines.pop(place)
    if random.random() < 0.7:
        lines.insert(random.randrange(len(lines) + 1), line)
        if random.random() < 0.5:
            lines.insert(place, line)
    data[:] = b"\n".join(lines)


def _cell(data, random, _others):
    """Put another value into a cell, or after a key."""
    lines = bytes(data).split(b"\n")
    place = random.randrange(len(lines))
    sign = b"=" if b"=" in lines[place] else b","
    parts = lines[place].split(sign)
    parts[random.randrange(len(parts))] = random.choice(TOKENS)
    lines[place] = sign.join(parts)
    data[:] = b"\n".join(lines)


def _number(data, random, _others):
    """Write a large number over four or eight bytes, as lengths in binary files are."""
    size = random.choice((1, 2, 4, 8))
    if len(data) >= size:
        place = random.randrange(len(data) - size + 1)
        value = random.choice((0, 1, 2**7, 2**15, 2**31 - 1, 2**31, 2**63, 2**64 - 1))
        value %= 1 << (8 * size)
        data[place : place + size] = value.to_bytes(
            size, random.choice(("little", "big"))
        )


def _encode(data, random, _others):
    text = bytes(data).decode("utf-8", "replace")
    data[:] = text.encode(
        random.choice(("utf-16", "utf-16-le", "utf-32", "cp1252")), "replace"
    )


def _ends(data, random, _others):
    data[:] = bytes(data).replace(
        b"\n", random.choice((b"\r", b"\r\n", b"\n\n", b"\n\r"))
    )


def _part(data, random):
    start = random.randrange(len(data) + 1)
    return start, min(len(data), start + random.choice((1, 2, 4, 16, 64, 1024)))


WAYS = (
    *(_flip, _set, _put, _put, _replace, _replace, _delete, _repeat, _truncate),
    *(_splice, _line, _line, _cell, _cell, _cell, _number, _number, _encode, _ends),
)
