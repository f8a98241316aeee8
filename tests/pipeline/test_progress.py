"""Stages of a computation: every one is reported, and failures are named after it."""

import pytest

import einschalt as es
from einschalt.interfaces.batch import block_run
from einschalt.interfaces.batch.batch_run import plan_batch
from einschalt.interfaces.batch.block_search import find_blocks
from einschalt.pipeline.progress import Stage, stage_reporter

# what the caller of densify does before and after it
OF_THE_CALLER = {Stage.READING, Stage.ASSESSMENT, Stage.WRITING}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blocks")
    es.simulate_block("demo", seed=4).write(folder / "demo")
    return folder


def test_every_stage_is_reported_in_its_order(folder):
    block = es.read_block(folder / "demo")
    settings = block.settings.model_copy(update={"method": "simultaneous"})
    reported = []
    es.densify(block, settings, progress=lambda *stage: reported.append(stage))
    expected = [stage for stage in Stage if stage not in OF_THE_CALLER]
    assert reported == [(stage, stage.fraction) for stage in expected]


def test_titles_are_texts():
    assert Stage.SIMULTANEOUS_ADJUSTMENT == "simultaneous adjustment"
    assert f"{Stage.DONE:<8}|" == "done    |"


def test_whoever_does_not_ask_hears_nothing():
    stage_reporter(None)(Stage.DONE)


@pytest.mark.parametrize("stage", list(Stage))
def test_a_failed_block_names_the_stage_that_ran(folder, tmp_path, monkeypatch, stage):
    given = {"method": "simultaneous"}  # which passes through every stage
    (task,) = plan_batch(find_blocks(folder, tmp_path), tmp_path, given=given).to_run
    remember = block_run._Progress.__call__

    def fail_there(progress, reported, fraction=0.0):
        remember(progress, reported, fraction)
        if reported is stage:
            raise RuntimeError

    monkeypatch.setattr(block_run._Progress, "__call__", fail_there)
    row = block_run.run_block(task)
    assert (row["outcome"], row["stage"]) == ("failed", stage.key)
