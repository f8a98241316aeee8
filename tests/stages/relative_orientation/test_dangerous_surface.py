"""Verdicts as tables: of measured models, of image pairs, and before the flight."""

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import SettingsError, TableError
from einschalt.stages.relative_orientation.dangerous_surface import (
    HEIGHTS,
    FlightPlan,
    forecast_dangerous_surfaces,
)
from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)

COLUMNS = [
    "verdict",
    "inflation",
    "sigma_omega",
    "over_correction_k",
    "over_correction_n",
    "gap",
    "n_0",
    "n_b",
    "singular_value_ratio",
    "reason",
]
BASE, DEPTH, DISTANCE = 92.0, 152.0, 153.0


def six_points(relative_depth=0.0):
    """Six standard points of a valley, wings seen under 100/152."""
    rows = [(x, side) for side in (0.0, 1.0, -1.0) for x in (0.0, BASE)]
    x, side = np.array(rows).T
    z = -DEPTH * (1.0 - relative_depth * np.abs(side))
    return np.column_stack([x, -z * side * 100.0 / 152.0, z])


def parallaxes(**models):
    """Table of y-parallaxes of 0 in models of given points."""
    tables = [
        pd.DataFrame(xyz, columns=["x", "y", "z"]).assign(
            model_id=name, point_id=[str(n + 1) for n in range(len(xyz))]
        )
        for name, xyz in models.items()
    ]
    return pd.concat(tables, ignore_index=True).assign(y_parallax=0.0)


def image_pair(xyz, angles=(0.0, 0.0, 0.0), kappa=0.0):
    """Image coordinates of points; the right camera is turned by small angles."""
    turn = np.array([[np.cos(kappa), np.sin(kappa)], [-np.sin(kappa), np.cos(kappa)]])
    omega, phi, swing = angles
    small = np.array([[1, swing, -phi], [-swing, 1, omega], [phi, -omega, 1]])
    small, _ = np.linalg.qr(small.T)
    small = (small * np.sign(np.diag(small))).T
    coordinates = []
    for ray, rotation in ((xyz, np.eye(3)), (xyz - [BASE, 0.0, 0.0], small)):
        turned = ray @ rotation.T
        coordinates.append(-DISTANCE * turned[:, :2] / turned[:, 2:] @ turn.T)
    table = pd.DataFrame(
        np.hstack(coordinates), columns=["x_left", "y_left", "x_right", "y_right"]
    )
    return table.assign(point_id=[str(n) for n in range(len(xyz))])


# -- y-parallaxes ------------------------------------------------------------------


def test_columns_and_index():
    given = parallaxes(flat=six_points(), valley=six_points(0.25))
    oriented = orient_from_parallaxes(given, BASE)
    surfaces = oriented.dangerous_surface
    assert surfaces.columns.tolist() == COLUMNS
    assert surfaces.index.name == "model_id"
    assert surfaces.index.tolist() == oriented.parameters.index.tolist()
    assert surfaces["verdict"].tolist() == ["safe", "weak"]
    assert surfaces.loc["flat", "reason"] == ""
    assert "5.8 times as uncertain" in surfaces.loc["valley", "reason"]
    np.testing.assert_allclose(
        surfaces["over_correction_n"] - surfaces["over_correction_k"], 1.0
    )


def test_sigma_omega_is_the_root_of_the_cofactor():
    oriented = orient_from_parallaxes(parallaxes(m=six_points(0.1)), BASE)
    np.testing.assert_allclose(
        oriented.dangerous_surface.loc["m", "sigma_omega"],
        np.sqrt(oriented.cofactor("m").loc["d_omega", "d_omega"]),
        rtol=1e-9,
    )


def test_summary_warns_of_a_model_near_a_surface():
    given = parallaxes(flat=six_points(), valley=six_points(0.25))
    said = str(orient_from_parallaxes(given, BASE))
    assert "model valley, weak: its points lie near a dangerous surface" in said
    assert "Measure points that lie higher or lower" in " ".join(said.split())
    assert "flat, weak" not in said


def test_models_that_fail_have_a_verdict_and_a_reason():
    line = np.linspace(0.0, 1.0, 6)[:, np.newaxis] * [BASE, 90.0, 10.0]
    given = parallaxes(
        flat=six_points(),
        line=line - [0.0, 45.0, DEPTH],
        same=six_points()[[0] * 6],
        four=six_points()[:4],
        behind=six_points() * [1.0, 1.0, -1.0],
        no_base=six_points(),
        critical=six_points(100.0**2 / (100.0**2 + 152.0**2)),
    )
    base = pd.Series(BASE, index=["flat", "line", "same", "four", "behind", "critical"])
    oriented = orient_from_parallaxes(given, base)
    surfaces = oriented.dangerous_surface
    assert surfaces.loc["flat", "verdict"] == "safe"
    others = surfaces.drop("flat")
    assert (others["verdict"] == "critical").all()
    assert set(oriented.failures["model_id"]) == set(others.index)
    for name, reason in {
        "line": "on a line",
        "same": "on a line or close together",
        "four": "4 points, but five are needed",
        "behind": "at or above the projection centres",
        "no_base": "it has no base",
        "critical": "on a dangerous surface",
    }.items():
        assert reason in others.loc[name, "reason"]


