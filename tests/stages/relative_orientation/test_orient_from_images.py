"""Tables of image coordinates in, one result out."""

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import EinschaltError, SettingsError, TableError
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.stages.relative_orientation.orient_from_images import orient_from_images

C = 152.0
COORDINATES = ["x_left", "y_left", "x_right", "y_right"]
RESIDUALS = [f"residual_{name}" for name in COORDINATES]
# base and angles of the right photograph of each model
TRUTH = {
    "1/2": ([92.0, 4.0, -3.0], [0.05, -0.06, 0.12]),
    "2/3": ([92.0, -5.0, 1.0], [-0.02, 0.03, 3.0]),
    "3/4": ([-4.0, 92.0, 2.0], [0.01, 0.04, -1.6]),
}


def simulate_model(model_id, n_points=15, noise=5e-3, seed=0):
    """Image coordinates of one model, the left photograph being the reference."""
    base, angles = TRUTH[model_id]
    rng = np.random.default_rng([seed, *map(ord, model_id)])
    plan = rng.uniform(-60.0, 60.0, (n_points, 2)) + 0.5 * np.array(base[:2])
    ground = np.column_stack([plan, rng.uniform(-170.0, -130.0, n_points)])
    right = (ground - base) @ rotation_from_angles(*angles).T
    image = np.hstack(
        [-C * ground[:, :2] / ground[:, 2:], -C * right[:, :2] / right[:, 2:]]
    )
    image += rng.normal(scale=noise, size=image.shape)
    table = pd.DataFrame(image, columns=COORDINATES)
    names = [f"p{place}" for place in range(n_points)]
    return table.assign(model_id=model_id, point_id=names)


@pytest.fixture
def image_pairs():
    """Three models, the last with its base along y."""
    return pd.concat([simulate_model(name) for name in TRUTH], ignore_index=True)


@pytest.fixture
def faulty_pairs(image_pairs):
    """One model each that is good, too small, in a line, and with a gross error."""
    small = simulate_model("2/3", n_points=4)
    line = simulate_model("1/2", noise=0.0).assign(model_id="line")
    line[COORDINATES] = np.linspace(0.0, 1.0, 15)[:, None] * [90.0, 60.0, -80.0, 55.0]
    line[["x_left", "x_right"]] += [2.0, -60.0]
    blunder = simulate_model("3/4").assign(model_id="blunder")
    blunder.loc[3, "y_right"] += 1.0
    good = image_pairs[image_pairs["model_id"] == "1/2"]
    return pd.concat([small, good, line, blunder], ignore_index=True)


# -------------------------------------------------------------------------- results


def test_elements_within_their_precision(image_pairs):
    oriented = orient_from_images(image_pairs, C, base_length=92.0)
    assert list(oriented.parameters.index) == list(TRUTH)
    names = ["bx", "by", "bz", "omega", "phi", "kappa"]
    assert list(oriented.parameters.columns) == names
    for model_id, (base, angles) in TRUTH.items():
        found = oriented.parameters.loc[model_id]
        is_along_x = model_id != "3/4"
        assert (found["bx"] == 92.0) == is_along_x
        scale = 1.0 if is_along_x else 92.0 / np.linalg.norm(base)
        deviation = oriented.covariance(model_id)
        sigma = np.sqrt(np.diag(deviation))
        assert list(deviation.index) == list(deviation.columns) == names[1:]
        wanted = np.array([scale * base[1], scale * base[2], *angles])
        assert np.all(np.abs(found[names[1:]] - wanted) < 6.0 * sigma + 1e-12)
    assert oriented.converged.all()
    assert oriented.sigma_0.between(2e-3, 9e-3).all()
    assert (oriented.n_points == 15).all()
    assert (oriented.redundancy == 10).all()


def test_default_base_is_one(image_pairs):
    one = orient_from_images(image_pairs, C)
    many = orient_from_images(image_pairs, C, base_length=92.0)
    lengths = ["bx", "by", "bz"]
    np.testing.assert_allclose(
        92.0 * one.parameters[lengths], many.parameters[lengths], rtol=1e-12
    )
    np.testing.assert_allclose(
        92.0 * one.model_points[["x", "y", "z"]],
        many.model_points[["x", "y", "z"]],
        rtol=1e-12,
    )
    assert one.parameters.loc["1/2", "bx"] == 1.0


