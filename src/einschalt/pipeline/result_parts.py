"""Attributes of a result that stand in its parts, with the types that they have there.

An annotation alone would make a field of a dataclass; a property of an attrgetter has
no type.
"""

import warnings
from collections.abc import Callable
from functools import cached_property, wraps
from operator import attrgetter
from typing import Generic, TypeVar

import pandas as pd

T = TypeVar("T")


class Part(Generic[T]):
    """An attribute that a part of the result has, read where that stands."""

    def __init__(self, place: str):
        self._of = attrgetter(place)

    def __get__(self, result, owner: type | None = None) -> T:
        """Read it; of the class, not of a result, the attribute itself."""
        return self if result is None else _for_its_user(self._of(result))


class CachedTable(cached_property[T]):
    """A table that is computed once, and given to each who asks as his own."""

    def __get__(self, result, owner: type | None = None) -> T:
        """Read it; of the class, not of a result, the attribute itself."""
        return _for_its_user(super().__get__(result, owner))

    def __set__(self, result, value):
        """Refuse to be set; without this, what is cached would be read directly."""
        raise AttributeError(self.attrname)


def _for_its_user(value):
    """What is a table as one that can be changed, and leaves the result as it is.

    Its columns are copied when they are written to.
    """
    return value.copy(deep=False) if isinstance(value, pd.DataFrame) else value


class FormerPart(Generic[T]):
    """A part of the two steps under the name that it had before it had a home."""

    def __set_name__(self, owner: type, name: str):
        """Keep the name."""
        self._name = name
        self.__doc__ = f"Deprecated: ``{name}`` of the solution in two steps."

    def __get__(self, result, owner: type | None = None) -> T | None:
        """Read it with a warning; None where the two steps are not possible."""
        if result is None:
            return self
        steps = getattr(result.solution, "two_step", result.solution)
        where = "solution" if steps is result.solution else "solution.two_step"
        message = f"result.{self._name} is now result.{where}.{self._name}"
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        return getattr(steps, self._name) if steps.is_possible else None


class ToldOnRequest:
    """A method of a part that gives a table, in the system of the results."""

    def __init__(self, place: str):
        self._of = attrgetter(place)

    def __get__(self, result, owner: type | None = None) -> Callable[..., pd.DataFrame]:
        """Bind it to a result; of the class, the attribute itself."""
        if result is None:
            return self
        ask = self._of(result)
        if result.output_system is None:
            return ask
        return wraps(ask)(
            lambda *args, **more: result._in_output_system(ask(*args, **more))
        )
