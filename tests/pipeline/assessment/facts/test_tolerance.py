"""Points that pass and fail, from a table made by hand and from blocks."""

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.facts.tolerance import MOST_NAMED, tolerance_facts
from einschalt.pipeline.assessment.tolerance import PRESETS, CheckedFigure, Tolerance
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

FIGURE = CheckedFigure("standard_error_total", 1.0, is_supported=True, is_tested=True)
POINTS = pd.DataFrame(
    {
        "point_id": ["a", "b", "c", "K", "L"],
        "role": ["new", "new", "new", "control", "control"],
        "standard_error_checked": [0.02, 0.03, 0.05, 0.01, 0.02],
        "is_within_tolerance": [True, False, False, True, True],
        "is_suspect": [False, True, False, False, False],
        "difference_easting": [np.nan, np.nan, np.nan, 0.03, 0.04],
        "difference_northing": [np.nan, np.nan, np.nan, 0.03, 0.04],
    }
)


def test_each_role_is_counted():
    facts = tolerance_facts(POINTS, PRESETS["vermv_2016"], FIGURE)
    assert [(one.role, one.n_pass, one.n_fail) for one in facts.roles] == [
        ("new", 1, 2),
        ("control", 2, 0),
    ]
    assert [one.largest for one in facts.roles] == [0.05, 0.02]
    assert (facts.suspects, facts.n_suspects) == (("b",), 1)
    assert facts.figure is FIGURE


def test_control_counts_where_the_ordinance_asks():
    # 4.2 and 5.7 cm against 5 cm
    facts = tolerance_facts(POINTS, PRESETS["vermv_2016"], FIGURE)
    assert (facts.n_control_beyond, facts.n_control) == (1, 2)
    facts = tolerance_facts(POINTS, PRESETS["vermv_2010"], FIGURE)
    assert (facts.n_control_beyond, facts.n_control) == (None, 2)
    new = POINTS[POINTS["role"] == "new"]
    facts = tolerance_facts(new, PRESETS["vermv_2016"], FIGURE)
    assert (facts.n_control_beyond, facts.n_control) == (None, 0)


def test_few_suspects_are_named_and_all_counted():
    many = POINTS.loc[[1] * 250]
    facts = tolerance_facts(many, Tolerance("as set", 0.04), FIGURE)
    assert (len(facts.suspects), facts.n_suspects) == (MOST_NAMED, 250)


def test_without_tolerance_or_points_there_is_nothing_to_tell():
    assert tolerance_facts(POINTS, None, FIGURE) is None
    assert tolerance_facts(POINTS.iloc[:0], PRESETS["vermv_2016"], FIGURE) is None


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_a_block_is_judged_by_its_points(demo_block, method):
    result = densify(demo_block, Settings(method=method, tolerance=0.05))
    facts, points = result.assessment.tolerance, result.points
    assert facts.tolerance == Tolerance("as set", 0.05)
    assert facts.figure == result.examination.checked
    for outcome in facts.roles:
        rows = points[points["role"] == outcome.role]
        passes = (rows["standard_error_checked"] <= 0.05) & ~rows["is_suspect"]
        assert (outcome.n_pass, outcome.n_fail) == (passes.sum(), (~passes).sum())
        assert outcome.largest == rows["standard_error_checked"].max()
