import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import SettingsError, TableError
from einschalt.stages.stage5_double_coverage import with_positions

PLAN = ["easting", "northing"]


@pytest.fixture
def values():
    """Two points in two coverages, one of them in two models of the first."""
    rows = [
        # coverage, model, point, easting, northing, M, u, v
        ("1", "7/8", "0012", 100.00, 200.00, 0.03, 0.40, 0.00),
        ("1", "8/9", "0012", 100.06, 200.00, 0.06, -0.10, 0.20),
        ("2", "7/8", "0012", 100.09, 200.00, 0.04, 0.00, 0.45),
        ("1", "7/8", "a", 500.00, 700.00, 0.05, 0.10, 0.10),
        ("2", "7/8", "a", 500.00, 700.06, 0.05, 0.10, 0.10),
        ("2", "7/8", "lone", 300.00, 300.00, 0.08, 0.50, 0.50),
    ]
    names = ["coverage", "model_id", "point_id", *PLAN]
    names += ["standard_error_paper", "position_u", "position_v"]
    return pd.DataFrame(rows, columns=names)


def by_point(result):
    return result.points.set_index("point_id")


# means


def test_every_value_counts_once(values):
    result = es.average_coverages(values)
    points = by_point(result)
    np.testing.assert_allclose(
        points[PLAN], [[100.05, 200.0], [500.0, 700.03], [300.0, 300.0]], rtol=1e-14
    )
    assert points["n_models"].tolist() == [3, 2, 1]
    assert points["n_coverages"].tolist() == [2, 2, 1]
    wanted = [np.sqrt(0.03**2 + 0.06**2 + 0.04**2) / 3, 0.05 / np.sqrt(2), 0.08]
    np.testing.assert_allclose(points["standard_error_paper"], wanted)
    # √(Σ(x − mean)² / (n − 1)); a single value has no spread
    spread = [np.sqrt((0.05**2 + 0.01**2 + 0.04**2) / 2), 0.06 / np.sqrt(2), np.nan]
    np.testing.assert_allclose(points["spread_total"], spread)
    assert len(result.used) == 6


def test_most_central_value_of_each_coverage(values):
    result = es.average_coverages(values, coverage_mean="most_central")
    points = by_point(result)
    # of the first coverage model 8/9, where max(|u|, |v|) is 0.2 against 0.4
    np.testing.assert_allclose(points.loc["0012", PLAN].astype(float), [100.075, 200.0])
    assert points["n_models"].tolist() == [2, 2, 1]
    kept = result.used[result.used["point_id"] == "0012"]
    assert kept["model_id"].tolist() == ["8/9", "7/8"]


def test_weights_are_inverse_squares_of_the_errors(values):
    points = by_point(es.average_coverages(values, weighting="weighted"))
    weights = np.array([0.03, 0.06, 0.04]) ** -2.0
    wanted = 100 + np.average([0.0, 0.06, 0.09], weights=weights)
    assert points.loc["0012", "easting"] == pytest.approx(wanted, abs=1e-12)
    assert points.loc["0012", "standard_error_paper"] == pytest.approx(
        weights.sum() ** -0.5
    )


def test_internal_error_compares_coverages_and_not_models(values):
    result = es.average_coverages(values)
    # means of the coverages: 100.03 against 100.09, and 6 cm in the northing
    single = np.sqrt((0.06**2 + 0.06**2) / (2 * 2))
    assert result.internal_single == pytest.approx(single)
    points = by_point(result)
    root = np.sqrt(points["n_coverages"])
    np.testing.assert_allclose(points["standard_error_internal"], single / root)


def test_without_a_second_coverage_the_internal_error_is_unknown(values):
    result = es.average_coverages(values[values["coverage"] == "1"])
    assert np.isnan(result.internal_single)
    assert result.points["standard_error_internal"].isna().all()


def test_coverage_and_errors_may_be_left_out(values):
    bare = values[["point_id", *PLAN]]
    points = by_point(es.average_coverages(bare))
    assert points["n_coverages"].eq(1).all()
    assert points["standard_error_paper"].isna().all()
    full = by_point(es.average_coverages(values))
    pd.testing.assert_frame_equal(points[PLAN], full[PLAN])


def test_heights_are_averaged_too(values):
    heights = values.assign(height=[10.0, 10.3, 10.6, 20.0, 21.0, 5.0])
    points = by_point(es.average_coverages(heights))
    np.testing.assert_allclose(points["height"], [10.3, 20.5, 5.0])
    plain = by_point(es.average_coverages(values))
    np.testing.assert_array_equal(points["spread_total"], plain["spread_total"])