def test_base_by_model(image_pairs):
    length = pd.Series({"3/4": 30.0, "1/2": 10.0, "2/3": 20.0})
    oriented = orient_from_images(image_pairs, C, base_length=length)
    assert oriented.parameters["bx"].iloc[:2].tolist() == [10.0, 20.0]
    last = oriented.parameters.loc["3/4", ["bx", "by", "bz"]]
    assert np.linalg.norm(last) == pytest.approx(30.0)


def test_models_may_be_named_by_numbers(image_pairs):
    numbered = image_pairs.assign(
        model_id=image_pairs["model_id"].map({"1/2": 12, "2/3": 23, "3/4": 34})
    )
    length = pd.Series({12: 10.0, 23: 20.0, 34: 30.0})
    oriented = orient_from_images(numbered, C, base_length=length)
    assert oriented.parameters["bx"].loc[["12", "23"]].tolist() == [10.0, 20.0]
    assert oriented.covariance(12).equals(oriented.covariance("12"))


def test_base_by_coverage_and_model(image_pairs):
    both = pd.concat([image_pairs.assign(coverage=name) for name in "ab"])
    length = pd.Series({(c, m): 10.0 + 10.0 * (c == "b") for c in "ab" for m in TRUTH})
    oriented = orient_from_images(both, C, base_length=length)
    assert oriented.parameters["bx"].loc["1/2"].tolist() == [10.0, 20.0]


def test_residuals_and_points_have_a_row_per_point(image_pairs):
    oriented = orient_from_images(image_pairs, C)
    residuals = oriented.residuals
    keys = ["model_id", "point_id"]
    tests = ["redundancy_number", "weight", "w", "p_value", "is_suspect"]
    assert list(residuals.columns) == [*keys, *RESIDUALS, *tests]
    assert residuals[keys].equals(image_pairs[keys])
    squares = (residuals[RESIDUALS] ** 2).sum(axis=1)
    total = squares.groupby(residuals["model_id"]).sum()
    wanted = oriented.sigma_0**2 * oriented.redundancy
    np.testing.assert_allclose(total.loc[wanted.index], wanted, rtol=1e-6)
    numbers = residuals.groupby("model_id")["redundancy_number"].sum()
    np.testing.assert_allclose(numbers, 10.0)
    assert list(oriented.model_points.columns) == [*keys, "x", "y", "z"]
    assert (oriented.model_points["z"] < 0.0).all()


def test_rows_in_any_order_give_the_same(image_pairs):
    shuffled = image_pairs.sample(frac=1.0, random_state=4)
    one = orient_from_images(image_pairs, C)
    other = orient_from_images(shuffled, C)
    pd.testing.assert_frame_equal(
        other.parameters.loc[one.parameters.index], one.parameters, rtol=1e-9
    )
    keys = ["model_id", "point_id"]
    merged = one.model_points.merge(other.model_points, on=keys)
    assert len(merged) == len(image_pairs)
    np.testing.assert_allclose(merged["z_x"], merged["z_y"], rtol=1e-9)


def test_coverages_tell_models_apart(image_pairs):
    other = image_pairs.copy()
    noise = np.random.default_rng(1).normal(scale=5e-3, size=(len(other), 4))
    other[COORDINATES] += noise
    both = pd.concat([image_pairs.assign(coverage="a"), other.assign(coverage="b")])
    oriented = orient_from_images(both, C)
    assert oriented.models["coverage"].tolist() == ["a"] * 3 + ["b"] * 3
    for table in (oriented.residuals, oriented.model_points):
        assert list(table.columns[:3]) == ["coverage", "model_id", "point_id"]
    alone = orient_from_images(image_pairs, C)
    pd.testing.assert_frame_equal(
        oriented.covariance("1/2", coverage="a"), alone.covariance("1/2")
    )
    with pytest.raises(TableError, match="model 1/2: coverages a, b each have"):
        oriented.covariance("1/2")
    with pytest.raises(TableError, match="model 9/9: there is no such model"):
        oriented.cofactor("9/9")


def test_orientations_stand_in_one_table(image_pairs):
    oriented = orient_from_images(image_pairs, C)
    table = oriented.orientations
    assert table["model_id"].tolist() == list(TRUTH)
    assert table["case"].unique().tolist() == ["dependent_right"]
    np.testing.assert_array_equal(table["kappa"], oriented.parameters["kappa"])


