from dataclasses import FrozenInstanceError

import numpy as np
import pandas as pd
import pytest
from pyproj import Transformer

import einschalt as es
from einschalt.foundations.errors import BlockError, SettingsError, TableError
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.stages import transformation_kinds
from einschalt.theory.transformation import sensitivity

KINDS = ["affine", "helmert", "rigid", "helmert_3d"]
PLAN = ["easting", "northing"]


@pytest.fixture(scope="module")
def ground():
    """Forty points of a 2 km square, with heights."""
    rng = np.random.default_rng(100)
    en = np.array([4.5e6, 5.3e6]) + rng.uniform(0.0, 2000.0, (40, 2))
    table = pd.DataFrame(en.round(3), columns=PLAN)
    names = [f"{place:04d}" for place in range(39)]
    return table.assign(height=rng.uniform(400, 500, 40), point_id=[*names, "7/8"])


def model_of(ground, model_id, rows, *, seed=0, scale=0.4, noise=0.02, **columns):
    """A model of some points: turned, at another scale, from another origin."""
    rng = np.random.default_rng(seed)
    points = ground.iloc[rows]
    centred = points[[*PLAN, "height"]].to_numpy() - [4.501e6, 5.301e6, 450.0]
    angles = rng.normal(0.0, 1e-4, 2)  # levelled, but for what noise leaves
    rotation = rotation_from_angles(*angles, rng.uniform(-3, 3))
    xyz = scale * centred @ rotation.T + rng.uniform(-100, 100, 3)
    xyz += rng.normal(0.0, noise * scale, xyz.shape) if noise else 0.0
    frame = pd.DataFrame(xyz, columns=["x", "y", "z"])
    return frame.assign(
        model_id=model_id, point_id=points["point_id"].to_numpy(), **columns
    )


@pytest.fixture(scope="module")
def flight(ground):
    """Three models of 12 points, neighbours sharing points."""
    parts = [
        model_of(ground, f"{k}/{k + 1}", range(8 * k, 8 * k + 12), seed=k)
        for k in range(1, 4)
    ]
    return pd.concat(parts, ignore_index=True)


def unit_scale(flight, kind):
    """The flight at the scale of the ground, where the kind holds it."""
    columns = ["x", "y", "z"]
    factor = 2.5 if kind == "rigid" else 1.0
    return flight.assign(**{c: factor * flight[c] for c in columns})


@pytest.fixture(params=KINDS)
def fitted(request, flight, ground):
    """The flight, and its transformation, of every kind in turn."""
    points = unit_scale(flight, request.param)
    return points, es.transform_models(points, ground, kind=request.param)


# tables


def test_affine_is_the_formula_that_is_promised(flight, ground):
    fit = es.transform_models(flight, ground)
    assert fit.kind == "affine"
    assert fit.parameters.index.name == "model_id"
    assert fit.parameters.columns.tolist() == ["a0", "a1", "a2", "b0", "b1", "b2"]
    p = fit.parameters.loc[flight["model_id"]].reset_index(drop=True)
    found = fit.transform(flight)
    east = p["a0"] + p["a1"] * flight["x"] + p["a2"] * flight["y"]
    north = p["b0"] + p["b1"] * flight["x"] + p["b2"] * flight["y"]
    np.testing.assert_allclose(found["easting"], east, rtol=0, atol=1e-7)
    np.testing.assert_allclose(found["northing"], north, rtol=0, atol=1e-7)


def test_helmert_is_the_formula_that_is_promised(flight, ground):
    fit = es.transform_models(flight, ground, kind="helmert")
    assert fit.parameters.columns.tolist() == ["a", "b", "te", "tn"]
    p = fit.parameters.loc[flight["model_id"]].reset_index(drop=True)
    found = fit.transform(flight)
    east = p["a"] * flight["x"] - p["b"] * flight["y"] + p["te"]
    north = p["b"] * flight["x"] + p["a"] * flight["y"] + p["tn"]
    np.testing.assert_allclose(found["easting"], east, rtol=0, atol=1e-7)
    np.testing.assert_allclose(found["northing"], north, rtol=0, atol=1e-7)


