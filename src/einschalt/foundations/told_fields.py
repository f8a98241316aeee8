"""Docstrings of classes whose fields are described where they are computed.

A public class that adds a figure or a file to a result of a lower floor has the same
fields. Its readers look at its own help; told twice, fields would drift.
"""

import inspect
from collections.abc import Callable
from typing import TypeVar

Kind = TypeVar("Kind", bound=type)
SECTION = "Attributes\n----------\n"


def with_fields_of(source: type) -> Callable[[Kind], Kind]:
    """Add the section of fields of ``source`` to the docstring of a class."""
    _, title, rest = inspect.cleandoc(source.__doc__ or "").partition(SECTION)
    fields, *_ = rest.partition("\n\n")  # sections behind it are not of the fields

    def told(kind: Kind) -> Kind:
        own = inspect.cleandoc(kind.__doc__ or "")
        kind.__doc__ = f"{own}\n\n{title}{fields}\n"
        return kind

    return told
