"""Libraries that come with an extra of the package alone."""

from importlib import import_module

from einschalt.foundations.errors import FileError

EXTRA = "export"


def imported(name, format_name, *, extra=EXTRA):
    """Import an optional library; a FileError says how it is had."""
    try:
        return import_module(name)
    except ImportError as error:
        raise FileError(
            f"{format_name} needs the library {name}, which is not installed",
            expected=f"the extra '{extra}' of einschalt",
            remedy=f"pip install '.[{extra}]' in the folder of the project",
        ) from error
