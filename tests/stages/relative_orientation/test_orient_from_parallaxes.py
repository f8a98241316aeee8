"""Tables of y-parallaxes in, orientations and corrected model points out."""

import re

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import (
    BlockError,
    EinschaltWarning,
    SettingsError,
    TableError,
)
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    METHODS,
    orient_from_parallaxes,
)
from einschalt.stages.relative_orientation.parallax_orientation import (
    correct_model_points,
)
from einschalt.theory.relative_orientation.hallert import flat_six_points
from einschalt.theory.relative_orientation.model_correction import disturb_model
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    ELEMENTS,
    INDEPENDENT,
)

BASE = 92.0
SIGMA = 0.005
ANGLE = 1e-3


def one_model(model_id, n_points, seed, case=INDEPENDENT, noise=SIGMA):
    """Machine coordinates, true coordinates and parallaxes of one hilly model."""
    rng = np.random.default_rng(seed)
    truth = rng.uniform([-5, -95, -180], [97, 95, -120], size=(n_points, 3))
    lengths = np.ones(5) if case == INDEPENDENT else np.array([1, 1, 1, 150.0, 150.0])
    elements = ANGLE * rng.normal(size=5) * lengths
    machine, parallax = disturb_model(truth, BASE, elements, case)
    table = pd.DataFrame(machine, columns=["x", "y", "z"])
    table.insert(0, "model_id", model_id)
    table.insert(1, "point_id", [f"{k:04d}" for k in range(n_points)])
    table["y_parallax"] = parallax + rng.normal(scale=noise, size=n_points)
    table[["x_true", "y_true", "z_true"]] = truth
    return table


@pytest.fixture
def flight():
    """Six models, one of each way to fail, in mixed order of rows."""
    parts = [
        one_model("1/2", 12, seed=1),
        one_model("2/3", 4, seed=2),
        one_model("3/4", 9, seed=3).assign(y=0.0, z=-150.0),
        one_model("4/5", 9, seed=4).assign(z=lambda table: -table["z"]),
        one_model("5/6", 5, seed=5),
        one_model("6/7", 60, seed=6),
    ]
    return pd.concat(parts, ignore_index=True).sample(frac=1.0, random_state=7)


BASES = pd.Series(BASE, index=["1/2", "2/3", "3/4", "4/5", "5/6"])


@pytest.mark.parametrize("case", CASES)
def test_model_is_oriented_and_corrected(case):
    table = one_model("7/8", 60, seed=8, case=case, noise=0.0)
    oriented = orient_from_parallaxes(table, BASE, case=case)
    assert oriented.parameters.columns.tolist() == list(ELEMENTS[case])
    corrected = oriented.corrected(table)
    # only the second order in the angles remains: 150 mm times 1e-6, times a few
    wrong = corrected[["x", "y", "z"]].to_numpy()
    wrong = wrong - corrected[["x_true", "y_true", "z_true"]].to_numpy()
    before = table[["x", "y", "z"]].to_numpy()
    before = before - table[["x_true", "y_true", "z_true"]].to_numpy()
    assert np.abs(wrong).max() < 150 * ANGLE**2 * 20
    assert np.abs(wrong).max() < 0.02 * np.abs(before).max()


def test_failing_models_are_rows_and_the_others_stay(flight):
    oriented = orient_from_parallaxes(flight, BASES)
    failures = oriented.failures.set_index("model_id")
    assert sorted(failures.index) == ["2/3", "3/4", "4/5", "6/7"]
    assert failures.columns.tolist() == ["coverage", "stage", "reason", "remedy"]
    assert (failures["stage"] == "stage2_relative_orientation").all()
    assert failures["reason"].to_dict() == {
        "2/3": "4 points, but five are needed",
        "3/4": "its points lie on a line or a dangerous surface, and do not determine "
        "the elements",
        "4/5": "a point lies at or above the projection centres, z >= 0",
        "6/7": "its base is missing",
    }
    assert failures["remedy"].to_dict() == {
        "2/3": "Measure more points in it",
        "3/4": "Measure points elsewhere: six in the usual pattern, or higher and "
        "lower ones",
        "4/5": "Count z upwards from the left projection centre: points have z < 0",
        "6/7": "Give its base",
    }
    is_usable = oriented.models.set_index("model_id")["is_usable"]
    assert set(is_usable[is_usable].index) == {"1/2", "5/6"}
    assert oriented.is_usable
    assert oriented.parameters.loc[failures.index].isna().all(axis=None)
    assert oriented.parameters.loc[["1/2", "5/6"]].notna().all(axis=None)
    n_points = {"1/2": 12, "2/3": 4, "3/4": 9, "4/5": 9, "5/6": 5, "6/7": 60}
    assert oriented.n_points.to_dict() == n_points
    assert oriented.redundancy[["1/2", "5/6", "3/4"]].tolist() == [7, 0, 0]
    assert oriented.sigma_0["1/2"] == pytest.approx(SIGMA, rel=1.0)
    assert np.isnan(oriented.sigma_0["5/6"])