@pytest.mark.parametrize("case", ["dependent_right", "dependent_left", "independent"])
def test_cases_describe_the_same_models(image_pairs, case):
    one = orient_from_images(image_pairs, C, base_length=92.0)
    other = orient_from_images(image_pairs, C, base_length=92.0, case=case)
    pd.testing.assert_series_equal(one.sigma_0, other.sigma_0)
    pd.testing.assert_frame_equal(one.residuals, other.residuals)
    names = other.covariance("1/2").columns
    assert list(names) == list(other.parameters.columns[1:])
    # distances between points, apart from the unit of the base
    for model_id in TRUTH:
        first, second = (
            points.loc[points["model_id"] == model_id, ["x", "y", "z"]].to_numpy()
            for points in (one.model_points, other.model_points)
        )
        ratio = (
            np.linalg.norm(second - second[0], axis=1)[1:]
            / np.linalg.norm(first - first[0], axis=1)[1:]
        )
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)


def test_determinants_are_another_estimate(image_pairs):
    rigorous = orient_from_images(image_pairs, C)
    other = orient_from_images(image_pairs, C, estimator="determinants")
    assert (other.sigma_0 >= rigorous.sigma_0).all()
    change = (other.parameters - rigorous.parameters).abs().to_numpy()
    assert 1e-9 < change.max() < 1e-3


def test_two_cameras(image_pairs):
    scaled = image_pairs.copy()
    scaled[["x_right", "y_right"]] *= 210.0 / C
    one = orient_from_images(image_pairs, C)
    other = orient_from_images(scaled, (C, 210.0))
    angles = ["omega", "phi", "kappa"]
    np.testing.assert_allclose(
        one.parameters[angles], other.parameters[angles], atol=1e-4
    )


# ------------------------------------------------------------------------- failures


def test_failed_models_are_rows(faulty_pairs):
    oriented = orient_from_images(faulty_pairs, C)
    failures = oriented.failures.set_index("model_id")
    assert list(failures.index) == ["2/3", "line"]
    assert failures["stage"].unique().tolist() == ["stage2_relative_orientation"]
    assert failures["coverage"].unique().tolist() == ["1"]
    few, line = failures["reason"]
    assert few == "4 points, but relative orientation needs 5"
    assert line == "its points lie in a line, in one place or near a dangerous surface"
    assert failures.loc["2/3", "remedy"].startswith("Measure at least six points")
    assert oriented.converged.to_dict() == {
        "2/3": False, "1/2": True, "line": False, "blunder": True
    }  # fmt: skip
    assert oriented.parameters.loc[["2/3", "line"]].isna().all(axis=None)
    assert oriented.sigma_0[["2/3", "line"]].isna().all()
    assert oriented.covariance("line").isna().all(axis=None)
    kept = {"1/2", "blunder"}
    assert set(oriented.residuals["model_id"]) == kept
    assert set(oriented.model_points["model_id"]) == kept
    assert oriented.residuals[RESIDUALS].notna().all(axis=None)


def test_a_gross_error_stands_out(faulty_pairs):
    oriented = orient_from_images(faulty_pairs, C)
    rows = oriented.residuals[oriented.residuals["model_id"] == "blunder"]
    size = np.sqrt((rows[RESIDUALS] ** 2).sum(axis=1) / rows["redundancy_number"])
    assert rows.loc[size.idxmax(), "point_id"] == "p3"


def test_confused_images_are_a_failure():
    rng = np.random.default_rng(3)
    nonsense = pd.DataFrame(rng.uniform(-90, 90, (12, 4)), columns=COORDINATES)
    nonsense = nonsense.assign(model_id="9/10", point_id=[str(k) for k in range(12)])
    oriented = orient_from_images(nonsense, C)
    assert len(oriented.failures) == 1
    assert oriented.failures["remedy"].iloc[0].startswith(("Look for", "Check that"))
    assert len(oriented.model_points) == 0


