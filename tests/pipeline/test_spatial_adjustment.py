"""Spatial models of both flights in one adjustment: heights as well."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.judged_alone import judged_alone
from tests.photographs_onto_control import one_flight

import einschalt as es
from einschalt.foundations.errors import GeometryError, SettingsError, TableError
from einschalt.interfaces.reports.html_report import render
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.pipeline.summary.sections import precision
from einschalt.pipeline.summary.summary import summarize
from einschalt.stages.stage2_relative_orientation import relative_orientation
from einschalt.theory.block_adjustment import spatial_solution

SPATIAL = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
PLANE, SPACE = ["easting", "northing"], ["easting", "northing", "height"]
SIMULTANEOUS = es.Settings(method="simultaneous")


def simulated(seed=2, measurement="machine", **noise):
    geometry = replace(SPATIAL, measurement=measurement)
    disturbed = replace(PRESETS["demo"].noise, **noise)
    return es.simulate_block("demo", seed=seed, geometry=geometry, noise=disturbed)


@pytest.fixture(scope="module")
def block():
    return simulated()


@pytest.fixture(scope="module")
def result(block):
    return es.densify(block, SIMULTANEOUS)


@pytest.fixture(scope="module")
def from_images():
    return es.densify(simulated(measurement="images"), SIMULTANEOUS)


def errors(points, truth):
    true = truth.set_index("point_id").loc[points["point_id"], SPACE]
    return points[SPACE].to_numpy() - true.to_numpy()


@pytest.mark.slow
def test_heights_between_few_control_points_follow_the_curved_earth():
    """Most models show too few of them to be placed, and so to be bent, alone."""
    over, claimed = [], []
    for seed in range(6):
        block = one_flight(seed, n_given=6)
        points = es.densify(block, SIMULTANEOUS).points
        points = points[points["role"] == "new"]
        assert len(points) == 94
        over.append(errors(points, block.truth)[:, 2])
        claimed.append(points["standard_error_height"].to_numpy())
        adjusted = es.adjust_block(block, kind="helmert_3d").points
        adjusted = adjusted.set_index("point_id").loc[points["point_id"], "height"]
        np.testing.assert_allclose(adjusted, points["height"], atol=1e-6)
    # six blocks of six control points: heights hang on a dozen numbers
    ratio = np.sqrt(np.mean(np.square(claimed)) / np.mean(np.square(over)))
    assert 0.7 < ratio < 1.4


@pytest.mark.slow
def test_covariances_are_those_of_the_errors_in_plan_and_height():
    plan, height, degrees = 0.0, 0.0, 0
    for seed in range(8):
        block = simulated(seed)
        points = es.adjust_block(block, kind="helmert_3d").points
        points = points[points["role"] != "control"]
        error = errors(points, block.truth)
        one, other = (points[f"standard_error_{name}"] ** 2 for name in PLANE)
        both = points["covariance_en"]
        matrix = np.stack([np.stack([one, both], -1), np.stack([both, other], -1)], 1)
        plan += np.einsum(
            "ni,nij,nj->", error[:, :2], np.linalg.inv(matrix), error[:, :2]
        )
        height += np.sum((error[:, 2] / points["standard_error_height"]) ** 2)
        degrees += len(points)
    # hundreds of points, some ten of which count as one
    assert plan / (2 * degrees) == pytest.approx(1.0, abs=0.25)
    assert height / degrees == pytest.approx(1.0, abs=0.25)


def test_it_is_better_than_two_steps_in_plan_and_height(block, result):
    ways = [result.points, result.two_step.points]
    plan, height = np.transpose(
        [
            (
                np.sqrt(np.mean((e[:, :2] ** 2).sum(axis=1))),
                np.sqrt(np.mean(e[:, 2] ** 2)),
            )
            for e in (errors(points, block.truth) for points in ways)
        ]
    )
    assert plan[0] < 0.9 * plan[1]
    assert height[0] < 0.8 * height[1]


def test_errors_of_heights_are_those_that_were_simulated(result):
    found = result.simultaneous.components.set_index("group")
    assert list(found.index) == [
        *("high_flight, plan", "high_flight, height"),
        *("low_flight, plan", "low_flight, height", "control"),
    ]
    for flight, m_g_um, scale in (("high", 7.5, 15_000), ("low", 5.0, 8_000)):
        row = found.loc[f"{flight}_flight, height"]
        # c / b times that in plan
        true = m_g_um * 1e-6 * scale / np.sqrt(2.0) * 153.0 / 92.0
        error = row["factor_standard_error"] / row["factor"] * row["standard_error_m"]
        assert row["is_estimated"]
        assert row["standard_error_m"] == pytest.approx(true, abs=4.0 * error)
    assert not found.loc[["low_flight, plan", "control"], "is_estimated"].any()


def test_parameters_transform_the_models_onto_the_points(block, result):
    rows = result.residuals.merge(
        result.models, on=["flight", "coverage", "model_id"]
    ).merge(result.points, on="point_id")
    # as they are after the map's scale and the Earth's curvature
    measured = pd.concat(
        [f.assign(flight=name) for name, f in result.two_step.model_points.items()]
    )
    rows = rows.merge(measured, on=["flight", "coverage", "model_id", "point_id"])
    xyz = rows[["x", "y", "z"]].to_numpy()
    omega, phi, kappa = rows[["omega", "phi", "kappa"]].to_numpy().T
    x, y, z = xyz.T
    x, y = x * np.cos(kappa) - y * np.sin(kappa), x * np.sin(kappa) + y * np.cos(kappa)
    x, z = x * np.cos(phi) + z * np.sin(phi), z * np.cos(phi) - x * np.sin(phi)
    y, z = y * np.cos(omega) - z * np.sin(omega), y * np.sin(omega) + z * np.cos(omega)
    turned = rows["scale"].to_numpy()[:, None] * np.column_stack([x, y, z])
    found = rows[["te", "tn", "th"]].to_numpy() + turned - rows[SPACE].to_numpy()
    residuals = [f"residual_{name}" for name in SPACE]
    np.testing.assert_allclose(found, rows[residuals], rtol=0, atol=1e-7)


def test_adjust_block_gives_the_same(block, result):
    alone = es.adjust_block(block, kind="helmert_3d")
    pd.testing.assert_frame_equal(
        alone.points.set_index("point_id")[SPACE],
        result.points.set_index("point_id")[SPACE],
    )
    assert alone.common.empty
    assert alone.deformations.empty
    assert alone.centres.empty
    usable = alone.models.iloc[0]
    covariance = np.asarray(alone.estimates.cofactors[0])
    assert covariance.shape == (7, 7)
    assert np.linalg.eigvalsh(covariance).min() > 0.0
    assert usable["transformation"] == "helmert_3d"


def test_redundancy_numbers_add_up(result):
    adjusted = result.simultaneous
    control = np.nansum(1.0 - adjusted.solution.control_leverage)
    rows = (1.0 - adjusted.solution.leverage).sum()
    assert adjusted.redundancy == pytest.approx(rows + control, rel=1e-9)
    own = adjusted.residuals
    assert (own["redundancy_number_height"].between(0.0, 1.0)).all()
    assert (
        own["external_reliability_height"] <= own["minimal_detectable_bias_height"]
    ).all()


def test_summary_and_report_say_the_heights(result):
    text = summarize(result).replace("\n    ", " ")
    assert "Heights of the new points: " in text
    assert (
        "Measured heights (standard errors estimated from the residuals): high" in text
    )
    assert "Heights of the new points: " in render(result)


def test_figure_of_the_heights_that_is_contradicted_is_not_left_alone(result):
    told = result.assessment
    assert "propagated figure of the heights" not in result.summary()
    worse = replace(told.credible_heights, is_lower_bound=True)
    said = precision.section(told.precision, told.credible, worse).text()
    first_line = "The measurements contradict the propagated figure of the heights: use"
    assert first_line in said.replace("\n    ", " ")


@pytest.mark.slow
def test_projection_centres_tie_the_models_of_images(from_images):
    adjusted = from_images.simultaneous
    centres = adjusted.centres
    # photographs of both flights have the same names
    assert centres["image_id"].duplicated().any()
    assert not centres.duplicated(["flight", "image_id"]).any()
    assert (centres.groupby("flight")["n_models"].max() >= 2).all()
    heights = centres.groupby("flight")["height"].agg(["min", "max"])
    # 1:15 000 and 1:8000 with c = 153 mm over ground at 520 m
    for flight, scale in (("high_flight", 15_000), ("low_flight", 8_000)):
        above = 0.153 * scale + 520.0
        assert heights.loc[flight].sub(above).abs().max() < 0.03 * above
    assert not adjusted.points["point_id"].isin(centres["image_id"]).any()
    assert set(adjusted.residuals["point_id"]) <= set(adjusted.points["point_id"])
    block = from_images.block
    n_rows = sum(
        len(flight.model_points) for flight in adjusted_flights(block).values()
    )
    assert len(adjusted.residuals) == n_rows
    assert "projection centres of 3" in summarize(from_images).replace("\n    ", " ")
    assert adjusted.models["n_points"].sum() == n_rows


def adjusted_flights(block):
    return {name: relative_orientation(f) for name, f in block.flights.items()}


def test_models_of_images_are_better_than_in_two_steps(from_images):
    truth = from_images.block.truth
    ways = [from_images.points, from_images.two_step.points]
    one, two = (np.sqrt(np.mean(errors(p, truth) ** 2, axis=0)) for p in ways)
    assert np.hypot(*one[:2]) < np.hypot(*two[:2])
    assert one[2] < two[2]


def test_a_model_without_ties_is_a_row(block):
    low = block.low_flight.model_points
    first = low.iloc[0]
    is_cut = (low["model_id"] == first["model_id"]) & (
        low["coverage"] == first["coverage"]
    )
    names = np.where(is_cut, "lost " + low["point_id"], low["point_id"])
    cut = replace(block.low_flight, model_points=low.assign(point_id=names))
    found = es.adjust_block(replace(block, low_flight=cut), kind="helmert_3d")
    (row,) = found.failures.to_dict("records")
    assert row["reason"].endswith("but helmert_3d needs 3")
    assert found.models["te"].isna().sum() == 1


def test_gross_errors_of_heights_are_found(block):
    low = block.low_flight.model_points.copy()
    low.loc[25, "z"] += 0.1
    bad = replace(block, low_flight=replace(block.low_flight, model_points=low))
    found = es.adjust_block(bad, kind="helmert_3d", outliers="snoop").residuals
    suspects = found[found["is_suspect"]]
    wrong = low.loc[25]
    assert wrong["point_id"] in set(suspects["point_id"])
    worst = suspects.loc[suspects["residual_height"].abs().idxmax()]
    assert (worst["model_id"], worst["point_id"]) == (
        wrong["model_id"],
        wrong["point_id"],
    )


def test_spatial_and_plane_models_are_not_mixed(block):
    high = replace(block.high_flight, transformation="affine")
    mixed = replace(block, high_flight=high)
    with pytest.raises(
        SettingsError, match=r"spatial and plane models.*the same kind of models"
    ):
        es.densify(mixed, SIMULTANEOUS)


def test_plane_tables_have_no_spatial_models():
    plane = es.simulate_block("demo", seed=2)
    with pytest.raises(SettingsError, match="high_flight and low_flight have no heigh"):
        es.adjust_block(plane, kind="helmert_3d")


def test_deformations_belong_to_plane_models(block):
    with pytest.raises(SettingsError, match="with kind = 'helmert_3d'; expected no de"):
        es.adjust_block(block, kind="helmert_3d", deformation=("cubic",))


def mirrored(block, axis):
    table = block.low_flight.model_points
    flight = replace(
        block.low_flight, model_points=table.assign(**{axis: -table[axis]})
    )
    return replace(block, low_flight=flight)


@pytest.mark.slow
def test_models_mirrored_in_plan_are_named(block):
    result = es.densify(mirrored(block, "x"), SIMULTANEOUS)
    found = judged_alone(result)
    low = result.models[result.models["flight"] == "low_flight"]
    assert found["models_upside_down"].facts["n_models"] == len(low)
    assert result.examination.credible.is_lower_bound


@pytest.mark.slow
def test_models_without_relief_of_their_own_hold_their_plan(block):
    low = block.low_flight.model_points.assign(z=0.0)
    flat = replace(block, low_flight=replace(block.low_flight, model_points=low))
    result = es.densify(flat, SIMULTANEOUS)
    new = result.points[result.points["role"] == "new"]
    true = np.sqrt(np.mean(np.sum(errors(new, block.truth)[:, :2] ** 2, axis=1)))
    claimed = result.examination.credible
    assert true < 1.2 * claimed.value
    assert not claimed.is_lower_bound


def test_models_that_never_settle_are_named(block, monkeypatch):
    monkeypatch.setattr(spatial_solution, "MOST_PASSES", 1)
    message = r"model \S+: The simultaneous .* does not converge; expected models that"
    with pytest.raises(GeometryError, match=message):
        es.adjust_block(mirrored(block, "x"), kind="helmert_3d")


@pytest.mark.parametrize("n_control", [4, 5])
def test_control_in_one_corner_holds_the_block(block, n_control):
    control = block.control_points[block.control_points["role"] == "control"]
    along = control[PLANE].sum(axis=1).to_numpy()
    few = control.iloc[np.argsort(along)[:n_control]]
    corner = replace(block, control_points=few, may_be_unmeasured=True)
    points = es.adjust_block(corner, kind="helmert_3d").points
    assert len(points) == len(block.truth)
    error = errors(points, block.truth)
    size = np.hypot(*error[:, :2].T) / points["standard_error_total"]
    assert np.sqrt(np.mean(size**2)) < 2.0
    assert np.abs(error[:, 2] / points["standard_error_height"]).max() < 4.5


def test_models_mirrored_in_height_show_it(block):
    found = es.adjust_block(mirrored(block, "z"), kind="helmert_3d").components
    factor = found.set_index("group")["factor"]
    # on flat ground the heights fit, but as badly as the relief is large
    assert factor["low_flight, height"] > 10.0
    assert factor["high_flight, height"] == pytest.approx(1.0, abs=0.3)


def test_covariances_of_spatial_control_are_used(block):
    control = block.control_points
    n = len(control)
    same = control.assign(
        standard_error_easting=0.03 / np.sqrt(2.0),
        standard_error_northing=0.03 / np.sqrt(2.0),
        standard_error_height=0.03 / np.sqrt(2.0),
        covariance_eh=np.zeros(n),
    )
    plain = es.adjust_block(block, kind="helmert_3d")
    found = es.adjust_block(replace(block, control_points=same), kind="helmert_3d")
    np.testing.assert_allclose(
        found.points[SPACE], plain.points[SPACE], rtol=0, atol=1e-8
    )
    loose = same.assign(standard_error_height=10.0)
    found = es.adjust_block(replace(block, control_points=loose), kind="helmert_3d")
    assert found.control["difference_height"].abs().max() > 0.05
    assert found.control[["difference_easting"]].abs().max().item() < 0.1


# errors along one line; in part: without standard_error_m the northing has none; each
# pair of the three is possible, all of them are not
ALONG = {f"standard_error_{axis}": 0.02 for axis in ("easting", "northing", "height")}
BEYOND = {"covariance_en": 3.9e-4, "covariance_eh": 3.9e-4, "covariance_nh": -3.9e-4}


@pytest.mark.parametrize(
    ("columns", "is_plane"),
    [
        (ALONG | {"covariance_en": 4e-4}, True),
        ({"standard_error_easting": 0.02}, True),
        (ALONG | BEYOND, False),
    ],
)
def test_impossible_covariances_are_refused(block, columns, is_plane):
    control = block.control_points.drop(columns="standard_error_m").assign(**columns)
    with pytest.raises(TableError, match="contradict each other, or are given in part"):
        es.adjust_block(replace(block, control_points=control), kind="helmert_3d")
    if is_plane:
        plane = es.simulate_block("demo", seed=2)
        control = plane.control_points.drop(columns="standard_error_m")
        plane = replace(plane, control_points=control.assign(**columns))
        with pytest.raises(TableError, match="contradict each other, or are given"):
            es.adjust_block(plane)
