"""Models with suspects, tested again with what the errors of their points share."""

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.stages import correlated_residuals
from einschalt.stages.correlated_residuals import MOST_POINTS
from einschalt.stages.model_screening import OUTLIERS, screen_models

NOISE, SHIFT = 0.02, 0.6
GROSS = ("2/3", "0016")


@pytest.fixture(scope="module")
def ground():
    rng = np.random.default_rng(0)
    table = pd.DataFrame(rng.uniform(0, 1000, (30, 2)), columns=["easting", "northing"])
    return table.assign(point_id=[f"{place:04d}" for place in range(30)])


@pytest.fixture(scope="module")
def flight(ground):
    """Three models of 16 points; in the last two some points are off together."""
    rng = np.random.default_rng(1)
    parts = []
    for k in range(3):
        points = ground.iloc[7 * k : 7 * k + 16]
        xy = points[["easting", "northing"]].to_numpy() + rng.normal(0, NOISE, (16, 2))
        xy[is_weak(points["point_id"])] += SHIFT
        part = pd.DataFrame(xy, columns=["x", "y"])
        parts.append(
            part.assign(model_id=f"{k}/{k + 1}", point_id=points["point_id"].array)
        )
    return pd.concat(parts, ignore_index=True)


def is_weak(point_ids):
    return np.isin(point_ids, ["0021", "0022"])


@pytest.fixture(scope="module")
def covariances(flight):
    """The two weak points share an error, the others have none but their own."""
    weak = is_weak(flight["point_id"])

    def of_pairs(pairs):
        first, second = pairs.T
        own = NOISE**2 * (first == second)
        return (own + SHIFT**2 * weak[first] * weak[second])[:, None, None] * np.eye(2)

    return of_pairs


def with_gross_error(flight):
    is_it = (flight["model_id"] == GROSS[0]) & (flight["point_id"] == GROSS[1])
    return flight.assign(x=flight["x"] + 0.4 * is_it)


def suspects_of(fit):
    rows = fit.residuals[fit.residuals["is_suspect"]]
    return list(zip(rows["model_id"], rows["point_id"], strict=True))


@pytest.mark.parametrize("outliers", OUTLIERS)
def test_points_that_are_off_together_are_no_suspects(
    flight, ground, covariances, outliers
):
    fit = es.transform_models(flight, ground)
    taken_for_independent = suspects_of(screen_models(fit, outliers))
    assert any(point in {"0021", "0022"} for _, point in taken_for_independent)
    assert suspects_of(screen_models(fit, outliers, covariances=covariances)) == []


@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_residuals_far_below_their_errors_keep_their_tests(
    flight, ground, covariances, outliers
):
    """They are rounding, a part of which stands out of the rest."""
    fit = es.transform_models(flight, ground)
    independent = screen_models(fit, outliers).residuals
    far = screen_models(
        fit, outliers, covariances=lambda pairs: 1e4 * covariances(pairs)
    )
    pd.testing.assert_frame_equal(far.residuals, independent)


@pytest.mark.parametrize("outliers", OUTLIERS)
def test_a_gross_error_beside_them_is_named(flight, ground, covariances, outliers):
    fit = es.transform_models(with_gross_error(flight), ground)
    found = screen_models(fit, outliers, covariances=covariances)
    assert suspects_of(found) == [GROSS]
    tests = found.residuals.set_index(["model_id", "point_id"])["p_value"]
    assert tests[GROSS] < 1e-6
    assert tests.drop(GROSS).min() > 1e-4


def test_of_a_point_out_of_the_fit_the_test_is_that_of_the_fit_with_it(
    flight, ground, covariances
):
    fit = es.transform_models(with_gross_error(flight), ground)
    named = screen_models(fit, "keep", covariances=covariances).residuals
    out = screen_models(fit, "snoop", covariances=covariances).residuals
    is_it = named["point_id"].eq(GROSS[1]) & named["model_id"].eq(GROSS[0])
    assert out.loc[is_it, "leverage"].item() == 0.0
    assert out.loc[is_it, "p_value"].item() == pytest.approx(
        named.loc[is_it, "p_value"].item(), rel=1e-6
    )


def test_whatever_would_be_a_suspect_is_tested_again(
    flight, ground, covariances, monkeypatch
):
    """At whatever significance: not by weights alone."""
    asked = []

    def remembered(pairs):
        asked.append(len(pairs))
        return covariances(pairs)

    monkeypatch.setattr(correlated_residuals, "STANDS_OUT", 1e-15)
    fit = es.transform_models(flight, ground)
    screen_models(fit, "keep", 1e-15, covariances=remembered)
    assert not asked
    screen_models(fit, "keep", 0.05, covariances=remembered)
    assert asked


@pytest.mark.parametrize("kind", ["affine", "helmert", "rigid"])
@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_independent_points_have_the_tests_that_they_had(
    flight, ground, kind, outliers
):
    fit = es.transform_models(with_gross_error(flight), ground, kind=kind)

    def independent(pairs):
        return (pairs[:, 0] == pairs[:, 1])[:, None, None] * np.eye(2)

    expected = screen_models(fit, outliers).residuals
    found = screen_models(fit, outliers, covariances=independent).residuals
    assert found["is_suspect"].equals(expected["is_suspect"])
    np.testing.assert_allclose(found["w"], expected["w"], rtol=1e-6)
    np.testing.assert_allclose(found["p_value"], expected["p_value"], rtol=1e-5)


def test_nothing_is_asked_where_nothing_stands_out(ground):
    def must_not_be_asked(pairs):
        raise AssertionError(pairs)

    # errors of one size, in all directions
    angle = 2.4 * np.arange(len(ground))
    xy = ground[["easting", "northing"]] + NOISE * np.c_[np.cos(angle), np.sin(angle)]
    model = xy.set_axis(["x", "y"], axis=1).assign(point_id=ground["point_id"])
    fit = es.transform_models(model.assign(model_id="0/1"), ground)
    screen_models(fit, covariances=must_not_be_asked)


def test_unknown_covariances_and_large_models_leave_the_tests(flight, ground):
    fit = es.transform_models(flight, ground)
    expected = screen_models(fit, "keep").residuals
    unknown = screen_models(
        fit, "keep", covariances=lambda pairs: np.full((len(pairs), 2, 2), np.nan)
    )
    pd.testing.assert_frame_equal(unknown.residuals, expected)
    assert len(flight) < MOST_POINTS
