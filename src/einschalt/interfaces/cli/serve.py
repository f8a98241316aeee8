"""``einschalt serve``: a page on this computer, for people who do not type."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status

EXAMPLES = (
    "einschalt serve",
    "einschalt serve BLOCKS",
    "einschalt serve BLOCKS --port 8417 --no-browser",
)


@with_exit_status
@done_in_work
def serve(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="FOLDER",
            show_default="the current folder",
            help="Folder that the page may open, and in which results are written: "
            "nothing outside it.",
        ),
    ] = Path(),
    port: Annotated[
        int,
        typer.Option(
            min=0, max=65535, show_default="any that is free", help="Port of the page."
        ),
    ] = 0,
    host: Annotated[
        Literal["127.0.0.1", "::1"],
        typer.Option(
            help="Name of this computer; no other computer can reach the page."
        ),
    ] = "127.0.0.1",
    browser: Annotated[
        bool,
        typer.Option("--browser/--no-browser", help="Show the page in the browser."),
    ] = True,
    most_upload: Annotated[
        float,
        typer.Option(
            min=1.0, help="Maximum total size of files dropped into the page [MB]."
        ),
    ] = 1000.0,
):
    """Work on a page in the browser, on this computer only.

    Opens blocks below a folder, or files that are dropped into the page; checks and
    computes them, shows and compares reports, plans flights, and runs batches. The
    printed address contains a key, without which nobody can open the page. Needs the
    extra serve: pip install '.[serve]' in the folder of the project.
    """
