"""Control points under each other's name: which, the figure, the headline."""

from dataclasses import replace

import numpy as np
import pytest
from tests.judged_alone import judged_alone
from tests.photographs_onto_control import one_flight

import einschalt as es
from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of
from einschalt.pipeline.summary.verdict import verdict

pytestmark = pytest.mark.slow

PLAN = ["easting", "northing"]
CODE = "exchanged_control"
WAYS = [
    *(("affine", "two_step"), ("affine", "simultaneous")),
    *(("helmert", "two_step"), ("helmert_3d", "two_step")),
    ("helmert_3d", "simultaneous"),
]


def simulated(kind="affine", seed=11):
    geometry = replace(PRESETS["demo"].geometry, transformation=kind)
    return es.simulate_block("demo", seed=seed, geometry=geometry)


def exchanged(block, seed=0):
    """Two control points under each other's name, and their names."""
    control = block.control_points
    places = np.flatnonzero(control["role"] == "control")
    one, other = np.random.default_rng(seed).choice(places, 2, replace=False)
    names = control["point_id"].to_numpy(dtype=object, copy=True)
    names[[one, other]] = names[[other, one]]
    changed = replace(block, control_points=control.assign(point_id=names))
    return changed, {str(names[one]), str(names[other])}


def onto_approximate_points(block, own_m=0.2, seed=3):
    """The low flight alone onto approximate points: control only checks it."""
    rng = np.random.default_rng(seed)
    known = block.truth[["point_id", *PLAN]].copy()
    known[PLAN] += rng.normal(0.0, own_m / np.sqrt(2.0), (len(known), 2))
    return replace(
        block, high_flight=None, approximate_points=known, approximate_m_0_m=own_m
    )


def densified(block, method="two_step"):
    return es.densify(block, es.Settings(method=method))


def true_error(result, block):
    new = result.points[result.points["role"] == "new"].set_index("point_id")
    true = block.truth.set_index("point_id").loc[new.index, PLAN]
    return float(np.sqrt(np.mean(np.sum((new[PLAN] - true) ** 2, axis=1))))


@pytest.mark.parametrize(("kind", "method"), WAYS)
def test_pair_is_named_and_tells_how_far_points_are_off(kind, method):
    block, pair = exchanged(simulated(kind))
    result = densified(block, method)
    assessment = result.assessment
    cause = next(found for found in assessment.findings if not found.explained_by)
    assert cause.code == CODE
    assert set(cause.names) == pair
    assert cause.facts["explains"]
    # metres, of which centimetres are unknown
    credible = assessment.credible
    assert credible.value == pytest.approx(true_error(result, block), rel=0.01)
    assert credible.is_lower_bound
    assert "put the names of control right first" in verdict(assessment)


def test_points_that_no_control_moves_are_as_good_as_they_are():
    block, pair = exchanged(onto_approximate_points(simulated()))
    result = densified(block)
    good = densified(onto_approximate_points(simulated()))
    assessment = result.assessment
    assert set(assessment.findings[0].names) == pair
    credible = assessment.credible
    assert credible.value == pytest.approx(good.assessment.credible.value)
    assert credible.is_lower_bound == good.assessment.credible.is_lower_bound
    assert true_error(result, block) < 1.3 * credible.value < 0.2
    assert "put the names of control right first" in verdict(assessment)
    # control is beyond the claim by nothing but the pair
    codes = {found.code for found in assessment.findings if not found.explained_by}
    assert "control_points_beyond_claim" not in codes


def test_pair_is_put_into_words():
    block, pair = exchanged(simulated())
    cause = densified(block).assessment.findings[0]
    said = suggestion_of(cause)
    assert all(name in str(said) for name in pair)
    assert "move by" in str(said)
    assert "Exchange their names" in said.remedy


def moved(block, by_name):
    control = block.control_points.set_index("point_id")
    for name, shift in by_name.items():
        control.loc[name, PLAN] = control.loc[name, PLAN] + np.array(shift)
    return replace(block, control_points=control.reset_index())


@pytest.mark.parametrize("n_wrong", [0, 1, 2])
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_other_errors_of_control_are_no_pair(n_wrong, method):
    block = simulated(seed=12)
    control = block.control_points
    names = control.loc[control["role"] == "control", "point_id"].iloc[[2, 9]]
    shifts = dict(zip(names, [(700.0, -90.0), (40.0, 900.0)], strict=True))
    wrong = moved(block, dict(list(shifts.items())[:n_wrong]))
    result = densified(wrong, method)
    assert result.examination.exchanged_control is None
    assert CODE not in judged_alone(result)


