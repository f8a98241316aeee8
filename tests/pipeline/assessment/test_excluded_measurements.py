"""What was found and excluded judges nothing any more; what is kept is bounded by it.

Points that the high flight did not measure have no residuals in the low flight, whose
models are not fitted onto them: only their values in other models tell.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.judged_alone import judged_alone

from einschalt.pipeline.assessment.evidence.control.heights import HEIGHT_OF_CHECK
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.simulate_block import simulate_block

pytestmark = pytest.mark.slow

PLAN = ["easting", "northing"]
METHODS = ("two_step", "simultaneous")
MODEL = ("1", "1/5")
PAIR = ("1030", "1039")


def with_low(block, points):
    return replace(block, low_flight=replace(block.low_flight, model_points=points))


def without_approximations(block, names):
    """The block, some points not measured in the high flight."""
    points = block.high_flight.model_points
    points = points[~points["point_id"].isin(names)].reset_index(drop=True)
    return replace(block, high_flight=replace(block.high_flight, model_points=points))


def rows_of(points, names):
    is_model = (points["coverage"] == MODEL[0]) & (points["model_id"] == MODEL[1])
    return points.index[is_model & points["point_id"].isin(names)]


def true_error(result):
    """TOTAL error of the new points, RMS [m]."""
    new = result.points[result.points["role"] == "new"]
    truth = result.block.truth.set_index("point_id").loc[new["point_id"], PLAN]
    miss = new[PLAN].to_numpy() - truth.to_numpy()
    return float(np.sqrt(np.mean(np.sum(miss**2, axis=1))))


@cache
def solved(block, method, outliers):
    """The result of a block, which is the same for all that ask for it."""
    return densify(
        block, block.settings.updated({"method": method, "outliers": outliers})
    )


@pytest.fixture(scope="module", autouse=True)
def _forgotten():
    yield
    solved.cache_clear()
    one_control_off.cache_clear()


@pytest.fixture(scope="module")
def clean():
    return simulate_block("demo", seed=5)


@pytest.fixture(scope="module")
def exchanged(clean):
    """Two points without approximate coordinates under each other's name."""
    points = clean.low_flight.model_points.copy()
    rows = rows_of(points, PAIR)
    points.loc[rows, "point_id"] = points.loc[rows, "point_id"].to_numpy()[::-1]
    return without_approximations(with_low(clean, points), PAIR)


@pytest.fixture(scope="module")
def one_wrong(clean):
    """One such point 200 m away in one of its models."""
    points = clean.low_flight.model_points.copy()
    points.loc[rows_of(points, PAIR[:1]), "x"] += 25.0
    return without_approximations(with_low(clean, points), PAIR[:1])


@pytest.fixture(scope="module")
def three_metres(clean):
    """A fitted point, 3 m off in one of its five models."""
    points = clean.low_flight.model_points.copy()
    points.loc[rows_of(points, PAIR[:1]), "x"] += 0.4
    return with_low(clean, points)


@cache
def one_control_off(metres):
    """The demo block in which one control point is given so far away."""
    block = simulate_block("demo", seed=7)
    control = block.control_points.copy()
    control.loc[control["point_id"] == "1100", "easting"] += metres
    return replace(block, control_points=control)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("outliers", ["snoop", "huber"])
@pytest.mark.parametrize("block", ["exchanged", "one_wrong"])
def test_the_claim_is_that_of_the_rest(clean, block, method, outliers, request):
    spoilt = request.getfixturevalue(block)
    result = solved(spoilt, method, outliers)
    without = without_approximations(clean, PAIR if block == "exchanged" else PAIR[:1])
    good = solved(without, method, outliers)
    assert true_error(result) == pytest.approx(true_error(good), rel=0.1)
    believed, expected = (r.examination.credible.value for r in (result, good))
    assert believed == pytest.approx(expected, rel=0.25)
    codes = set(judged_alone(result))
    assert not codes & {"contradicting_control", "strained_network", "broken_network"}
    assert not result.points.loc[~result.points["point_id"].isin(PAIR), "is_suspect"][
        ~good.points["is_suspect"].to_numpy()[~good.points["point_id"].isin(PAIR)]
    ].any()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("outliers", ["keep", "snoop", "huber"])
def test_names_exchanged_without_approximations_are_named(exchanged, method, outliers):
    judged = solved(exchanged, method, outliers).assessment
    cause = judged.findings[0]
    assert cause.code == "exchanged_names"
    assert set(cause.names) == set(PAIR)
    assert "exchanged_names" in judged.causes
    # 340 m apart, and a model of some centimetres with the names put right
    assert cause.expected < 0.2
    assert cause.observed > 100.0


@pytest.mark.parametrize("block", ["exchanged", "one_wrong"])
def test_kept_errors_are_counted_where_they_are(block, request):
    result = solved(request.getfixturevalue(block), "two_step", "keep")
    credible, true = result.examination.credible, true_error(result)
    assert credible.is_lower_bound
    # or worse: and not a hundred times as bad as it is
    assert 0.8 * true < credible.value < 1.3 * true
    assert result.examination.patterns.strain.p_value > 0.01
    m_g = result.examination.components.low_flight
    assert m_g.estimated == pytest.approx(m_g.given, rel=0.25)


