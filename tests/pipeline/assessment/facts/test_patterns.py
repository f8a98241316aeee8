"""Why strain was not looked for."""

import pytest

from einschalt.pipeline.assessment.evidence import systematic_errors
from einschalt.pipeline.assessment.examination import examine
from einschalt.pipeline.assessment.facts.patterns import NoStrainTest, pattern_facts


@pytest.mark.parametrize("name", ["good", "faulty", "simultaneous"])
def test_where_strain_was_tested_there_is_nothing_to_excuse(name, request):
    result = request.getfixturevalue(f"{name}_result")
    facts = pattern_facts(result.examination)
    assert facts.patterns.affinities == result.patterns.affinities
    assert facts.patterns.strain is not None
    assert facts.untested is None
    assert facts.size == ""


def test_orientations_that_bend_models_are_said(parallaxes_result):
    facts = pattern_facts(parallaxes_result.examination)
    assert facts.patterns.strain is None
    assert facts.untested is NoStrainTest.ORIENTATIONS_BEND_WEIGHED


def test_a_block_that_is_too_large_is_said_with_its_size(monkeypatch, good_result):
    monkeypatch.setattr(systematic_errors, "MOST_CONTROL", 3)
    facts = pattern_facts(examine(good_result.solution))
    control = good_result.block.control_points
    n_control = (control["role"] != "check").sum()
    assert facts.untested is NoStrainTest.TOO_LARGE
    assert facts.size == f"{n_control} control points, at most 3"


def test_blocks_whose_errors_are_not_propagated_have_no_reason(
    given_approximations_result,
):
    facts = pattern_facts(given_approximations_result.examination)
    assert facts.patterns.affinities == ()
    assert facts.untested is None
