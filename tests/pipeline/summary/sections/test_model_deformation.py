"""What is said of deformations, and which of the two ways is to be believed."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.facts.model_deformation import deformation_facts
from einschalt.pipeline.summary.sections.model_deformation import (
    belief_text,
    own_section,
    section,
)

FLIGHTS = ["high_flight", "low_flight"]


def examined_with(*, detected=False, modelled=False, alike=False, own="", checks=None):
    """Verdict on the low flight, and RMS at ten check points both ways."""
    found = pd.DataFrame(
        {
            "flight": FLIGHTS,
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
    tables = SimpleNamespace(is_spatial=False, images=(None, None))
    adjusted = SimpleNamespace(deformations=found, tables=tables)
    if checks is None:
        solution = SimpleNamespace(two_step=SimpleNamespace(is_possible=False))
        return SimpleNamespace(adjustment=adjusted, solution=solution)
    n, one, two = checks

    def points(error):
        columns = {"difference_easting": error, "difference_northing": 0.0}
        names = [str(k) for k in range(n)]
        return pd.DataFrame({"point_id": names, "role": "check", **columns})

    beside = SimpleNamespace(is_possible=True, points=points(two))
    solution = SimpleNamespace(two_step=beside)
    return SimpleNamespace(
        adjustment=adjusted,
        solution=solution,
        points=points(one),
        shares_control_errors=False,
    )


def verdict(examined):
    return belief_text(deformation_facts(examined))


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        ({}, "Use the simultaneous adjustment: no deformation was found."),
        (
            {"detected": True},
            "Use the two steps, or model the deformation: the simultaneous",
        ),
        (
            {"detected": True, "alike": True},
            "Use the two steps, or model the deformation: the simultaneous",
        ),
        (
            {"detected": True, "modelled": True},
            "Use the simultaneous adjustment: the deformation is modelled, and",
        ),
        (
            {"detected": True, "modelled": True, "alike": True},
            "Use the two steps if they are possible: each model is deformed in its own",
        ),
        ({"alike": True}, "Use the two steps if they are possible"),
        ({"own": "tested"}, "Use the two steps if they are possible"),
        ({"own": "modelled"}, "Use the simultaneous adjustment: it models the"),
    ],
)
def test_what_shows_decides(facts, said):
    assert verdict(examined_with(**facts)).startswith(said)


def test_check_points_decide_where_there_are_enough():
    """On the real block s_0 was 0.99, and check points had 8.0 against 6.0 cm."""
    worse = verdict(examined_with(checks=(10, 0.080, 0.060)))
    assert worse == (
        "Use the two steps: at the check points they have 6.0 cm, the simultaneous "
        "adjustment has 8.0 cm."
    )
    better = verdict(examined_with(alike=True, checks=(10, 0.03, 0.06)))
    assert better.startswith("Use the simultaneous adjustment: at the check")
    # too few of them, or as good as equal: what shows decides
    assert "no deformation was found" in verdict(examined_with(checks=(7, 0.08, 0.06)))
    assert "no deformation was found" in verdict(
        examined_with(checks=(10, 0.062, 0.06))
    )


@pytest.mark.parametrize(
    "facts", [{}, {"detected": True, "modelled": True}, {"own": "modelled"}]
)
def test_nothing_is_said_against_the_verdict(facts):
    """Control that is wrong may speak for the two steps where no deformation does."""
    told = deformation_facts(examined_with(**facts))
    better, same = (SimpleNamespace(method=m) for m in ("two_step", "simultaneous"))
    said = belief_text(told, better)
    assert said.endswith("; the two steps are better for another reason.")
    assert belief_text(told, same) == belief_text(told)
    # where deformation speaks for the two steps as well, that is the reason
    left = deformation_facts(examined_with(detected=True))
    assert belief_text(left, better) == belief_text(left)


def test_the_table_says_sizes_and_what_was_done():
    shown = section(deformation_facts(examined_with(detected=True, modelled=True)))
    assert [row[0] for row in shown.rows] == ["high flight", "low flight"]
    assert shown.rows[1][2:] == ("4.00 cm", "15.00 cm", "modelled", "-0.10")
    assert shown.rows[0][4] == "not modelled"


def test_what_each_model_has_for_itself_is_a_table_of_its_own():
    assert own_section(deformation_facts(examined_with())).rows == ()
    shown = own_section(deformation_facts(examined_with(own="modelled")))
    assert shown.rows[1] == ("low flight", "6.0 cm")
    assert "p < 0.001. The adjustment models it" in shown.remarks[0]
    tested = own_section(deformation_facts(examined_with(own="tested")))
    assert tested.remarks[0].endswith("It is not modelled.")


def test_what_spatial_models_share_is_a_bend_of_their_heights():
    examined = examined_with(detected=True, modelled=True, own="modelled")
    examined.adjustment.tables.is_spatial = True
    found = examined.adjustment.deformations
    found["neighbour_correlation"] = np.nan
    found["own_size_edge_height"] = [0.0, 0.021]
    facts = deformation_facts(examined)
    shared = section(facts)
    assert shared.title == "Bend in height common to the models of a flight (RMS)"
    assert shared.header[2:] == ("in the middle", "at the edge", "in the adjustment")
    assert shared.rows[1][2:] == ("4.00 cm", "15.00 cm", "modelled")
    assert shared.remarks[0].startswith("Use the simultaneous adjustment")
    shown = own_section(facts)
    assert shown.header == ("", "in plan (total)", "in height")
    assert shown.rows[1] == ("low flight", "6.0 cm", "2.1 cm")
    assert len(shown.remarks) == 1  # which way to use is said once


@pytest.mark.parametrize(
    ("p_value", "is_modelled", "said"),
    [
        (1e-6, True, "The coordinates are as without it, and the standard errors"),
        (1e-6, False, "The standard errors are without it."),
        (0.4, False, "It is not significant."),
    ],
)
def test_photographs_are_bent_for_themselves(p_value, is_modelled, said):
    examined = examined_with()
    examined.adjustment.tables.is_spatial = True
    examined.adjustment.tables.images = (None, "of the low flight")
    found = examined.adjustment.deformations
    found["own_p_value"], found["own_is_modelled"] = p_value, is_modelled
    facts = deformation_facts(examined)
    table = own_section(facts)
    assert table.title == "Deformation of each single photograph (RMS at its edge)"
    assert table.header == ("", "in plan (total)")  # heights follow from it
    assert said in table.remarks[0]
    assert ("no adjustment corrects that" in section(facts).remarks[-1]) is is_modelled


def test_of_few_image_points_nothing_is_told():
    examined = examined_with()
    examined.adjustment.tables.is_spatial = True
    examined.adjustment.tables.images = (None, "of the low flight")
    examined.adjustment.deformations["own_p_value"] = np.nan
    facts = deformation_facts(examined)
    assert section(facts).rows
    assert own_section(facts).rows == ()


def test_nothing_is_said_where_nothing_was_tested():
    untested = examined_with()
    untested.adjustment.deformations = untested.adjustment.deformations.iloc[:0]
    assert deformation_facts(untested) is None
    assert section(None).rows == ()


def test_what_could_not_be_tested_is_not_said_to_be_absent():
    examined = examined_with()
    examined.adjustment.deformations[["p_value", "own_size_edge"]] = np.nan
    assert verdict(examined).startswith("Deformation of models cannot be tested")
    # one flight that could be tested is enough to say something
    examined.adjustment.deformations.loc[0, "p_value"] = 0.4
    assert "no deformation was found" in verdict(examined)
