"""Which of the two ways to believe, from verdicts made by hand."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.facts.model_deformation import (
    Belief,
    deformation_facts,
)


def examined_with(*, detected=False, modelled=False, alike=False, own="", checks=None):
    """Verdict on the low flight, and differences at check points of both ways."""
    found = pd.DataFrame(
        {
            "flight": ["high_flight", "low_flight"],
            "p_value": [0.4, 1e-9 if detected else 0.3],
            "size_middle": [0.001, 0.04],
            "size_edge": [0.002, 0.15],
            "is_detected": [False, detected],
            "is_modelled": [False, modelled],
            "neighbour_correlation": [-0.05, 0.4 if alike else -0.1],
            "is_alike": [False, alike],
            "n_terms": 14,
            "own_size_edge": [0.0, 0.06 if own else 0.0],
            "own_size_edge_height": 0.0,
            "own_p_value": 1e-9 if own else 0.4,
            "own_is_modelled": [False, own == "modelled"],
        }
    )

    def points(n, error):
        differences = {"difference_easting": 0.6 * error, "difference_northing": -0.8}
        differences["difference_northing"] *= error
        names = [str(k) for k in range(n)]
        return pd.DataFrame({"point_id": names, "role": "check", **differences})

    beside = SimpleNamespace(is_possible=checks is not None)
    mine = None
    if checks is not None:
        (n_one, one), (n_two, two) = checks
        mine, beside.points = points(n_one, one), points(n_two, two)
    return SimpleNamespace(
        adjustment=SimpleNamespace(
            deformations=found,
            tables=SimpleNamespace(is_spatial=False, images=(None, None)),
        ),
        solution=SimpleNamespace(two_step=beside),
        points=mine,
        shares_control_errors=False,
    )


@pytest.mark.parametrize(
    ("shown", "belief"),
    [
        ({}, Belief.NO_DEFORMATION),
        ({"detected": True}, Belief.DEFORMATION_LEFT),
        ({"detected": True, "alike": True}, Belief.DEFORMATION_LEFT),
        ({"detected": True, "modelled": True}, Belief.DEFORMATION_MODELLED),
        (
            {"detected": True, "modelled": True, "alike": True},
            Belief.MODELS_DIFFER,
        ),
        ({"alike": True}, Belief.MODELS_DIFFER),
        ({"own": "tested"}, Belief.MODELS_DIFFER),
        ({"own": "modelled"}, Belief.OWN_DEFORMATIONS_MODELLED),
        ({"own": "modelled", "alike": True}, Belief.MODELS_DIFFER),
    ],
)
def test_without_check_points_what_shows_decides(shown, belief):
    facts = deformation_facts(examined_with(**shown))
    assert facts.belief is belief
    assert np.isnan(facts.check_rms_simultaneous)
    assert np.isnan(facts.check_rms_two_steps)


@pytest.mark.parametrize(
    ("checks", "belief"),
    [
        (((10, 0.08), (10, 0.06)), Belief.CHECK_POINTS_TWO_STEPS),
        (((8, 0.03), (8, 0.06)), Belief.CHECK_POINTS_SIMULTANEOUS),
        # as good as equal, or too few that both have
        (((10, 0.074), (10, 0.06)), Belief.NO_DEFORMATION),
        (((10, 0.08), (7, 0.06)), Belief.NO_DEFORMATION),
    ],
)
def test_check_points_decide_where_there_are_enough(checks, belief):
    facts = deformation_facts(examined_with(checks=checks))
    assert facts.belief is belief
    (n_one, one), (n_two, two) = checks
    expected = (one, two) if min(n_one, n_two) >= 8 else (np.nan, np.nan)
    found = (facts.check_rms_simultaneous, facts.check_rms_two_steps)
    assert found == pytest.approx(expected, nan_ok=True)


def test_what_could_not_be_tested_is_not_said_to_be_absent():
    examined = examined_with()
    examined.adjustment.deformations[["p_value", "own_size_edge"]] = np.nan
    assert deformation_facts(examined).belief is Belief.UNTESTED


def test_every_flight_is_there(simultaneous_result):
    facts = deformation_facts(simultaneous_result.examination)
    found = simultaneous_result.simultaneous.deformations
    assert [one.flight for one in facts.flights] == found["flight"].tolist()
    assert [one.p_value for one in facts.flights] == found["p_value"].tolist()
    assert facts.belief is Belief.NO_DEFORMATION
    untested = examined_with()
    untested.adjustment.deformations = untested.adjustment.deformations.iloc[:0]
    assert deformation_facts(untested) is None