def test_order_of_rows_is_irrelevant(values):
    one = by_point(es.average_coverages(values))
    shuffled = values.sample(frac=1.0, random_state=3)
    other = by_point(es.average_coverages(shuffled)).loc[one.index]
    pd.testing.assert_frame_equal(other, one, rtol=1e-12)


def test_values_without_coordinates_are_passed_over(values):
    values.loc[1, "easting"] = np.nan
    result = es.average_coverages(values)
    assert by_point(result).loc["0012", "n_models"] == 2
    assert len(result.used) == 5


def test_columns_that_the_mean_does_not_need_stay(values):
    result = es.average_coverages(values.assign(m_t=0.01))
    assert result.used["m_t"].eq(0.01).all()


def test_names_stay_text(values):
    numbered = values.assign(point_id=[12, 12, 12, 13, 13, 14], coverage=[1] * 6)
    numbered["model_id"] = ["a", "b", "c", "a", "b", "a"]
    points = es.average_coverages(numbered).points
    assert points["point_id"].tolist() == ["12", "13", "14"]


def test_a_thousand_points_as_one_by_one():
    rng = np.random.default_rng(11)
    rows = pd.DataFrame(
        {
            "point_id": rng.integers(0, 300, 1000).astype(str),
            "coverage": rng.integers(1, 4, 1000).astype(str),
            "model_id": np.arange(1000).astype(str),
            "easting": 4.5e6 + rng.normal(size=1000),
            "northing": 5.3e6 + rng.normal(size=1000),
            "standard_error_paper": rng.uniform(0.1, 0.5, 1000),
        }
    )
    points = by_point(es.average_coverages(rows, weighting="weighted"))
    for point_id, part in rows.groupby("point_id"):
        found = points.loc[point_id]
        weights = part["standard_error_paper"] ** -2.0
        for name in PLAN:
            mean = np.average(part[name], weights=weights)
            assert found[name] == pytest.approx(mean, abs=3e-9)
        assert found["n_models"] == len(part)
        assert found["n_coverages"] == part["coverage"].nunique()


# positions


def test_positions_go_by_model_and_coverage():
    points = pd.DataFrame(
        {
            "coverage": ["1", "2", "1", "2", "1"],
            "model_id": "7/8",
            "point_id": ["a", "a", "b", "b", "c"],
            "x": [0.0, 0.0, 10.0, 4.0, 5.0],
            "y": [0.0, 3.0, 10.0, 3.0, 2.0],
        },
        index=[5, 4, 3, 2, 1],
    )
    found = with_positions(points[["coverage", "model_id", "point_id"]], points)
    assert found.index.tolist() == [5, 4, 3, 2, 1]
    np.testing.assert_allclose(found["position_u"], [-0.5, -0.5, 0.5, 0.5, 0.0])
    np.testing.assert_allclose(found["position_v"], [-0.5, 0.0, 0.5, 0.0, -0.3])


# texts


def test_summary(values):
    result = es.average_coverages(values)
    first, second = str(result).splitlines()
    assert first == "3 points from 6 values, 2 of them in several coverages"
    assert second.startswith("one coverage, from the differences of the coverages")
    assert "4.2 cm" in second


# what is refused


def test_unknown_options(values):
    with pytest.raises(SettingsError, match="coverage_mean = 'median' is unknown; exp"):
        es.average_coverages(values, coverage_mean="median")
    with pytest.raises(SettingsError, match="weighting = 'best' is unknown; expected"):
        es.average_coverages(values, weighting="best")


@pytest.mark.parametrize(
    ("missing", "options"),
    [
        ("easting", {}),
        ("point_id", {}),
        ("position_v", {"coverage_mean": "most_central"}),
        ("standard_error_paper", {"weighting": "weighted"}),
    ],
)
def test_missing_columns(values, missing, options):
    with pytest.raises(TableError, match=f"values: column '{missing}' is missing"):
        es.average_coverages(values.drop(columns=missing), **options)


def test_no_value_at_all(values):
    with pytest.raises(TableError, match="values: no row has coordinates; expected ea"):
        es.average_coverages(values.assign(easting=np.nan))
    with pytest.raises(TableError, match="values: the table has no rows"):
        es.average_coverages(values.iloc[:0])


@pytest.mark.parametrize("bad", [0.0, -0.1, np.nan, np.inf])
def test_weighted_mean_needs_positive_errors(values, bad):
    values.loc[2, "standard_error_paper"] = bad
    with pytest.raises(TableError, match=r"point 0012.*: standard_error_paper"):
        es.average_coverages(values, weighting="weighted")


