"""``einschalt completion``: what a shell needs to complete commands and options."""

from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status

EXAMPLES = (
    "einschalt completion bash >> ~/.bashrc",
    "einschalt completion zsh > ~/.zfunc/_einschalt",
    "einschalt completion fish > ~/.config/fish/completions/einschalt.fish",
)


@with_exit_status
@done_in_work
def completion(
    shell: Annotated[
        Literal["bash", "zsh", "fish"],
        typer.Argument(metavar="SHELL", help="bash, zsh or fish."),
    ],
):
    """Print what a shell needs to complete commands and options.

    What is completed comes from the commands themselves: nothing has to be done again
    after an update.
    """