def test_order_of_rows_does_not_matter():
    given = parallaxes(a=six_points(0.1), b=six_points(0.25), c=six_points())
    mixed = given.sample(frac=1.0, random_state=1)
    one = orient_from_parallaxes(given, BASE).dangerous_surface
    other = orient_from_parallaxes(mixed, BASE).dangerous_surface
    pd.testing.assert_frame_equal(one, other.loc[one.index], rtol=1e-9)


# -- image coordinates -------------------------------------------------------------


def many_points(relative_depth, n_points=40, seed=1):
    """Points of a valley that is the cylinder through the base at its deepest."""
    rng = np.random.default_rng(seed)
    slope = rng.uniform(-1.0, 1.0, n_points) * 100.0 / 152.0
    critical = 100.0**2 / (100.0**2 + 152.0**2)
    rise = relative_depth / critical * (1.0 - 1.0 / (1.0 + slope**2))
    z = -DEPTH * (1.0 - rise)
    return np.column_stack([rng.uniform(0.0, BASE, n_points), -z * slope, z])


@pytest.mark.parametrize("case", ["dependent_right", "dependent_left", "independent"])
@pytest.mark.parametrize("kappa", [0.0, 2.0, np.pi])
def test_image_pairs(case, kappa):
    angles = (0.02, -0.03, 0.05)
    pairs = pd.concat(
        image_pair(many_points(depth), angles, kappa).assign(model_id=str(depth))
        for depth in (0.0, 0.2, 0.29)
    )
    surfaces = orient_from_images(pairs, DISTANCE, case=case).dangerous_surface
    assert surfaces.columns.tolist() == COLUMNS
    assert surfaces["verdict"].tolist() == ["safe", "weak", "critical"]
    # image errors: 1 / |1 - delta / critical| up to weights of nearer points
    np.testing.assert_allclose(
        surfaces["inflation"],
        1.0 / (1.0 - np.array([0.0, 0.2, 0.29]) / 0.302),
        rtol=0.2,
    )


def test_sigma_omega_of_images_is_that_of_their_adjustment():
    # a parallax of two images has the variance of two coordinates
    pair = image_pair(many_points(0.1)).assign(model_id="m")
    oriented = orient_from_images(pair, DISTANCE, case="independent")
    middle = DEPTH / BASE  # in the unit of the base
    found = oriented.dangerous_surface.loc["m", "sigma_omega"]
    claimed = np.sqrt(oriented.cofactor("m").loc["omega_2", "omega_2"])
    np.testing.assert_allclose(
        found * np.sqrt(2.0) * middle / DISTANCE, claimed, rtol=0.01
    )


def test_pairs_that_fail_keep_the_reason_of_their_failure():
    good = image_pair(many_points(0.0)).assign(model_id="good")
    four = image_pair(many_points(0.0)[:4]).assign(model_id="four")
    same = image_pair(many_points(0.0)[[3] * 8]).assign(model_id="same")
    same["point_id"] = [str(n) for n in range(8)]
    oriented = orient_from_images(pd.concat([four, good, same]), DISTANCE)
    surfaces = oriented.dangerous_surface
    assert surfaces["verdict"].to_dict() == {
        "four": "critical",
        "good": "safe",
        "same": "critical",
    }
    reasons = oriented.models.set_index("model_id")["reason"]
    assert surfaces["reason"].to_dict() == reasons.to_dict()


# -- before the flight -------------------------------------------------------------


def terrain(**models):
    return pd.DataFrame(list(models.values()), columns=HEIGHTS).assign(
        model_id=list(models)
    )


WIDE = {"principal_distance": 0.152}


def test_forecast_of_a_valley_and_its_remedy():
    heights = terrain(
        flat=[600.0] * 6, valley=[600.0] * 2 + [850.0] * 4, ridge=[900, 900, *[700] * 4]
    )
    forecast = forecast_dangerous_surfaces(
        heights, FlightPlan(**WIDE, flying_height=1000.0)
    )
    models = forecast.models
    assert models["verdict"].tolist() == ["safe", "weak", "safe"]
    np.testing.assert_allclose(models.loc["flat", "inflation"], 1.0)
    assert models.loc["ridge", "inflation"] < 1.0
    np.testing.assert_allclose(models["critical_depth"], 302.08, atol=0.005)
    assert "Fly 1660 m above the valley" in str(forecast)
    # and there it is safe indeed, if only just
    height = models.loc["valley", "safe_flying_height"]
    higher = FlightPlan(**WIDE, flying_height=height + 1.0)
    again = forecast_dangerous_surfaces(heights, higher).models
    assert again.loc["valley", "verdict"] == "safe"
    np.testing.assert_allclose(again.loc["valley", "inflation"], 2.0, rtol=2e-3)


