"""Progress on standard error."""

import sys
import threading
from types import SimpleNamespace

from einschalt.foundations import kernels
from einschalt.interfaces.cli import compiling, progress
from einschalt.interfaces.cli.compiling import compilations_shown, usual_kernels
from einschalt.interfaces.cli.progress import stage_progress
from einschalt.pipeline.progress import Stage

TENTHS = [f"{10 * tenth:3d}%  laying out plans" for tenth in range(11)]
STAGES = [Stage.RELATIVE_ORIENTATION, Stage.ERROR_PROPAGATION, Stage.DONE]


def show(*, is_quiet):
    with stage_progress(is_quiet=is_quiet) as report:
        for stage in STAGES:
            report(stage, stage.fraction)


def test_lines_where_there_is_no_terminal(capsys, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    show(is_quiet=False)
    said = capsys.readouterr()
    assert said.out == ""
    assert (
        said.err == "  0%  relative orientation\n 90%  error propagation\n100%  done\n"
    )


def test_no_lines_of_what_is_done_at_once(capsys):
    show(is_quiet=False)
    assert capsys.readouterr() == ("", "")


def test_few_lines_of_many_steps(capsys, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    with stage_progress(is_quiet=False) as report:
        for k in range(1001):
            report("laying out plans", k / 1000)
    assert capsys.readouterr().err.splitlines() == TENTHS


def test_a_step_that_takes_long_is_shown_in_its_midst(capsys, monkeypatch):
    """Eleven seconds went by in silence, since the only step had begun at once."""
    monkeypatch.setattr(progress, "PATIENCE", 0.05)
    shown = threading.Event()
    few_lines = progress._few_lines

    def telling():
        line = few_lines()

        def told(title, fraction):
            line(title, fraction)
            shown.set()

        return told

    monkeypatch.setattr(progress, "_few_lines", telling)
    with progress.late_steps() as report:
        report("laying out plans", 0.25)
        assert shown.wait(30.0)
    assert capsys.readouterr().err == " 25%  laying out plans\n"


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
    with stage_progress(is_quiet=False) as report:
        report("[/nonsense]", 0.5)


def test_what_is_compiled_is_said_at_the_stage_that_waits(capsys, monkeypatch):
    monkeypatch.setattr(compiling, "PAUSE_IN_A_LOG", 0.0)
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    monkeypatch.setattr(kernels, "_watch", kernels._Watch())
    with (
        stage_progress(is_quiet=False) as show,
        compilations_shown(show) as shown,
    ):
        shown.n_usual = 2
        shown(Stage.MODEL_TRANSFORMATION, 0.5)
        for name in ("_fit", "_sums", "_one_more"):
            kernels._watch.n_kernels += 1
            kernels._watch.announce(name)
    assert capsys.readouterr().err.splitlines() == [
        " 50%  model transformation",
        " 50%  compiling 1 of about 2 kernels, once after installation",
        " 50%  compiling 2 of about 2 kernels, once after installation",
        " 50%  compiling kernel 3, once after installation",
    ]


def test_planning_says_what_is_compiled(capsys, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    monkeypatch.setattr(kernels, "_watch", kernels._Watch())
    with progress.late_progress() as shown:
        kernels._watch.n_kernels += 1
        kernels._watch.announce("_fit")
        shown("laying out plans", 0.25)
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith(f"  0%  compiling 1 of about {compiling.OF_LAYOUTS} ")
    assert second == " 25%  laying out plans"


def test_not_every_kernel_is_said(capsys, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    monkeypatch.setattr(kernels, "_watch", kernels._Watch())
    with stage_progress(is_quiet=False) as show, compilations_shown(show):
        for name in ("_fit", "_sums"):
            kernels._watch.announce(name)
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_blocks_from_images_take_more_kernels(demo_block):
    low = SimpleNamespace(is_oriented_numerically=True)
    from_images = SimpleNamespace(flights={"low_flight": low})
    assert usual_kernels(demo_block) < usual_kernels(from_images)
