"""XML of other programs: without document types and entities, and with whole text."""

import re
from xml.etree import ElementTree as ET
from xml.parsers import expat

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError

FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff\ud800-\udfff]")
MOST_BYTES = 2**28
MOST_DEPTH = 100


def read_xml(data, source, expected):
    """Root of a document; a FileError names the line where it is no whole XML.

    Document types are refused before anything is made of them, and with them entities,
    which could grow without bounds or lead to other files.
    """
    if len(data) > MOST_BYTES:
        raise FileError(
            f"has {len(data)} bytes",
            expected=f"at most {MOST_BYTES}",
            remedy="Export less at once",
            file=source,
        )
    data = _declared_first(data)
    try:
        _guard(source, expected).Parse(data, True)
        return ET.fromstring(data)
    except (expat.ExpatError, ET.ParseError, ValueError, LookupError) as error:
        said = str(error)
        if isinstance(error, expat.ExpatError):
            said = expat.ErrorString(error.code)
        raise FileError(
            f"is no whole XML: {shortened(said, 80)}",
            expected=expected,
            remedy="Export it again",
            file=source,
            row=getattr(error, "lineno", None),
        ) from error


def _declared_first(data):
    """The document with what blanks stand before its declaration behind that.

    MicMac reads such files of hands and scripts. Lines keep their numbers.
    """
    begun = data.lstrip(b" \t\r\n")
    if not begun.startswith(b"<?xml"):
        return data
    blanks = data[: len(data) - len(begun)]
    declaration, end, rest = begun.partition(b"?>")
    return declaration + end + blanks + rest


def _guard(source, expected):
    """Parser that makes nothing of a document, and refuses what is no plain data."""
    guard = expat.ParserCreate()
    depth = 0

    def refuse(found):
        raise FileError(
            f"the XML {found}, as these programs do not write it",
            expected=expected,
            remedy="Check where the file comes from",
            file=source,
            row=guard.CurrentLineNumber,
        )

    def go_in(*_):
        nonlocal depth
        depth += 1
        if depth > MOST_DEPTH:
            refuse(f"is nested more than {MOST_DEPTH} times")

    def go_out(*_):
        nonlocal depth
        depth -= 1

    def doctype(*_):
        refuse("defines a document type or entities")

    guard.StartDoctypeDeclHandler = doctype
    guard.StartElementHandler, guard.EndElementHandler = go_in, go_out
    return guard


def local(element):
    """Name of an element without its namespace."""
    return element.tag.rpartition("}")[2]


def each(element, name):
    """All elements of that name below one, whatever their namespace."""
    return (one for one in element.iter() if local(one) == name)


def child(element, *names):
    """First element on the way of names below one, or None."""
    for name in names:
        if element is None:
            return None
        element = next((one for one in element if local(one) == name), None)
    return element


def text_of(element, *names):
    """Text of the first element on the way of names; empty where there is none."""
    found = child(element, *names)
    return "" if found is None else (found.text or "").strip()


def xml_bytes(root):
    """Document of a root, indented, as UTF-8.

    A FileError where a name has characters that XML cannot hold.
    """
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    found = FORBIDDEN.search(text)
    if found:
        raise FileError(
            f"a name has the character {found[0]!r}, which XML cannot hold",
            expected="names of letters, digits and signs",
            remedy="Rename the point, or choose another format",
        )
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()
