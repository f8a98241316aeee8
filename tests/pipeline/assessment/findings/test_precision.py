from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tests.changed_results import changed

from einschalt.pipeline.assessment.findings.precision import (
    block_that_shrinks,
    imprecise_points,
)
from einschalt.pipeline.densify import densify

TOTAL = "standard_error_total"


def with_errors(result, **errors):
    points = result.points.copy()
    for name, error in errors.items():
        points.loc[points["point_id"] == name, TOTAL] = error
    return changed(result, points=points)


@pytest.fixture(scope="module")
def even(demo_block):
    """A result with 4 cm for every point."""
    result = densify(demo_block)
    return changed(result, points=result.points.assign(**{TOTAL: 0.04}))


def of_new(result):
    points = result.points
    return points.loc[points["role"] == "new", "point_id"].tolist()


def test_even_precision_is_not_worth_a_word(even):
    assert imprecise_points(even.examination) is None
    first = of_new(even)[0]
    assert imprecise_points(with_errors(even, **{first: 0.119}).examination) is None
    without = changed(even, points=even.points.drop(columns=TOTAL))
    assert imprecise_points(without.examination) is None
    assert imprecise_points(with_errors(even, **{first: np.nan}).examination) is None


def test_the_worst_come_first_and_the_others_have_their_figure(even):
    a, b = of_new(even)[:2]
    found = imprecise_points(with_errors(even, **{a: 0.2, b: 0.3}).examination)
    assert found.names == (b, a)
    assert found.facts == {
        "n_points": 2,
        "times_usual": 3.0,
        "median": 0.04,
        "largest": 0.3,
        "rms_of_others": pytest.approx(0.04),
        "n_models": 0,
        "models": (),
    }


def test_a_model_most_of_whose_points_they_are_is_named(even):
    table = even.block.low_flight.model_points
    model = table["model_id"].iloc[0]
    its = table.loc[(table["model_id"] == model) & (table["coverage"] == "1")]
    found = imprecise_points(
        with_errors(even, **dict.fromkeys(its["point_id"], 1.0)).examination
    )
    assert found.facts["n_models"] > 0
    assert model in found.facts["models"]


def test_control_and_check_points_do_not_count(even):
    points = even.points
    given = points.loc[points["role"] != "new", "point_id"]
    assert (
        imprecise_points(with_errors(even, **dict.fromkeys(given, 9.0)).examination)
        is None
    )


@pytest.mark.parametrize(("pull", "is_said"), [(0.04, True), (0.02, False)])
def test_a_block_shrinks_where_its_pull_is_beyond_half_the_claim(pull, is_said):
    """Three new points of 5 cm, and a control point that does not count."""
    error = 0.05 / np.sqrt(2.0)
    points = pd.DataFrame(
        {
            "point_id": ["a", "b", "c", "K"],
            "role": ["new", "new", "new", "control"],
            "standard_error_easting": error,
            "standard_error_northing": error,
        }
    )
    moved = pd.DataFrame({"easting": [0.0, pull, 0.0, 9.0], "northing": 0.0})
    moved.loc[[0, 2], "northing"] = pull / 2.0
    adjustment = SimpleNamespace(points=points, displacements=moved)
    found = block_that_shrinks(SimpleNamespace(adjustment=adjustment))
    if not is_said:
        assert found is None
        return
    rms = pull * np.sqrt((1.0 + 0.25 + 0.25) / 3.0)
    assert found.names == ("b",)
    assert found.facts["moved"] == pytest.approx(rms)
    assert found.facts["largest"] == pytest.approx(pull)
    assert found.facts["ratio_to_claimed"] == pytest.approx(rms / 0.05)


def test_where_the_pull_is_not_known_nothing_is_said():
    adjustment = SimpleNamespace(displacements=None)
    assert block_that_shrinks(SimpleNamespace(adjustment=adjustment)) is None
