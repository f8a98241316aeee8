"""Differences at known points, beside those of the table of points."""

import numpy as np
import pytest

from einschalt.pipeline.assessment.facts.known_points import known_point_facts

LEFT_OUT = "control points, each left out"


def rms_of(table):
    squares = table[["difference_easting", "difference_northing"]] ** 2
    return np.sqrt(squares.sum(axis=1).mean())


@pytest.mark.parametrize("name", ["good", "faulty", "simultaneous"])
def test_differences_are_those_of_the_points(name, request):
    result = request.getfixturevalue(f"{name}_result")
    found = {
        what: rest for what, *rest in known_point_facts(result.examination).differences
    }
    for role in ("control", "check"):
        rows = result.points[result.points["role"] == role]
        n_points, rms = found[f"{role} points"]
        assert n_points == len(rows)
        assert rms == pytest.approx(rms_of(rows))
    assert (LEFT_OUT in found) == (name != "simultaneous")


@pytest.mark.parametrize("name", ["good", "faulty"])
def test_the_worst_of_those_left_out_are_named(name, request):
    result = request.getfixturevalue(f"{name}_result")
    facts = known_point_facts(result.examination)
    table = result.control_left_out.sort_values("p_value", kind="stable")
    assert facts.left_out.worst == tuple(table["point_id"][:3])
    first = table.iloc[0]
    assert facts.left_out.largest == pytest.approx(
        np.hypot(first["difference_easting"], first["difference_northing"])
    )
    # w² is d V⁻¹ d, two on the average
    expected = np.mean(table["w"] ** 2) / 2.0
    assert facts.left_out.normalized_square == pytest.approx(expected)
    n_points, rms = next(rest for what, *rest in facts.differences if what == LEFT_OUT)
    assert (n_points, rms) == (len(table), pytest.approx(rms_of(table)))


def test_what_is_not_there_has_no_row(unchecked_result, simultaneous_result):
    names = [
        row[0] for row in known_point_facts(unchecked_result.examination).differences
    ]
    assert "check points" not in names
    assert known_point_facts(simultaneous_result.examination).left_out is None
