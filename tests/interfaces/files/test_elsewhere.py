"""Nothing of a file that lies elsewhere gets into messages, nor the names beside it."""

import os
from types import SimpleNamespace

import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.files.block_folder import find_problems
from einschalt.interfaces.files.grid_files import grid_folder

SECRET = "hunter2"


@pytest.fixture
def job(tmp_path, make_block):
    """A block in a job, and files of somebody else."""
    others = tmp_path / "others"
    others.mkdir()
    (others / "env.txt").write_text(f"PASSWORD={SECRET}\nmore=1\n")
    (others / "key").write_text(f"-----BEGIN {SECRET}-----\nabc\n")
    (others / "hunter2.pem").write_bytes(b"\xff\xfe" + SECRET.encode())
    return make_block(tmp_path / "job" / "block")


def said_of(block, named, target=None):
    block.replace("block.toml", '"control_points.csv"', f'"{named}"')
    if target is not None:
        (block.path / named).symlink_to(target)
    found = find_problems(block.path)
    return " ".join([*map(str, found.problems), *found.notes])


@pytest.mark.parametrize(
    ("named", "target"),
    [
        ("../../others/env.txt", None),
        ("linked.csv", "../../others/env.txt"),
        ("linked.txt", "../../others/key"),
        ("linked.csv", "../../others/key"),
        ("linked.csv", "../../others/hunter2.pem"),
        ("linked.xlsx", "../../others/env.txt"),
        ("../../others/nothing.csv", None),
    ],
)
def test_no_word_of_it_is_said(job, named, target):
    said = said_of(job, named, target)
    assert named in said
    assert SECRET not in said


def test_hidden_files_are_elsewhere_wherever_they_lie(job):
    hidden = job.path.parent / ".ssh"
    hidden.mkdir()
    (hidden / "env.txt").write_text(f"PASSWORD={SECRET}\n")
    assert SECRET not in said_of(job, "../.ssh/env.txt")


def test_sound_tables_from_elsewhere_are_read_and_judged_as_others(job):
    table = job.path / "control_points.csv"
    other = job.path.parents[1] / "others" / "control.csv"
    other.write_bytes(table.read_bytes())
    assert said_of(job, "linked.csv", other) == ""
    lines = other.read_text().splitlines()
    lines[2] = lines[2].replace(lines[2].split(",")[1], "n/a")
    other.write_text("\n".join(lines))
    found = find_problems(job.path)
    assert "row 3" in str(found.problems[0])
    assert "'n/a' is not a number" in str(found.problems[0])


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of POSIX")
def test_a_pipe_is_no_grid(tmp_path):
    (tmp_path / "grids").mkdir()
    os.mkfifo(tmp_path / "grids" / "BETA2007.gsb")
    with pytest.raises(SettingsError, match=r"holds BETA2007\.gsb, which is no file"):
        grid_folder(SimpleNamespace(grids="grids"), tmp_path)
