"""``einschalt completion``: what a shell needs to complete commands and options."""

from typing import Annotated, Literal

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status

EXAMPLES = (
    "einschalt completion bash >> ~/.bashrc",
    "einschalt completion zsh > ~/.zfunc/_einschalt",
    "einschalt completion fish > ~/.config/fish/completions/einschalt.fish",
    "einschalt completion powershell | Out-String | Invoke-Expression",
)


@with_exit_status
@done_in_work
def completion(
    shell: Annotated[
        Literal["bash", "zsh", "fish", "powershell"],
        typer.Argument(metavar="SHELL", help="bash, zsh, fish or powershell."),
    ],
):
    """Print a shell script that completes commands and options.

    Completions come from the commands themselves: nothing has to be repeated after an
    update.
    """
