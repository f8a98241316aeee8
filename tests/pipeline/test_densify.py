"""The driver: what goes in, what comes out, and what never enters."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import GeometryError

MODEL = ["coverage", "model_id"]
POINT_COLUMNS = [
    "point_id",
    "easting",
    "northing",
    "standard_error_easting",
    "standard_error_northing",
    "covariance_en",
    "standard_error_total",
    "standard_error_paper",
    "standard_error_internal",
    "n_models",
    "n_coverages",
    "spread_total",
    "role",
]
MODEL_COLUMNS = [
    "flight",
    "coverage",
    "model_id",
    "transformation",
    "n_points",
    "redundancy",
    "m_0",
    "s_0",
    "is_usable",
    "reason",
]


@pytest.fixture(scope="module")
def block():
    return es.simulate_block("demo", seed=4)


@pytest.fixture(scope="module")
def result(block):
    return es.densify(block)


def coordinates(result):
    return result.points.set_index("point_id")[["easting", "northing"]]


def with_flight(block, **changes):
    return replace(block, low_flight=replace(block.low_flight, **changes))


def test_tables_have_the_columns_that_are_promised(result):
    assert list(result.points.columns)[: len(POINT_COLUMNS)] == POINT_COLUMNS
    assert list(result.models.columns)[: len(MODEL_COLUMNS)] == MODEL_COLUMNS
    assert list(result.failures.columns) == [
        *("flight", "coverage", "model_id", "stage", "reason", "remedy")
    ]
    assert set(result.points["role"]) == {"new", "control", "check"}


def test_every_measured_point_gets_coordinates(block, result):
    measured = set(block.low_flight.model_points["point_id"])
    assert set(result.points["point_id"]) == measured
    assert result.points["easting"].notna().all()


def test_paper_figure_is_the_budget_of_the_values_averaged(block):
    result = es.densify(block, es.Settings(coverage_mean="most_central"))
    values = result.single_values
    m_0 = result.models.set_index(["flight", "coverage", "model_id"])["m_0"]
    keys = [("low_flight", *key) for key in values[["coverage", "model_id"]].to_numpy()]
    leverage = (values["m_t"] / m_0.loc[keys].to_numpy()) ** 2
    budget = es.error_budget(5.0, 8000, m_0.loc[keys].to_numpy() * np.sqrt(leverage))
    np.testing.assert_allclose(values["standard_error_paper"], budget)
    eccentricity = values[["position_u", "position_v"]].abs().max(axis=1)
    chosen = eccentricity.groupby([values["point_id"], values["coverage"]]).idxmin()
    of_point = values.loc[chosen].groupby("point_id")
    mean = of_point[["easting", "northing"]].mean()
    pd.testing.assert_frame_equal(
        coordinates(result).sort_index(), mean, check_names=False, atol=1e-6
    )
    root = np.sqrt(of_point["standard_error_paper"].apply(lambda m: (m**2).sum()))
    expected = root / of_point.size()
    found = result.points.set_index("point_id")["standard_error_paper"].sort_index()
    np.testing.assert_allclose(found, expected)


def test_given_coordinates_of_check_points_never_enter(block, result):
    control = block.control_points.copy()
    is_check = control["role"] == "check"
    assert is_check.any()
    control.loc[is_check, "easting"] += 5.0
    moved = es.densify(replace(block, control_points=control))
    pd.testing.assert_frame_equal(coordinates(moved), coordinates(result))
    at_check = moved.points["role"] == "check"
    change = moved.points["difference_easting"] - result.points["difference_easting"]
    np.testing.assert_allclose(change[at_check], -5.0)


def test_measurements_of_check_points_never_enter(block, result):
    check = block.control_points.query("role == 'check'")["point_id"]
    points = block.low_flight.model_points.copy()
    is_check = points["point_id"].isin(check)
    points.loc[is_check, "x"] += 1.0
    moved = es.densify(with_flight(block, model_points=points))
    others = ~result.points["point_id"].isin(check).to_numpy()
    pd.testing.assert_frame_equal(
        coordinates(moved)[others], coordinates(result)[others]
    )


def test_one_bad_model_does_not_stop_the_block(block, result):
    points = block.low_flight.model_points
    first = points[["coverage", "model_id"]].iloc[0]
    is_first = (points["coverage"] == first["coverage"]) & (
        points["model_id"] == first["model_id"]
    )
    rest = points[~is_first | (is_first.cumsum() <= 2)]
    found = es.densify(with_flight(block, model_points=rest))
    (failure,) = found.failures.to_dict("records")
    assert failure["flight"] == "low_flight"
    assert failure["model_id"] == first["model_id"]
    assert failure["stage"] == "stage3_model_transformation"
    assert failure["reason"] == "2 common points, but affine needs 3"
    assert failure["remedy"].startswith("Transform with helmert")
    assert found.figures.n_failed == 1
    assert np.isfinite(found.points["standard_error_total"]).all()
    assert len(found.points) >= len(result.points) - 5


def test_no_usable_model_is_an_error(block):
    points = block.low_flight.model_points
    in_a_line = with_flight(block, model_points=points.assign(y=2.0 * points["x"]))
    with pytest.raises(
        GeometryError, match="no model of the low flight could be transformed: its p"
    ) as refused:
        es.densify(in_a_line)
    # whoever follows causes would never come to an end
    assert refused.value.__cause__ is None


def test_no_model_with_enough_points_is_no_block(block):
    points = block.low_flight.model_points.groupby(["coverage", "model_id"]).head(2)
    with pytest.raises(es.EinschaltError, match="2 of its points have coordinates"):
        with_flight(block, model_points=points)


def test_without_redundancy_nothing_is_claimed(block):
    points = block.low_flight.model_points.groupby(["coverage", "model_id"])
    corners = points.sample(3, random_state=2)
    found = es.densify(with_flight(block, model_points=corners))
    assert found.models.query("flight == 'low_flight'")["m_0"].isna().all()
    assert found.points["standard_error_internal"].isna().all()
    assert np.isnan(found.figures.mean_internal)


def test_given_approximations_instead_of_a_high_flight(block):
    # the errors that they share are not known: so their values count alike
    result = es.densify(block, es.Settings(weighting="plain"))
    approximate = result.approximations[["point_id", "easting", "northing"]]
    given = es.Block(
        control_points=block.control_points,
        approximate_points=approximate,
        low_flight=block.low_flight,
        approximate_m_0_m=0.10,
        may_be_unmeasured=True,
        crs=block.crs,
    )
    found = es.densify(given)
    np.testing.assert_allclose(coordinates(found), coordinates(result), atol=1e-6)
    assert "standard_error_total" not in found.points
    assert set(found.models["flight"]) == {"low_flight"}


def test_order_of_rows_changes_nothing(block, result):
    rng = np.random.default_rng(0)
    points = block.low_flight.model_points
    shuffled = points.iloc[rng.permutation(len(points))]
    found = es.densify(with_flight(block, model_points=shuffled))
    names = ["easting", "northing", "standard_error_total", "standard_error_paper"]
    one = found.points.set_index("point_id")[names].sort_index()
    two = result.points.set_index("point_id")[names].sort_index()
    np.testing.assert_allclose(one, two, atol=1e-7)


def test_the_same_input_gives_the_same_digits(block, result):
    again = es.densify(block)
    pd.testing.assert_frame_equal(again.points, result.points, check_exact=True)


def test_results_are_frozen_and_print_their_summary(result):
    assert str(result) == result.summary()
    with pytest.raises(FrozenInstanceError):
        result.points = None


def test_progress_names_the_stages(block):
    said = []
    es.densify(block, progress=lambda title, fraction: said.append((title, fraction)))
    titles, fractions = zip(*said, strict=True)
    assert titles[0] == "relative orientation"
    assert titles[-1] == "done"
    assert list(fractions) == sorted(fractions)
    assert fractions[-1] == 1.0


@pytest.mark.parametrize("coverages", [("1", "1"), ("1", "2")])
def test_two_models_alone_have_the_covariances_of_their_points(block, coverages):
    """Most points are in both: rows of few points do not tell models apart."""
    points = block.low_flight.model_points
    held = {key: set(part.point_id) for key, part in points.groupby(MODEL)}
    pairs = [
        (len(held[one] & held[two]), one, two)
        for one in held
        for two in held
        if one < two and (one[0], two[0]) == coverages
    ]
    _, *chosen = max(pairs)
    is_kept = points.set_index(MODEL).index.isin(chosen)
    result = es.densify(with_flight(block, model_points=points[is_kept]))
    expected = result.errors.covariance
    for name, variance in zip(result.errors.point_ids, expected, strict=True):
        alone = result.covariance_between([(name, name)])[0]
        np.testing.assert_allclose(alone, variance, rtol=1e-6, atol=1e-10)
