"""The wheel in an empty environment of every Python that is here: ``make pythons``.

All that it needs comes from the index, as for a user who installs it: a package that
is imported and not declared is missed here, and a version of Python that one of them
does not have yet. The demo runs there, with its data files and kernels of its own.
"""

import json
import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.test_package import build_wheel, run

from einschalt.interfaces.cli.work.demo import BLOCKS

MINORS = range(11, 15)
"""Of Python 3: those of the classifiers of pyproject.toml."""


def interpreters():
    """Find an interpreter of each version.

    Returns
    -------
    dict of str to str
        Path by version, as 3.12; that of this process for its own.
    """
    found = {}
    for minor in MINORS:
        name = f"3.{minor}"
        places = (place for place in _places(name) if _version_of(place) == name)
        place = next(places, None)
        if place is not None:
            found[name] = place
    return found


def _places(version):
    """Where an interpreter may be: this one, on the path, or kept by pyenv."""
    yield sys.executable
    on_path = shutil.which(f"python{version}")
    if on_path:
        yield on_path
    if shutil.which("pyenv"):
        root = subprocess.run(
            ["pyenv", "root"], capture_output=True, text=True, check=False
        )
        kept = Path(root.stdout.strip()) / "versions"
        yield from map(str, sorted(kept.glob(f"{version}.*/bin/python"), reverse=True))


def _version_of(place):
    code = "import sys; print('{}.{}'.format(*sys.version_info))"
    said = subprocess.run([place, "-c", code], capture_output=True, check=False)
    return said.stdout.decode().strip()


def try_wheel(wheel, version, place, folder):
    """Install the wheel into an empty environment, and run the demo there.

    Parameters
    ----------
    wheel : Path
    version : str
    place : str
        Interpreter of that version.
    folder : Path
        For environment and results.

    Returns
    -------
    str
        What came of it, in a line. AssertionError where it does not work.
    """
    begin = time.monotonic()
    run(place, "-m", "venv", folder / "environment")
    binaries = folder / "environment" / ("Scripts" if os.name == "nt" else "bin")
    run(binaries / "python", "-m", "pip", "install", "--quiet", wheel)
    installed = time.monotonic()
    (line,) = run(binaries / "einschalt", "demo", "--json", cwd=folder).splitlines()
    figures = json.loads(line)["figures"]
    for name in BLOCKS:
        assert (folder / "out" / name / "report.html").stat().st_size > 10_000, name
        assert figures[name]["credible"] > 0.01, name
    code = "import einschalt; print(einschalt.__file__)"
    where = Path(run(binaries / "python", "-c", code, cwd=folder).strip())
    assert where.is_relative_to(folder / "environment"), where
    demo = time.monotonic()
    return (
        f"Python {version}: installed in {installed - begin:.0f} s, "
        f"demo in {demo - installed:.0f} s"
    )


def main():
    """Try every version that is here, two at a time.

    Returns
    -------
    int
        Exit status: 0 where the demo ran with all of them.
    """
    found = interpreters()
    absent = [f"3.{minor}" for minor in MINORS if f"3.{minor}" not in found]
    with TemporaryDirectory() as place:
        root = Path(place)
        wheel = build_wheel(root)

        def tried(version):
            folder = root / version
            folder.mkdir()
            try:
                return True, try_wheel(wheel, version, found[version], folder)
            except (AssertionError, subprocess.TimeoutExpired) as error:
                return False, f"Python {version}: {error}"

        with ThreadPoolExecutor(2) as at_once:
            all_tried = list(at_once.map(tried, found))
    lines = [said for _, said in all_tried]
    if absent:
        lines.append(f"not installed here: Python {', '.join(absent)}")
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    return 0 if all(is_good for is_good, _ in all_tried) else 1


if __name__ == "__main__":
    sys.exit(main())