@pytest.mark.parametrize(
    ("change", "base", "reason"),
    [
        ({}, 1e-9, "its base is less than a thousandth of its depth"),
        ({}, 92e-3, "its base is less than a thousandth of its depth"),
        ({}, 92e3, "its base is more than a hundred times its depth"),
        ({"x": 1e20}, BASE, "a coordinate or y-parallax is larger than 1e12"),
        ({"y_parallax": -1e29}, BASE, "a coordinate or y-parallax is larger than"),
        ({"z": -1e-300}, BASE, "a point lies at or above the projection centres"),
    ],
)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", CASES)
def test_lengths_that_cannot_be_meant(change, base, reason, method, case):
    wrong = six_points("1/2", seed=1).assign(point_id=list("123456"))
    for name, value in change.items():
        wrong.loc[2, name] = value
    table = pd.concat([wrong, six_points("2/3", seed=2)])
    bases = pd.Series({"1/2": base, "2/3": BASE})
    oriented = orient_from_parallaxes(table, bases, case=case, method=method)
    assert oriented.failures["model_id"].tolist() == ["1/2"]
    assert oriented.failures["reason"].iloc[0].startswith(reason)
    assert oriented.dangerous_surface.loc["2/3", "verdict"] == "safe"
    assert "model 1/2: " in oriented.summary()


@pytest.mark.parametrize(
    ("change", "mean"),
    [(lambda x: -x, "-46"), (lambda x: x - 46.0, "0"), (lambda x: x + 46.0, "92")],
    ids=["mirrored", "from the middle", "from another origin"],
)
def test_models_beside_their_base_are_said(change, mean):
    table = six_points("1/2", seed=1)
    wrong = table.assign(x=change(table["x"]), model_id="wrong")
    oriented = orient_from_parallaxes(pd.concat([table, wrong]), BASE)
    said = " ".join(oriented.summary().split())
    assert f"model wrong: its points lie at x = {mean} on average, the base fr" in said
    assert "Count x from the left projection centre along the base" in said
    assert "model 1/2" not in said


def six_points(model_id, seed):
    parallax = np.random.default_rng(seed).normal(scale=SIGMA, size=6)
    table = pd.DataFrame(flat_six_points(95.0, BASE, 152.0), columns=list("xyz"))
    return table.assign(model_id=model_id, point_id=range(6), y_parallax=parallax)


def test_one_model_alone_equals_the_same_among_many(flight):
    together = orient_from_parallaxes(flight, BASES)
    alone = orient_from_parallaxes(flight[flight["model_id"] == "1/2"], BASE)
    pd.testing.assert_series_equal(
        alone.parameters.loc["1/2"], together.parameters.loc["1/2"], rtol=1e-12
    )
    pd.testing.assert_frame_equal(alone.cofactor("1/2"), together.cofactor("1/2"))


def test_order_of_rows_does_not_matter(flight):
    one = orient_from_parallaxes(flight, BASES)
    other = orient_from_parallaxes(flight.iloc[::-1], BASES)
    pd.testing.assert_frame_equal(
        one.parameters, other.parameters.loc[one.parameters.index], rtol=1e-9
    )


def test_residuals_stand_in_the_order_of_the_parallaxes(flight):
    oriented = orient_from_parallaxes(flight, BASES)
    used = flight[flight["model_id"].isin(["1/2", "5/6"])]
    residuals = oriented.residuals
    assert residuals.columns.tolist() == [
        *("model_id", "point_id", "residual", "redundancy_number"),
    ]
    assert residuals["point_id"].tolist() == used["point_id"].tolist()
    assert residuals["model_id"].tolist() == used["model_id"].tolist()
    of_model = residuals[residuals["model_id"] == "1/2"]
    assert of_model["redundancy_number"].sum() == pytest.approx(7.0)
    sigma_0 = np.sqrt((of_model["residual"] ** 2).sum() / 7)
    assert oriented.sigma_0["1/2"] == pytest.approx(sigma_0)


def test_covariance_is_named_and_scaled(flight):
    oriented = orient_from_parallaxes(flight, BASES)
    covariance = oriented.covariance("1/2")
    names = list(ELEMENTS[INDEPENDENT])
    assert covariance.index.tolist() == covariance.columns.tolist() == names
    pd.testing.assert_frame_equal(
        covariance, oriented.cofactor("1/2") * oriented.sigma_0["1/2"] ** 2
    )
    assert oriented.covariance("5/6").isna().all(axis=None)
    with pytest.raises(TableError, match="model 9/9: there is no such model"):
        oriented.cofactor("9/9")