def test_excluded_rows_are_in_no_figure_of_one_adjustment(exchanged):
    kept, result = (solved(exchanged, "simultaneous", how) for how in ("keep", "snoop"))
    of_kept, points = (
        r.points.set_index("point_id").loc[list(PAIR)] for r in (kept, result)
    )
    assert (of_kept["n_models"] - points["n_models"]).tolist() == [1, 1]
    assert (points["spread_total"] < 0.3).all()
    model = result.models.set_index(["flight", "coverage", "model_id"])
    model = model.loc[("low_flight", *MODEL)]
    assert model["m_0"] < 0.1
    # eight points, of which two are out: 12 coordinates less six parameters, and what
    # the points themselves take
    assert 0.0 < model["redundancy"] < 6.0
    assert result.figures.m_0_low < 0.1
    assert result.solution.adjustment.s_0 == pytest.approx(1.0, abs=0.15)
    deformed = result.solution.adjustment.deformations
    assert (deformed["size_edge"] < 0.2).all()


def test_downweighted_gross_errors_do_not_make_s_0_large(one_wrong):
    result = solved(one_wrong, "simultaneous", "huber")
    assert result.solution.adjustment.s_0 == pytest.approx(1.0, abs=0.15)


def test_suspects_that_are_excluded_are_called_so(three_metres):
    """Of a fitted point, which its model refuses."""
    remedies = {
        how: {
            f.code: f.remedy
            for f in solved(three_metres, "simultaneous", how).assessment.findings
        }
        for how in ("keep", "snoop", "huber")
    }
    told = {how: codes["suspect_observations"] for how, codes in remedies.items()}
    assert told == {
        "keep": "measure_again_or_snoop",
        "snoop": "measure_excluded_again",
        "huber": "measure_again",
    }


@pytest.mark.parametrize("method", METHODS)
def test_a_gross_error_that_takes_part_is_told_once_and_first(three_metres, method):
    result = solved(three_metres, method, "keep")
    cause, *others = result.assessment.findings
    assert cause.code == "kept_gross_measurements"
    assert cause.facts["observations"] == (("low_flight", *MODEL, PAIR[0]),)
    assert cause.observed == pytest.approx(3.2, abs=0.2)
    assert len(others) > 5
    assert {found.explained_by for found in others} == {cause.code}
    assert result.assessment.causes == (cause.code,)
    assert "gross errors take part" in result.summary().splitlines()[0]
    # what it advises helps
    followed = solved(three_metres, method, "snoop")
    assert followed.assessment.claim_is_supported


def test_what_is_still_found_without_gross_errors_does_not_follow_from_them(
    three_metres,
):
    control = three_metres.control_points.copy()
    wrong = control.index[control["role"] == "control"][0]
    control.loc[wrong, "easting"] += 3.0
    block = replace(three_metres, control_points=control)
    found = solved(block, "two_step", "keep").assessment.findings
    explained_by = {one.code: one.explained_by for one in found}
    assert "kept_gross_measurements" in explained_by
    assert explained_by["control_that_contradicts"] == ""
    assert explained_by["suspect_observations"] == "kept_gross_measurements"


def test_kept_exchanged_names_explain_deformations(exchanged):
    judged = solved(exchanged, "simultaneous", "keep").assessment
    found = {f.code: f.explained_by for f in judged.findings}
    assert found["deformed_models"] == "exchanged_names"


@pytest.fixture(scope="module")
def one_wrong_control():
    """A control point 3 m off, which one model of the high flight holds."""
    block = simulate_block("demo", seed=24)
    control = block.control_points.copy()
    control.loc[control["point_id"] == "1013", "easting"] += 3.0
    return replace(block, control_points=control)


def test_control_whose_only_measurement_is_excluded_makes_no_pattern(one_wrong_control):
    """It was called a broken network, of 31 times the true error."""
    result = solved(one_wrong_control, "two_step", "snoop")
    gross = result.solution.gross_measurements
    assert gross["flight"].tolist() == ["high_flight"]
    assert result.examination.excluded_control == set(gross["point_id"])
    assert 0.7 < result.examination.credible.value / true_error(result) < 1.7
    assert "broken_network" not in judged_alone(result)


@pytest.mark.parametrize("method", METHODS)
def test_wrong_control_is_no_gross_measurement(one_wrong_control, method):
    found = solved(one_wrong_control, method, "keep").assessment.findings
    codes = {one.code: one.explained_by for one in found}
    assert "kept_gross_measurements" not in codes
    control = {"control_that_contradicts", "control_against_block"} & set(codes)
    assert control
    assert all(codes[code] == "" for code in control)