def test_one_dangerous_plane_is_harmless_before_the_flight():
    deep = 600.0 + 1000.0 * 100.0**2 / (100.0**2 + 152.0**2)
    heights = terrain(
        left=[600, 600, deep, 600, deep, 600], both=[600, 600, *[deep] * 4]
    )
    models = forecast_dangerous_surfaces(
        heights, FlightPlan(**WIDE, flying_height=1000.0)
    ).models
    assert models["verdict"].tolist() == ["safe", "critical"]
    np.testing.assert_allclose(models.loc["left", "inflation"], np.sqrt(2.0))


def test_scale_flying_height_and_altitude_mean_the_same():
    heights = terrain(a=[600, 620, 700, 720, 690, 650])
    plans = [
        FlightPlan(**WIDE, scale_number=8000.0),
        FlightPlan(**WIDE, flying_height=1216.0),
        FlightPlan(**WIDE, altitude=1826.0),
    ]
    first, *others = (forecast_dangerous_surfaces(heights, p).models for p in plans)
    for other in others:
        pd.testing.assert_frame_equal(first, other)


def test_altitude_is_one_for_all_models():
    heights = terrain(low=[600.0] * 6, high=[1200.0] * 6)
    plan = FlightPlan(**WIDE, altitude=2000.0)
    flying_height = forecast_dangerous_surfaces(heights, plan).models["flying_height"]
    assert flying_height.tolist() == [1400.0, 800.0]


def test_standard_error_is_that_of_a_flat_six_point_model():
    plan = FlightPlan(**WIDE, scale_number=8000.0, parallax_error=5e-6)
    found = forecast_dangerous_surfaces(terrain(a=[500.0] * 6), plan).models
    np.testing.assert_allclose(
        found["standard_error_omega"], np.sqrt(0.75) * 0.152 / 0.1**2 * 5e-6
    )


def test_terrain_above_the_flight_is_critical():
    heights = terrain(peak=[600, 600, 600, 1700, 600, 600], flat=[600.0] * 6)
    for plan in (
        FlightPlan(**WIDE, altitude=1600.0),
        FlightPlan(**WIDE, altitude=600.0),
        FlightPlan(**WIDE, altitude=0.0),
    ):
        forecast = forecast_dangerous_surfaces(heights, plan)
        assert forecast.models.loc["peak", "verdict"] == "critical"
        assert "terrain reaches the flying height" in str(forecast)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({}, "no flying height is given; expected one of scale_number"),
        (
            {"scale_number": 8000, "altitude": 900},
            "scale_number and altitude are given",
        ),
        ({"scale_number": 0}, r"scale_number = 0; expected a number above 0"),
        (
            {"scale_number": 8000, "principal_distance": 152.0},
            r"0\.001 and 5\. Did you mistake metres",
        ),
        ({"altitude": 900, "forward_overlap": 1.0}, r"forward_overlap = 1; expected"),
        (
            {"altitude": 900, "wing": 0.2},
            r"wing = 0\.2; expected within the image, metres between",
        ),
        ({"altitude": 900, "image_format": -0.2}, r"image_format = -0\.2"),
        ({"altitude": 900, "parallax_error": 0.0}, r"parallax_error = 0; expected"),
    ],
)
def test_plans_that_make_no_sense(changes, message):
    with pytest.raises(SettingsError, match=message):
        FlightPlan(**{**WIDE, **changes})


def test_heights_are_checked():
    plan = FlightPlan(**WIDE, flying_height=1000.0)
    with pytest.raises(TableError, match="column 'h6' is missing"):
        forecast_dangerous_surfaces(terrain(a=[1] * 6).drop(columns="h6"), plan)
    with pytest.raises(TableError, match=r"model a: h3 'n/a' is not a number"):
        forecast_dangerous_surfaces(terrain(a=[1, 1, "n/a", 1, 1, 1]), plan)


def test_wing_of_other_formats():
    assert FlightPlan(**WIDE, altitude=900).wing_in_image == pytest.approx(0.1)
    small = FlightPlan(**WIDE, altitude=900, image_format=0.18)
    assert small.wing_in_image == pytest.approx(0.075)
    tiny = FlightPlan(principal_distance=0.035, altitude=900, image_format=0.024)
    assert tiny.wing_in_image == pytest.approx(0.006)
