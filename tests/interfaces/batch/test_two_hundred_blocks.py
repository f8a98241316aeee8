"""An office's night: 200 blocks of which 10 are broken, and the morning after.

It takes some minutes: run by ``make faults``; ``test_batch_run.py`` has it with fewer.
"""

import json
import os
import subprocess
import sys

import pandas as pd
import pytest

N_SOUND = 190
# of the whole command, in processor time: others may want the computer as well
LONGEST_SKIPPING = 5.0

pytestmark = pytest.mark.skipif(
    "EINSCHALT_LONG" not in os.environ, reason="takes minutes: make faults"
)


@pytest.fixture(scope="module")
def night(tmp_path_factory, make_blocks, breakages):
    root = tmp_path_factory.mktemp("night")
    make_blocks(root / "blocks", N_SOUND, breakages)
    return root, batch(root)


def batch(root, *options):
    """Status, processor seconds and table of a batch, called as a user calls it."""
    call = [sys.executable, "-m", "einschalt", "batch", "blocks", "-o", "out", *options]
    begin = processor_seconds()
    done = subprocess.run(call, cwd=root, capture_output=True, text=True, check=False)
    seconds = processor_seconds() - begin
    assert "Traceback" not in done.stdout + done.stderr
    table = pd.read_parquet(root / "out" / "blocks.parquet").set_index("block")
    return done.returncode, seconds, table


def test_190_results_and_10_rows_with_the_right_reason(night, breakages):
    root, (status, _, table) = night
    assert status == 1
    assert table["outcome"].value_counts().to_dict() == {"done": 190, "failed": 10}
    for name, (_, stage, reason, remedy) in breakages.items():
        row = table.loc[name]
        assert (row["outcome"], row["stage"]) == ("failed", stage), name
        assert reason in row["reason"], name
        assert remedy in row["remedy"], name
    results = list((root / "out").glob("*/provenance.json"))
    assert len(results) == N_SOUND


def test_the_morning_after(night, breakages):
    """What is sound is skipped at once; one control file changed is one block run."""
    root, _ = night
    status, _, table = batch(root)
    assert status == 1
    assert table["outcome"].value_counts().to_dict() == {"skipped": 190, "failed": 10}
    for name in breakages:  # they are no blocks any more
        (root / "blocks" / name / "block.toml").rename(root / f"{name}.toml")
    status, seconds, table = batch(root)
    assert status == 0
    assert table["outcome"].tolist() == ["skipped"] * 190
    assert seconds < LONGEST_SKIPPING
    before = dict(created(root))
    control = root / "blocks" / "block_77" / "control_points.csv"
    text = control.read_text(encoding="utf-8")
    control.write_text(text.replace("13000.00", "13000.02", 1), encoding="utf-8")
    status, _, table = batch(root)
    assert status == 0
    assert table.index[table["outcome"] == "done"].tolist() == ["block_77"]
    after = dict(created(root))
    assert [name for name in before if before[name] != after[name]] == ["block_77"]


def processor_seconds():
    """Of all processes that were started and have ended."""
    times = os.times()
    return times.children_user + times.children_system


def created(root):
    """When the result of each block was computed."""
    for path in sorted((root / "out").glob("*/provenance.json")):
        yield path.parent.name, json.loads(path.read_text("utf-8"))["created"]
