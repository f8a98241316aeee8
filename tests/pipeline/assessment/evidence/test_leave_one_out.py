"""Control points left out in one pass are those that were left out one by one."""

from dataclasses import replace
from functools import cached_property

import numpy as np
import pytest
from scipy import sparse

from einschalt.pipeline.assessment.evidence import leave_one_out
from einschalt.pipeline.assessment.evidence.claim import LEFT_OUT
from einschalt.pipeline.assessment.findings.suspects import control_that_contradicts
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.pipeline.summary.summary import sections
from einschalt.stages.error_propagation import covariances
from einschalt.stages.error_propagation.error_model import model_of_high_flight
from einschalt.stages.stage3_model_transformation import transform_models
from einschalt.stages.stage5_double_coverage import average_coverages, with_positions
from einschalt.theory.adjustment import rows_of_chains
from einschalt.theory.adjustment.point_operator import Axes, PointOperator

PLAN = ["easting", "northing"]
DIFFERENCES = ["difference_easting", "difference_northing"]


def of_kinds(block, high, low):
    return replace(
        block,
        high_flight=replace(block.high_flight, transformation=high),
        low_flight=replace(block.low_flight, transformation=low),
    )


def as_check_point(block, name):
    control = block.control_points.copy()
    control.loc[control["point_id"] == name, "role"] = "check"
    return replace(block, control_points=control)


def assert_same(result, predict, tolerance):
    """What one pass gives for every fourth point is what ``predict`` gives."""
    table = result.control_left_out.iloc[::4]
    assert len(table) >= 3
    for row in table.itertuples():
        given = result.block.control_points.set_index("point_id").loc[row.point_id]
        expected = predict(row.point_id) - given[PLAN].to_numpy(dtype=float)
        found = [row.difference_easting, row.difference_northing]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=tolerance)


@pytest.mark.slow
@pytest.mark.parametrize("mean", ["all", "most_central"])
@pytest.mark.parametrize(
    ("high", "low"),
    [("affine", "affine"), ("helmert", "helmert"), ("affine", "helmert")],
)
def test_differences_are_those_of_densifying_again(demo_block, high, low, mean):
    block = of_kinds(demo_block, high, low)
    settings = Settings(coverage_mean=mean, weighting="plain")

    def predict(name):
        points = densify(as_check_point(block, name), settings).solution.points
        return points.set_index("point_id").loc[name, PLAN].to_numpy(dtype=float)

    assert_same(densify(block, settings), predict, 1e-8)


@pytest.mark.parametrize("mean", ["all", "most_central"])
@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_weights_stay_those_of_the_whole_block(demo_block, kind, mean):
    block = of_kinds(demo_block, kind, kind)
    settings = Settings(coverage_mean=mean, weighting="weighted")
    result = densify(block, settings)
    high_points, low_points = (
        result.solution.model_points[name] for name in ("high_flight", "low_flight")
    )
    control = block.control_points[block.control_points["role"] != "check"]
    checks = set(block.control_points["point_id"]) - set(control["point_id"])
    errors = {  # those of the whole block
        "high": result.solution.high.transformation.values(
            high_points, least_redundancy=30
        ),
        "low": result.single_values,
    }

    def averaged(points, ground, flight):
        values = transform_models(points, ground, kind).transform(points)
        column = {"high": "m_t", "low": "standard_error_paper"}[flight]
        values["standard_error_paper"] = errors[flight][column].to_numpy()
        values = with_positions(values.drop(columns="m_t"), points)
        return average_coverages(
            values, coverage_mean=mean, weighting="weighted"
        ).points

    def predict(name):
        others = control[control["point_id"] != name]
        ground = averaged(high_points, others, "high")
        ground = ground[~ground["point_id"].isin({*checks, name})][["point_id", *PLAN]]
        final = averaged(low_points, ground, "low").set_index("point_id")
        return final.loc[name, PLAN].to_numpy(dtype=float)

    assert_same(result, predict, 1e-8)


@pytest.mark.slow
def test_rigid_models_to_first_order():
    geometry = replace(PRESETS["demo"].geometry, transformation="rigid")
    block = simulate_block("demo", seed=3, geometry=geometry)
    settings = Settings(weighting="plain")

    def predict(name):
        points = densify(as_check_point(block, name), settings).solution.points
        return points.set_index("point_id").loc[name, PLAN].to_numpy(dtype=float)

    # residuals of 10 cm turn a model of 2 km by 5e-5
    assert_same(densify(block, settings), predict, 1e-5)


def test_points_that_a_model_needs_are_not_left_out(demo_block):
    """A model of three control points has an affine transformation by all of them."""
    points = demo_block.high_flight.model_points
    control = demo_block.control_points
    names = control.loc[control["role"] != "check", "point_id"]
    model = (points["coverage"] == "1") & (points["model_id"] == points["model_id"][0])
    of_model = points[model & points["point_id"].isin(names)]
    kept = set(of_model["point_id"].iloc[:3])
    dropped = of_model.index[3:]
    high = replace(
        demo_block.high_flight, model_points=points.drop(dropped).reset_index(drop=True)
    )
    block = replace(demo_block, high_flight=high, may_be_unmeasured=True)
    result = densify(block)
    left_out = set(result.control_left_out["point_id"])
    assert left_out
    assert not left_out & kept
    everything = densify(demo_block).control_left_out
    assert kept <= set(everything["point_id"])