def with_corners(kind, *, seed=5, n_inside=0):
    """A block on the control points of its corners, and some inside."""
    geometry = replace(PRESETS["demo"].geometry, transformation=kind)
    block = es.simulate_block("demo", seed=seed, geometry=geometry)
    control = block.control_points[block.control_points["role"] == "control"]
    plan = control[PLAN].to_numpy()
    corners = [np.argmax(plan @ way) for way in [(1, 1), (1, -1), (-1, 1), (-1, -1)]]
    inside = [k for k in range(len(control)) if k not in corners][:n_inside]
    control = control.iloc[sorted([*corners, *inside])].reset_index(drop=True)
    return replace(block, control_points=control)


def names_exchanged(block, one, other):
    names = block.control_points["point_id"]
    names = names.replace({one: other, other: one})
    return replace(block, control_points=block.control_points.assign(point_id=names))


@pytest.mark.parametrize("kind", ["affine", "helmert"])
@pytest.mark.parametrize("n_inside", [0, 1])
def test_opposite_corners_that_are_a_mirror(kind, n_inside):
    """Bends of models took up what was missed: 2 m were told for 1600, as supported."""
    block = with_corners(kind, n_inside=n_inside)
    plan = block.control_points.set_index("point_id")[PLAN].to_numpy() @ [1.0, 1.0]
    names = block.control_points["point_id"].to_numpy()
    one, other = names[plan.argmax()], names[plan.argmin()]
    result = densified(names_exchanged(block, one, other), "simultaneous")
    cause = result.assessment.findings[0]
    assert (cause.code, set(cause.names)) == (CODE, {one, other})
    credible = result.assessment.credible
    assert credible.value == pytest.approx(true_error(result, block), rel=0.1)
    assert credible.is_lower_bound


def test_models_of_a_left_handed_machine_have_no_pair():
    block = with_corners("affine")
    flights = {
        name: replace(
            flight,
            model_points=flight.model_points.assign(x=-flight.model_points["x"]),
        )
        for name, flight in block.flights.items()
    }
    result = densified(replace(block, **flights), "simultaneous")
    assert result.examination.frame.is_mirrored
    assert result.examination.exchanged_control is None


@pytest.mark.parametrize("roles", [("check", "control"), ("check", "check")])
def test_check_points_have_names_as_well(roles):
    block = simulated()
    given = block.control_points.groupby("role")["point_id"].apply(list)
    one, other = given[roles[0]][0], given[roles[1]][2]
    wrong = names_exchanged(block, one, other)
    result = densified(wrong)
    cause = result.assessment.findings[0]
    assert (cause.code, set(cause.names)) == (CODE, {one, other})
    assert result.assessment.credible.value == pytest.approx(
        true_error(result, block), rel=0.25
    )


def test_pair_in_models_that_failed_is_named_beside_what_is_left():
    """Two steps have none of its models: 5.6 cm were told, and no name."""
    block = one_flight(4, 8)
    names = block.control_points["point_id"].replace({"1009": "1092", "1092": "1009"})
    changed = {
        name: getattr(block, name).assign(point_id=names)
        for name in ("control_points", "approximate_points")
    }
    result = densified(replace(block, **changed))
    assert len(result.failures) == 19
    assert set(result.assessment.findings[0].names) == {"1009", "1092"}
    credible = result.assessment.credible
    assert not credible.is_lower_bound
    assert credible.value == pytest.approx(true_error(result, block), rel=0.25)
    head = result.summary().splitlines()[0]
    assert "put the names of control right first" in head
    assert "cm (total, mean of two coverages; " in head


def exchanged_in_both(block, seed):
    """Two near points that models are fitted onto under each other's name."""
    control = block.control_points
    plan = control[PLAN].to_numpy() @ [1.0, 1j]
    rng = np.random.default_rng(seed + 1000)
    one = int(rng.integers(len(control)))
    other = int(np.argsort(np.abs(plan - plan[one]))[1 + rng.integers(2)])
    names = control["point_id"].to_numpy(dtype=object, copy=True)
    names[[one, other]] = names[[other, one]]
    changed = replace(
        block,
        control_points=control.assign(point_id=names),
        approximate_points=block.approximate_points.assign(point_id=names),
    )
    return changed, {str(names[one]), str(names[other])}


