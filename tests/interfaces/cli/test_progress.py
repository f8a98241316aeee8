"""Progress on standard error."""

import sys

from einschalt.interfaces.cli.progress import stage_progress
from einschalt.pipeline.progress import Stage

STAGES = [Stage.RELATIVE_ORIENTATION, Stage.ERROR_PROPAGATION, Stage.DONE]


def show(*, is_quiet):
    with stage_progress(is_quiet=is_quiet) as progress:
        for stage in STAGES:
            progress(stage, stage.fraction)


def test_lines_where_there_is_no_terminal(capsys):
    show(is_quiet=False)
    said = capsys.readouterr()
    assert said.out == ""
    assert (
        said.err == "  0%  relative orientation\n 90%  error propagation\n100%  done\n"
    )


def test_nothing_when_quiet(capsys):
    show(is_quiet=True)
    assert capsys.readouterr() == ("", "")


def test_a_bar_on_a_terminal_is_gone_at_the_end(capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("FORCE_COLOR", "1")
    show(is_quiet=False)
    said = capsys.readouterr()
    assert said.out == ""
    assert "error propagation" in said.err or "done" in said.err
    assert "\x1b[2K" in said.err  # the line is erased


def test_a_bar_does_not_read_markup(capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with stage_progress(is_quiet=False) as progress:
        progress("[/nonsense]", 0.5)
