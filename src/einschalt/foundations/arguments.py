"""Arguments of the public interface: what a value is, and whether it can be used.

A call with a value of a wrong kind ends with an :class:`EinschaltError` that names
the argument, as a wrong cell of a table does, and not with a TypeError from inside.
"""

import errno
import os
from contextlib import suppress
from numbers import Real
from pathlib import Path

import numpy as np

from einschalt.foundations.errors import FileError, SettingsError
from einschalt.foundations.near_words import nearest
from einschalt.foundations.number_parsing import LARGEST_NUMBER
from einschalt.foundations.system_errors import reason_of
from einschalt.foundations.value_descriptions import described

StrPath = str | os.PathLike[str]
"""What names a file or folder."""


def is_choice(value, allowed):
    """Whether a value is one of the words that are allowed; None may be one of them.

    Lists and arrays, which cannot be looked up, are no words.
    """
    return isinstance(value, str | None) and value in allowed


def require_choice(name, value, allowed):
    """See that the argument ``name`` is one of the words that are allowed."""
    if is_choice(value, allowed):
        return
    known = [word for word in allowed if word is not None]
    near = nearest(value, known)
    raise SettingsError(
        f"{name} = {described(value)} is unknown",
        expected=" or ".join(known),
        remedy=f'Write {name}="{near}"' if near else "",
    )


def require_kind(name, value, kinds, *, expected, remedy=""):
    """See that the argument ``name`` is of the kind that is needed."""
    if not isinstance(value, kinds):
        found = f"{name} = {described(value)}"
        raise SettingsError(found, expected=expected, remedy=remedy)


def require_text(name, value, *, expected):
    """See that an argument is a text that can be written into a file.

    Half of a surrogate pair cannot.
    """
    require_kind(name, value, str, expected=expected)
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:
        found = f"{name} = {described(value)} is no Unicode text"
        raise SettingsError(found, expected=expected) from None


def finite_number(name, value, *, expected="a number"):
    """Take an argument as a finite float; truth values and texts are no numbers."""
    values = as_numbers(name, value, expected=expected)
    if values.ndim == 0 and abs(values) <= LARGEST_NUMBER:
        return float(values)
    raise SettingsError(f"{name} = {described(value)}", expected=expected)


def as_numbers(name, value, *, expected="a number, or an array of numbers"):
    """Take an argument, a number or a sequence of them, as an array of floats.

    NaN where a value is left out; truth values, texts and complex numbers are none.
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O" and all(map(_is_measure, array.flat)):
            array = array.astype(float)
    except (TypeError, ValueError, OverflowError):  # ragged, or beyond 10³⁰⁸
        array = np.asarray(None)
    # lists of nothing have no kind
    if array.dtype.kind in "iuf":
        return array.astype(float)
    raise SettingsError(f"{name} = {described(value)}", expected=expected)


def _is_measure(value):
    # bool is an int to Python, and yet no measure
    return isinstance(value, Real) and not isinstance(value, bool)


def as_path(name, value):
    """Take an argument as the path of a file or folder."""
    path = os.fspath(value) if isinstance(value, os.PathLike) else value
    if isinstance(path, str) and path and "\0" not in path:
        _require_possible(name, path)
        return Path(path)
    raise FileError(
        f"{name} = {described(value)}",
        expected="the path of a file or folder, as text or Path",
        remedy='Write it in quotes: "out/block"',
    )


def _require_possible(name, path):
    """Refuse a path that the system takes for no file, whoever would ask for it."""
    with suppress(ValueError):
        try:
            Path(path).lstat()
        except OSError as error:
            if error.errno == errno.ENAMETOOLONG:
                raise FileError(
                    f"{name} = {described(path)} can be no file: {reason_of(error)}",
                    remedy="Correct the name",
                ) from error