def test_tables_of_models_and_residuals(fitted, ground):
    points, fit = fitted
    assert fit.models["model_id"].tolist() == ["1/2", "2/3", "3/4"]
    assert fit.models["transformation"].eq(fit.kind).all()
    assert fit.models["n_points"].tolist() == [12, 12, 12]
    assert fit.models["is_usable"].all()
    assert fit.models["reason"].eq("").all()
    np.testing.assert_allclose(fit.models["m_0"], np.sqrt(2) * fit.models["s_0"])
    # noise 2 cm a coordinate on the ground; s_0 of r = 18 … 29 within ± 60 %
    assert fit.models["s_0"].between(0.008, 0.035).all()
    assert len(fit.residuals) == 36
    assert len(fit.failures) == 0
    transformed = fit.transform(points).merge(
        ground, on="point_id", suffixes=("", "_given")
    )
    both = fit.residuals.merge(transformed, on=["model_id", "point_id"])
    for name in PLAN:
        off = both[name] - both[f"{name}_given"]
        np.testing.assert_allclose(both[f"residual_{name}"], off, rtol=0, atol=3e-9)
    np.testing.assert_allclose(
        fit.residuals["leverage"] + fit.residuals["redundancy_number"], 1.0
    )


def test_redundancy_numbers_of_plane_models_sum_to_half_the_redundancy(flight, ground):
    # they are means of easting and northing
    fit = es.transform_models(flight, ground)
    total = fit.residuals.groupby("model_id")["redundancy_number"].sum()
    np.testing.assert_allclose(total, fit.models["redundancy"] / 2, rtol=1e-9)


def test_result_is_frozen_and_prints_its_summary(fitted):
    _, fit = fitted
    assert str(fit) == repr(fit) == fit.summary()
    with pytest.raises(FrozenInstanceError):
        fit.kind = "affine"


def test_summary(flight, ground):
    fit = es.transform_models(flight, ground.iloc[:22])
    lines = fit.summary().splitlines()
    # points 0 to 21: all of model 1/2, six of 2/3, none of 3/4
    assert lines[0] == (
        "affine transformation of 2 of 3 models, 18 points, redundancy 24"
    )
    assert lines[1] == f"m_0 (total, all models together)  {fit.m_0:.4f} m"
    assert lines[2].startswith("m_0 of single models  0.0")
    assert "1 model failed:" in lines
    assert "no common points, but affine needs 3" in lines[-1]


# names


def test_names_are_text_as_given(ground):
    rows = range(34, 40)
    one = model_of(ground, "12", rows, seed=1)
    two = model_of(ground, "0012", rows, seed=2)
    fit = es.transform_models(pd.concat([one, two], ignore_index=True), ground)
    assert fit.parameters.index.tolist() == ["12", "0012"]
    assert "7/8" in fit.residuals["point_id"].tolist()
    assert "0038" in fit.residuals["point_id"].tolist()
    single = es.transform_models(two, ground)
    np.testing.assert_array_equal(
        fit.parameters.loc["0012"], single.parameters.loc["0012"]
    )


def test_point_12_is_not_point_0012(ground):
    model = model_of(ground, "1", range(10, 16))
    other = model.assign(point_id=model["point_id"].str.lstrip("0"))
    fit = es.transform_models(other, ground)
    assert fit.models["n_points"].tolist() == [0]
    assert fit.failures["reason"].tolist() == ["no common points, but affine needs 3"]


def test_whole_numbers_serve_as_names():
    model = pd.DataFrame(
        {"model_id": 5, "point_id": [1, 2, 3], "x": [0, 1, 0], "y": [0, 0, 1]}
    )
    ground = pd.DataFrame(
        {"point_id": [1.0, 2.0, 3.0], "easting": [5, 7, 5], "northing": [5, 5, 7]}
    )
    fit = es.transform_models(model, ground)
    assert fit.parameters.index.tolist() == ["5"]
    assert fit.covariance(5).shape == (6, 6)


