"""Messages in Python name arguments: ``max_height``, and not ``--max-height``.

What is planned is asked on the command line and in Python; its advice names options,
which are there how the program is called.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from einschalt.foundations.errors import BlockError, EinschaltError

# none within the line of a command, such as ``einschalt simulate --plan``
OPTION = re.compile(r"(?<![\w-])--([a-z][a-z0-9]*(?:-[a-z0-9]+)*)(?:=|\b)")
COMMAND = re.compile(r"\b(?:einschalt|simulate|convert|densify|init) [^.;]*$")
TEXTS = ("found", "expected", "remedy")


def with_arguments(text: str) -> str:
    """Write the argument of each option that a text names.

    >>> with_arguments("Give a smaller --spacing, or a --max-height of 120 m")
    'Give a smaller spacing, or a max_height of 120 m'
    """

    def argument(option):
        if COMMAND.search(option.string[: option.start()]):
            return option[0]
        return option[1].replace("-", "_")

    return OPTION.sub(argument, text)


@contextmanager
def naming_arguments() -> Iterator[None]:
    """Let errors that are raised inside name arguments of Python."""
    try:
        yield
    except EinschaltError as error:
        raise _named(error) from error.__cause__


def _named(error):
    if isinstance(error, BlockError):
        return BlockError([_named(problem) for problem in error.problems])
    said = {name: getattr(error, name) for name in TEXTS}
    named = {name: with_arguments(text or "") for name, text in said.items()}
    return error if named == said else error.with_facts(**named)
