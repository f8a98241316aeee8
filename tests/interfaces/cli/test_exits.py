"""How commands end."""

import json
import os
import shutil
import signal
import subprocess
import sys

import pytest
import typer

from einschalt.foundations.errors import FileError
from einschalt.foundations.interruptions import (
    Terminated,
    ended_in_order,
    uninterrupted,
)
from einschalt.interfaces.cli.exits import with_exit_status
from einschalt.interfaces.cli.main import app


@pytest.mark.parametrize(
    ("error", "status", "says"),
    [
        (FileError("is empty", file="a.csv"), 2, "einschalt: a.csv: is empty.\n"),
        (
            PermissionError(13, "Permission denied", "b.csv"),
            2,
            "einschalt: b.csv: permission denied\n",
        ),
        (
            MemoryError(),
            2,
            "einschalt: there is not enough memory for this. Take fewer",
        ),
        (
            OSError(12, "Cannot allocate memory"),
            2,
            "einschalt: there is not enough memory for this. Take fewer",
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


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_signal_that_ends_lets_the_work_be_put_away(capsys):
    put_away = []

    @with_exit_status
    def command():
        try:
            signal.raise_signal(signal.SIGTERM)
        finally:
            put_away.append("staging")

    with pytest.raises(typer.Exit) as end:
        command()
    assert end.value.exit_code == 143
    assert capsys.readouterr().err.startswith("einschalt: ended by SIGTERM; files")
    assert put_away == ["staging"]
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_signals_wait_for_files_and_ignored_ones_stay_ignored():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    done = []

    def work():
        with ended_in_order():
            signal.raise_signal(signal.SIGHUP)
            with uninterrupted():
                signal.raise_signal(signal.SIGTERM)
                done.append("files")

    try:
        with pytest.raises(Terminated, match="SIGTERM"):
            work()
    finally:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    assert done == ["files"]


def test_faults_of_the_program_keep_their_traceback():
    @with_exit_status
    def command():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        command()


def test_a_fault_of_the_program_has_its_json_too(monkeypatch, capsys):
    """Status 1 came with nothing on standard output, which programs cannot read."""

    def spoilt(**_options):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("einschalt.interfaces.cli.work.explain.explain", spoilt)
    with pytest.raises(ZeroDivisionError):
        app(["explain", "Passpunkt", "--json"], prog_name="einschalt")
    told = json.loads(capsys.readouterr().out)
    assert (told["command"], told["status"]) == ("explain", 1)
    (problem,) = told["problems"]
    assert problem["found"] == "ZeroDivisionError: division by zero"
    assert problem["expected"]
    assert problem["remedy"]


def test_commands_keep_their_name_and_help():
    @with_exit_status
    def command(block: str):
        """Do something."""

    assert command.__name__ == "command"
    assert command.__doc__ == "Do something."


def shell(command, folder, **environment):
    """What a user's shell does, with its redirections."""
    return subprocess.run(
        ["bash", "-c", f'"{sys.executable}" -m einschalt {command}'],
        cwd=folder,
        capture_output=True,
        check=False,
        timeout=1200,
        env={**os.environ, **environment},
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "status"),
    [
        ("check block >&-", 0),
        ("check block >&- 2>&-", 0),
        ("check nowhere >&- 2>&- <&-", 2),
        ("--version >&-", 0),
        ("densify block -o out >&- 2>&-", 0),
        ("check block > /dev/full", 2),
        ("--help > /dev/full", 2),
    ],
)
def test_closed_and_full_streams_end_with_a_status(
    command, status, tmp_path, small_block
):
    (tmp_path / "block").symlink_to(small_block.path)
    done = shell(command, tmp_path)
    assert done.returncode == status
    assert b"Traceback" not in done.stderr
    if "densify" in command:
        # nothing that was printed went into a file that was opened meanwhile
        assert (tmp_path / "out" / "points.parquet").read_bytes()[-4:] == b"PAR1"
    if "/dev/full" in command:
        assert b"no space left" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["0", "1"])
def test_any_name_of_a_folder_in_the_c_locale(mode, tmp_path, small_block):
    name = os.fsdecode("Vöckla√".encode() + b"\xff")
    shutil.copytree(small_block.path, tmp_path / name)
    text = (tmp_path / name / "block.toml").read_text(encoding="utf-8")
    unnamed = "\n".join(k for k in text.split("\n") if not k.startswith("name"))
    (tmp_path / name / "block.toml").write_text(unnamed, encoding="utf-8")
    done = shell(
        "densify V* -o $'\\xc3\\xb6ut\\xff'",
        tmp_path,
        LC_ALL="C",
        PYTHONUTF8=mode,
        PYTHONCOERCECLOCALE="0",
    )
    assert (done.returncode, b"Traceback" in done.stderr) == (0, False)
    out = tmp_path / os.fsdecode("öut".encode() + b"\xff")
    assert {"points.csv", "report.html", "provenance.json"} <= {
        f.name for f in out.iterdir()
    }
    assert (out / "block.gpkg").read_bytes().startswith(b"SQLite format 3")
