"""Runs: they report, end, and leave whole results or nothing."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from einschalt.interfaces.files.output_folder import write_folder
from einschalt.interfaces.local_page import run_process, runs
from einschalt.pipeline.progress import Stage


def waited_for(visitor, number, *, until):
    """State of a run, when it has got as far."""
    end = time.monotonic() + 300.0
    while time.monotonic() < end:
        state = json.loads(visitor.get(f"/run/{number}/state").text)
        if until(state) or state["state"] != "running":
            return state
        time.sleep(0.05)
    pytest.fail(f"still {state}")


def has_ended(_state):
    return False


@pytest.fixture
def runs_wait(monkeypatch):
    """Runs wait in the midst of their work until they are ended."""
    monkeypatch.setattr(runs, "MODULE", "waiting_run")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))


def is_computing(state):
    return state["stage"] not in ("starting", str(Stage.READING))


@pytest.mark.slow
def test_a_block_is_computed_and_its_report_shown(visit, root, small_block):
    small_block.path.rename(root / "nine <points>")
    visitor = visit(root)
    address = "/block?path=nine+%3Cpoints%3E"
    assert "Compute the points" in visitor.get(address).text
    fields = {"path": "nine <points>", "output": "new/out", "method": "two_step"}
    started = visitor.post("/start", fields)
    assert (started.status, started.headers["location"]) == (303, "/run/1")
    assert "nine &lt;points&gt;" in visitor.get("/run/1").text
    state = waited_for(visitor, 1, until=has_ended)
    assert state == {
        "state": "done",
        "stage": "done",
        "fraction": 1.0,
        "problems": [],
    }
    led = visitor.get("/run/1")
    assert led.headers["location"] == "/result?path=new%2Fout"
    assert "<iframe" in visitor.get("/result?path=new%2Fout").text
    report = visitor.get("/report?path=new/out")
    assert report.text == (root / "new" / "out" / "report.html").read_text("utf-8")
    # its scripts may do nothing in the name of the page
    policy = report.headers["content-security-policy"]
    assert policy.startswith(
        "sandbox allow-scripts allow-downloads; default-src 'none'"
    )
    assert "allow-same-origin" not in policy
    # a report that somebody has changed is not shown
    (root / "new" / "out" / "report.html").write_text("<script>1</script>")
    assert visitor.get("/report?path=new/out").status == 404


@pytest.mark.slow
def test_a_cancelled_run_leaves_nothing(visit, root, small_block, runs_wait):
    small_block.path.rename(root / "block")
    visitor = visit(root)
    before = sorted(root.rglob("*"))
    visitor.post("/start", {"path": "block", "output": "new/out"})
    waited_for(visitor, 1, until=is_computing)
    visitor.post("/run/1/cancel")
    state = waited_for(visitor, 1, until=has_ended)
    assert state["state"] == "cancelled"
    assert sorted(root.rglob("*")) == before
    assert "nothing was written" in visitor.get("/run/1").text


@pytest.mark.slow
def test_a_run_that_is_ended_leaves_nothing(visit, root, small_block, runs_wait):
    small_block.path.rename(root / "block")
    visitor = visit(root)
    before = sorted(root.rglob("*"))
    visitor.post("/start", {"path": "block", "output": "out"})
    run = visitor.session.runs.get(1)
    waited_for(visitor, 1, until=is_computing)
    os.kill(run._process.pid, signal.SIGKILL)
    state = waited_for(visitor, 1, until=has_ended)
    assert state["state"] == "failed"
    assert "signal 9" in state["problems"][0]
    assert sorted(root.rglob("*")) == before


@pytest.fixture
def start(monkeypatch, root):
    """Start a run of a module beside this one, without a page; its state at its end."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    started = runs.Runs()

    def state_at_end(module):
        monkeypatch.setattr(runs, "MODULE", module)
        question = {"kind": "densify", "output": str(root / "out"), "language": "en"}
        run = started.start(question, "block", {})
        run._reader.join(60.0)
        return run

    state_at_end.runs = started
    return state_at_end


def test_a_run_that_is_killed_while_it_answers_has_ended(start):
    run = start("cut_run")
    assert (run.state, run.fraction) == ("failed", 0.5)
    assert "signal 9" in run.problems[0]


def test_a_run_that_ends_before_it_is_asked_has_failed(start, monkeypatch):
    started = runs._started

    def ended():
        process = started()
        process.wait(60.0)
        return process

    monkeypatch.setattr(runs, "_started", ended)
    run = start("no_such_module")
    assert run.state == "failed"
    assert "exit status 1" in run.problems[0]


def test_the_oldest_runs_that_have_ended_are_forgotten(start, monkeypatch):
    monkeypatch.setattr(runs, "MOST_KEPT", 2)
    for _ in range(3):
        start("no_such_module")
    assert list(start.runs.all) == [2, 3]
    assert start.runs.get(3).number == 3


@pytest.mark.slow
def test_a_run_whose_server_was_killed_ends_without_a_word(root, small_block):
    """It is nobody's any more: no answer is read, and no line of input comes."""
    question = {"kind": "densify", "block": str(small_block.path), "given": {}}
    question |= {"output": str(root / "out"), "language": "en"}
    paths = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    process = subprocess.Popen(
        [sys.executable, "-m", "waiting_run"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        **pipes,
    )
    process.stdin.write(json.dumps(question).encode() + b"\n")
    process.stdin.flush()
    stages = [json.loads(process.stdout.readline())["stage"] for _ in range(2)]
    assert stages[-1] == str(Stage.MODEL_TRANSFORMATION)
    process.stdout.close()
    process.stdin.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait(60.0) == 0
    assert list(root.iterdir()) == []


def test_what_is_wrong_is_said_without_options_of_the_command_line(
    root, small_block, capfd
):
    (root / "mine.csv").write_text("mine")
    said = []
    question = {"kind": "densify", "block": str(small_block.path), "given": {}}
    run_process._answer(
        {**question, "output": str(root)}, lambda **answer: said.append(answer)
    )
    assert said[-1]["end"] == "failed"
    (problem,) = said[-1]["problems"]
    assert "mine.csv" in problem
    assert "--" not in problem
    assert [path.name for path in root.iterdir()] == ["mine.csv"]


def test_no_more_runs_at_once_than_may(visit, root, small_block, monkeypatch):
    small_block.path.rename(root / "block")
    monkeypatch.setattr(runs, "MOST_AT_ONCE", 0)
    visitor = visit(root)
    answer = visitor.post("/start", {"path": "block", "output": "out"})
    assert answer.status == 429
    assert "at most 0 at once" in answer.text
    assert not (root / "out").exists()


def test_an_interruption_waits_until_files_have_their_places(tmp_path, monkeypatch):
    from einschalt.interfaces.files import output_folder
    from einschalt.interfaces.files.output_folder import InputFiles, Output
    from einschalt.interfaces.files.written_files import Source

    place = output_folder._put_in_place

    def interrupted(*arguments):
        signal.raise_signal(signal.SIGINT)
        place(*arguments)

    monkeypatch.setattr(output_folder, "_put_in_place", interrupted)
    output = Output(Source("densify"), frozenset({"a.csv"}), InputFiles())
    with pytest.raises(KeyboardInterrupt):
        write_folder(
            tmp_path / "out",
            output,
            {"program": "einschalt"},
            lambda new: (new / "a.csv").write_text("whole"),
        )
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["a.csv", "provenance.json"]