def test_a_missing_base_is_told_from_points_in_one_place(image_pairs):
    turned = image_pairs[image_pairs["model_id"] == "1/2"]
    rays = np.column_stack([turned[["x_left", "y_left"]], np.full(len(turned), -C)])
    rays = rays @ rotation_from_angles(0.05, -0.02, 0.3).T
    noise = np.random.default_rng(1).normal(scale=5e-3, size=(len(rays), 2))
    turned = turned.assign(model_id="no base")
    turned[["x_right", "y_right"]] = -C * rays[:, :2] / rays[:, 2:] + noise
    same = turned.assign(model_id="one place", x_left=1.0, y_left=2.0)
    same = same.assign(x_right=-80.0, y_right=2.0)
    table = pd.concat([turned, image_pairs, same])
    for case in ("dependent_right", "independent"):
        oriented = orient_from_images(table, C, case=case)
        reasons = oriented.failures.set_index("model_id")["reason"]
        assert reasons["no base"] == (
            "both photographs see its points as from one place: its base is too short"
        )
        assert reasons["one place"].startswith("its points lie in a line, in one place")
        assert oriented.dangerous_surface.loc["no base", "reason"] == reasons["no base"]
        assert len(reasons) == 2


@pytest.mark.parametrize("size", [1e5, 1e9, 1e29])
@pytest.mark.parametrize("outliers", ["keep", "snoop", "huber", "tukey"])
def test_a_point_far_outside_stops_nothing(image_pairs, size, outliers):
    image_pairs.loc[3, "x_right"] = size
    oriented = orient_from_images(image_pairs, C, outliers=outliers)
    assert oriented.converged[["2/3", "3/4"]].all()
    assert oriented.model_precision["sigma_z_image"].notna().any()
    assert len(oriented.summary()) > 0


def test_five_points_have_no_sigma(image_pairs):
    few = image_pairs.groupby("model_id", sort=False).head(5)
    oriented = orient_from_images(few, C)
    assert oriented.sigma_0.isna().all()
    assert (oriented.redundancy == 0).all()
    assert oriented.covariance("1/2").isna().all(axis=None)
    assert "fits about as well" in oriented.summary()


# ------------------------------------------------------------------------- messages


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.drop(columns="x_left"), "column 'x_left' is missing"),
        (
            lambda t: t.assign(y_left=np.nan),
            "y_left is missing; .* expected millimetres",
        ),
        (lambda t: pd.concat([t, t.head(1)]), "the row repeats row 0"),
        (
            lambda t: t.assign(**{name: t[name] / 0.006 for name in COORDINATES}),
            r"with a principal distance of 152; expected millim.* give pixels\?",
        ),
        (
            lambda t: t.assign(**{name: t[name] + 130.0 for name in COORDINATES}),
            r"none of them negative; expected .* Is the origin in a corner\?",
        ),
        (
            lambda t: t.assign(**{name: 4.0 * t[name] for name in COORDINATES}),
            r"points 7\d° away from the axis of the camera; expected points up to 63°",
        ),
        (
            lambda t: t.assign(**{name: t[name] / 1000.0 for name in COORDINATES}),
            r"Did you give metres\? Multiply them by 1000",
        ),
    ],
)
def test_what_is_wrong_with_the_table_is_said(image_pairs, change, message):
    with pytest.raises(EinschaltError, match=message):
        orient_from_images(change(image_pairs), C)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"case": "right"}, "case = 'right' is unknown; expected dependent_right or"),
        ({"outliers": "ransac"}, "outliers = 'ransac' is unknown; expected keep or sn"),
        ({"estimator": "best"}, "estimator = 'best' is unknown; expected rigorous or"),
        ({"principal_distance": 0.152}, r"= 0.152; expected .* Did you give metres\?"),
        ({"principal_distance": -152.0}, "principal_distance = -152.0; expected 1 to"),
        ({"principal_distance": (1.0, 2.0, 3.0)}, "one number or one for each side"),
        ({"case": ["independent"]}, r"case = \['independent'\] is unknown"),
        ({"principal_distance": "wide"}, "= 'wide'; expected millimetres"),
        ({"base_length": "long"}, "base_length = 'long'; expected millimetres"),
        (
            {"base_length": pd.Series("long", ["1/2", "2/3", "3/4"])},
            "model 1/2: base_length = nan; expected a positive length for every model",
        ),
        (
            {"base_length": pd.Series([1.0, 2.0], index=["1/2", "1/2"])},
            "model 1/2: base_length has the model twice; .* by coverage and model_id",
        ),
        ({"base_length": 0.0}, "model 1/2: base_length = 0.0; expected a positive"),
        (
            {"base_length": pd.Series({"1/2": 1.0, "2/3": 1.0})},
            "model 3/4: base_length = nan; expected a positive length for every model",
        ),
    ],
)
def test_what_is_wrong_with_an_argument_is_said(image_pairs, arguments, message):
    distance = arguments.pop("principal_distance", C)
    with pytest.raises(SettingsError, match=message):
        orient_from_images(image_pairs, distance, **arguments)