@pytest.mark.parametrize(
    "base",
    [
        BASE,
        np.float32(BASE),
        92,
        pd.Series({"1/2": BASE}),
        pd.DataFrame({"model_id": ["1/2"], "base": [BASE]}),
        pd.DataFrame({"coverage": ["2"], "model_id": ["1/2"], "base": [BASE]}),
    ],
    ids=["float", "float32", "int", "series", "table", "table_with_coverage"],
)
def test_base_in_every_form(base):
    oriented = orient_from_parallaxes(one_model("1/2", 9, seed=1), base)
    assert oriented.models["base"].tolist() == [BASE]
    assert oriented.failures.empty


def test_base_left_empty_fails_alone():
    table = pd.concat([one_model("1", 9, seed=1), one_model("2", 9, seed=2)])
    base = pd.DataFrame({"model_id": [1, 2], "base": [BASE, np.nan]})
    oriented = orient_from_parallaxes(table, base)
    assert oriented.failures["model_id"].tolist() == ["2"]
    assert oriented.failures["reason"].tolist() == ["its base is missing"]


@pytest.fixture
def two_coverages():
    """Two coverages that count their models alike, with different bases."""
    first = one_model("1", 9, seed=21).assign(coverage="A")
    second = one_model("1", 9, seed=22).assign(coverage="B")
    return pd.concat([first, second], ignore_index=True)


def test_models_are_told_apart_by_coverage(two_coverages):
    base = pd.DataFrame({"coverage": ["B", "A"], "model_id": "1", "base": [BASE, 80.0]})
    oriented = orient_from_parallaxes(two_coverages, base)
    assert oriented.models["coverage"].tolist() == ["A", "B"]
    assert oriented.models["base"].tolist() == [80.0, BASE]
    assert oriented.residuals["coverage"].tolist() == ["A"] * 9 + ["B"] * 9
    with pytest.raises(TableError, match="coverages A, B each have this model"):
        oriented.cofactor("1")
    in_b = two_coverages[two_coverages["coverage"] == "B"].drop(columns="coverage")
    alone = orient_from_parallaxes(in_b, BASE)
    pd.testing.assert_frame_equal(alone.cofactor("1"), oriented.cofactor("1", "B"))
    corrected = oriented.corrected(two_coverages)
    pd.testing.assert_frame_equal(
        corrected.iloc[9:][["x", "y", "z"]], alone.corrected(in_b)[["x", "y", "z"]]
    )


def test_parallaxes_without_coverage_serve_a_model_of_any_coverage():
    table = one_model("7/8", 9, seed=23)
    oriented = orient_from_parallaxes(table, BASE)
    corrected = oriented.corrected(table.assign(coverage="2"))
    assert len(corrected) == 9
    assert (corrected["coverage"] == "2").all()


def test_two_coverages_need_parallaxes_that_name_them(two_coverages):
    in_a = two_coverages.iloc[:9].drop(columns="coverage")
    oriented = orient_from_parallaxes(in_a, BASE)
    done = correct_model_points(oriented, two_coverages)
    assert done.points.empty
    assert done.failures["coverage"].tolist() == ["A", "B"]
    assert set(done.failures["reason"]) == {"several coverages have this model"}
    assert set(done.failures["remedy"]) == {"Give both tables the column coverage"}
    base = pd.DataFrame({"coverage": ["A", "B"], "model_id": "1", "base": [BASE, 80.0]})
    failures = orient_from_parallaxes(in_a, base).failures
    assert failures["reason"].tolist() == ["several coverages have its base"]


def test_corrected_keeps_rows_and_columns(flight):
    oriented = orient_from_parallaxes(flight, BASES)
    extra = pd.concat([flight, one_model("8/9", 3, seed=31)]).assign(n_settings=2)
    left_out = "5 models left out, not corrected: .*8/9"
    with pytest.warns(EinschaltWarning, match=left_out):
        corrected = oriented.corrected(extra)
    is_kept = extra["model_id"].isin(["1/2", "5/6"])
    kept = extra[is_kept]
    others = [name for name in extra.columns if name not in ("x", "y", "z")]
    pd.testing.assert_frame_equal(
        corrected[others], kept[others], check_dtype=False, check_column_type=False
    )
    assert corrected.columns.tolist() == extra.columns.tolist()
    assert not np.allclose(corrected["x"], kept["x"])