def test_value_that_is_no_number(values):
    wrong = values.astype({"northing": object})
    wrong.loc[3, "northing"] = "n/a"
    with pytest.raises(
        TableError, match=r"values, row 3, point a, model 7/8: northing 'n/a'"
    ):
        es.average_coverages(wrong)


def test_value_that_stands_twice(values):
    twice = pd.concat([values, values.iloc[[4]]], ignore_index=True)
    with pytest.raises(TableError, match=r"row 6, point a, model 7/8: the row repeats"):
        es.average_coverages(twice)


# rigorous weights


def covariances_by(matrix, d):
    """Of pairs of rows, from the whole matrix."""
    blocks = matrix.reshape(len(matrix) // d, d, len(matrix) // d, d)
    return lambda pairs: blocks[pairs[:, 0], :, pairs[:, 1]]


def random_matrix(n):
    root = np.random.default_rng(11).normal(0.0, 0.03, (n, 2 * n))
    return root @ root.T


def best_mean(values, matrix, rows, names):
    """Least squares with all correlations of some rows."""
    d = len(names)
    places = (d * np.array(rows)[:, None] + np.arange(d)).ravel()
    whiten = np.linalg.inv(np.linalg.cholesky(matrix[np.ix_(places, places)]))
    design = np.tile(np.eye(d), (len(rows), 1))
    observed = values.loc[rows, names].to_numpy().ravel()
    return np.linalg.lstsq(whiten @ design, whiten @ observed, rcond=None)[0]


@pytest.mark.parametrize("names", [PLAN, [*PLAN, "height"]])
def test_rigorous_means_are_those_of_least_squares(values, names):
    values = values.assign(height=[10.0, 10.3, 10.6, 20.0, 21.0, 5.0])
    values = values[[*values.columns[:3], *names, *values.columns[5:8]]]
    matrix = random_matrix(6 * len(names))
    result = es.average_coverages(
        values,
        weighting="rigorous",
        covariances=covariances_by(matrix, len(names)),
    )
    points = by_point(result)
    for name, rows in (("0012", [0, 1, 2]), ("a", [3, 4]), ("lone", [5])):
        expected = best_mean(values, matrix, rows, names)
        found = points.loc[name, names].to_numpy(dtype=float)
        np.testing.assert_allclose(found, expected, atol=1e-7)
    assert points["n_models"].tolist() == [3, 2, 1]


def test_of_rigorous_weights_only_the_values_that_are_used_have_a_share(values):
    matrix = random_matrix(12)
    values.loc[0, "easting"] = np.nan
    result = es.average_coverages(
        values,
        coverage_mean="most_central",
        weighting="rigorous",
        covariances=covariances_by(matrix, 2),
    )
    expected = best_mean(values, matrix, [1, 2], PLAN)
    found = by_point(result).loc["0012", PLAN].to_numpy(dtype=float)
    np.testing.assert_allclose(found, expected, atol=1e-7)
    total = result.weights[np.isin(result.row_numbers, [1, 2])].sum(axis=0)
    np.testing.assert_allclose(total, np.eye(2), atol=1e-12)


def test_a_coverage_has_rigorous_weights_of_its_own(values):
    matrix = random_matrix(12)
    result = es.average_coverages(
        values, weighting="rigorous", covariances=covariances_by(matrix, 2)
    )
    rows = [0, 1]
    place = [int(np.flatnonzero(result.row_numbers == row)[0]) for row in rows]
    given = values.loc[rows, PLAN].to_numpy()
    found = np.einsum("nab,nb->a", result.coverage_weights[place], given)
    expected = best_mean(values, matrix, rows, PLAN)
    np.testing.assert_allclose(found, expected, atol=1e-7)


def test_independent_values_that_are_alike_in_both_coordinates_have_their_errors(
    values,
):
    error = values["standard_error_paper"].to_numpy()
    matrix = np.kron(np.diag(error**2 / 2.0), np.eye(2))
    rigorous = by_point(
        es.average_coverages(
            values, weighting="rigorous", covariances=covariances_by(matrix, 2)
        )
    )
    weighted = by_point(es.average_coverages(values, weighting="weighted"))
    pd.testing.assert_frame_equal(rigorous, weighted, rtol=1e-8)


def test_rigorous_weights_need_covariances(values):
    with pytest.raises(SettingsError, match="without covariances of the values"):
        es.average_coverages(values, weighting="rigorous")
