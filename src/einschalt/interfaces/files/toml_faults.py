"""What is no TOML, and in which line."""

import re

from einschalt.foundations.language import mark

WHERE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")
FAULTS_OF_TOML = (
    mark("cannot declare {0} twice"),
    mark("cannot mutate immutable namespace {0}"),
    mark("cannot overwrite a value"),
    mark("cannot redefine namespace {0}"),
    mark("duplicate inline table key {0}"),
    mark("escaped character is not a Unicode scalar value"),
    mark("expected {0}"),
    mark("expected '=' after a key in a key/value pair"),
    mark("expected ']' at the end of a table declaration"),
    mark("expected ']]' at the end of an array declaration"),
    mark("expected newline or end of document after a statement"),
    mark("found invalid character {0}"),
    mark("illegal character {0}"),
    mark("invalid date or datetime"),
    mark("invalid hex value"),
    mark("invalid initial character for a key part"),
    mark("invalid statement"),
    mark("invalid value"),
    mark("unclosed array"),
    mark("unclosed inline table"),
    mark("unescaped '\\' in a string"),
    mark("unterminated string"),
)
"""What tomllib says, as it stands in a sentence: for the catalogue."""


def toml_fault(error: Exception) -> tuple[str, int | None]:
    """Fault of a TOMLDecodeError as it stands in a sentence, and its line.

    >>> toml_fault(ValueError("Invalid value (at line 3, column 7)"))
    ('invalid value at column 7', 3)
    """
    said = str(error)
    place, what = WHERE.search(said), WHERE.sub("", said)
    reason = f"{what[:1].lower()}{what[1:]}"
    if place is None or not place[1]:
        return reason, None
    return f"{reason} at column {place[2]}", int(place[1])