def test_model_of_one_name_in_two_coverages(ground):
    first = model_of(ground, "7/8", range(12), seed=1, coverage="1")
    second = model_of(ground, "7/8", range(6, 20), seed=2, coverage="2")
    both = pd.concat([first, second], ignore_index=True)
    fit = es.transform_models(both, ground)
    assert fit.models["coverage"].tolist() == ["1", "2"]
    assert fit.models["n_points"].tolist() == [12, 14]
    for coverage, part in (("1", first), ("2", second)):
        alone = es.transform_models(part, ground)
        np.testing.assert_array_equal(
            fit.cofactor("7/8", coverage), alone.cofactor("7/8")
        )
        np.testing.assert_array_equal(
            fit.covariance("7/8", coverage), alone.covariance("7/8", coverage)
        )
        rows = both["coverage"] == coverage
        pd.testing.assert_frame_equal(
            fit.transform(both)[rows].reset_index(drop=True),
            alone.transform(part),
        )
        assert fit.proj_pipeline("7/8", coverage) == alone.proj_pipeline("7/8")
    with pytest.raises(TableError, match="coverages 1, 2 each have this model"):
        fit.covariance("7/8")
    with pytest.raises(TableError, match="model 9/9: there is no such model"):
        fit.cofactor("9/9")


# order and mixture


def test_order_of_rows_is_irrelevant(fitted, ground):
    points, fit = fitted
    shuffled = points.sample(frac=1.0, random_state=1)
    again = es.transform_models(
        shuffled, ground.sample(frac=1.0, random_state=2), kind=fit.kind
    )
    there = fit.transform(points)
    here = again.transform(points)
    names = [c for c in ("easting", "northing", "height") if c in there]
    np.testing.assert_allclose(here[names], there[names], rtol=0, atol=2e-9)
    np.testing.assert_allclose(here["m_t"], there["m_t"], rtol=1e-6)
    # transformed points keep the rows and the index of what was asked
    moved = again.transform(shuffled)
    assert moved.index.tolist() == shuffled.index.tolist()
    assert moved["point_id"].tolist() == shuffled["point_id"].tolist()


def test_points_without_partner_take_no_part(flight, ground):
    fit = es.transform_models(flight, ground)
    fewer = ground[ground["point_id"] != "0010"]
    without = es.transform_models(flight, fewer)
    assert without.models["n_points"].tolist() == [11, 12, 12]
    assert "0010" not in without.residuals["point_id"].tolist()
    # but they are transformed
    moved = without.transform(flight)
    assert moved["easting"].notna().all()
    more = pd.concat([ground, ground.assign(point_id=ground["point_id"] + "x")])
    again = es.transform_models(flight, more.reset_index(drop=True))
    pd.testing.assert_frame_equal(again.parameters, fit.parameters)


def test_columns_that_are_not_needed_are_ignored(flight, ground):
    fit = es.transform_models(flight.drop(columns="z"), ground[["point_id", *PLAN]])
    more = es.transform_models(
        flight.assign(remark="good", n_settings=2), ground.assign(role="control")
    )
    pd.testing.assert_frame_equal(fit.parameters, more.parameters)


# failures


