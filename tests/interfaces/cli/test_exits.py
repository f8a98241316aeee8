"""How commands end."""

import pytest
import typer

from einschalt.foundations.errors import FileError
from einschalt.interfaces.cli.exits import with_exit_status


@pytest.mark.parametrize(
    ("error", "status", "says"),
    [
        (FileError("is empty", file="a.csv"), 2, "einschalt: a.csv: is empty.\n"),
        (
            PermissionError(13, "Permission denied", "b.csv"),
            2,
            "einschalt: b.csv: Permission denied\n",
        ),
        (KeyboardInterrupt(), 130, "einschalt: interrupted"),
    ],
)
def test_errors_end_with_a_message_and_a_status(error, status, says, capsys):
    @with_exit_status
    def command():
        raise error

    with pytest.raises(typer.Exit) as end:
        command()
    assert end.value.exit_code == status
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(says)


def test_faults_of_the_program_keep_their_traceback():
    @with_exit_status
    def command():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        command()


def test_commands_keep_their_name_and_help():
    @with_exit_status
    def command(block: str):
        """Do something."""

    assert command.__name__ == "command"
    assert command.__doc__ == "Do something."
