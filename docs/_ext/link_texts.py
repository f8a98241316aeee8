"""Links whose text is the name of a page's file get the title of the page.

On the site nobody sees files; where the sources are read, their names help.
"""

import re

# [theory/claim.md](theory/claim.md), also with a place behind it
NAMED_BY_FILE = re.compile(r"\[`?[\w./]+\.md`?\]\(([^)\s]+\.md(?:#[^)\s]+)?)\)")


def titled(text):
    """The same page, with links that name themselves.

    >>> titled("see [tables.md](tables.md) and [planning](planning.md)")
    'see [](tables.md) and [planning](planning.md)'
    """
    return NAMED_BY_FILE.sub(r"[](\1)", text)


def _read(_app, _name, content):
    content[0] = titled(content[0])


def setup(app):
    """Before a page is read."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True}
