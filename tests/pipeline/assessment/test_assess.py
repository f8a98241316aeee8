"""An assessment holds everything, in plain values where asked, and stays as it is."""

import json
from dataclasses import FrozenInstanceError, fields

import pytest
from tests.judged_alone import judged_alone

from einschalt.pipeline.assessment.assess import Assessment
from einschalt.pipeline.assessment.findings.catalogue import ORDER
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block

RESULTS = ["good", "faulty", "given_approximations", "unchecked", "simultaneous"]
# of the examination, which many tests ask alone: it takes a third of an assessment
AS_EXAMINED = ("credible", "credible_heights", "claim", "height_claim", "deformation")


@pytest.fixture(params=RESULTS)
def result(request):
    return request.getfixturevalue(f"{request.param}_result")


@pytest.fixture
def assessment(result):
    return result.assessment


@pytest.mark.slow
@pytest.mark.parametrize("name", AS_EXAMINED)
def test_figures_are_those_of_the_examination(result, name):
    assert getattr(result.assessment, name) is getattr(result.examination, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*RESULTS, "shifted_names"])
def test_no_finding_is_left_out_because_it_follows_from_another(name, request):
    result = request.getfixturevalue(f"{name}_result")
    told = {found.code for found in result.assessment.findings}
    # no judge tells these
    causes = {"exchanged_names", "kept_gross_measurements"}
    assert told - causes == set(judged_alone(result))


def test_it_is_frozen(assessment):
    for name in (field.name for field in fields(Assessment)):
        with pytest.raises(FrozenInstanceError):
            setattr(assessment, name, None)


def test_findings_are_sorted_the_gravest_first(assessment):
    places = [ORDER.index(finding.code) for finding in assessment.findings]
    assert places == sorted(places)


def test_a_faulty_block_has_several_findings(faulty_result, good_result):
    codes = [finding.code for finding in faulty_result.assessment.findings]
    assert len(codes) >= 3
    assert codes[:2] == ["exchanged_names", "failed_models"]
    assert good_result.assessment.findings == ()


def test_as_dict_it_survives_json(assessment):
    plain = assessment.to_dict()
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert list(plain) == [field.name for field in fields(Assessment)]


def test_the_dict_says_what_the_assessment_does(assessment):
    plain = assessment.to_dict()
    assert [finding["code"] for finding in plain["findings"]] == [
        finding.code for finding in assessment.findings
    ]
    assert plain["block"]["name"] == assessment.block.name
    assert plain["precision"]["n_new"] == assessment.precision.n_new
    tests = [test["name"] for test in plain["claim"]["tests"]]
    assert tests == [test.name for test in assessment.claim.tests]
    # arrays of drawn errors are no result
    assert "residuals" not in plain["claim"]


def test_no_matrix_of_the_computation_is_in_the_dict(assessment):
    """They would make the file grow with the square of the control points."""

    def wide_rows(part, is_row=False):
        if isinstance(part, dict):
            return sum(map(wide_rows, part.values()))
        if not isinstance(part, list):
            return 0
        is_wide = is_row and len(part) > 9
        return is_wide + sum(wide_rows(one, is_row=True) for one in part)

    assert wide_rows({"covariance": [[0.0] * 10] * 10}) == 10
    assert wide_rows(assessment.to_dict()) == 0


def test_each_way_is_judged_in_its_own_way(good_result, simultaneous_result):
    two_steps, adjusted = good_result.assessment, simultaneous_result.assessment
    assert two_steps.deformation is None
    assert adjusted.deformation is not None
    assert adjusted.iterations is None
    assert not hasattr(two_steps.precision, "s_0")
    assert adjusted.precision.s_0 == simultaneous_result.simultaneous.s_0


def test_without_a_tolerance_none_is_judged(assessment):
    assert assessment.tolerance is None


@pytest.mark.slow
def test_what_enlarges_a_claim_is_told():
    # of forty clean blocks this one has control apart by chance (P 0.002), in a step
    # that larger errors explain as well
    judged = densify(simulate_block("demo", seed=0)).assessment
    assert judged.credible.is_lower_bound
    assert judged.credible.factor > 2.0
    told = {found.code: found for found in judged.findings}
    assert told["contradicting_control"].probability == pytest.approx(0.0018, rel=0.1)