def faulty_flight(ground):
    """A good model among a short one, an empty one, a line, a heap, a mirror image."""
    good = model_of(ground, "good", range(12), seed=1)
    one = model_of(ground, "one", [3], seed=2)
    two = model_of(ground, "two", [3, 4], seed=2)
    none = model_of(ground, "none", range(5), seed=3).assign(
        point_id=list("abcde"),
    )
    line = model_of(ground, "line", range(6), seed=4)
    line["y"] = 0.5 * line["x"] + 3.0
    heap = model_of(ground, "heap", range(6), seed=5).assign(x=1.0, y=2.0)
    mirror = model_of(ground, "mirror", range(8), seed=6)
    mirror["x"] *= -1.0
    parts = [one, none, good, line, two, heap, mirror]
    return pd.concat(parts, ignore_index=True)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        (
            "affine",
            {
                "one": "1 common point, but affine needs 3",
                "none": "no common points, but affine needs 3",
                "line": (
                    "its points lie on a line or in one place, but affine needs "
                    "three off a line"
                ),
                "two": "2 common points, but affine needs 3",
                "heap": (
                    "its points lie on a line or in one place, but affine needs "
                    "three off a line"
                ),
            },
        ),
        (
            "helmert",
            {
                "one": "1 common point, but helmert needs 2",
                "none": "no common points, but helmert needs 2",
                "heap": (
                    "its points lie on a line or in one place, but helmert needs "
                    "two apart"
                ),
                "mirror": "the model is a mirror image of the ground",
            },
        ),
        (
            "rigid",
            {
                "one": "1 common point, but rigid needs 2",
                "none": "no common points, but rigid needs 2",
                "heap": (
                    "its points lie on a line or in one place, but rigid needs "
                    "two apart"
                ),
                "mirror": "the model is a mirror image of the ground",
            },
        ),
    ],
)
def test_models_that_fail_are_rows_with_reason_and_remedy(ground, kind, expected):
    fit = es.transform_models(unit_scale(faulty_flight(ground), kind), ground, kind)
    failures = fit.failures.set_index("model_id")
    assert failures["reason"].to_dict() == expected
    assert failures["stage"].eq("stage3_model_transformation").all()
    for model_id, remedy in failures["remedy"].items():
        reason = expected[model_id]
        if model_id == "mirror":
            assert remedy == "Exchange easting and northing, or turn the sign of x"
        elif kind == "affine" and reason.startswith(("2 common", "its points lie")):
            assert remedy == "Transform with helmert, or merge it with its neighbour"
        else:
            assert remedy == (
                "Measure more common points in it, or merge it with its neighbour"
            )
    models = fit.models.set_index("model_id")
    assert (~models["is_usable"]).sum() == len(expected)
    assert models["reason"].loc[list(expected)].to_dict() == expected


@pytest.mark.parametrize("kind", ["affine", "helmert", "rigid"])
def test_models_that_fail_do_not_touch_the_others(ground, kind):
    flight = unit_scale(faulty_flight(ground), kind)
    fit = es.transform_models(flight, ground, kind)
    good = flight[flight["model_id"] == "good"].reset_index(drop=True)
    alone = es.transform_models(good, ground, kind)
    np.testing.assert_array_equal(
        fit.parameters.loc["good"], alone.parameters.loc["good"]
    )
    failed = fit.failures["model_id"]
    assert fit.parameters.loc[failed].isna().all(axis=None)
    assert not fit.residuals["model_id"].isin(failed).any()
    moved = fit.transform(flight).set_index("model_id")
    assert moved.loc[failed, [*PLAN, "m_t"]].isna().all(axis=None)
    np.testing.assert_allclose(
        moved.loc["good", PLAN], alone.transform(good)[PLAN], rtol=0, atol=0
    )
    back = fit.inverse(fit.transform(flight).fillna(0.0)).set_index("model_id")
    assert back.loc[failed, ["x", "y"]].isna().all(axis=None)
    # a model that is turned over does not spoil what all have in common
    lasting = ~fit.models["model_id"].isin(failed)
    assert fit.m_0 == pytest.approx(
        np.sqrt(
            2
            * fit.fit.sum_of_squares[lasting].sum()
            / fit.fit.redundancy[lasting].sum()
        )
    )
    with pytest.raises(TableError, match=r"model heap: it has no transformation; exp"):
        fit.proj_pipeline("heap")


