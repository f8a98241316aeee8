"""The package is built, installed where nothing is, and used there."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

import einschalt as es
from einschalt.interfaces.cli.work.demo import BLOCKS, examples_folder

ROOT = Path(__file__).parents[1]
SOURCES = ("src", "data_examples", "docs", "pyproject.toml", "setup.py", "MANIFEST.in")
DATA = (
    *("py.typed", "glossary.md", "interfaces/files/styles/points.qml"),
    "foundations/languages/de.mo",
    *("interfaces/reports/templates/report.html.j2", "interfaces/reports/templates"),
    *(f"interfaces/local_page/{name}" for name in ("templates/base.html.j2", "static")),
    *(f"data_examples/{name}/block.toml" for name in BLOCKS),
)
BACKEND = "from setuptools import build_meta; print(build_meta.build_{}({!r}))"
OF_POSIX = ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty")
SIGNALS = ("SIGINT", "SIGTERM", "SIGABRT", "SIGFPE", "SIGILL", "SIGSEGV")  # of Windows


def run(*arguments, **options):
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        [str(argument) for argument in arguments],
        env=environment,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
        timeout=500,
        **options,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel of this checkout."""
    if int(version("setuptools").partition(".")[0]) < 77:
        pytest.skip("setuptools 77 or newer is not installed: it builds the package")
    return build_wheel(tmp_path_factory.mktemp("package"))


def build_wheel(root):
    """Make a wheel of a source distribution, as an index would have them."""
    checkout = root / "checkout"
    checkout.mkdir()
    leave = shutil.ignore_patterns("__pycache__", "*.egg-info")
    for name in (*SOURCES, "README.md", "LICENSE"):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        options = {"ignore": leave} if copy is shutil.copytree else {}
        copy(ROOT / name, checkout / name, **options)
    run(sys.executable, "-c", BACKEND.format("sdist", str(root)), cwd=checkout)
    (archive,) = root.glob("*.tar.gz")
    with tarfile.open(archive) as file:
        # Python 3.11.2, which Debian has, knows no filters yet
        safe = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}
        file.extractall(root / "unpacked", **safe)
    (unpacked,) = (root / "unpacked").iterdir()
    run(sys.executable, "-c", BACKEND.format("wheel", str(root)), cwd=unpacked)
    (built,) = root.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """A new environment with the wheel; what it needs is taken from this one."""
    place = tmp_path_factory.mktemp("environment")
    venv.create(place, with_pip=False)
    python = place / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    run(
        *(sys.executable, "-m", "pip", "--python", python, "install", "--quiet"),
        *("--no-deps", "--no-index", "--no-compile", wheel),
    )
    where = "import sysconfig; print(sysconfig.get_path('purelib'))"
    own = Path(run(python, "-c", where).strip())
    theirs = Path(importlib.util.find_spec("numpy").origin).parents[1]
    # a folder in a .pth is searched last, and its own .pth files are not read
    (own / "needed.pth").write_text(f"{theirs}\n", encoding="utf-8")
    _take_compiled_kernels(own / "einschalt")
    return python


def _take_compiled_kernels(package):
    """Kernels compiled for the same sources."""
    sources = Path(es.__file__).parent
    for kernel in sources.rglob("*.nb[ic]"):
        place = package / kernel.relative_to(sources)
        place.parent.mkdir(exist_ok=True)
        shutil.copy2(kernel, place)


@pytest.mark.slow
def test_the_wheel_holds_data_licences_and_no_more(wheel):
    with zipfile.ZipFile(wheel) as file:
        names = set(file.namelist())
        (metadata,) = (name for name in names if name.endswith("/METADATA"))
        said = file.read(metadata).decode("utf-8").partition("\n\n")[0].split("\n")
    for name in DATA:
        assert any(one.startswith(f"einschalt/{name}") for one in names), name
    tops = {name.partition("/")[0] for name in names}
    assert tops == {"einschalt", f"einschalt-{es.__version__}.dist-info"}
    assert {
        *("License-Expression: BSD-3-Clause", "License-File: LICENSE"),
        "License-File: data_examples/sxb_strasbourg/LICENCE.txt",
        *(f"Version: {es.__version__}", "Description-Content-Type: text/markdown"),
        "Author: the einschalt developers",
    } <= set(said)
    assert not any(line.startswith(("Project-URL", "Home-page")) for line in said)
    assert wheel.stat().st_size < 3_000_000


@pytest.mark.slow
def test_the_demo_runs_where_only_the_wheel_is(installed, tmp_path):
    script = installed.with_name("einschalt")
    where = run(installed, "-c", "import einschalt; print(einschalt.__file__)")
    assert Path(where.strip()).is_relative_to(installed.parents[1])
    (line,) = run(script, "demo", "--json", cwd=tmp_path).splitlines()
    said = json.loads(line)
    assert said["paths"] == [str(Path("out", name)) for name in BLOCKS]
    for name in BLOCKS:
        assert (tmp_path / "out" / name / "report.html").stat().st_size > 10_000
        assert said["figures"][name]["credible"] > 0.01
    assert said["figures"]["neukirchen"]["block"] == "Neukirchen (simulated)"
    printed = run(script, "explain", "Passpunkt", cwd=tmp_path)
    assert printed.startswith("control point, control, c. point (Points, flights, mo")


def test_make_and_the_program_show_the_same_blocks():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for name in BLOCKS:
        assert f"densify data_examples/{name} --output out/{name}" in makefile
    assert examples_folder() == ROOT / "data_examples"


def test_the_version_is_the_same_everywhere():
    for file, line in (
        ("pyproject.toml", f'version = "{es.__version__}"'),
        ("CITATION.cff", f"version: {es.__version__}"),
    ):
        assert line in (ROOT / file).read_text(encoding="utf-8").splitlines(), file


@pytest.mark.slow
def test_every_module_is_imported_where_posix_is_not():
    code = (
        "import sys, pkgutil, importlib, signal\n"
        f"sys.modules.update(dict.fromkeys({OF_POSIX!r}))\n"
        f"for name in {{n for n in dir(signal) if n[:3] == 'SIG'}} - {set(SIGNALS)}:\n"
        "    delattr(signal, name)\n"
        "import einschalt\n"
        "for one in pkgutil.walk_packages(einschalt.__path__, 'einschalt.'):\n"
        "    if not one.name.endswith('__main__'):\n"
        "        importlib.import_module(one.name)\n"
        "print(len(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 500


def test_import_takes_no_library_with_it():
    code = "import sys; before = set(sys.modules); import einschalt\n"
    code += "print(*sorted(set(sys.modules) - before))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    new = {name.partition(".")[0] for name in done.stdout.split()}
    assert new - set(sys.stdlib_module_names) == {"einschalt"}
    assert len(done.stdout.split()) < 80  # 0.03 s; typing alone would double that
