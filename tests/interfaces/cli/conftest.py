"""The command line in this process, and as a process of its own."""

import os
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from einschalt.interfaces.cli.main import app


@pytest.fixture(scope="session")
def invoke():
    """Run a command in this process."""
    runner = CliRunner()

    def call(*arguments):
        return runner.invoke(app, [str(argument) for argument in arguments])

    return call


@pytest.fixture(scope="session")
def spawn():
    """Run ``python -m einschalt`` as a user's shell would."""

    def call(*arguments, encoding="utf-8", **options):
        return subprocess.run(
            [sys.executable, "-m", "einschalt", *map(str, arguments)],
            capture_output=True,
            text=True,
            encoding=encoding,
            check=False,
            timeout=1200,
            **options,
        )

    return call


@pytest.fixture(scope="module")
def undrawn():
    """Figures beside plans are made and not drawn: what they show is seen elsewhere.

    To draw them takes most of the time of a command that writes a plan.
    """
    from einschalt.interfaces.reports import figure_files

    def no_picture(_figure, kinds=tuple(figure_files.FIGURE_FORMATS)):
        return dict.fromkeys(kinds, b"not drawn")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure_files, "figure_bytes", no_picture)
        yield


@pytest.fixture(scope="session", autouse=True)
def propagated_once():
    """Lay out and propagate each design once for all commands of this process.

    Commands in two languages, with a figure or a table beside them ask for the same
    plans; what is propagated is English in every language.
    """
    from einschalt.pipeline.block.block import plain_fields
    from einschalt.pipeline.planning.choice import check

    propagate, known = check.propagate_design, {}

    def remembered(design):
        key = type(design), repr(plain_fields(design))
        if key not in known:
            known[key] = propagate(design)
        return known[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(check, "propagate_design", remembered)
        yield


@pytest.fixture(scope="session")
def processor_seconds():
    """Least processor time of ``python ...``, each way in turn three times [s].

    Beside each other: computers are fast and slow, and what else they do is no fault
    of a command.
    """

    def once(arguments):
        before = os.times()
        subprocess.run([sys.executable, *arguments], capture_output=True, check=True)
        after = os.times()
        user = after.children_user - before.children_user
        return user + after.children_system - before.children_system

    def least(*ways):
        rounds = [[once(way) for way in ways] for _ in range(3)]
        return [min(seconds) for seconds in zip(*rounds, strict=True)]

    return least


@pytest.fixture(scope="session")
def block_folder(tmp_path_factory, demo_block):
    """The demo block as a folder."""
    from einschalt.interfaces.files.block_writing import write_block

    folder = tmp_path_factory.mktemp("block")
    write_block(demo_block, folder)
    return folder


@pytest.fixture
def spoilt_folder(tmp_path, block_folder):
    """The demo block with a value that is no number, and a misspelt point."""
    import shutil

    folder = tmp_path / "spoilt"
    shutil.copytree(block_folder, folder)
    file = folder / "low_flight.csv"
    lines = file.read_text(encoding="utf-8").split("\n")
    row = lines[4].split(",")
    lines[4] = ",".join([*row[:3], "n/a", *row[4:]])
    file.write_text("\n".join(lines), encoding="utf-8")
    control = folder / "control_points.csv"
    text = control.read_text(encoding="utf-8").split("\n")
    text[1] = text[1].replace(text[1].split(",")[0], "1oo1", 1)
    control.write_text("\n".join(text), encoding="utf-8")
    return folder