@pytest.mark.parametrize("kind", ["affine", "helmert", "rigid", "helmert_3d"])
def test_ground_points_in_one_place_are_a_failure(ground, kind):
    """A perfect fit of scale 0 was told, and its inverse was NaN."""
    good = model_of(ground, "good", range(9), seed=1)
    heap = model_of(ground, "heap", [9, 10, 11, 12, 13], seed=2)
    flight = unit_scale(pd.concat([good, heap], ignore_index=True), kind)
    place = ground.iloc[9][[*PLAN, "height"]].to_list()
    same = ground.copy()
    same.loc[range(9, 14), [*PLAN, "height"]] = place
    fit = es.transform_models(flight, same, kind)
    row = fit.failures.set_index("model_id").loc["heap"]
    assert row["reason"] == "all of its points have the same ground coordinates"
    assert row["remedy"] == "Give each ground point its own coordinates"
    assert fit.models["is_usable"].tolist() == [True, False]


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1])
def test_affine_onto_a_line_has_no_inverse(ground, turn):
    model = model_of(ground, "flat", range(9), seed=1)
    along = ground["easting"] - ground["easting"].mean()
    line = ground.assign(
        easting=5e6 + np.cos(turn) * along, northing=5e6 + np.sin(turn) * along
    )
    fit = es.transform_models(model, line)
    assert fit.is_usable
    moved = fit.transform(model)
    assert np.isfinite(moved[PLAN]).all(axis=None)
    assert fit.inverse(moved)[["x", "y"]].isna().all(axis=None)


def test_mirror_image_has_no_pipeline(ground):
    fit = es.transform_models(faulty_flight(ground), ground, "helmert")
    with pytest.raises(TableError, match="model mirror: it has no transformation"):
        fit.proj_pipeline("mirror")


def test_spatial_model_on_a_line_and_turned_inside_out(ground):
    good = model_of(ground, "good", range(9), seed=1)
    line = model_of(ground, "line", range(5), seed=2)
    line[["y", "z"]] = 0.0
    mirror = model_of(ground, "mirror", range(12), seed=3, noise=0.0)
    mirror["x"] *= -1.0
    fit = es.transform_models(
        pd.concat([line, good, mirror], ignore_index=True), ground, "helmert_3d"
    )
    reasons = fit.failures.set_index("model_id")["reason"]
    assert reasons["line"] == (
        "its points lie on a line or in one place, but helmert_3d needs "
        "three off a line"
    )
    assert reasons["mirror"] == "the model is a mirror image of the ground"
    assert fit.is_usable


def test_a_model_in_space_is_not_to_be_merged_with_its_neighbour(ground):
    """Nobody can merge models of photographs, of which 18 of 35 were told so."""
    both = [
        model_of(ground, "few", range(2), seed=1),
        model_of(ground, "good", range(9), seed=1),
    ]
    fit = es.transform_models(pd.concat(both), ground, "helmert_3d")
    assert fit.failures["remedy"].tolist() == [
        "Measure more common points in it, or determine more control points there"
    ]


def test_not_one_model_usable_is_no_exception(ground):
    fit = es.transform_models(model_of(ground, "one", [3]), ground)
    assert not fit.is_usable
    assert np.isnan(fit.m_0)
    assert len(fit.residuals) == 0
    assert "0 of 1 models" in fit.summary()


# minimal models


def test_minimal_model_has_coordinates_but_no_precision(ground):
    few = model_of(ground, "few", range(3), seed=1)
    many = model_of(ground, "many", range(12), seed=2)
    flight = pd.concat([few, many], ignore_index=True)
    fit = es.transform_models(flight, ground)
    models = fit.models.set_index("model_id")
    assert models.loc["few", "redundancy"] == 0
    assert models.loc["few", "is_usable"]
    assert np.isnan(models.loc["few", ["m_0", "s_0"]].astype(float)).all()
    assert fit.covariance("few").isna().all(axis=None)
    assert fit.cofactor("few").notna().all(axis=None)
    moved = fit.transform(flight).set_index("model_id")
    assert moved.loc["few", PLAN].notna().all(axis=None)
    assert moved.loc["few", "m_t"].isna().all()
    # among the values of a block it has the m_0 of all models together
    values = fit.values(flight).set_index("model_id")
    np.testing.assert_allclose(values.loc["few", "m_t"], fit.m_0, rtol=1e-9)
    np.testing.assert_array_equal(values.loc["many", "m_t"], moved.loc["many", "m_t"])