# so few models show three of four or five control points that two steps are impossible
FEW = [(1, 4, "simultaneous"), (2, 5, "simultaneous"), (3, 8, "two_step")]


@pytest.mark.parametrize(("seed", "n_given", "method"), [*FEW, (3, 8, "simultaneous")])
def test_pair_of_photographs_that_go_onto_control(seed, n_given, method):
    good = one_flight(seed, n_given)
    block, pair = exchanged_in_both(good, seed)
    result = densified(block, method)
    assessment = result.assessment
    assert assessment.findings[0].code == CODE
    assert set(assessment.findings[0].names) == pair
    credible = assessment.credible
    assert credible.value == pytest.approx(true_error(result, block), rel=0.01)
    assert credible.is_lower_bound
    new = result.points[result.points["role"] == "new"].set_index("point_id")
    off = new["height"] - block.truth.set_index("point_id").loc[new.index, "height"]
    height = assessment.credible_heights
    assert height.value == pytest.approx(np.sqrt(np.mean(off**2)), rel=0.01)


@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_pair_that_two_steps_do_not_have(outliers):
    """No model that shows three control points holds one of the pair."""
    block, pair = exchanged_in_both(one_flight(12, 7), 12)
    result = es.densify(block, es.Settings(method="simultaneous", outliers=outliers))
    assert result.solution.two_step.points["difference_easting"].abs().max() < 1.0
    assert set(result.assessment.findings[0].names) == pair
    assert result.assessment.credible.value == pytest.approx(
        true_error(result, block), rel=0.1
    )


@pytest.mark.parametrize("method", ["simultaneous", "auto"])
def test_pair_is_the_remedy_where_hardly_anything_converges(method):
    """Last digits, as processors round them, decide whether this block does."""
    block, pair = exchanged_in_both(one_flight(12, 4), 12)
    refused = told = None
    try:
        told = es.densify(
            block, es.Settings(method=method, outliers="snoop")
        ).assessment
    except GeometryError as error:
        refused = error
    if refused is not None:
        one, other = [n for n in block.control_points["point_id"] if n in pair]
        assert f"names of control points {one} and {other}" in refused.remedy
        assert "does not converge" in str(refused)
    else:
        first = told.findings[0]
        assert (first.code, set(first.names)) == ("exchanged_control", set(pair))
        assert told.credible.is_lower_bound


def test_too_little_control_is_no_matter_of_names():
    block, _ = exchanged_in_both(one_flight(12, 4), 12)
    with pytest.raises(GeometryError) as caught:
        es.densify(block, es.Settings(method="two_step"))
    assert "names of control points" not in caught.value.remedy


@pytest.mark.parametrize("n_given", [4, 6])
@pytest.mark.parametrize("n_wrong", [1, 2])
def test_other_errors_of_few_points_are_no_pair(n_given, n_wrong):
    block = one_flight(4, n_given)
    names = block.control_points["point_id"]
    shifts = [(210.0, -90.0), (40.0, 300.0)]
    shifts = dict(zip(names, shifts[:n_wrong], strict=False))
    wrong = moved(block, shifts)
    wrong = replace(
        wrong,
        approximate_points=wrong.control_points[[*PLAN, "height", "point_id"]],
    )
    result = densified(wrong, "simultaneous")
    assert result.examination.exchanged_control is None


def mixed(block, order, tables=("control_points",)):
    """The names of control in another order, and the name under which each is given."""
    control = block.control_points
    places = np.flatnonzero(control["role"] == "control")[: len(order)]
    names = control["point_id"].to_numpy(dtype=object, copy=True)
    given_as = dict(zip(names[places], names[places][order], strict=True))
    names[places] = names[places][order]
    changed = {n: getattr(block, n).assign(point_id=names) for n in tables}
    wrong = {name: given for name, given in given_as.items() if name != given}
    return replace(block, **changed), wrong


ORDERS = {
    "two pairs": [4, 1, 7, 3, 0, 5, 6, 2],
    "three went round": [6, 1, 0, 3, 4, 5, 2],
    "slipped by one": [14, *range(14)],
    "a part slipped by two": [0, 1, 2, 5, 6, 7, 8, 3, 4],
}
MIXED_WAYS = list(zip(ORDERS, [*WAYS[::2], WAYS[1]], strict=True))


