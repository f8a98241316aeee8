"""The example blocks are what their README says."""

import re
import shlex
from pathlib import Path

from typer.testing import CliRunner

from einschalt.interfaces.cli.main import app

ROOT = Path(__file__).parents[1]
NEUKIRCHEN = ROOT / "data_examples" / "neukirchen"


def test_neukirchen_is_made_by_the_command_in_its_readme(tmp_path):
    readme = (NEUKIRCHEN / "README.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^einschalt (.*)$", readme, re.MULTILINE)
    words = shlex.split(command)
    words[words.index("--output") + 1] = str(tmp_path)
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    for name in ("block.toml", "control_points.csv", "truth.csv"):
        assert (tmp_path / name).read_bytes() == (NEUKIRCHEN / name).read_bytes()


def check(name):
    return CliRunner().invoke(app, ["check", str(ROOT / "data_examples" / name)])


def test_nothing_is_wrong_with_neukirchen():
    done = check("neukirchen")
    assert done.exit_code == 0, done.output


def test_two_models_of_strasbourg_hold_too_few_control_points():
    done = check("sxb_strasbourg")
    assert done.exit_code == 2
    said = [line for line in done.output.splitlines() if "common points" in line]
    assert len(said) == 2
    assert "8811-8936" in said[0]
    assert "8811-9111" in said[1]
    assert all("2 of its points have coordinates" in line for line in said)