def test_models_that_are_hardly_checked_may_take_the_m_0_of_all(ground):
    few = model_of(ground, "few", range(5), seed=1)
    many = model_of(ground, "many", range(25), seed=2)
    flight = pd.concat([few, many], ignore_index=True)
    fit = es.transform_models(flight, ground)
    own = fit.transform(flight).set_index("model_id")["m_t"]
    found = fit.values(flight, least_redundancy=30).set_index("model_id")["m_t"]
    m_0 = fit.models.set_index("model_id")["m_0"]
    np.testing.assert_allclose(found["few"], own["few"] * fit.m_0 / m_0["few"])
    np.testing.assert_array_equal(found["many"], own["many"])


# precision


def test_covariance_is_that_of_unit_weight_times_the_cofactors(fitted):
    _, fit = fitted
    s_0 = fit.models.set_index("model_id").loc["2/3", "s_0"]
    covariance, cofactor = fit.covariance("2/3"), fit.cofactor("2/3")
    names = fit.parameters.columns.tolist()
    assert covariance.index.tolist() == covariance.columns.tolist() == names
    np.testing.assert_allclose(covariance, s_0**2 * cofactor, rtol=1e-12)
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9, atol=1e-15)
    size = np.sqrt(np.diag(cofactor))
    assert (np.linalg.eigvalsh(cofactor / np.outer(size, size)) > -1e-9).all()


def test_error_of_a_point_is_m_0_times_the_root_of_its_leverage(flight, ground):
    for kind in ("affine", "helmert"):
        fit = es.transform_models(flight, ground, kind)
        moved = fit.transform(flight).merge(fit.residuals, on=["model_id", "point_id"])
        m_0 = fit.models.set_index("model_id").loc[moved["model_id"], "m_0"]
        wanted = m_0.to_numpy() * np.sqrt(moved["leverage"])
        np.testing.assert_allclose(moved["m_t"], wanted, rtol=1e-9)


# weights


def test_weights_may_come_in_either_table_as_series_or_as_array(flight, ground):
    rng = np.random.default_rng(5)
    of_point = pd.Series(rng.uniform(0.5, 2.0, 40), index=ground["point_id"])
    of_row = flight["point_id"].map(of_point)
    wanted = es.transform_models(flight, ground, weights=of_row.to_numpy())
    plain = es.transform_models(flight, ground)
    assert not np.allclose(wanted.models["s_0"], plain.models["s_0"])
    for fit in (
        es.transform_models(flight, ground, weights=of_point),
        es.transform_models(flight, ground, weights=of_row.tolist()),
        es.transform_models(flight.assign(weight=of_row), ground),
        es.transform_models(flight, ground.assign(weight=of_point.to_numpy())),
        es.transform_models(
            flight.assign(weight=np.sqrt(of_row)),
            ground.assign(weight=np.sqrt(of_point.to_numpy())),
        ),
        es.transform_models(flight.assign(weight=of_row), ground, weights=np.ones(36)),
    ):
        np.testing.assert_allclose(fit.parameters, wanted.parameters, rtol=1e-9)
        np.testing.assert_allclose(fit.models["s_0"], wanted.models["s_0"], rtol=1e-6)


