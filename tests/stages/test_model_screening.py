"""Gross errors in the models of a flight: named, taken out, or given less weight."""

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import SettingsError
from einschalt.stages.model_screening import (
    OUTLIERS,
    screen_models,
    suspect_rows,
    without_gross_errors,
)

NOISE = 0.02
GROSS = [("1/2", "0004"), ("3/4", "0022")]
KINDS = ["affine", "helmert", "rigid", "helmert_3d"]


@pytest.fixture(scope="module")
def ground():
    """Thirty points, 4 to 5 thousand kilometres from the origin."""
    rng = np.random.default_rng(0)
    origin = np.array([4.5e6, 5.3e6, 400.0])
    enh = origin + rng.uniform(0, 1000, (30, 3))
    table = pd.DataFrame(enh, columns=["easting", "northing", "height"])
    return table.assign(point_id=[f"{place:04d}" for place in range(30)])


@pytest.fixture(scope="module")
def flight(ground):
    """Three models of 18 points; in two of them one point is 1 m wrong."""
    rng = np.random.default_rng(1)
    parts = []
    for k in range(1, 4):
        points = ground.iloc[6 * (k - 1) : 6 * (k - 1) + 18]
        xyz = points[["easting", "northing", "height"]].to_numpy() - [4.5e6, 5.3e6, 0]
        xyz = xyz + rng.normal(0, NOISE, xyz.shape)
        part = pd.DataFrame(xyz, columns=["x", "y", "z"])
        model = f"{k}/{k + 1}"
        parts.append(part.assign(model_id=model, point_id=points["point_id"].array))
    table = pd.concat(parts, ignore_index=True)
    for model, point in GROSS:
        is_it = (table["model_id"] == model) & (table["point_id"] == point)
        table.loc[is_it, "x"] += 1.0
    return table


@pytest.fixture(scope="module", params=KINDS)
def transformation(request, flight, ground):
    return es.transform_models(flight, ground, kind=request.param)


def suspects_of(fit):
    rows = fit.residuals[fit.residuals["is_suspect"]]
    return list(zip(rows["model_id"], rows["point_id"], strict=True))


def test_residuals_have_tests_in_the_order_of_the_points(transformation, flight):
    residuals = transformation.residuals
    assert residuals["point_id"].tolist() == flight["point_id"].tolist()
    assert residuals["is_suspect"].dtype == bool
    assert residuals["w"].notna().all()
    assert residuals["p_value"].between(0, 1).all()
    assert suspects_of(transformation) == GROSS


@pytest.mark.parametrize("outliers", OUTLIERS)
def test_every_way_names_the_gross_errors(transformation, flight, outliers):
    screened = screen_models(transformation, outliers)
    assert suspects_of(screened) == GROSS
    residuals = screened.residuals
    assert residuals["point_id"].tolist() == flight["point_id"].tolist()
    assert residuals["model_id"].tolist() == flight["model_id"].tolist()


def test_keeping_changes_no_more_than_who_is_named(transformation):
    kept = screen_models(transformation, "keep", 0.05)
    columns = ["residual_easting", "leverage", "w", "p_value"]
    pd.testing.assert_frame_equal(
        kept.residuals[columns], transformation.residuals[columns]
    )
    assert kept.residuals["is_suspect"].sum() >= len(GROSS)


def test_snooping_fits_as_if_the_points_had_not_been_measured(
    transformation, flight, ground
):
    screened = screen_models(transformation, "snoop")
    is_gross = pd.MultiIndex.from_frame(flight[["model_id", "point_id"]]).isin(GROSS)
    without = es.transform_models(flight[~is_gross], ground, kind=transformation.kind)
    pd.testing.assert_frame_equal(screened.parameters, without.parameters)
    pd.testing.assert_frame_equal(screened.models, without.models)
    assert screened.models["n_points"].tolist() == [17, 18, 17]
    out = screened.residuals[is_gross]
    np.testing.assert_allclose(np.abs(out["residual_easting"]), 1.0, atol=0.1)
    assert (out["leverage"] == 0.0).all()
    assert (out["redundancy_number"] == 1.0).all()
    assert (out["p_value"] < 1e-9).all()
    # what propagates errors sees the points that were fitted
    assert len(screened.observed.weights) == len(flight) - 2


@pytest.mark.parametrize("outliers", ["huber", "tukey"])
def test_robust_norms_leave_gross_errors_little_weight(transformation, outliers):
    screened = screen_models(transformation, outliers)
    is_gross = screened.residuals["is_suspect"].to_numpy()
    weights = screened.observed.weights
    assert weights[is_gross].max() < 0.15
    assert np.median(weights[~is_gross]) > 0.85
    assert screened.models["m_0"].max() < 0.1
    assert transformation.models["m_0"].max() > 0.15


def test_values_of_suspects_go_where_others_remain(transformation, flight):
    screened = screen_models(transformation, "snoop")
    values = screened.values(flight)
    found = without_gross_errors(values, suspect_rows(values, screened))
    is_gone = found["easting"].isna()
    gone = found.loc[is_gone, ["model_id", "point_id"]]
    # point 0004 lies in one model only: nothing is better than its value
    assert gone.to_numpy().tolist() == [["3/4", "0022"]] or gone.empty
    in_models = flight.groupby("point_id")["model_id"].nunique()
    assert len(gone) == sum(in_models[point] > 1 for _, point in GROSS)
    pd.testing.assert_frame_equal(found[~is_gone], values[~is_gone])


def test_models_that_fail_stay_failures(flight, ground):
    few = flight[~((flight["model_id"] == "2/3") & (flight.index % 9 != 0))]
    fit = es.transform_models(few, ground)
    for outliers in OUTLIERS:
        screened = screen_models(fit, outliers)
        assert screened.failures["model_id"].tolist() == ["2/3"]
        assert "2/3" not in set(screened.residuals["model_id"])
        assert suspects_of(screened) == GROSS


