"""Docstrings of classes whose fields stand in that of the class below them.

A public class that adds a figure or a file to a result of a lower floor has the same
fields. Its readers look at its own help; told twice, fields would drift.
"""

import inspect
from typing import TypeVar

Kind = TypeVar("Kind", bound=type)
SECTION = "Attributes\n----------\n"


def with_fields_of_base(kind: Kind) -> Kind:
    """Add the section of fields of its base to the docstring of a class."""
    own, (base, *_) = inspect.cleandoc(kind.__doc__), kind.__bases__
    _, title, fields = inspect.cleandoc(base.__doc__).partition(SECTION)
    if not title:
        raise ValueError(f"{base.__name__} describes no fields")
    kind.__doc__ = f"{own}\n\n{title}{fields}"
    return kind
