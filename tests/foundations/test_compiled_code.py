"""Users who may write neither beside the source nor into a home can compute."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import einschalt
from einschalt.foundations import compiled_code
from einschalt.interfaces.cli.main import app


def test_nothing_is_done_where_there_is_a_place(monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    compiled_code.provide_cache()
    assert "NUMBA_CACHE_DIR" not in os.environ


def test_a_given_place_stays(monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", "given")
    monkeypatch.setattr(compiled_code, "_usual", list)
    compiled_code.provide_cache()
    assert os.environ["NUMBA_CACHE_DIR"] == "given"


def test_a_place_of_a_single_run_is_said_with_the_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.setattr(compiled_code, "_usual", list)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    compiled_code.provide_cache()
    assert compiled_code.is_cache_temporary()
    said = CliRunner().invoke(app, ["check", "--explain", "point_id"]).stderr
    assert said.count("every run compiles anew") == 1
    assert "Set NUMBA_CACHE_DIR to a folder of your own." in said
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "own"))
    assert not compiled_code.is_cache_temporary()


@pytest.mark.skipif(os.name == "nt", reason="users of POSIX")
def test_user_without_home_on_a_package_of_another(tmp_path):
    """What numba does where it finds no place is an error when a kernel is imported."""
    copy = tmp_path / "site"
    package = copy / "einschalt"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(einschalt.__file__).parent, package, ignore=ignored)
    for folder in (package, *package.rglob("*")):
        # a file where a folder for the cache would be: root may write everywhere
        if folder.is_dir():
            (folder / "__pycache__").write_text("")
    home = tmp_path / "home"
    home.write_text("")
    code = (
        "import os; real = os.access\n"
        f"os.access = lambda p, m: not str(p).startswith({str(tmp_path)!r})"
        " and real(p, m)\n"
        "from einschalt.theory.transformation import plane_fit\n"
        "print(os.environ['NUMBA_CACHE_DIR'])"
    )
    environment = {
        **os.environ,
        **dict.fromkeys(("HOME", "XDG_CACHE_HOME"), str(home)),
        "PYTHONPATH": str(copy),
    }
    environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "einschalt-" in done.stdout
    assert not Path(done.stdout.strip()).exists()
