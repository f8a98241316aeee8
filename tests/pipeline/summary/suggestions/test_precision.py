from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.summary.suggestions.precision import imprecise_points


def with_errors(result, **errors):
    points = result.points.copy()
    for name, error in errors.items():
        points.loc[points["point_id"] == name, TOTAL] = error
    return replace(result, points=points)


TOTAL = "standard_error_total"


@pytest.fixture(scope="module")
def even(demo_block):
    """A result with 4 cm for every point."""
    result = densify(demo_block)
    return replace(result, points=result.points.assign(**{TOTAL: 0.04}))


def of_new(result):
    points = result.points
    return points.loc[points["role"] == "new", "point_id"].tolist()


def test_even_precision_is_not_worth_a_word(even):
    assert imprecise_points(even) is None
    first = of_new(even)[0]
    assert imprecise_points(with_errors(even, **{first: 0.119})) is None
    without = replace(even, points=even.points.drop(columns=TOTAL))
    assert imprecise_points(without) is None
    assert imprecise_points(with_errors(even, **{first: np.nan})) is None


def test_the_worst_come_first_and_the_others_have_their_figure(even):
    a, b = of_new(even)[:2]
    said = str(imprecise_points(with_errors(even, **{a: 0.2, b: 0.3})))
    assert said == (
        "2 new points with standard errors of more than 3 times the median of 4.0 cm, "
        f"up to 30 cm ({b}, {a}); the others have 4.0 cm (total, RMS). Measure more "
        "control there, spread over the model, or do without these points."
    )


def test_a_model_most_of_whose_points_they_are_is_named(even):
    table = even.block.low_flight.model_points
    model = table["model_id"].iloc[0]
    its = table.loc[(table["model_id"] == model) & (table["coverage"] == "1")]
    said = imprecise_points(with_errors(even, **dict.fromkeys(its["point_id"], 1.0)))
    assert "They are most points of low-flight model" in said.problem
    assert model in said.problem.split("low-flight")[1]


def test_control_and_check_points_do_not_count(even):
    points = even.points
    given = points.loc[points["role"] != "new", "point_id"]
    assert imprecise_points(with_errors(even, **dict.fromkeys(given, 9.0))) is None
