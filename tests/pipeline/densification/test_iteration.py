"""The low flight repeated on its own coordinates, with control held.

That the propagation goes exactly through all passes is tested in
tests/truth/test_errors_of_one_block.py.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.given_approximations import onto_given_approximations

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.assessment.findings.iterations import drift
from einschalt.pipeline.block.block import Block, Flight, plain_fields
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.pipeline.summary.summary import sections
from einschalt.stages.stage3_model_transformation import transform_models
from einschalt.stages.stage5_double_coverage import average_coverages

PLAN = ["easting", "northing"]


def by_hand(block, result, n_passes):
    """Points after each pass, with the functions of the stages alone."""
    control = block.control_points.set_index("point_id")
    checks = control.index[control["role"] == "check"]
    held = control[control["role"] != "check"]
    low = block.low_flight.points_to_fit
    points, passes = result.approximations, []
    for number in range(n_passes):
        ground = points.set_index("point_id")[PLAN].drop(checks, errors="ignore")
        if number > 0:
            known = ground.index.intersection(held.index)
            ground.loc[known] = held.loc[known, PLAN].to_numpy(dtype=float)
        fit = transform_models(
            low, ground.reset_index(), block.low_flight.transformation
        )
        points = average_coverages(fit.transform(low).drop(columns="m_t")).points
        passes.append(points)
    return passes


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_passes_are_those_of_the_stages(demo_block, kind):
    low = replace(demo_block.low_flight, transformation=kind)
    block = replace(demo_block, low_flight=low)
    result = densify(block, Settings(iterations=4, weighting="plain"))
    *_, before, expected = by_hand(block, result, 4)
    np.testing.assert_allclose(result.solution.points[PLAN], expected[PLAN], atol=1e-8)
    shift = np.hypot(*(expected[PLAN] - before[PLAN]).to_numpy().T)
    last = result.iterations.iloc[-1]
    assert result.iterations["iteration"].tolist() == [2, 3, 4]
    assert last["largest_move"] == pytest.approx(shift.max(), abs=1e-8)
    assert last["point_id"] == expected["point_id"][shift.argmax()]
    assert last["move_rms"] == pytest.approx(np.sqrt(np.mean(shift**2)), abs=1e-8)


@pytest.mark.slow
def test_it_ends_where_nothing_moves_by_a_millimetre(demo_block):
    result = densify(demo_block, Settings(iterations=100))
    moves = result.iterations["largest_move"]
    assert 5 < len(moves) < 60
    assert moves.iloc[-1] < 0.001 <= moves.iloc[-2]
    text = sections(result.assessment)["iterations"].text()
    assert "Converged: no point moved by 1.0 mm." in text.replace("\n    ", " ")
    assert "iterations.csv has all of them" in text.replace("\n    ", " ")
    assert len(text.splitlines()) < 16


@pytest.mark.slow
def test_one_pass_is_what_it_was(demo_block, good_result):
    result = densify(demo_block, Settings(iterations=1))
    assert result.iterations.empty
    np.testing.assert_array_equal(
        result.solution.points[PLAN], good_result.points[PLAN]
    )
    assert "Iterations" not in result.summary()


@pytest.mark.slow
def test_held_control_makes_points_better_and_the_claim_knows_it():
    """True errors of eight blocks; all models: theory says 4.8 -> 3.9 on Neukirchen."""
    squares, normalised = {1: [], 5: []}, {1: [], 5: []}
    for seed in range(8):
        block = simulate_block("demo", seed=seed)
        truth = block.truth.set_index("point_id")
        for n, of_passes in squares.items():
            result = densify(block, Settings(iterations=n))
            true = truth.loc[result.solution.points["point_id"], PLAN].to_numpy()
            error = result.solution.points[PLAN].to_numpy() - true
            of_passes.append(np.mean(error**2))
            inverse = np.linalg.inv(result.errors.covariance)
            square = np.einsum("ni,nij,nj->n", error, inverse, error)
            normalised[n].append(square.mean() / 2.0)
    assert np.mean(squares[5]) < 0.8 * np.mean(squares[1])
    scatter = np.std(normalised[5], ddof=1) / np.sqrt(8)
    assert np.mean(normalised[5]) == pytest.approx(1.0, abs=3.0 * scatter)


@pytest.mark.slow
def test_claim_after_the_last_pass_stands():
    blocks = [simulate_block("demo", seed=seed) for seed in range(5)]
    stand = [
        densify(block, Settings(iterations=4)).claim.is_supported for block in blocks
    ]
    # one block of a hundred is called out by chance: two of five once in a thousand
    assert sum(stand) >= 4


def test_tables_and_tests_are_those_of_the_last_pass(demo_block, good_result):
    result = densify(demo_block, Settings(iterations=4))
    assert "control points" not in [test.name for test in result.claim.tests]
    table = result.error_sources
    np.testing.assert_allclose(
        table["standard_error_total"],
        result.solution.points["standard_error_total"],
        atol=1e-9,
    )
    shares = result.block_error_sources.set_index("source")["share"]
    before = good_result.block_error_sources.set_index("source")["share"]
    assert shares["high_flight"] < 0.7 * before["high_flight"]
    # the sizes of errors come from the first pass
    assert result.components == good_result.components
    assert result.neighbours["standard_error_total"].notna().all()
    assert (result.solution.points["standard_error_total"] < 0.1).all()


def test_the_summary_tells_of_control_that_is_held(demo_block, good_result):
    result = densify(demo_block, Settings(iterations=3))
    text = " ".join(sections(result.assessment)["iterations"].text().split())
    n_held = int((result.solution.points["role"] == "control").sum())
    assert f"{n_held} control points held at given coordinates" in text
    assert "Not converged after 3 passes" in text
    once = good_result.figures.mean_total
    assert f"Propagated: {100 * once:.1f} cm after one pass" in text
    assert drift(result.examination) is None


@pytest.mark.slow
def test_a_block_that_nothing_holds_drifts_and_is_told(demo_block):
    """Control only where the low flight does not see it."""
    control = demo_block.control_points
    names = control.loc[control["role"] != "check", "point_id"]
    points = demo_block.low_flight.model_points
    points = points[~points["point_id"].isin(names)].reset_index(drop=True)
    low = replace(demo_block.low_flight, model_points=points)
    block = replace(demo_block, low_flight=low, may_be_unmeasured=True)
    central = {"coverage_mean": "most_central"}
    result = densify(block, Settings(iterations=25, **central))
    found = drift(result.examination)
    assert found.code == "drift_without_control"
    assert found.remedy == "one_pass_or_measure_control"
    text = " ".join(sections(result.assessment)["iterations"].text().split())
    assert "0 control points held" in text
    # theory: best after some passes, then worse and worse
    best = densify(block, Settings(iterations=6, **central)).figures.mean_total
    assert result.figures.mean_total > 1.02 * best


@pytest.mark.slow
def test_iterations_that_make_points_worse_are_told(demo_block):
    control = demo_block.control_points
    names = control.loc[control["role"] != "check", "point_id"].iloc[1:]
    points = demo_block.low_flight.model_points
    points = points[~points["point_id"].isin(names)].reset_index(drop=True)
    low = replace(demo_block.low_flight, model_points=points)
    block = replace(demo_block, low_flight=low, may_be_unmeasured=True)
    settings = Settings(iterations=30, coverage_mean="most_central")
    found = drift(densify(block, settings).examination)
    assert found.code == "iterations_that_spoil"
    assert found.observed > found.expected > 0.0
    assert 0 < found.facts["n_models_held"] < found.facts["n_models"]


def test_given_approximations_can_be_iterated(demo_block):
    block = onto_given_approximations(demo_block, own_error=0.1, seed=3)
    result = densify(block, Settings(iterations=3))
    assert result.errors is None
    assert result.claim.is_supported
    # control took part: it is no check any more
    assert "control points" not in [test.name for test in result.claim.tests]
    truth = demo_block.truth.set_index("point_id").loc[
        result.solution.points["point_id"], PLAN
    ]
    once = densify(block).solution.points
    error = {
        name: np.sqrt(np.mean((points[PLAN].to_numpy() - truth.to_numpy()) ** 2))
        for name, points in (("once", once), ("thrice", result.solution.points))
    }
    assert error["thrice"] < error["once"]


def test_given_approximations_without_control_drift(demo_block):
    low = Flight(**plain_fields(demo_block.low_flight))
    truth = demo_block.truth[["point_id", *PLAN]]
    block = Block(low_flight=low, approximate_points=truth)
    result = densify(block, Settings(iterations=2))
    assert drift(result.examination).code == "drift_without_control"


def test_thin_control_without_a_figure_is_told(demo_block):
    block = onto_given_approximations(demo_block, own_error=0.1, seed=3)
    control = block.control_points.iloc[:1]
    result = densify(replace(block, control_points=control), Settings(iterations=3))
    assert drift(result.examination).code == "drift_that_nothing_tells"


def test_what_cannot_be_iterated_is_refused(demo_block):
    settings = Settings(iterations=2, method="simultaneous")
    with pytest.raises(
        SettingsError, match=r"adjusts all models at once.*Take iterations out"
    ):
        densify(demo_block, settings)
    points = demo_block.low_flight.model_points.assign(z=0.0)
    low = replace(
        demo_block.low_flight, model_points=points, transformation="helmert_3d"
    )
    block = replace(demo_block, low_flight=low)
    with pytest.raises(SettingsError, match=r"transformed in space \(helmert_3d\)"):
        densify(block, Settings(iterations=2))


@pytest.mark.parametrize("value", [0, -1, 101, 1.5, True, "2", None])
def test_nonsense_is_refused(value):
    with pytest.raises(
        SettingsError, match=r"\[settings\] iterations = .*a whole number from 1 to 100"
    ):
        Settings(iterations=value)