@pytest.mark.parametrize(("which", "way"), MIXED_WAYS)
def test_names_that_were_mixed_are_named(which, way):
    """130 m were told for 210, 79 km for 1600 m, other targets as the cause."""
    kind, method = way
    block, given_as = mixed(simulated(kind), ORDERS[which])
    result = densified(block, method)
    cause = result.assessment.findings[0]
    assert cause.code == CODE
    assert dict(zip(cause.names, cause.facts["given_as"], strict=True)) == given_as
    credible = result.assessment.credible
    assert credible.value == pytest.approx(true_error(result, block), rel=0.01)
    assert "put the names of control right first" in verdict(result.assessment)
    said = suggestion_of(cause)
    name = cause.names[0]
    assert f"{len(given_as)} points of the control list lie where others" in str(said)
    if "slipped" in which:
        rows = "1 row" if which == "slipped by one" else "2 rows"
        slip = f"names of the list have slipped by {rows}: {name} lies where"
        assert f"{slip} {given_as[name]} is given, and so on to" in str(said)
    else:
        assert f"{name} where {given_as[name]} is given" in str(said)
    assert "Put their names right" in said.remedy


def with_name_lost(block, way):
    """Names from a row on moved up or down, as where a cell was deleted or inserted."""
    control = block.control_points
    names = control["point_id"].to_numpy(dtype=object, copy=True)
    if way == "deleted":  # the last row has no name then
        names[5:-1] = names[6:].copy()
        control = control.assign(point_id=names).iloc[:-1]
    else:
        names[6:] = names[5:-1].copy()
        control = control.assign(point_id=names).drop(index=control.index[5])
    return replace(block, control_points=control.reset_index(drop=True))


@pytest.mark.parametrize(
    ("way", "kind", "method"),
    [("deleted", "affine", "two_step"), ("inserted", "helmert_3d", "simultaneous")],
)
def test_list_that_lost_a_name_is_told_as_such(way, kind, method):
    """860 m were told for 620, with a strained network as the cause."""
    good = simulated(kind)
    block = with_name_lost(good, way)
    result = densified(block, method)
    cause = result.assessment.findings[0]
    names = good.control_points["point_id"].to_list()
    assert (cause.code, cause.facts["slipped_rows"]) == (CODE, 1)
    moved = names[6:-1]
    to = names[7:] if way == "deleted" else names[5:-2]
    assert list(cause.names[:-1]) == moved
    assert list(cause.facts["given_as"]) == to
    lost, nameless = (
        (names[-1], names[6]) if way == "deleted" else (names[5], names[-2])
    )
    assert cause.names[-1] == cause.facts["lost"] == lost
    assert cause.facts["nameless"] == nameless
    assert result.assessment.credible.value == pytest.approx(
        true_error(result, block), rel=0.01
    )
    said = " ".join(str(suggestion_of(cause)).split())
    slip = f"slipped by 1 row: {moved[0]} lies where {to[0]} is given"
    assert f"{slip}, and so on to {moved[-1]}" in said
    assert f"no coordinates of {lost} are given, and those of {nameless} are of" in said


@pytest.mark.parametrize("which", ["two pairs", "three went round"])
def test_names_that_were_mixed_where_photographs_go_onto_control(which):
    """Mirrored models were the cause, and 26 km were told for 660 m."""
    tables = ("control_points", "approximate_points")
    block, given_as = mixed(one_flight(1, 15), ORDERS[which], tables)
    result = densified(block, "simultaneous")
    assert set(result.assessment.findings[0].names) == set(given_as)
    assert result.assessment.credible.value == pytest.approx(
        true_error(result, block), rel=0.01
    )


@pytest.mark.parametrize("which", ["two pairs", "three went round", "slipped by one"])
def test_names_that_were_mixed_where_control_is_not_fitted(which):
    block, given_as = mixed(onto_approximate_points(simulated()), ORDERS[which])
    result = densified(block)
    cause = result.assessment.findings[0]
    assert dict(zip(cause.names, cause.facts["given_as"], strict=True)) == given_as
    assert true_error(result, block) < 1.3 * result.assessment.credible.value < 0.2


@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_pair_in_control_alone_of_which_two_steps_hold_nothing(method):
    """4 km were told for 10 cm in two steps; 750 m for 1000 in one adjustment."""
    good = one_flight(12, 8)
    names = good.control_points["point_id"].to_numpy(dtype=object, copy=True)
    names[[1, 7]] = names[[7, 1]]
    block = replace(good, control_points=good.control_points.assign(point_id=names))
    result = densified(block, method)
    assert set(result.assessment.findings[0].names) == {names[1], names[7]}
    assert result.assessment.credible.value == pytest.approx(
        true_error(result, block), rel=0.25
    )
