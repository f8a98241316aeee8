"""What ``einschalt completion`` does."""

from typer.completion import get_completion_script

from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.main import COMPLETION
from einschalt.interfaces.cli.outcome import report


def completion(shell):
    """Print the script: the shell asks the program, which knows its commands."""
    options = {"prog_name": "einschalt", "complete_var": COMPLETION, "shell": shell}
    script = get_completion_script(**options)
    report(script=script)
    print_out(script)
