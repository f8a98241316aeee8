"""Paths on the command line: an empty word, of a variable not set, names no folder."""

from pathlib import Path

import typer


def given_path(text):
    """Take a word of the command line as a path; an empty one is refused.

    ``Path("")`` would be the present folder, and results would be strewn into it.
    """
    if not str(text):
        raise typer.BadParameter("the path is empty; expected a file or folder.")
    return Path(text)


def output_option(text):
    """Option ``--output`` of a command."""
    return typer.Option(
        "--output", "-o", parser=given_path, metavar="<path>", help=text
    )


def overwrite_option(text="Replace what lies there, inputs excepted."):
    """Option ``--overwrite`` of a command."""
    return typer.Option("--overwrite", help=text)