def test_options_are_checked(transformation):
    with pytest.raises(SettingsError, match=r"outliers = 'ransac' is unknown"):
        screen_models(transformation, "ransac")
    with pytest.raises(SettingsError, match=r"significance = 1\.5; expected a number"):
        screen_models(transformation, "snoop", 1.5)


@pytest.mark.parametrize("kind", ["affine", "helmert", "rigid"])
def test_points_of_unequal_precision_are_tested_by_their_own(flight, ground, kind):
    precision = np.random.default_rng(4).uniform(0.2, 3.0, len(flight))
    fit = es.transform_models(flight, ground, kind=kind)
    tested = screen_models(fit, "keep", precision=precision).residuals
    # the fit itself keeps its weights; its tests are those of a weighted fit
    for name in ("residual_easting", "leverage"):
        np.testing.assert_array_equal(tested[name], fit.residuals[name])
    weighted = es.transform_models(flight.assign(weight=precision), ground, kind=kind)
    for name in ("w", "p_value"):
        np.testing.assert_allclose(tested[name], weighted.residuals[name], rtol=1e-9)


@pytest.mark.slow
def test_points_that_are_said_to_be_worse_are_no_suspects(ground):
    rng = np.random.default_rng(5)
    shares = []
    for _ in range(40):
        size = np.where(rng.random(len(ground)) < 0.3, 3.0, 1.0)
        xy = ground[["easting", "northing"]].to_numpy() - [4.5e6, 5.3e6]
        xy = xy + rng.normal(0, NOISE, xy.shape) * size[:, None]
        table = pd.DataFrame(xy, columns=["x", "y"])
        model = table.assign(model_id="1/2", point_id=ground["point_id"].array)
        fit = es.transform_models(model, ground)
        equal = screen_models(fit).residuals["p_value"] < 0.05
        known = screen_models(fit, precision=size**-2.0).residuals["p_value"] < 0.05
        shares.append((equal.mean(), known.mean()))
    equal, known = np.mean(shares, axis=0)
    assert known == pytest.approx(0.05, abs=0.02)
    assert equal > 0.08


@pytest.mark.parametrize("outliers", OUTLIERS)
def test_known_gross_errors_are_as_if_they_had_not_been_measured(
    transformation, flight, ground, outliers
):
    names = pd.MultiIndex.from_frame(flight[["model_id", "point_id"]])
    is_gross = names.isin([*GROSS, ("2/3", "0010")])
    screened = screen_models(transformation, outliers, is_gross=is_gross)
    kept = es.transform_models(flight[~is_gross], ground, kind=transformation.kind)
    expected = screen_models(kept, outliers)
    pd.testing.assert_frame_equal(screened.parameters, expected.parameters)
    pd.testing.assert_frame_equal(screened.models, expected.models)
    residuals = screened.residuals
    assert residuals["point_id"].tolist() == flight["point_id"].tolist()
    assert residuals["model_id"].tolist() == flight["model_id"].tolist()
    assert residuals.loc[is_gross, "is_suspect"].all()
    assert (residuals.loc[is_gross, "leverage"] == 0.0).all()
    pd.testing.assert_frame_equal(
        residuals[~is_gross].reset_index(drop=True), expected.residuals
    )
    # a prediction test of a good point that was taken out is no alarm
    others = residuals[is_gross].set_index(["model_id", "point_id"])["p_value"]
    assert (others[GROSS] < 1e-9).all()
    assert others[("2/3", "0010")] > 0.001


@pytest.mark.parametrize("precision", [None, "given"])
def test_known_gross_errors_and_unequal_precision(flight, ground, precision):
    if precision is not None:
        precision = np.random.default_rng(4).uniform(0.2, 3.0, len(flight))
    fit = es.transform_models(flight, ground)
    names = pd.MultiIndex.from_frame(flight[["model_id", "point_id"]])
    is_gross = names.isin(GROSS)
    known = screen_models(fit, "keep", precision=precision, is_gross=is_gross)
    found = screen_models(fit, "snoop", precision=precision)
    pd.testing.assert_frame_equal(known.residuals, found.residuals)


def test_too_few_points_are_not_made_fewer(flight, ground):
    names = flight[["model_id", "point_id"]]
    is_first = (names["model_id"] == "1/2").to_numpy()
    fit = es.transform_models(flight, ground, kind="affine")
    # 18 points, of which two would be left
    is_gross = is_first & (np.cumsum(is_first) <= 16)
    screened = screen_models(fit, "keep", is_gross=is_gross)
    assert screened.models["n_points"].tolist() == [18, 18, 18]
    # and with three the model is still determined
    is_gross = is_first & (np.cumsum(is_first) <= 15)
    screened = screen_models(fit, "keep", is_gross=is_gross)
    assert screened.models["n_points"].tolist() == [3, 18, 18]
    assert screened.models["is_usable"].all()
    assert len(screened.residuals) == len(flight)


def test_values_of_gross_errors_go_where_others_remain():
    values = pd.DataFrame(
        {
            "point_id": ["a", "a", "b", "c", "c"],
            "easting": [1.0, 2.0, 3.0, np.nan, 5.0],
            "northing": [1.0, 2.0, 3.0, np.nan, 5.0],
        }
    )
    is_gross = np.array([True, False, True, False, True])
    left = without_gross_errors(values, is_gross)
    np.testing.assert_array_equal(left["easting"], [np.nan, 2.0, 3.0, np.nan, 5.0])
    np.testing.assert_array_equal(left["northing"], left["easting"])
    assert without_gross_errors(values, ~np.ones(5, dtype=bool)) is values
