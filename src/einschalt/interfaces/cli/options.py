"""Options that several commands have, and words of which they are made.

An empty path, of a variable that is not set, names no folder.
"""

from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.wrong_calls import WrongValueError


def given_path(text):
    """Take a word of the command line as a path; an empty one is refused.

    ``Path("")`` would be the present folder, and results would be strewn into it.
    """
    if not str(text):
        raise WrongValueError("the path is empty", expected="a file or folder")
    return Path(text)


def output_option(text):
    """Option ``--output`` of a command."""
    return typer.Option(
        "--output", "-o", parser=given_path, metavar="<path>", help=text
    )


def overwrite_option(text="Replace existing files, except inputs."):
    """Option ``--overwrite`` of a command."""
    return typer.Option("--overwrite", help=text)


def optional(panel, kind, text, *names):
    """Option without a default, its help after the word of what it belongs to."""
    option = typer.Option(*names, show_default=False, help=f"{panel}: {text}")
    return Annotated[kind | None, option]


Block = Annotated[
    Path, typer.Argument(metavar="BLOCK", help="Folder of the block, or block.toml.")
]
Results = Annotated[Path, output_option("Folder for the results.")]
Overwrite = Annotated[bool, overwrite_option()]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
CRS = Annotated[
    str | None,
    typer.Option(
        show_default="that of the block",
        help="System of the ground coordinates, such as EPSG:3067.",
    ),
]
SourceCRS = Annotated[
    str | None,
    typer.Option(
        show_default=False,
        help="System of the model coordinates, if they are those of an old frame.",
    ),
]
Strict = Annotated[
    bool,
    typer.Option(
        "--strict",
        help="End with status 3 if the stated precision is not supported.",
    ),
]