def _under_each_others_name(block, one, other):
    """Exchange two names in all measurements of both flights."""

    def exchanged(flight):
        points = flight.model_points.copy()
        names = {one: other, other: one}
        points["point_id"] = points["point_id"].replace(names)
        return replace(flight, model_points=points)

    flights = {name: exchanged(flight) for name, flight in block.flights.items()}
    return replace(block, **flights)


@pytest.mark.parametrize(
    ("seed", "pair"), [(2, ("1093", "1027")), (5, ("1060", "1070"))]
)
def test_control_under_the_name_of_a_new_point_is_named(seed, pair):
    """The new point was 2.3 km off, without a word, in a result with 3.0 cm."""
    block = _under_each_others_name(simulate_block("demo", seed=seed), *pair)
    judged = solved(block, "simultaneous", "snoop").assessment
    (found,) = [f for f in judged.findings if f.code == "control_under_another_name"]
    assert tuple(found.names) == pair
    assert judged.findings[0] is found
    assert found.observed < 0.1
    assert found.expected > 100.0
    assert judged.claim_is_supported is False


@pytest.mark.parametrize("metres", [10.0, 900.0])
def test_the_wrong_control_point_comes_first(metres):
    """A good one that it moves was named first, and was to be checked first."""
    found = solved(one_control_off(metres), "two_step", "keep")
    codes = {f.code: f for f in found.assessment.findings}
    assert codes["control_that_contradicts"].names[0] == "1100"
    # where it is given lies no new point
    assert "control_under_another_name" not in codes


@pytest.mark.parametrize("flights", ["high_flight", "low_flight"])
def test_names_exchanged_everywhere_may_be_exchanged_in_either_flight(flights):
    """Corrected in the low flight alone, two points were 287 m off, and none told."""
    block = simulate_block("demo", seed=1)
    both = _under_each_others_name(block, "1026", "1027")
    block = replace(block, **{flights: both.flights[flights]})
    found = solved(block, "two_step", "snoop").assessment.findings[0]
    assert found.code == "exchanged_names"
    assert found.remedy == "compare_names_of_both_flights"
    assert set(found.names) == {"1026", "1027"}


def test_names_exchanged_in_one_model_are_to_be_corrected_there(exchanged):
    found = solved(exchanged, "two_step", "snoop").assessment.findings[0]
    assert found.code == "exchanged_names"
    assert found.remedy == "put_the_names_right"


@pytest.mark.parametrize("seed", [1, 2])
def test_heights_without_the_control_that_was_set_aside_are_as_claimed(seed):
    """The two steps hold it: of the adjustment 30 cm were claimed, where 4 are true."""
    geometry = BlockGeometry(
        width=3e3,
        height=3e3,
        n_check=6,
        measurement="images",
        transformation="helmert_3d",
    )
    block = simulate_block("demo", seed=seed, geometry=geometry)
    control = block.control_points.copy()
    row = control.index[control["role"] == "control"][5]
    control.loc[row, "height"] += 3.0
    result = solved(replace(block, control_points=control), "simultaneous", "snoop")
    new = result.points[result.points["role"] == "new"]
    true = block.truth.set_index("point_id")["height"].reindex(new["point_id"])
    error = np.sqrt(np.mean((new["height"].to_numpy() - true.to_numpy()) ** 2))
    heights = result.examination.credible_heights
    assert not heights.is_lower_bound
    assert 0.7 < heights.value / error < 1.4
    # and it is the heights of the adjustment that are compared with the check points
    check = result.points[result.points["role"] == "check"]
    test = result.examination.height_claim.of(HEIGHT_OF_CHECK)
    rms = np.sqrt(np.mean(check["difference_height"] ** 2))
    assert test.observed == pytest.approx(rms)


WRONG_CONTROL = [
    ("two_step", "keep", "control_that_contradicts"),
    ("simultaneous", "keep", "control_against_block"),
    ("simultaneous", "snoop", "control_set_aside"),
]


@pytest.mark.parametrize(("method", "outliers", "code"), WRONG_CONTROL)
def test_what_follows_from_wrong_control_stands_under_it(method, outliers, code):
    """Ten findings stood beside each other, and m_g was to be raised."""
    result = solved(one_control_off(900.0), method, outliers)
    judged = result.assessment
    first, *others = judged.findings
    assert first.code == code
    assert first.names[0] == "1100"
    follows = [found.code for found in others if found.explained_by == code]
    assert list(first.facts["explains"]) == follows
    assert "coverages_that_differ" in follows
    assert not [found for found in others if not found.explained_by]
    assert judged.causes == (code,)
    is_out = code == "control_set_aside"
    assert judged.claim_is_supported is is_out


def test_what_does_not_follow_from_a_wrong_control_point_stands_by_itself():
    block = one_control_off(10.0)
    low = block.low_flight.model_points.copy()
    row = low.index[~low["point_id"].isin(block.control_points["point_id"])][20]
    low.loc[row, "x"] += 1000.0
    findings = solved(with_low(block, low), "two_step", "snoop").assessment.findings
    by_itself = {found.code for found in findings if not found.explained_by}
    assert {"control_that_contradicts", "gross_measurements"} <= by_itself
