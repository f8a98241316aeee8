"""Dataclasses that name the field that a misspelt argument means."""

from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any, TypeVar

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.near_words import nearest

Kind = TypeVar("Kind", bound=type)


def with_known_fields(kind: Kind) -> Kind:
    """Let a dataclass refuse arguments that are none of its fields by a SettingsError.

    >>> from dataclasses import dataclass
    >>> @with_known_fields
    ... @dataclass
    ... class Flight:
    ...     scale_number: float
    >>> Flight(scale_nunber=8000)
    Traceback (most recent call last):
    einschalt.foundations.errors.SettingsError: Flight has no field scale_nunber; \
expected scale_number. Write scale_number.
    """
    names = [field.name for field in fields(kind) if field.init]
    construct: Callable[..., None] = kind.__init__

    @wraps(construct)
    def checked(self: Any, *args: Any, **given: Any) -> None:
        for name in given:
            if name not in names:
                near = nearest(name, names)
                raise SettingsError(
                    f"{kind.__name__} has no field {shortened(name)}",
                    expected=", ".join(names),
                    remedy=f"Write {near}" if near else "Take it out",
                )
        construct(self, *args, **given)

    kind.__init__ = checked
    return kind
