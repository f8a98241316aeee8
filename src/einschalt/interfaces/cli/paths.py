"""Paths on the command line: an empty word, of a variable not set, names no folder."""

from pathlib import Path

import typer


def given_path(text):
    """Take a word of the command line as a path.

    Parameters
    ----------
    text : str or Path

    Returns
    -------
    Path

    Raises
    ------
    BadParameter
        It is empty. ``Path("")`` would be the present folder, and results would be
        strewn into it.
    """
    if not str(text):
        raise typer.BadParameter("the path is empty; expected a file or folder.")
    return Path(text)


def output_option(text):
    """Option ``--output`` of a command.

    Parameters
    ----------
    text : str
        Its help.

    Returns
    -------
    typer.models.OptionInfo
    """
    return typer.Option(
        "--output", "-o", parser=given_path, metavar="<path>", help=text
    )


def overwrite_option(text="Replace what lies there, inputs excepted."):
    """Option ``--overwrite`` of a command.

    Parameters
    ----------
    text : str, optional
        Its help.

    Returns
    -------
    typer.models.OptionInfo
    """
    return typer.Option("--overwrite", help=text)