def test_models_left_out_are_said_with_their_reason(flight):
    oriented = orient_from_parallaxes(flight, BASES)
    above = one_model("1/2", 9, seed=1).assign(z=1.0)
    points = pd.concat([above, one_model("2/3", 4, seed=2), one_model("x", 3, seed=9)])
    done = correct_model_points(oriented, points)
    assert done.points.empty
    assert done.failures["model_id"].tolist() == ["1/2", "2/3", "x"]
    assert done.failures["reason"].tolist() == [
        "a point lies at or above the projection centres, z >= 0",
        "4 points, but five are needed",
        "it has no y-parallaxes",
    ]
    assert done.failures["remedy"].tolist() == [
        "Count z upwards from the left projection centre: points have z < 0",
        "Measure more points in it",
        "Measure y-parallaxes in it",
    ]


def test_rays_that_part_after_the_correction_are_said():
    # parallaxes of the size of the model turn the bundles beyond all reason
    table = one_model("1", 6, seed=5)
    table["y_parallax"] += 5e3 * np.sign(table["y"]) * (table["x"] > 40)
    oriented = orient_from_parallaxes(table, BASE)
    done = correct_model_points(oriented, table)
    assert done.failures["reason"].tolist() == [
        "rays of a point do not meet after the correction"
    ]
    assert done.failures["remedy"].tolist() == ["Check its y-parallaxes for a blunder"]


def test_corrected_needs_z():
    table = one_model("1", 9, seed=1)
    with pytest.raises(TableError, match="column 'z' is missing"):
        orient_from_parallaxes(table, BASE).corrected(table.drop(columns="z"))


def test_case_and_method_are_checked():
    table = one_model("1", 9, seed=1)
    known = "expected independent or dependent_left or dependent_right"
    with pytest.raises(SettingsError, match=f"case = 'dep2' is unknown; {known}"):
        orient_from_parallaxes(table, BASE, case="dep2")
    with pytest.raises(SettingsError, match='Write case="dependent_right"'):
        orient_from_parallaxes(table, BASE, case="dependend_right")
    with pytest.raises(
        SettingsError, match="method = 'bachmann' is unknown; expected least_squares"
    ):
        orient_from_parallaxes(table, BASE, method="bachmann")


@pytest.mark.parametrize("base", [0.0, -92.0, np.nan, np.inf, True, "92", None])
def test_base_must_be_a_positive_length(base):
    with pytest.raises(SettingsError, match=r"base = .*; expected a positive length"):
        orient_from_parallaxes(one_model("1", 9, seed=1), base)


def test_tables_are_checked():
    table = one_model("1", 9, seed=1)
    with pytest.raises(TableError, match="column 'y_parallax' is missing"):
        orient_from_parallaxes(table.drop(columns="y_parallax"), BASE)
    with pytest.raises(TableError, match=r"point 0003, model 1: z .*is missing"):
        orient_from_parallaxes(table.assign(z=table["z"].where(table.index != 3)), BASE)
    with pytest.raises(BlockError, match="repeats row"):
        orient_from_parallaxes(pd.concat([table, table]), BASE)
    with pytest.raises(TableError, match=r"base .* is not above 0"):
        orient_from_parallaxes(table, pd.Series({"1": -92.0}))
    with pytest.raises(TableError, match="column 'base' is missing"):
        orient_from_parallaxes(table, pd.DataFrame({"model_id": ["1"]}))


def test_print_is_the_summary(flight):
    oriented = orient_from_parallaxes(flight, BASES)
    text = oriented.summary()
    assert str(oriented) == repr(oriented) == text
    assert text.startswith(
        "Relative orientation from y-parallaxes: 2 of 6 models oriented\n"
        "independent pair; least squares\n"
    )
    assert "Problems and suggestions" in text
    assert "model 6/7: its base is missing. Give its base." in text
    assert "Corrections still to be made [gon]" in text
    assert max(map(len, text.splitlines())) <= 88


def test_summary_says_where_the_linear_equations_do_not_suffice():
    table = one_model("1/2", 12, seed=1)
    oriented = orient_from_parallaxes(table, BASE)
    assert oriented.linearisation_error["1/2"] < oriented.sigma_0["1/2"]
    assert "Problems" not in oriented.summary()
    rng = np.random.default_rng(3)
    truth = rng.uniform([-5, -95, -180], [97, 95, -120], size=(12, 3))
    elements = 0.03 * rng.normal(size=5)
    machine, parallax = disturb_model(truth, BASE, elements, INDEPENDENT)
    table[["x", "y", "z"]] = machine
    table["y_parallax"] = parallax
    oriented = orient_from_parallaxes(table, BASE)
    said = " ".join(oriented.summary().split())
    assert "its corrections are so large that the linear equations neglect" in said
    assert "Correct it, and measure again." in said


def test_summary_of_many_models_is_cut():
    table = pd.concat([one_model(f"m{k}", 6, seed=k) for k in range(25)])
    text = orient_from_parallaxes(table, BASE, case="dependent_left").summary()
    assert len(re.findall(r"\n  m\d", text)) == 20
    assert text.endswith("and 5 more")
    assert "d_by, d_bz in the unit of the model" in text