# -------------------------------------------------------------------------- summary


def test_print_is_the_summary(image_pairs, golden):
    oriented = orient_from_images(image_pairs, C)
    assert str(oriented) == repr(oriented) == oriented.summary()
    golden(oriented.summary() + "\n", "summary_image_orientation.txt")


def test_summary_says_what_is_doubtful(faulty_pairs, golden):
    oriented = orient_from_images(faulty_pairs, C)
    golden(oriented.summary() + "\n", "summary_image_orientation_faulty.txt")


def test_many_models_are_not_listed_one_by_one(image_pairs):
    many = pd.concat(
        [
            image_pairs.assign(model_id=image_pairs["model_id"] + f"-{k}")
            for k in range(9)
        ]
    )
    summary = orient_from_images(many, C).summary()
    assert "27 of 27 models" in summary
    assert len(summary.splitlines()) < 10


def test_summary_without_any_oriented_model(image_pairs):
    few = image_pairs.groupby("model_id", sort=False).head(4)
    summary = orient_from_images(few, C).summary()
    assert summary.startswith("Relative orientation of 0 of 3 models")
    assert "model 3/4: 4 points, but relative orientation needs 5" in summary


# ------------------------------------------------------------------ tests and blunders


def test_a_suspect_is_named(faulty_pairs):
    residuals = orient_from_images(faulty_pairs, C).residuals
    suspects = residuals[residuals["is_suspect"]]
    assert suspects[["model_id", "point_id"]].to_numpy().tolist() == [["blunder", "p3"]]
    assert suspects["p_value"].item() < 1e-4
    assert (residuals["weight"] == 1.0).all()


def test_suspects_are_taken_out(faulty_pairs, image_pairs):
    oriented = orient_from_images(faulty_pairs, C, outliers="snoop")
    assert oriented.n_points["blunder"] == 14
    assert oriented.sigma_0["blunder"] < 9e-3
    is_it = (faulty_pairs["model_id"] == "blunder") & (faulty_pairs["point_id"] == "p3")
    without = orient_from_images(faulty_pairs[~is_it], C)
    pd.testing.assert_frame_equal(oriented.parameters, without.parameters)
    pd.testing.assert_frame_equal(oriented.model_points, without.model_points)
    row = oriented.residuals.set_index(["model_id", "point_id"]).loc[("blunder", "p3")]
    assert row["is_suspect"]
    assert np.isnan(row["weight"])
    assert row["redundancy_number"] == 1.0
    # the millimetre is shared among the coordinates: a half to y of each photograph
    missed = np.linalg.norm(row[RESIDUALS].astype(float))
    assert 0.5 < missed < 1.0
    assert row["w"] > 40.0
    good = orient_from_images(image_pairs, C, outliers="snoop")
    plain = orient_from_images(image_pairs, C)
    pd.testing.assert_frame_equal(good.parameters, plain.parameters)


@pytest.mark.parametrize("norm", ["huber", "tukey"])
def test_suspects_get_less_weight(faulty_pairs, image_pairs, norm):
    oriented = orient_from_images(faulty_pairs, C, outliers=norm)
    assert oriented.n_points["blunder"] == 15
    row = oriented.residuals.set_index(["model_id", "point_id"]).loc[("blunder", "p3")]
    assert row["weight"] < 0.05
    assert row["is_suspect"]
    snooped = orient_from_images(faulty_pairs, C, outliers="snoop")
    columns = ["w", "p_value", "is_suspect"]
    pd.testing.assert_frame_equal(
        oriented.residuals[columns], snooped.residuals[columns]
    )
    angles = ["omega", "phi", "kappa"]
    apart = oriented.parameters[angles] - snooped.parameters[angles]
    kept = orient_from_images(faulty_pairs, C).parameters[angles]
    covariance = snooped.covariance("blunder").loc[angles, angles]
    sigma = np.sqrt(np.diag(covariance))
    assert (apart.loc["blunder"].abs() < sigma).all()
    spoilt = (kept - snooped.parameters[angles]).loc["blunder"].abs()
    assert (spoilt > 3.0 * sigma).any()
    assert "blunder p3. They have less weight" in " ".join(oriented.summary().split())
    with pytest.raises(SettingsError, match="weights, which the determinants do not"):
        orient_from_images(image_pairs, C, estimator="determinants", outliers=norm)


