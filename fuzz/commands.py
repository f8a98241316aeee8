"""Commands of the command line on hostile files, in this process."""

import shutil

from typer.testing import CliRunner

from einschalt.interfaces.cli.main import app
from fuzz.judges import Breach, judge_output

STATUSES = {0, 1, 2}


def command(*arguments):
    """Make a reader of a command.

    Parameters
    ----------
    *arguments : str
        ``FILE`` stands for the hostile file, ``FOLDER`` for its folder, ``OUT`` for a
        folder of results, which is emptied before.

    Returns
    -------
    callable
        Takes the path of the hostile file; raises :class:`Breach` where the command
        ends with a traceback, with another status than it may, or prints what steers
        a terminal.
    """

    def read(path):
        folder = path.parent
        out = folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        places = {"FILE": path, "FOLDER": folder, "OUT": out}
        call = list(arguments)
        for sign, place in places.items():
            call = [word.replace(sign, str(place)) for word in call]
        ended = CliRunner().invoke(app, call)
        if not isinstance(ended.exception, (SystemExit, type(None))):
            raise ended.exception
        if ended.exit_code not in STATUSES:
            raise Breach(f"ends with status {ended.exit_code}")
        judge_output(ended.output)

    return read
