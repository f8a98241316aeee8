import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import GeometryError

PLAN = ["easting", "northing"]


@pytest.fixture(scope="module")
def truth():
    rng = np.random.default_rng(200)
    en = np.array([50_000.0, 350_000.0]) + rng.uniform(0, 3000, (60, 2))
    return pd.DataFrame(en, columns=PLAN).assign(
        point_id=[f"{place:03d}" for place in range(60)]
    )


def high_flight(truth, noise, seed=0):
    """Two coverages of two models each; the models of a coverage overlap."""
    rng = np.random.default_rng(seed)
    parts = []
    for coverage in ("1", "2"):
        for model_id, rows in (("1/2", slice(0, 40)), ("2/3", slice(20, 60))):
            part = truth.iloc[rows]
            centred = part[PLAN].to_numpy() - [51_500.0, 351_500.0]
            angle = rng.uniform(-np.pi, np.pi)
            c, s = np.cos(angle), np.sin(angle)
            xy = centred @ np.array([[c, s], [-s, c]]) / 5.0
            xy += rng.normal(0.0, noise / 5.0, xy.shape) if noise else 0.0
            frame = pd.DataFrame(xy, columns=["x", "y"]).assign(
                coverage=coverage,
                model_id=model_id,
                point_id=part["point_id"].to_numpy(),
            )
            parts.append(frame)
    return pd.concat(parts, ignore_index=True)


@pytest.fixture(scope="module")
def control(truth):
    return truth.iloc[::3].assign(role="control").reset_index(drop=True)


@pytest.mark.parametrize("kind", ["affine", "helmert"])
@pytest.mark.parametrize("coverage_mean", ["all", "most_central"])
def test_without_noise_the_truth_comes_back(truth, control, kind, coverage_mean):
    found = es.approximate_coordinates(
        high_flight(truth, 0.0), control, kind, coverage_mean=coverage_mean
    )
    both = found.points.merge(truth, on="point_id", suffixes=("", "_true"))
    assert len(both) == 60
    for name in PLAN:
        np.testing.assert_allclose(both[name], both[f"{name}_true"], rtol=0, atol=1e-7)


def test_table_of_points(truth, control):
    found = es.approximate_coordinates(high_flight(truth, 0.1), control)
    assert found.points.columns.tolist() == [
        "point_id",
        *PLAN,
        "n_models",
        "n_coverages",
        "spread_total",
    ]
    points = found.points.set_index("point_id")
    assert points.loc["000", "n_models"] == 2
    assert points.loc["030", "n_models"] == 4
    assert points["n_coverages"].eq(2).all()
    # noise of 10 cm a coordinate: 14 cm total of a value, of which a mean of the two
    # models of a coverage, or one, is a coverage's value
    assert 0.09 < found.internal_single < 0.17


def test_check_points_have_no_part(truth, control):
    flight = high_flight(truth, 0.1)
    checked = control.assign(role=["check"] * 4 + ["control"] * 16)
    found = es.approximate_coordinates(flight, checked)
    fewer = es.approximate_coordinates(flight, control.iloc[4:].drop(columns="role"))
    pd.testing.assert_frame_equal(found.points, fewer.points)
    assert (
        not found.transformation.residuals["point_id"]
        .isin(checked["point_id"][:4])
        .any()
    )


def test_weights_follow_the_errors_of_the_transformation(truth, control):
    flight = high_flight(truth, 0.1)
    plain = es.approximate_coordinates(flight, control)
    weighted = es.approximate_coordinates(flight, control, weighting="weighted")
    # 14 control points are too few for an m_0 of the model's own: that of all is used
    assert weighted.transformation.models["redundancy"].max() < 30
    values = weighted.transformation.values(flight, least_redundancy=30)
    part = values[values["point_id"] == "030"]
    wanted = np.average(part["easting"], weights=part["m_t"] ** -2.0)
    points = weighted.points.set_index("point_id")
    assert points.loc["030", "easting"] == pytest.approx(wanted, abs=1e-8)
    apart = np.abs(plain.points["easting"] - weighted.points["easting"])
    assert 1e-4 < apart.max() < 0.1


def test_well_checked_models_are_weighted_by_their_own_errors(truth):
    flight = high_flight(truth, 0.1)
    control = truth.iloc[:-10]
    weighted = es.approximate_coordinates(flight, control, weighting="weighted")
    assert weighted.transformation.models["redundancy"].min() >= 30
    part = weighted.transformation.transform(flight)
    part = part[part["point_id"] == "030"]
    wanted = np.average(part["northing"], weights=part["m_t"] ** -2.0)
    points = weighted.points.set_index("point_id")
    assert points.loc["030", "northing"] == pytest.approx(wanted, abs=1e-8)


def test_model_that_fails_leaves_its_points_to_the_others(truth, control):
    flight = high_flight(truth, 0.1)
    # 1/2 of the first coverage is left with one control point
    is_model = (flight["coverage"] == "1") & (flight["model_id"] == "1/2")
    is_control = flight["point_id"].isin(control["point_id"])
    drop = is_model & is_control & (flight["point_id"] != "000")
    found = es.approximate_coordinates(flight[~drop], control)
    failures = found.failures
    assert failures[["coverage", "model_id"]].to_numpy().tolist() == [["1", "1/2"]]
    assert failures["stage"].tolist() == ["stage1_approximate_coordinates"]
    assert failures["reason"].tolist() == ["1 common point, but affine needs 3"]
    points = found.points.set_index("point_id")
    # seen by the failed model and by 1/2 of the second coverage
    assert points.loc["001", "n_models"] == 1
    assert points["easting"].notna().all()


def test_summary(truth, control):
    found = es.approximate_coordinates(high_flight(truth, 0.1), control)
    lines = str(found).splitlines()
    assert lines[0] == "approximate coordinates of 60 points"
    assert lines[1].startswith("affine transformation of 4 of 4 models")
    assert lines[-1].startswith("one coverage, from the differences of the coverages")


def test_no_model_usable(truth, control):
    flight = high_flight(truth, 0.1)
    with pytest.raises(
        GeometryError,
        match=(
            r"model 1/2, 2/3, 1/2, 2/3: no model of the high flight could be "
            r"transformed: no common points, but affine needs 3; expected at least "
            r"one usable model\. Measure more common points in it"
        ),
    ):
        es.approximate_coordinates(
            flight, control.assign(point_id=control["point_id"] + "x")
        )
