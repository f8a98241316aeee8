"""The README's code runs, and prints what the README says that it prints."""

import contextlib
import io
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from einschalt.interfaces.cli.main import app

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SUMMARY = (ROOT / "docs" / "summary.md").read_text(encoding="utf-8")


def fenced(language, page=README):
    return re.findall(rf"```{language}\n(.*?)```", page, flags=re.DOTALL)


def without_time(text):
    return re.sub(r"Computed in .*", "Computed in …", text).strip()


@pytest.fixture
def at_root_with_scratch_output(monkeypatch, tmp_path):
    # the code of the README writes to out/: let it do so elsewhere
    for name in ("data_examples", "pipelines"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
@pytest.mark.usefixtures("at_root_with_scratch_output")
def test_code_prints_what_stands_below_it():
    (code,), (beginning,) = fenced("python"), fenced("text")
    # the page on the summary has all of it
    (same_code,), (printed,) = fenced("python", SUMMARY), fenced("text", SUMMARY)
    assert same_code == code
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(code, "README.md", "exec"), {})
    assert without_time(said.getvalue()) == without_time(printed)
    first, nothing_else = beginning.split("…\n")
    assert said.getvalue().startswith(first)
    assert len(first) > 100
    assert nothing_else == ""
    assert Path("out/neukirchen/report.html").exists()


def test_linked_pages_exist():
    targets = re.findall(r"\]\(([^)#]+)\)", README)
    assert targets
    assert [target for target in targets if not (ROOT / target).exists()] == []


def test_make_targets_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"\bmake (\w+)", README))
    assert {"demo", "test", "lint", "bench"} <= targets
    assert targets <= set(re.findall(r"^(\w+):", makefile, re.MULTILINE))


def test_the_picture_is_there_and_made_by_a_target():
    (picture,) = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README)
    content = (ROOT / picture).read_bytes()
    assert content.startswith(b"\x89PNG")
    assert len(content) < 150_000
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert f"PICTURE := {picture}\n" in makefile


def test_commands_of_the_readme_and_their_options_exist():
    calls = re.findall(
        r"^(?:\./)?einschalt (\w+)([^#\n]*)", "\n".join(fenced("sh")), re.MULTILINE
    )
    assert len(calls) > 8
    option = re.compile(r"--[a-z-]+")
    for name, rest in calls:
        shown = CliRunner().invoke(app, [name, "--help"])
        assert shown.exit_code == 0, name
        assert set(option.findall(rest)) <= set(option.findall(shown.output)), name
