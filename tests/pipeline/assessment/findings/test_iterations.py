"""Drift, from an iteration made by hand; whole blocks stand in test_iteration."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings.iterations import drift


def iterated(*, n_held=3, n_models_held=8, once=0.05, now=0.04):
    """Ten models after three passes; ``once`` and ``now`` are propagated figures."""
    return SimpleNamespace(
        iteration=SimpleNamespace(
            moves=pd.DataFrame({"move_rms": [0.03, 0.01]}),
            n_held=n_held,
            n_models=10,
            n_models_held=n_models_held,
        ),
        figures=SimpleNamespace(mean_within=now),
        total_of_one_pass=once,
    )


def test_iterations_that_control_holds_are_left_in_peace():
    assert drift(iterated()) is None
    assert drift(SimpleNamespace(iteration=None)) is None


def test_a_block_that_nothing_holds_drifts():
    found = drift(iterated(n_held=0))
    assert found.code == "drift_without_control"
    assert found.gravity is Gravity.GRAVE
    assert found.facts["moved"] == pytest.approx(0.04)
    assert found.facts["propagated_once"] == pytest.approx(0.05)
    assert found.facts["propagated_now"] == 0.04


def test_a_figure_that_grows_is_told():
    found = drift(iterated(now=0.06))
    assert found.code == "iterations_that_spoil"
    assert (found.facts["n_models_held"], found.facts["n_models"]) == (8, 10)


@pytest.mark.parametrize(("n_models_held", "is_told"), [(4, True), (5, False)])
def test_thin_control_is_told_where_no_figure_tells(n_models_held, is_told):
    block = iterated(n_models_held=n_models_held, once=np.nan, now=np.nan)
    found = drift(block)
    assert (found is not None) == is_told
    if is_told:
        assert found.code == "drift_that_nothing_tells"
