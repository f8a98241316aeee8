"""What libraries say of damaged files, in the words of messages.

They stand in errors as they are; the usual ones are told in other languages.
"""

from einschalt.foundations.language import mark

USUAL = (
    # expat, of XML
    mark("XML declaration not well-formed"),
    mark("duplicate attribute"),
    mark("junk after document element"),
    mark("mismatched tag"),
    mark("no element found"),
    mark("not well-formed (invalid token)"),
    mark("partial character"),
    mark("unclosed CDATA section"),
    mark("unclosed token"),
    mark("undefined entity"),
    mark("unexpected end of data"),
    mark("unknown encoding"),
    # json
    mark("Expecting value: line {0} column {1} (char {2})"),
    mark("Expecting ',' delimiter: line {0} column {1} (char {2})"),
    mark("Expecting ':' delimiter: line {0} column {1} (char {2})"),
    mark(
        "Expecting property name enclosed in double quotes: line {0} column {1} "
        "(char {2})"
    ),
    mark("Extra data: line {0} column {1} (char {2})"),
    mark("Invalid control character at: line {0} column {1} (char {2})"),
    mark("Unterminated string starting at: line {0} column {1} (char {2})"),
    # Python, of numbers
    mark("could not convert string to float: {0}"),
    mark("invalid literal for int() with base 10: {0}"),
    # csv
    mark("field larger than field limit ({0})"),
    # SQLite
    mark("database disk image is malformed"),
    mark("disk I/O error"),
    mark("file is not a database"),
    # of images
    mark("image file is truncated ({0} bytes not processed)"),
)
"""Reasons that usual libraries give, for the catalogue."""


def without_statement(reason: str) -> str:
    """Take the statement in SQL away that stands before what is wrong with it.

    >>> without_statement("sqlite3_exec(SELECT a FROM b) failed: disk I/O error")
    'disk I/O error'
    """
    return reason.rpartition(") failed: ")[2]