@pytest.mark.parametrize("norm", ["huber", "tukey"])
def test_robust_weights_change_no_test_of_clean_points(image_pairs, norm):
    kept, robust = (
        orient_from_images(image_pairs, C, outliers=way).residuals
        for way in ("keep", norm)
    )
    assert not kept["is_suspect"].any()
    assert (robust["weight"] < 1.0).any()
    columns = ["w", "p_value", "is_suspect"]
    pd.testing.assert_frame_equal(robust[columns], kept[columns])


def test_summary_names_what_was_taken_out(faulty_pairs):
    said = orient_from_images(faulty_pairs, C, outliers="snoop").summary()
    assert "blunder p3. They were taken out: measure them" in " ".join(said.split())


# ----------------------------------------------------------- precision of model points


@pytest.mark.parametrize("case", ["dependent_right", "dependent_left", "independent"])
def test_precision_of_model_points(image_pairs, case):
    oriented = orient_from_images(image_pairs, C, base_length=92.0, case=case)
    precision = oriented.model_precision
    keys = ["model_id", "point_id"]
    names = ["sigma_x", "sigma_y", "sigma_z"]
    assert list(precision.columns) == [*keys, *names, "sigma_z_image", "base_to_height"]
    assert precision[keys].equals(oriented.model_points[keys])
    assert (precision["sigma_z_image"] < precision["sigma_z"]).all()
    # 130 to 170 mm below a base of about 92 mm, seen askew by up to 60 mm
    assert precision["base_to_height"].between(0.45, 0.75).all()
    for model_id in TRUTH:
        covariance = oriented.model_covariance(model_id)
        assert covariance.index.equals(covariance.columns)
        assert covariance.index[1] == ("p0", "y")
        own = precision.loc[precision["model_id"] == model_id, names]
        np.testing.assert_allclose(np.sqrt(np.diag(covariance)), own.to_numpy().ravel())


def test_covariance_of_an_unknown_model(image_pairs):
    with pytest.raises(TableError, match="model 9: there is no such model"):
        orient_from_images(image_pairs, C).model_covariance("9")


def test_models_that_failed_have_no_precision(faulty_pairs):
    oriented = orient_from_images(faulty_pairs, C)
    assert len(oriented.model_precision) == 30
    assert oriented.model_precision.notna().all().all()
    assert oriented.model_covariance("line").shape == (0, 0)


def test_rays_that_do_not_meet_have_a_reason(image_pairs):
    is_wrong = image_pairs["model_id"] == "1/2"
    noise = np.random.default_rng(4).normal(scale=0.4, size=(is_wrong.sum(), 2))
    image_pairs.loc[is_wrong, ["x_right", "y_right"]] += noise
    oriented = orient_from_images(image_pairs, C)
    surfaces = oriented.dangerous_surface
    assert oriented.converged["1/2"]
    assert oriented.sigma_0["1/2"] > 0.1
    assert "no measuring is so poor" in surfaces.loc["1/2", "reason"]
    assert (surfaces.drop("1/2")["reason"] == "").all()
    said = " ".join(oriented.summary().split())
    assert "model 1/2: sigma_0 is above 0.1 mm" in said


def test_exchanged_images_have_a_reason(image_pairs):
    left, right = ["x_left", "y_left"], ["x_right", "y_right"]
    is_wrong = image_pairs["model_id"] == "1/2"
    image_pairs.loc[is_wrong, left + right] = image_pairs.loc[
        is_wrong, right + left
    ].to_numpy()
    surfaces = orient_from_images(image_pairs, C).dangerous_surface
    assert "left and right image are exchanged" in surfaces.loc["1/2", "reason"]
    assert (surfaces.drop("1/2")["reason"] == "").all()
