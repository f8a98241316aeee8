"""``einschalt serve`` before it serves, and what it is made with."""

import ast
from pathlib import Path

import pytest

import einschalt
from einschalt.interfaces.cli.work import serve as work

SOURCE = Path(einschalt.__file__).parent
FRAMEWORK = {"starlette", "uvicorn", "anyio"}


def test_without_the_extra_it_is_said_what_to_install(invoke, monkeypatch, tmp_path):
    monkeypatch.setattr(work, "find_spec", lambda _: None)
    ended = invoke("serve", tmp_path)
    assert ended.exit_code == 2
    assert "which are not installed" in ended.stderr
    assert "pip install '.[serve]' in the folder of the project" in ended.stderr


def test_a_folder_that_is_not_there_is_refused(invoke, tmp_path):
    ended = invoke("serve", tmp_path / "nothing")
    assert ended.exit_code == 2
    assert "there is no such folder" in ended.stderr


def test_other_computers_are_no_choice(invoke, tmp_path):
    ended = invoke("serve", tmp_path, "--host", "0.0.0.0")
    assert ended.exit_code == 2
    assert "127.0.0.1" in ended.stderr


@pytest.mark.slow
def test_only_the_local_page_knows_its_framework():
    for path in SOURCE.rglob("*.py"):
        if path.parent.name == "local_page":
            continue
        nodes = ast.walk(ast.parse(path.read_text("utf-8")))
        imports = [n for n in nodes if isinstance(n, (ast.Import, ast.ImportFrom))]
        names = {getattr(n, "module", None) or n.names[0].name for n in imports}
        assert not FRAMEWORK & {name.split(".")[0] for name in names}, path