def test_table_holds_together(good_result):
    table = good_result.control_left_out
    d = table[DIFFERENCES].to_numpy()
    total = table["standard_error_easting"] ** 2 + table["standard_error_northing"] ** 2
    np.testing.assert_allclose(table["standard_error_total"] ** 2, total)
    # affine: both coordinates are equally good and not correlated
    np.testing.assert_allclose(table["covariance_en"], 0.0, atol=1e-12)
    np.testing.assert_allclose(
        table["w"], np.hypot(*d.T) / table["standard_error_easting"], rtol=1e-6
    )
    np.testing.assert_allclose(table["p_value"], np.exp(-(table["w"] ** 2) / 2.0))
    roles = good_result.block.control_points.set_index("point_id")["role"]
    assert (roles[table["point_id"]] == "control").all()


@pytest.mark.slow
def test_a_wrong_control_point_is_named(demo_block):
    name = densify(demo_block).control_left_out["point_id"][4]
    control = demo_block.control_points.copy()
    control.loc[control["point_id"] == name, "northing"] += 1.0
    result = densify(replace(demo_block, control_points=control))
    table = result.control_left_out
    assert table.loc[table["p_value"].idxmin(), "point_id"] == name
    found = control_that_contradicts(result.examination)
    assert found.names[0] == name
    assert found.probability < 0.001
    assert found.remedy == "check_worst_control"
    assert control_that_contradicts(densify(demo_block).examination) is None


@pytest.mark.slow
def test_control_that_is_worse_than_given_is_called_out():
    block = simulate_block("neukirchen", seed=2)
    control = block.control_points.copy()
    noise = np.random.default_rng(2).standard_normal((len(control), 2))
    control[PLAN] += 0.06 * noise * (control[["role"]] != "check").to_numpy()
    result = densify(replace(block, control_points=control))
    assert LEFT_OUT in [test.name for test in result.claim.rejected]
    assert result.left_out_control.normalized_square > 1.5
    # no bound of the points' error: control is not all of it
    others = [t for t in result.claim.rejected if t.is_length and t.name != LEFT_OUT]
    ratios = [t.observed / t.predicted for t in others]
    assert result.claim.enlargement == max([1.0, *ratios])


def test_summary_says_how_left_out_points_fit(good_result):
    section = sections(good_result.assessment)["known_points"]
    assert section.rows[1][0] == "control points, each left out"
    square = good_result.left_out_control.normalized_square
    assert f"Observed / expected variance {square:.2f};" in section.remarks[0]
    table = good_result.control_left_out
    worst = table.loc[table["p_value"].idxmin(), "point_id"]
    assert f"worst at {worst}," in section.remarks[0]


@pytest.mark.slow
def test_without_control_that_took_part_nothing_is_left_out(
    demo_block, given_approximations_result
):
    without_errors = demo_block.control_points.drop(columns="standard_error_m")
    for result in (
        given_approximations_result,
        densify(demo_block, Settings(method="simultaneous")),
        densify(replace(demo_block, control_points=without_errors)),
    ):
        assert result.control_left_out.empty
        assert "is_suspect" in result.control_left_out
        assert "each left out" not in result.summary()


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_rigorous_weights_stay_those_of_the_whole_block(demo_block, kind):
    block = of_kinds(demo_block, kind, kind)
    result = densify(block, Settings(weighting="rigorous"))
    high, low = (
        result.solution.model_points[name] for name in ("high_flight", "low_flight")
    )
    of_high = model_of_high_flight(
        block, high, result.solution.high.transformation
    ).covariances_of_values
    of_low = result.solution.propagation.covariances_of_values
    control = block.control_points[block.control_points["role"] != "check"]
    checks = set(block.control_points["point_id"]) - set(control["point_id"])

    def averaged(points, ground, covariances):
        values = transform_models(points, ground, kind).transform(points)
        return average_coverages(
            values.drop(columns="m_t"), weighting="rigorous", covariances=covariances
        ).points

    def predict(name):
        others = control[control["point_id"] != name]
        ground = averaged(high, others, of_high)
        ground = ground[~ground["point_id"].isin({*checks, name})][["point_id", *PLAN]]
        final = averaged(low, ground, of_low).set_index("point_id")
        return final.loc[name, PLAN].to_numpy(dtype=float)

    assert_same(result, predict, 1e-7)


def test_operators_of_flights_are_formed_once(demo_block, monkeypatch):
    """They are most of the time and memory of thousands of control points in space."""
    formed, form = [], leave_one_out._Prediction.of_flights.func

    def counted(parts):
        formed.append(parts)
        return form(parts)

    once = cached_property(counted)
    once.__set_name__(leave_one_out._Prediction, "of_flights")
    monkeypatch.setattr(leave_one_out._Prediction, "of_flights", once)
    assert densify(demo_block).examination.left_out_control is not None
    assert len(formed) == 1


def test_rows_of_a_formed_product_are_cut_and_not_multiplied(monkeypatch):
    rng = np.random.default_rng(1)
    dense = rng.standard_normal((40, 30)) * (rng.random((40, 30)) < 0.05)
    chain = PointOperator((sparse.csr_array(dense),), Axes.PLANE)
    places = np.arange(5, 15)
    ((_, any_rows),) = covariances._rows_of({"a": chain}, places[[1, 0, *range(2, 10)]])
    monkeypatch.setattr(rows_of_chains, "times", None)
    ((_, rows),) = covariances._rows_of({"a": chain}, places)
    found, expected = (sparse.csr_array(r.matrix).toarray() for r in (rows, any_rows))
    np.testing.assert_array_equal(found, dense[10:30])
    np.testing.assert_array_equal(found[4:], expected[4:])