def test_weights_belong_to_rows_in_whatever_order(flight, ground):
    rng = np.random.default_rng(6)
    weights = rng.uniform(0.5, 2.0, len(flight))
    order = rng.permutation(len(flight))
    fit = es.transform_models(flight, ground, weights=weights)
    again = es.transform_models(flight.iloc[order], ground, weights=weights[order])
    np.testing.assert_allclose(
        again.parameters.loc[fit.parameters.index], fit.parameters, rtol=1e-9
    )


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_weight_of_an_observation_must_be_positive(flight, ground, bad):
    weights = np.ones(len(flight))
    weights[5] = bad
    named = rf"point 0013, model 1/2: weight {bad} of an observation; expected a pos"
    with pytest.raises(TableError, match=named):
        es.transform_models(flight, ground, weights=weights)
    of_point = pd.Series(1.0, index=ground["point_id"])
    of_point["0013"] = bad
    with pytest.raises(TableError, match=named):
        es.transform_models(flight, ground, weights=of_point)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan])
def test_weight_column_must_be_positive(flight, ground, bad):
    weighted = flight.assign(weight=1.0)
    weighted.loc[5, "weight"] = bad
    named = r"model_points, row 5, point 0013, model 1/2: weight"
    with pytest.raises(TableError, match=named):
        es.transform_models(weighted, ground)
    given = ground.assign(weight=1.0)
    given.loc[13, "weight"] = bad
    with pytest.raises(TableError, match=r"ground_points, row 13, point 0013: weight"):
        es.transform_models(flight, given)


def test_point_that_a_series_of_weights_leaves_out(flight, ground):
    of_point = pd.Series(1.0, index=ground["point_id"]).drop("0013")
    with pytest.raises(TableError, match="point 0013, model 1/2: weight nan"):
        es.transform_models(flight, ground, weights=of_point)


def test_weight_of_a_point_without_partner_is_not_asked_for(flight, ground):
    fewer = ground[ground["point_id"] != "0013"]
    of_point = pd.Series(1.0, index=fewer["point_id"])
    fit = es.transform_models(flight, fewer, weights=of_point)
    assert fit.is_usable


def test_weights_that_belong_to_nothing(flight, ground):
    with pytest.raises(TableError, match=r"weights has the shape \(3,\); expected one"):
        es.transform_models(flight, ground, weights=[1.0, 2.0, 3.0])
    twice = pd.Series([1.0, 2.0], index=["0013", "0013"])
    with pytest.raises(TableError, match="point 0013: weights has several rows for it"):
        es.transform_models(flight, ground, weights=twice)


# what is refused


def test_unknown_kind(flight, ground):
    with pytest.raises(SettingsError, match=r"kind = 'afine' is unknown; expected aff"):
        es.transform_models(flight, ground, kind="afine")


def test_missing_columns(flight, ground):
    with pytest.raises(TableError, match="model_points: column 'x' is missing"):
        es.transform_models(flight.rename(columns={"x": "X_mm"}), ground)
    with pytest.raises(TableError, match="ground_points: column 'northing' is miss"):
        es.transform_models(flight, ground.drop(columns="northing"))
    with pytest.raises(TableError, match="model_points: column 'z' is missing"):
        es.transform_models(flight.drop(columns="z"), ground, kind="helmert_3d")
    with pytest.raises(TableError, match="ground_points: column 'height' is missing"):
        es.transform_models(flight, ground.drop(columns="height"), kind="helmert_3d")


def test_value_that_is_no_number(flight, ground):
    wrong = flight.astype({"x": object})
    wrong.loc[4, "x"] = "n/a"
    with pytest.raises(
        TableError, match=r"model_points, row 4, point 0012, model 1/2: x 'n/a'"
    ):
        es.transform_models(wrong, ground)


def test_point_twice_in_a_model(flight, ground):
    twice = pd.concat([flight, flight.iloc[[3, 20]]], ignore_index=True)
    with pytest.raises(BlockError, match=r"row 36, point 0011, model 1/2: the row rep"):
        es.transform_models(twice, ground)


def test_model_that_was_not_fitted(flight, ground):
    fit = es.transform_models(flight[flight["model_id"] != "2/3"], ground)
    named = "model 2/3: the model was not fitted"
    with pytest.raises(TableError, match=named):
        fit.transform(flight)
    with pytest.raises(TableError, match=named):
        fit.inverse(flight.assign(easting=0.0, northing=0.0))


@pytest.fixture
def fit_of_coverages(ground):
    """Model 7/8 in coverages 1 and 2, that of 1 only in 1, that of 2 only in 2."""
    parts = [
        model_of(ground, name, range(12), seed=seed, coverage=coverage)
        for seed, (name, coverage) in enumerate(
            [("7/8", "1"), ("one", "1"), ("7/8", "2"), ("two", "2")]
        )
    ]
    points = pd.concat(parts, ignore_index=True)
    return points, es.transform_models(points, ground)


@pytest.mark.parametrize("name", ["transform", "inverse", "values"])
def test_points_without_coverage_of_a_model_in_several(fit_of_coverages, name):
    points, fit = fit_of_coverages
    asked = points.assign(easting=0.0, northing=0.0)[points["coverage"] == "2"]
    said = (
        "model 7/8: coverages 1, 2 each have this model; expected a column coverage, "
        "which says of each point which of them is meant. Add it to the table."
    )
    with pytest.raises(TableError) as caught:
        getattr(fit, name)(asked.drop(columns="coverage"))
    assert str(caught.value) == said


@pytest.mark.parametrize("name", ["transform", "inverse", "values"])
def test_points_without_coverage_are_in_that_of_their_model(fit_of_coverages, name):
    points, fit = fit_of_coverages
    points = points.assign(easting=3.0e4, northing=2.0e4)
    asked = points[points["model_id"].isin(["two", "one"])].iloc[::-1]
    whole = getattr(fit, name)(asked)
    assert whole["coverage"].tolist() == ["2"] * 12 + ["1"] * 12
    pd.testing.assert_frame_equal(
        getattr(fit, name)(asked.drop(columns="coverage")), whole
    )


def test_points_without_coverage_of_no_model(fit_of_coverages):
    points, fit = fit_of_coverages
    asked = points.drop(columns="coverage").assign(model_id="9/9").iloc[:12]
    with pytest.raises(TableError, match="model 9/9: the model was not fitted"):
        fit.transform(asked)


# there and back


def test_inverse_leads_back(fitted):
    points, fit = fitted
    back = fit.inverse(fit.transform(points))
    names = [name for name in ("x", "y", "z") if name in back]
    np.testing.assert_allclose(back[names], points[names], rtol=0, atol=1e-8)
    assert back["point_id"].tolist() == points["point_id"].tolist()
    assert "coverage" not in back


def test_pipeline_says_the_same_to_proj(fitted):
    points, fit = fitted
    model = points[points["model_id"] == "2/3"]
    wanted = fit.transform(model)
    names = [name for name in ("easting", "northing", "height") if name in wanted]
    source = [model[c].to_numpy() for c in ("x", "y", "z")[: len(names)]]
    found = Transformer.from_pipeline(fit.proj_pipeline("2/3")).transform(*source)
    np.testing.assert_allclose(np.column_stack(found), wanted[names], rtol=0, atol=1e-6)


@pytest.mark.parametrize("kind", transformation_kinds.TRANSFORMATION_KINDS)
def test_every_kind_has_its_sensitivity(ground, kind):
    """What propagates errors must know every kind that can be fitted."""
    fit = es.transform_models(unit_scale(faulty_flight(ground), kind), ground, kind).fit
    axes = len(transformation_kinds.TRANSFORMATION_KINDS[kind].target)
    derived = sensitivity.sensitivity(fit, np.zeros(1, dtype=int), np.ones((1, axes)))
    cofactors = sensitivity.cofactors_of_rest(fit)
    assert derived.shape == (1, axes, cofactors.shape[1])
